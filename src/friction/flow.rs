//! `du/dp = f(u)` along a path, for the models whose law has no solution in closed form.

use crate::Scalar;
use crate::param::{ParamError, fits, to_positive};

/// Substeps per unit of the path: a control tick of a precision stage takes one.
const PER_UNIT: f64 = 16.0;

/// Substeps after which every law here has settled to rounding: 32 along the path to `u = 1`, and 37 e-foldings.
pub(crate) const MOST_SUBSTEPS: usize = 1024;

/// Runge and Kutta's fourth-order step on a law whose slope is of the order of 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Flow<S> {
    sixth: S,
    substep: S,
}

impl<S: Scalar> Flow<S> {
    pub(crate) fn try_new() -> Result<Self, ParamError> {
        fits::<S>("slopes of a substep", 64.0)?;
        Ok(Self {
            sixth: to_positive("one sixth", 1.0 / 6.0)?,
            substep: to_positive("substep of the path", 1.0 / PER_UNIT)?,
        })
    }

    /// The next substep of a path of which `left` is left; NaN counts as a long way.
    #[inline]
    pub(crate) fn portion(&self, left: S) -> S {
        if left < self.substep {
            left
        } else {
            self.substep
        }
    }

    /// One substep of `h`.
    #[inline]
    pub(crate) fn substep(&self, u: S, h: S, slope: impl Fn(S) -> S) -> S {
        let half = h.half();
        let k1 = slope(u);
        let k2 = slope(u + half * k1);
        let k3 = slope(u + half * k2);
        let k4 = slope(u + h * k3);
        let middle = k2 + k3;
        u + h * (self.sixth * (k1 + middle + middle + k4))
    }

    /// How much of the path it takes to get from `u` to `to`, less than a substep away, by Simpson's rule.
    #[inline]
    pub(crate) fn path_to(&self, u: S, to: S, slope: impl Fn(S) -> S) -> S {
        let pace = |u: S| slope(u).magnitude().reciprocal();
        let middle = pace(u + (to - u).half());
        let sum = pace(u).add_input(pace(to));
        let sum = sum.add_input(middle.add_input(middle).add_input(middle.add_input(middle)));
        (to - u).magnitude().mul_input(self.sixth.mul_input(sum))
    }

    /// `u` at the end of `path`, or as soon as it has settled.
    pub(crate) fn along(&self, mut u: S, mut path: S, slope: impl Fn(S) -> S) -> S {
        for _ in 0..MOST_SUBSTEPS {
            if path == S::ZERO {
                break;
            }
            let h = self.portion(path);
            let next = self.substep(u, h, &slope);
            if next == u {
                break;
            }
            u = next;
            path = path.sub_input(h);
        }
        u
    }
}
