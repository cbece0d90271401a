//! The catalogue: effects of a card and columns, one a file; the waves are in one, and what is no more than a force of the motion stands here.
//! A new effect is a file of its own or a few lines here, and a line in [`ALL`].

pub mod actuator_dead_zone;
pub mod actuator_saturation;
mod ahead;
pub mod axis_coupling;
pub mod backlash;
pub(in crate::diagnose) mod behind;
mod card;
pub mod channel_delay;
pub mod constant_force;
mod cosines;
pub mod coulomb_asymmetry;
pub mod creep;
mod displaced;
pub mod drive_compliance;
pub mod dwell_aging;
pub mod formula;
pub mod frictional_lag;
pub mod gravity;
pub mod grid;
mod lack;
pub mod load_dependent_friction;
pub mod local_friction_spot;
mod of_motion;
pub mod periodic;
pub mod position_force;
pub mod position_friction;
pub mod position_spring;
mod readout;
pub mod run_in;
mod scene;
pub mod stribeck;
#[cfg(test)]
pub(super) mod tests;
pub mod thermal_drift;
pub mod viscous;
mod wave;

use super::axis::Axis;
use super::expr::{Expr, Function::Abs, Input::Velocity};
use super::normal::Bound;
use super::signals::Signals;
use super::weak::Column;
pub use card::{BARE, Card, Class, Line, Part, Scale};
use formula::Stated;
use lack::{both_directions, several_speeds};
use of_motion::{OF_VELOCITY, OfMotion};
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;
use readout::enter;

/// Every effect, in the order in which ties are decided: the simpler one first.
pub static ALL: [&dyn Effect; 28] = [
    &constant_force::ConstantForce,
    &viscous::Viscous,
    &VISCOUS_ASYMMETRY,
    &coulomb_asymmetry::CoulombAsymmetry,
    &QUADRATIC_DRAG,
    &stribeck::Stribeck,
    &position_spring::PositionSpring,
    &gravity::Gravity,
    &periodic::PERIODIC_FORCE,
    &periodic::PERIODIC_FRICTION,
    &position_force::PositionForce,
    &local_friction_spot::LocalFrictionSpot,
    &position_friction::PositionFriction,
    &periodic::TORQUE_RIPPLE,
    &periodic::ENCODER_ERROR,
    &periodic::EXTERNAL_VIBRATION,
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

/// `d·|v|`: viscous friction is `d` more forwards than its mean, and `d` less backwards.
pub static VISCOUS_ASYMMETRY: OfMotion = OfMotion {
    card: Card {
        id: form::VISCOUS_ASYMMETRY.id,
        name: "viscous friction that differs by direction",
        words: "viscous friction that is higher one way than the other",
        experiment: "strokes at 1, 3 and 10 times the speed, in both directions",
        coefficient: "half_difference_N_s_per_m",
        lacks: |s| both_directions(s).or_else(|| several_speeds(s)),
        formula: Some(|stated| {
            Some(stated.get("half_difference_N_s_per_m")? * Expr::from(Velocity).of(Abs))
        }),
        ..OF_VELOCITY
    },
    force: |s, i| s.v[i].abs(),
};

/// `c·v·|v|`.
pub static QUADRATIC_DRAG: OfMotion = OfMotion {
    card: Card {
        id: form::QUADRATIC_DRAG.id,
        name: "quadratic drag",
        words: "a force that grows with the square of velocity",
        experiment: "constant speeds over a decade, up to the highest",
        coefficient: "drag_N_s2_per_m2",
        bound: Bound::NonNegative,
        formula: Some(|stated| {
            let v = || Expr::from(Velocity);
            Some(stated.get("drag_N_s2_per_m2")? * v() * v().of(Abs))
        }),
        ..OF_VELOCITY
    },
    force: |s, i| s.v[i] * s.v[i].abs(),
};

/// What every recording may have to a small extent: it stands in every hypothesis, and is named where it is more.
pub static ALWAYS_FREE: &dyn Effect = &channel_delay::ChannelDelay;

/// A line in time, which would be taken for noise where it is not looked for.
pub static VIBRATION: &dyn Effect = &periodic::EXTERNAL_VIBRATION;

/// The effect of an id.
pub fn by_id(id: &str) -> Option<&'static dyn Effect> {
    ALL.into_iter().find(|effect| effect.id() == id)
}

/// Its place in the catalogue: of two, the simpler one has the lower.
pub fn rank(effect: &dyn Effect) -> usize {
    let place = ALL.iter().position(|e| e.id() == effect.id());
    place.unwrap_or(ALL.len())
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
    /// Viscous coefficient (N·s/m or N·m·s/rad).
    pub viscous: f64,
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

/// An effect of the catalogue: physics that a model may lack. One is told by its card and its columns, and by what it has of its own.
pub trait Effect: Sync {
    /// What of it no recording changes.
    fn card(&self) -> &Card;

    /// Columns at the sample rate, linear in their coefficients.
    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column>;

    /// Its [id](Card::id).
    fn id(&self) -> &'static str {
        self.card().id
    }

    /// Its [name](Card::name).
    fn name(&self) -> &'static str {
        self.card().name
    }

    /// What it is, in [words](Card::words).
    fn words(&self) -> &'static str {
        self.card().words
    }

    /// Its [class](Card::class).
    fn class(&self) -> Class {
        self.card().class
    }

    /// Its [axis](Card::axis).
    fn axis(&self) -> Axis {
        self.card().axis
    }

    /// Its [experiment](Card::experiment).
    fn experiment(&self) -> &'static str {
        self.card().experiment
    }

    /// Its [line](Card::line).
    fn line(&self) -> Option<Line> {
        self.card().line
    }

    /// Whether it [passes](Card::is_transient).
    fn is_transient(&self) -> bool {
        self.card().is_transient
    }

    /// Whether it is a line or a narrow place, which chance makes as well: what it takes is held against placebos.
    fn is_narrow(&self) -> bool {
        self.card().is_spot || self.line().is_some()
    }

    /// Whether it follows the motion as hysteresis does, so that what is wrong with the hysteresis looks like it.
    fn is_law(&self) -> bool {
        match self.class() {
            Class::Law => true,
            Class::Drift => self.is_transient(),
            Class::Drive => self.line().is_none(),
            Class::Plain | Class::Place => false,
        }
    }

    /// Its force as a [formula](Card::formula) with these parameters (in the keys of a linear axis), `level` (N or N·m) being that of the recording's
    /// friction.
    fn formula(&self, parameters: &[(String, Estimate)], level: f64) -> Option<Expr> {
        let formula = self.card().formula?;
        formula(&Stated::new(parameters, level))
    }

    /// What the recording [lacks](Card::lacks) to show it.
    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        (self.card().lacks)(s)
    }

    /// What the recording lacks to tell it [well](Card::blurred).
    fn blurred(&self, s: &Signals) -> Option<&'static str> {
        (self.card().blurred)(s)
    }

    /// Ids of effects that no fit to this recording separates from it.
    fn equivalents(&self, s: &Signals) -> Vec<&'static str> {
        let _ = s;
        Vec::new()
    }

    /// Whether it is no larger than what every recording may have.
    fn is_harmless(&self, scene: &Scene, coefficients: &[f64]) -> bool {
        let _ = (scene, coefficients);
        false
    }

    /// Ids of effects that are not offered beside it in such a shape, and whose place it takes: what it contains. Where either contains the other,
    /// each says so.
    fn excludes(&self, shape: &[f64]) -> Vec<&'static str> {
        let _ = shape;
        Vec::new()
    }

    /// Its shape in a model file.
    fn shape_in(&self, entry: &Entry, model: &Model) -> Vec<f64> {
        let _ = model;
        let keys = self.card().shape.iter();
        keys.map(|(key, _)| entry.get(key)).collect()
    }

    /// The nearest shape that a model file holds.
    fn storable(&self, shape: &[f64]) -> Vec<f64> {
        shape.to_vec()
    }

    /// Shapes to try, from what the recording covers; empty where it cannot act, or where lines give them.
    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let _ = scene;
        match self.line() {
            Some(_) => Vec::new(),
            None => vec![Vec::new()],
        }
    }

    /// Shapes from which a simulated effect may find a better one than `shape`, once friction and inertia are known beside it; empty where one
    /// search finds it.
    fn valleys(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        let _ = shape;
        Vec::new()
    }

    /// A simpler simulated effect that a shape of it may be taken for, and its shape.
    fn simpler(&self, shape: &[f64]) -> Option<(&'static dyn Effect, Vec<f64>)> {
        let _ = shape;
        None
    }

    /// A shape parameter brought within what a recording can resolve.
    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let _ = scene;
        shape[index]
    }

    /// Whether coefficients have the sign, or the size, that the physics has.
    fn admits(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        let _ = (shape, coefficients);
        true
    }

    /// Whether a simulation has the effect, too, of another size; `None` where its own effort must tell.
    fn in_simulation(&self, shape: &[f64]) -> Option<bool> {
        let _ = shape;
        None
    }

    /// Parameters with intervals, in the keys of a linear axis: its coefficient and its shape.
    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one(self.card())
    }

    /// Its shapes in a user's model, empty where the model lacks it.
    fn in_model(&self, model: &Model) -> Vec<Vec<f64>> {
        let own = model.effects.iter().filter(|e| e.id() == self.id());
        own.map(|e| self.shape_in(e, model)).collect()
    }

    /// Enters the model file.
    ///
    /// # Errors
    /// Why a model file cannot hold it.
    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
