//! The catalogue: one effect a file. A new effect is a new file and a line in [`ALL`].

pub mod actuator_dead_zone;
pub mod actuator_saturation;
mod ahead;
pub mod axis_coupling;
pub mod backlash;
pub(in crate::diagnose) mod behind;
pub mod channel_delay;
pub mod constant_force;
mod cosines;
pub mod coulomb_asymmetry;
pub mod creep;
mod displaced;
pub mod drive_compliance;
pub mod dwell_aging;
pub mod encoder_error;
pub mod external_vibration;
pub mod frictional_lag;
pub mod gravity;
pub mod grid;
mod lack;
pub mod load_dependent_friction;
pub mod local_friction_spot;
pub mod periodic_force;
pub mod periodic_friction;
pub mod position_force;
pub mod position_friction;
pub mod position_spring;
pub mod quadratic_drag;
mod readout;
pub mod run_in;
mod scene;
pub mod stribeck;
#[cfg(test)]
pub(super) mod tests;
pub mod thermal_drift;
pub mod torque_ripple;
pub mod viscous;
pub mod viscous_asymmetry;
mod wave;

use super::axis::Axis;
use super::normal::Bound;
use super::signals::Signals;
use super::weak::Column;
use preslide_fit::effects::Effect as Entry;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Every effect, in the order in which ties are decided: the simpler one first.
pub static ALL: [&dyn Effect; 28] = [
    &constant_force::ConstantForce,
    &viscous::Viscous,
    &viscous_asymmetry::ViscousAsymmetry,
    &coulomb_asymmetry::CoulombAsymmetry,
    &quadratic_drag::QuadraticDrag,
    &stribeck::Stribeck,
    &position_spring::PositionSpring,
    &gravity::Gravity,
    &periodic_force::PeriodicForce,
    &periodic_friction::PeriodicFriction,
    &position_force::PositionForce,
    &local_friction_spot::LocalFrictionSpot,
    &position_friction::PositionFriction,
    &torque_ripple::TorqueRipple,
    &encoder_error::EncoderError,
    &external_vibration::ExternalVibration,
    &channel_delay::ChannelDelay,
    &drive_compliance::DriveCompliance,
    &frictional_lag::FrictionalLag,
    &thermal_drift::ThermalDrift,
    &run_in::RunIn,
    &dwell_aging::DwellAging,
    &load_dependent_friction::LoadDependentFriction,
    &axis_coupling::AxisCoupling,
    &backlash::Backlash,
    &actuator_dead_zone::ActuatorDeadZone,
    &actuator_saturation::ActuatorSaturation,
    &creep::Creep,
];

/// What every recording may have to a small extent: it stands in every hypothesis, and is named where it is more.
pub static ALWAYS_FREE: &dyn Effect = &channel_delay::ChannelDelay;

/// A line in time, which would be taken for noise where it is not looked for.
pub static VIBRATION: &dyn Effect = &external_vibration::ExternalVibration;

/// The effect of an id.
pub fn by_id(id: &str) -> Option<&'static dyn Effect> {
    ALL.into_iter().find(|effect| effect.id() == id)
}

/// Its place in the catalogue: of two, the simpler one has the lower.
pub fn rank(effect: &dyn Effect) -> usize {
    let place = ALL.iter().position(|e| e.id() == effect.id());
    place.unwrap_or(ALL.len())
}

/// How much an effect may explain by chance, and what it competes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One coefficient that every machine may have: weight, viscous friction, a spring. Tried before all others.
    Plain,
    /// A change of the friction law over speed, load or direction.
    Law,
    /// A place: friction that wanders may repeat there by chance.
    Place,
    /// Slow change over time, path or temperature: friction that wanders may look like it.
    Drift,
    /// The drive, the encoder or the channels.
    Drive,
}

/// How a shape parameter is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// By its logarithm.
    Logarithmic,
    /// By itself, in shares of the travel.
    Travel,
    /// As a period in position: by phase over the travel.
    Period,
    /// As a frequency in time: by phase over the recording.
    Frequency,
    /// Chosen from the grid only.
    Chosen,
}

/// Where lines of the mismatch's spectrum give further shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A period in position of the force.
    Force,
    /// A period in position of the friction level.
    Level,
    /// A period in position of what the drive gives for its command.
    Effort,
    /// A frequency in time of the force.
    Time,
}

/// A motion that shows an effect, for the experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Triangles inside triangles, for hysteresis, backlash and encoder.
    Nested,
    /// The same stroke at speeds of three decades.
    Speeds,
    /// Slow moves after rests of 0.1, 1 and 10 s.
    Rests,
    /// Slow passes over the whole travel, there and back.
    Passes,
    /// Fast strokes, for inertia, delay and elasticity.
    Fast,
    /// The same fast strokes over and over, a rest, and some more: what runs in stays, warmth goes back.
    Again,
}

/// The model that effects act through.
#[derive(Clone, Default)]
pub struct Baseline {
    /// Inertia (kg or kg·m²).
    pub mass: f64,
    /// Stiffness (N/m) and yield displacement (m) of the blocks.
    pub blocks: Vec<(f64, f64)>,
    /// Friction without effects (N or N·m).
    pub friction: Vec<f64>,
    /// Its usual size in sliding (N or N·m).
    pub level: f64,
    /// Its part in blocks that slip.
    pub slipping: Vec<f64>,
    /// Stiffness of the blocks that stick (N/m or N·m/rad).
    pub stiffness: Vec<f64>,
    /// Whole modelled effort, plain effects included.
    pub fitted: Vec<f64>,
    /// The recording's own viscous coefficient (N·s/m or N·m·s/rad), where the effort of a simulation is taken off.
    pub beside_simulation: Option<f64>,
    /// The frequency (Hz) at which the load of its elastic drive swings, where it has one.
    pub simulated_swing: Option<f64>,
}

/// What columns are made of: the motion, the model that effects act through, the measured effort.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// Coordinates.
    pub s: &'a Signals,
    /// The model.
    pub core: &'a Baseline,
    /// Measured effort at the samples (N or N·m).
    pub effort: &'a [f64],
}

/// An effect as fitted, for its parameters.
pub struct Fitted<'a> {
    /// Shape parameters.
    pub shape: &'a [f64],
    /// Coefficients of the columns.
    pub coefficients: &'a [f64],
    /// Standard errors of the shape parameters; `None` where chosen from a grid.
    pub shape_errors: &'a [Option<f64>],
    /// Standard errors of the coefficients.
    pub errors: &'a [Option<f64>],
    /// Degrees of freedom behind the errors, plus one.
    pub folds: usize,
    /// The first coefficient under another value of an assumed shape parameter (`motor_share`), all else fitted.
    pub at_shape: &'a dyn Fn(&[f64]) -> Option<f64>,
    /// What it acts through.
    pub scene: Scene<'a>,
}

/// An effect of the catalogue: physics that a model may lack.
pub trait Effect: Sync {
    /// Its id in model files and JSON.
    fn id(&self) -> &'static str;

    /// Its name for a person: "friction spot".
    fn name(&self) -> &'static str;

    /// What it is, for a control engineer: "a narrow place of higher or lower friction".
    fn words(&self) -> &'static str;

    /// What it competes with.
    fn class(&self) -> Class;

    /// The coordinate over which it acts.
    fn axis(&self) -> Axis;

    /// The experiment that decides between it and its rivals.
    fn experiment(&self) -> &'static str;

    /// The parts of a motion that show it.
    fn shown_by(&self) -> &'static [Part] {
        &[Part::Passes, Part::Speeds]
    }

    /// Effects that no fit to this recording separates from it.
    fn equivalents(&self, s: &Signals) -> &'static [&'static dyn Effect] {
        let _ = s;
        &[]
    }

    /// Effects of the same shape that are tried in its place: next to it they are no simpler, and where they predict better it is they.
    fn in_place(&self) -> &'static [&'static dyn Effect] {
        &[]
    }

    /// Whether it acts for a while after a stop or a reversal only.
    fn is_transient(&self) -> bool {
        false
    }

    /// Whether it is no larger than what every recording may have.
    fn is_harmless(&self, scene: &Scene, coefficients: &[f64]) -> bool {
        let _ = (scene, coefficients);
        false
    }

    /// Effects that are not offered beside it in such a shape, and whose place it takes: what it contains. Where either contains the other,
    /// each says so.
    fn excludes(&self, shape: &[f64]) -> &'static [&'static dyn Effect] {
        let _ = shape;
        &[]
    }

    /// Whether it may act more than once in one machine.
    fn recurs(&self) -> bool {
        false
    }

    /// What the recording lacks to show it, if anything.
    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        let _ = s;
        None
    }

    /// What the recording lacks to separate it well from hysteresis, though it can be named where the data do.
    fn blurred(&self, s: &Signals) -> Option<&'static str> {
        let _ = s;
        None
    }

    /// Shape parameters: key in the units of a linear axis, and scale.
    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[]
    }

    /// Its shape in a model file.
    fn shape_in(&self, entry: &Entry, model: &Model) -> Vec<f64> {
        let _ = model;
        self.shape().iter().map(|(key, _)| entry.get(key)).collect()
    }

    /// The nearest shape that a model file holds.
    fn storable(&self, shape: &[f64]) -> Vec<f64> {
        shape.to_vec()
    }

    /// Shapes to try, from what the recording covers; empty where it cannot act.
    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let _ = scene;
        vec![Vec::new()]
    }

    /// The spectrum whose lines give further shapes.
    fn line(&self) -> Option<Line> {
        None
    }

    /// Whether it is a line or a narrow place, which chance makes as well: what it takes is held against placebos.
    fn is_narrow(&self) -> bool {
        self.line().is_some()
    }

    /// A shape parameter brought within what a recording can resolve.
    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let _ = scene;
        shape[index]
    }

    /// Columns at the sample rate, linear in their coefficients.
    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column>;

    /// How its coefficients are bound wherever they are fitted.
    fn bound(&self) -> Bound {
        Bound::Free
    }

    /// Whether coefficients have the sign, or the size, that the physics has.
    fn admits(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        let _ = (shape, coefficients);
        true
    }

    /// Whether its columns are made of the fitted or measured effort itself (then it is no part of that effort's model).
    fn acts_on_effort(&self) -> bool {
        false
    }

    /// Whether a simulation has the effect, too, of another size; `None` where its own effort must show it.
    fn in_simulation(&self, shape: &[f64]) -> Option<bool> {
        let _ = shape;
        None
    }

    /// Parameters with intervals, in the keys of a linear axis.
    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)>;

    /// Its shapes in a user's model, empty where the model lacks it.
    fn in_model(&self, model: &Model) -> Vec<Vec<f64>> {
        let own = model.effects.iter().filter(|e| e.id() == self.id());
        own.map(|e| self.shape_in(e, model)).collect()
    }

    /// Enters the model file.
    ///
    /// # Errors
    /// Why a model file cannot hold it.
    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String>;
}
