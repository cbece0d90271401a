//! A cosine of a place in turns, without a call to a trigonometric function.

use crate::Scalar;
use crate::param::{Bound, ParamError, fits, positive, to_positive, to_scalar};
use core::f64::consts::TAU;

/// `sin(2πs) ≈ s·(C1 + C3·s² + C5·s⁴ + C7·s⁶)` for `|s| ≤ ¼`, the odd polynomial of degree 7 with the least largest
/// error (6e-7), found by iterated least squares on 4001 Chebyshev points.
const SINE: [f32; 4] = [6.283_164, -41.337_143, 81.340_77, -70.993_43];

/// `cos(2π·turns)`, within ±1 for any input, NaN included. Largest error 1e-6 for `|turns| ≤ ½` in floats; beyond that
/// the rounding of `turns` itself adds to it.
#[inline]
pub(super) fn cosine<S: Scalar>(turns: S) -> S {
    let quarter = S::ONE.half().half();
    let nearest = S::from_int(turns.round_to_int());
    let off = turns.sub_input(nearest).limited(S::ONE.half()).magnitude();
    let s = quarter - off;
    let [c1, c3, c5, c7] = SINE.map(S::from_f32);
    let y = s * s;
    (s * (c1 + y * (c3 + y * (c5 + y * c7)))).limited(S::ONE)
}

/// Positions are scaled by `2⁻⁸` before the period is applied: exact in floats, and in fixed point the period is then
/// resolved 256 times finer.
pub(super) const PRESCALE: f64 = 256.0;

/// A position as it meets a factor that holds [`PRESCALE`].
#[inline]
pub(super) fn prescaled<S: Scalar>(position: S) -> S {
    position.mul_input(S::from_q16((65_536.0 / PRESCALE) as i32))
}

/// `value` in the number type, refused where rounding moves it by more than `tolerance` of itself.
pub(super) fn precise<S: Scalar>(
    name: &'static str,
    value: f64,
    tolerance: f64,
) -> Result<S, ParamError> {
    let own: S = to_positive(name, value)?;
    if (own.to_f64() / value - 1.0).abs() > tolerance {
        return Err(ParamError::new(name, value, Bound::Resolvable));
    }
    Ok(own)
}

/// `cos(2πx/p + φ)` of a position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wave<S> {
    per_length: S,
    phase: S,
}

impl<S: Scalar> Wave<S> {
    /// `period` is `p` in SI, `phase` is `φ` (rad), `unit` is the position's unit.
    pub(super) fn try_new(period: f64, phase: f64, unit: f64) -> Result<Self, ParamError> {
        positive("period", period)?;
        fits::<S>("coefficients of the cosine", 82.0)?;
        let turns = phase / TAU;
        Ok(Self {
            // A coarser one would put the waves elsewhere after some periods.
            per_length: precise("turns per unit of length", PRESCALE * unit / period, 1e-3)?,
            phase: to_scalar("phase", turns - libm::round(turns))?,
        })
    }

    #[inline]
    pub(super) fn at(&self, position: S) -> S {
        cosine(
            self.per_length
                .mul_input(prescaled(position))
                .add_input(self.phase),
        )
    }
}
