//! Friction that grows while the axis rests.

use super::{Bounds, Effect, LARGEST_LEVEL, Situation};
use crate::Scalar;
use crate::param::{Bound, ParamError, Units, at_least, at_most, positive, to_positive, to_scalar};
use core::f64::consts::LOG10_E;

/// `dwell_aging`: `m = 1 + a·log10(1 + θ/τ)`, where `θ` is the age of the contact.
///
/// `dθ/dt = 1 − |v|·θ/λ` (the ageing law: J. H. Dieterich, *Modeling of rock friction 1*, J. Geophys. Res. 84, 1979):
/// at rest `θ` is the time of rest, moving on erases it along the path `λ`. Explicit Euler, the loss held below the
/// whole age, so stable for any speed. Costs a logarithm a tick (`libm`).
#[derive(Clone, Debug, PartialEq)]
pub struct DwellAging<S = f32> {
    /// Per natural logarithm.
    level: S,
    /// Age of a tick in units of `τ`.
    per_tick: S,
    erased_per_velocity: S,
    oldest: S,
    bound: S,
}

impl<S: Scalar> DwellAging<S> {
    /// `per_decade` is `a` (-), `time_constant` is `τ` (s), `erasing_path` is `λ` (m or rad), `sample_time` is `T_s` (s).
    /// Ageing stops after `decades` (-), 1…6: at `θ = 10^decades·τ`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of its range, or does not fit `S` in `units`; where `S` is too
    /// coarse to add a tick to the oldest age, which fewer decades cure.
    pub fn try_new(
        per_decade: f64,
        time_constant: f64,
        erasing_path: f64,
        decades: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("time constant of the ageing", time_constant)?;
        positive("path that erases the ageing", erasing_path)?;
        positive("sample time", sample_time)?;
        at_least("decades of ageing", decades, 1.0)?;
        at_most("decades of ageing", decades, 6.0)?;
        let bound = per_decade.abs() * decades * (1.0 + 1e-3);
        at_most("level of the ageing", bound, LARGEST_LEVEL)?;
        let per_tick: S = to_positive("ageing per tick", sample_time / time_constant)?;
        let oldest: S = to_positive("oldest age", libm::pow(10.0, decades) - 1.0)?;
        if oldest - per_tick == oldest {
            return Err(ParamError::new(
                "ageing per tick at the given decades",
                sample_time / time_constant,
                Bound::Resolvable,
            ));
        }
        Ok(Self {
            level: to_scalar("level of the ageing", per_decade * LOG10_E)?,
            per_tick,
            erased_per_velocity: to_positive(
                "ageing erased per tick and velocity",
                sample_time / erasing_path * units.velocity,
            )?,
            oldest,
            bound: to_scalar("level of the ageing", bound)?,
        })
    }
}

impl<S: Scalar> Effect<S> for DwellAging<S> {
    /// `θ/τ`; the axis has just moved.
    type State = S;
    const LEVEL: bool = true;

    fn at_rest(&self) -> S {
        S::ZERO
    }

    #[inline]
    fn level(&self, state: &mut S, at: &Situation<S>) -> S {
        let erased = self
            .erased_per_velocity
            .mul_input(at.velocity.magnitude())
            .limited(S::ONE);
        let age = *state - *state * erased;
        *state = age.add_input(self.per_tick).limited(self.oldest);
        self.level.mul_input(state.ln_1p()).limited(self.bound)
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.bound)
    }
}
