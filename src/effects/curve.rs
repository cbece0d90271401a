//! A function of a magnitude on a uniform table: no exponential and no division in the control tick.

use crate::Scalar;
use crate::param::{ParamError, fits, to_positive, to_scalar};

/// Intervals of the table.
const INTERVALS: usize = 64;

/// `ln 1e4`: where an exponential has fallen to 1e-4 the table ends.
pub(super) const DECAYED: f64 = 9.210_340_371_976_184;

/// `f(|u|)` by linear interpolation on `0…end`, with the last node's value beyond; NaN counts as beyond.
///
/// For the functions tabulated here, `exp(−u^δ)` of height 1 up to where it is 1e-4, the error is at most 4e-3 at
/// `δ = 1`…`1.3`, 6e-4 at `δ ≥ 2` (`host-tests` assert it).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve<S> {
    nodes: [S; INTERVALS + 1],
    per_unit: S,
}

impl<S: Scalar> Curve<S> {
    /// Tabulates `height·f(u)` for `u` (SI) in `0…end`, 0 at the end and beyond; `unit` is the run-time argument's unit.
    pub(super) fn falling(
        name: &'static str,
        height: f64,
        end: f64,
        unit: f64,
        f: impl Fn(f64) -> f64,
    ) -> Result<Self, ParamError> {
        fits::<S>("number of table intervals", INTERVALS as f64)?;
        let mut nodes = [S::ZERO; INTERVALS + 1];
        for (j, node) in nodes.iter_mut().take(INTERVALS).enumerate() {
            // A tail that the type cannot resolve is 0.
            let value = height * f(end * j as f64 / INTERVALS as f64);
            *node = S::try_from_f64(value).unwrap_or(S::ZERO);
        }
        nodes[0] = to_scalar(name, height * f(0.0))?;
        Ok(Self {
            nodes,
            per_unit: to_positive("table nodes per unit", INTERVALS as f64 / end * unit)?,
        })
    }

    #[inline]
    pub(super) fn at(&self, u: S) -> S {
        let place = u.magnitude().mul_input(self.per_unit);
        let Some(j) = place.whole_below(INTERVALS) else {
            return self.nodes[INTERVALS];
        };
        let (Some(low), Some(high)) = (self.nodes.get(j), self.nodes.get(j + 1)) else {
            return self.nodes[INTERVALS];
        };
        *low + (place - S::from_int(j as i32)) * (*high - *low)
    }
}
