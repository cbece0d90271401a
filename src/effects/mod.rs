//! Physics beyond the friction model, composed with it by type.
//!
//! An [`Effect`] changes the friction level, adds a force, or corrects the position; [`With`] composes a tuple of them
//! with any [`Friction`](crate::Friction) model into another one, so the control task takes it as it takes [`Gms`](crate::Gms):
//!
//! `F = max(0, 1 + Σ level_i)·F_model(x + Σ shift_i) + Σ force_i`
//!
//! An effect that is not in the tuple is not in the program. Every term is bounded whatever its input, NaN included
//! ([`Effect::bounds`]), so the composed model is bounded as long as the friction model is ([`crate::Friction::limit`]).
//!
//! ```
//! use preslide::effects::{PeriodicForce, Stribeck, Viscous, With};
//! use preslide::{Block, Friction, Motion, QuasiStaticGms, Units};
//!
//! let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
//! let gms = QuasiStaticGms::<2>::try_new(&blocks, 0.9, Units::SI)?;
//! let model = With::try_new(gms, (
//!     Stribeck::try_new(0.2, 1e-3, 2.0, Units::SI)?,          // 20 % more friction near standstill
//!     Viscous::try_new(12.0, 0.5, Units::SI)?,                // 12 N·s/m, never more than 0.5 N
//!     PeriodicForce::try_new(0.03, 2.857e-4, 0.0, Units::SI)?, // 30 mN of cogging
//! ))?;
//! let mut state = model.at_rest();
//! model.set_position(&mut state, 0.0); // cogging needs to know where the axis is
//! let force = model.step(&mut state, Motion { displacement: 1e-3, velocity: 0.0 });
//! assert!((force - (1.2 * 0.9 + 0.03)).abs() < 1e-5);
//! # Ok::<(), preslide::ParamError>(())
//! ```
//!
//! | id in model files | type | acts on | bound |
//! |---|---|---|---|
//! | `constant_force` | [`ConstantForce`] | force | its magnitude |
//! | `viscous_N_s_per_m` | [`Viscous`] | force | given |
//! | `viscous_asymmetry` | [`ViscousAsymmetry`] | force | given |
//! | `quadratic_drag` | [`QuadraticDrag`] | force | given |
//! | `position_spring` | [`PositionSpring`] | force | given |
//! | `position_force` | [`PositionForce`] | force | `Σ abs(c_j)` |
//! | `periodic_force` | [`PeriodicForce`] | force | its amplitude |
//! | `gravity` (rotary axes) | [`Gravity`] | force | its amplitude |
//! | `external_vibration` | [`ExternalVibration`] | force | its amplitude |
//! | `coulomb_asymmetry` | [`CoulombAsymmetry`] | level | its magnitude |
//! | `stribeck` | [`Stribeck`] | level | its magnitude |
//! | `frictional_lag` | [`FrictionalLag`] | level | its magnitude |
//! | `position_friction` | [`PositionFriction`] | level | `Σ abs(c_j)` |
//! | `local_friction_spot` | [`LocalFrictionSpot`] | level | its magnitude |
//! | `periodic_friction` | [`PeriodicFriction`] | level | its magnitude |
//! | `load_dependent_friction` | [`LoadDependentFriction`] | level | given |
//! | `thermal_drift` | [`ThermalDrift`], or over time [`WarmUp`] | level | given, or its magnitude |
//! | `run_in` | [`RunIn`] | level | its magnitude |
//! | `dwell_aging` | [`DwellAging`] | level | per decade × decades |
//! | `encoder_error` | [`EncoderError`] | position | its magnitude |
//!
//! **On the host only** (`preslide_fit::effects`), because a controller cannot use them as a feed-forward of the present motion:
//! `channel_delay`, `drive_compliance` (both need the force's future or its second derivative), `backlash`, `creep`,
//! `torque_ripple`, `actuator_dead_zone`, `actuator_saturation` (a property of the drive, not a force to add). `lead_error` and
//! `presliding_shape` have no term: the one is a calibration of the encoder, the other more blocks.
//!
//! The catalogue, with the signature of each effect, is the project's; laws that have one author name him where they stand.
//! In fixed point, constructors refuse a parameter that the type cannot hold or resolve in the chosen
//! [`Units`](crate::Units); a position beyond the type's range saturates. Effects with a slow memory ([`RunIn`], [`WarmUp`],
//! [`DwellAging`]) are meant for floats.

mod asymmetry;
mod compose;
mod curve;
mod dwell;
mod encoder_error;
mod forces;
mod gravity;
mod map;
mod odometer;
mod periodic;
mod spot;
mod stribeck;
mod surroundings;
mod vibration;
mod wave;
mod wear;
mod with;

pub use asymmetry::CoulombAsymmetry;
pub use dwell::DwellAging;
pub use encoder_error::EncoderError;
pub use forces::{ConstantForce, PositionSpring, QuadraticDrag, Viscous, ViscousAsymmetry};
pub use gravity::Gravity;
pub use map::{PositionForce, PositionFriction};
pub use odometer::Odometer;
pub use periodic::{PeriodicForce, PeriodicFriction};
pub use spot::LocalFrictionSpot;
pub use stribeck::{FrictionalLag, Stribeck};
pub use surroundings::{LoadDependentFriction, ThermalDrift};
pub use vibration::ExternalVibration;
pub use wear::{RunIn, WarmUp};
pub use with::{With, WithState};

use crate::Scalar;
use crate::param::{ParamError, at_most, to_scalar};

/// What an effect may know of a tick, in the model's units (temperature in °C, load in force units).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Situation<S> {
    /// Where the axis is.
    pub position: S,
    /// That is known: without it, effects that belong to a place ([`Effect::PLACED`]) are off.
    pub located: bool,
    /// How fast it moves.
    pub velocity: S,
    /// The friction model's force in this tick, before any effect.
    pub friction: S,
    /// Temperature (°C), as last set.
    pub temperature: Option<S>,
    /// Load, as last set.
    pub load: Option<S>,
}

/// What an effect's outputs never exceed in magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounds<S> {
    /// Of [`Effect::level`] (-).
    pub level: S,
    /// Of [`Effect::force`], in force units.
    pub force: S,
    /// Of [`Effect::shift`], in length units.
    pub shift: S,
}

impl<S: Scalar> Bounds<S> {
    /// No effect at all.
    pub const NONE: Self = Self {
        level: S::ZERO,
        force: S::ZERO,
        shift: S::ZERO,
    };

    /// An effect on the level alone.
    pub fn of_level(level: S) -> Self {
        Self {
            level,
            ..Self::NONE
        }
    }

    /// A force alone.
    pub fn of_force(force: S) -> Self {
        Self {
            force,
            ..Self::NONE
        }
    }
}

/// A physical effect beside the friction model: immutable parameters that advance a separate state.
///
/// An effect overrides what it acts on and sets the constant of that name; the rest stays 0 and costs nothing.
pub trait Effect<S: Scalar>: Clone + PartialEq {
    /// What it remembers.
    type State: Clone;

    /// [`Effect::level`] is not always 0.
    const LEVEL: bool = false;
    /// [`Effect::force`] is not always 0.
    const FORCE: bool = false;
    /// [`Effect::shift`] is not always 0.
    const SHIFT: bool = false;
    /// It belongs to places: it acts once the model has been told where the axis is ([`crate::Friction::set_position`]), which a controller
    /// does once it is homed or zeroed. Whoever composes effects asks.
    const PLACED: bool = false;

    /// The state of an axis that has stood since it was switched on.
    fn at_rest(&self) -> Self::State;

    /// Change of the friction level, `m − 1` (-). Called once a tick.
    #[inline]
    fn level(&self, _state: &mut Self::State, _at: &Situation<S>) -> S {
        S::ZERO
    }

    /// Additional force, in force units, positive where it resists motion in +x. Called once a tick.
    #[inline]
    fn force(&self, _state: &mut Self::State, _at: &Situation<S>) -> S {
        S::ZERO
    }

    /// True position less the measured one, in length units.
    #[inline]
    fn shift(&self, _position: S) -> S {
        S::ZERO
    }

    /// The bounds that hold for any input.
    fn bounds(&self) -> Bounds<S>;
}

/// Largest magnitude of a change of the friction level that a constructor takes.
pub const LARGEST_LEVEL: f64 = 10.0;

/// A change of the friction level in the number type.
fn level<S: Scalar>(name: &'static str, value: f64) -> Result<S, ParamError> {
    at_most(name, value.abs(), LARGEST_LEVEL)?;
    to_scalar(name, value)
}
