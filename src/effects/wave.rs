//! A cosine of a place in turns, without a call to a trigonometric function.

use crate::Scalar;
use crate::param::{Bound, ParamError, fits, positive, to_positive, to_scalar};
use core::f64::consts::TAU;

/// `sin(2πs) ≈ s·(C1 + C3·s² + C5·s⁴ + C7·s⁶)` for `|s| ≤ ¼`, the odd polynomial of degree 7 with the least largest
/// error (6e-7), found by iterated least squares on 4001 Chebyshev points.
const SINE: [f32; 4] = [6.283_164, -41.337_143, 81.340_77, -70.993_43];

/// How far the approximation reaches beyond ±1, rounding in `f32` included.
pub(super) const OVERSHOOT: f64 = 2e-6;

/// `cos(2π·turns)`, within ±(1 + [`OVERSHOOT`]) for any input, NaN included. Largest error 1e-6 for `|turns| ≤ ½`;
/// beyond that the rounding of `turns` itself adds to it.
#[inline]
pub(super) fn cosine<S: Scalar>(turns: S) -> S {
    let quarter = S::ONE.half().half();
    let nearest = S::from_int(turns.round_to_int());
    let off = turns.sub_input(nearest).limited(S::ONE.half()).magnitude();
    let s = quarter - off;
    let [c1, c3, c5, c7] = SINE.map(S::from_f32);
    let y = s * s;
    s * (c1 + y * (c3 + y * (c5 + y * c7)))
}

/// `cos(2πx/p + φ)` of a position.
#[derive(Clone, Debug)]
pub(super) struct Wave<S> {
    per_length: S,
    phase: S,
}

impl<S: Scalar> Wave<S> {
    /// `period` is `p` in SI, `phase` is `φ` (rad), `unit` is the position's unit.
    pub(super) fn try_new(period: f64, phase: f64, unit: f64) -> Result<Self, ParamError> {
        positive("period", period)?;
        fits::<S>("coefficients of the cosine", 82.0)?;
        let exact = unit / period;
        let per_length: S = to_positive("turns per unit of length", exact)?;
        // A coarse fixed point type would put the waves elsewhere after some periods.
        if (per_length.to_f64() / exact - 1.0).abs() > 1e-3 {
            return Err(ParamError {
                parameter: "turns per unit of length",
                block: None,
                value: exact,
                bound: Bound::Resolvable,
            });
        }
        let turns = phase / TAU;
        Ok(Self {
            per_length,
            phase: to_scalar("phase", turns - libm::round(turns))?,
        })
    }

    #[inline]
    pub(super) fn at(&self, position: S) -> S {
        cosine(self.per_length.mul_input(position).add_input(self.phase))
    }
}

/// What `amplitude` times a wave never exceeds, in the number type.
pub(super) fn reach<S: Scalar>(name: &'static str, amplitude: f64) -> Result<S, ParamError> {
    to_scalar(name, amplitude.abs() * (1.0 + OVERSHOOT))
}
