//! Friction that follows what another sensor measures: temperature, load.

use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::{ParamError, Units, positive, to_scalar};

/// A level that is linear in an input, bounded.
#[derive(Clone, Debug, PartialEq)]
struct Slope<S> {
    per_unit: S,
    origin: S,
    limit: S,
}

impl<S: Scalar> Slope<S> {
    #[inline]
    fn at(&self, input: Option<S>) -> S {
        match input {
            // NaN is a sensor that failed: the nominal friction.
            Some(input) if input.partial_cmp(&input).is_some() => self
                .per_unit
                .mul_input(input.sub_input(self.origin))
                .limited(self.limit),
            _ => S::ZERO,
        }
    }
}

/// `thermal_drift`: `m = 1 + β·(T − T0)`, bounded. Tell the temperature through
/// [`WithState::temperature`](super::WithState::temperature); until then the level is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalDrift<S = f32>(Slope<S>);

impl<S: Scalar> ThermalDrift<S> {
    /// `per_kelvin` is `β` (1/K), `temperature` is `T0` (°C), `limit` (-) bounds `|m − 1|`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `limit` not positive, or one does not fit `S`.
    pub fn try_new(per_kelvin: f64, temperature: f64, limit: f64) -> Result<Self, ParamError> {
        positive("limit of the thermal drift", limit)?;
        Ok(Self(Slope {
            per_unit: to_scalar("friction level per kelvin", per_kelvin)?,
            origin: to_scalar("temperature of the nominal friction", temperature)?,
            limit: level("limit of the thermal drift", limit)?,
        }))
    }
}

impl<S: Scalar> Effect<S> for ThermalDrift<S> {
    type State = ();
    const LEVEL: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.0.at(at.temperature)
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.0.limit)
    }
}

/// `load_dependent_friction`: `m = 1 + c·(load − load0)`, bounded. Tell the load through
/// [`WithState::load`](super::WithState::load); until then the level is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadDependentFriction<S = f32>(Slope<S>);

impl<S: Scalar> LoadDependentFriction<S> {
    /// `per_newton` is `c` (1/N), `load` is `load0` (N), `limit` (-) bounds `|m − 1|`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `limit` not positive, or one does not fit `S` in `units`.
    pub fn try_new(
        per_newton: f64,
        load: f64,
        limit: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("limit of the load's effect", limit)?;
        Ok(Self(Slope {
            per_unit: to_scalar("friction level per newton", per_newton * units.force)?,
            origin: to_scalar("load of the nominal friction", load / units.force)?,
            limit: level("limit of the load's effect", limit)?,
        }))
    }
}

impl<S: Scalar> Effect<S> for LoadDependentFriction<S> {
    type State = ();
    const LEVEL: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.0.at(at.load)
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.0.limit)
    }
}
