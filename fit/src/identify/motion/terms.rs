//! What a motion fit may move: the parameters of a body, in groups that come and go together.

use super::body::{Body, Place};
use crate::effects::{Effect, form};
use crate::friction::FrictionModel;
use crate::model::Model;

/// A parameter of [`Body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Term {
    Inertia,
    Viscous,
    Coulomb,
    Offset,
    Slant,
    Spring,
    Sine,
    Cosine,
    Transmitted,
    MotorInertia,
    Stribeck,
    StribeckSpeed,
    Drag,
    Along1,
    Along2,
}

/// What every body has.
pub(super) const RIGID: [Term; 4] = [Term::Inertia, Term::Viscous, Term::Coulomb, Term::Offset];

/// Physics that is tried beside it, with its id in the catalogue.
pub(super) const GROUPS: [(&str, &[Term]); 7] = [
    ("viscous_asymmetry", &[Term::Slant]),
    ("gravity", &[Term::Sine, Term::Cosine]),
    ("position_spring", &[Term::Spring]),
    (
        "load_dependent_friction",
        &[Term::Transmitted, Term::MotorInertia],
    ),
    ("stribeck", &[Term::Stribeck, Term::StribeckSpeed]),
    ("quadratic_drag", &[Term::Drag]),
    ("position_friction", &[Term::Along1, Term::Along2]),
];

/// The sizes that a machine gives its parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    pub(super) inertia: f64,
    /// A force (N or N·m) of friction's size.
    pub(super) force: f64,
    /// `M/b` (s): how long a motion remembers its start.
    pub(super) forgets_s: f64,
    /// The top speed (m/s or rad/s).
    pub(super) speed: f64,
    pub(super) place: Place,
}

/// A parameter's scale is this share of the machine's size for it: starts are scattered by as much.
const SHARE: f64 = 0.1;

impl Term {
    /// What counts as a large change of it (SI).
    pub(super) fn scale(self, sizes: &Sizes) -> f64 {
        let travel = sizes.place.travel[1] - sizes.place.travel[0];
        SHARE
            * match self {
                Self::Inertia => sizes.inertia,
                Self::Viscous | Self::Slant => sizes.force / sizes.speed,
                Self::Coulomb | Self::Stribeck | Self::Offset | Self::Sine | Self::Cosine => {
                    sizes.force
                }
                Self::Spring => sizes.force / travel,
                Self::Transmitted | Self::MotorInertia => 1.0,
                Self::StribeckSpeed => sizes.speed,
                Self::Drag => sizes.force / sizes.speed.powi(2),
                Self::Along1 | Self::Along2 => 0.5,
            }
    }

    /// Where it begins when its group comes in: what has no slope at zero begins beside it.
    pub(super) fn beginning(self, sizes: &Sizes) -> f64 {
        match self {
            Self::Transmitted | Self::MotorInertia | Self::Stribeck | Self::StribeckSpeed => {
                self.scale(sizes)
            }
            _ => 0.0,
        }
    }

    /// Its value in a body; the motor's inertia is a share of the whole.
    pub(super) fn of(self, body: &Body) -> f64 {
        match self {
            Self::Inertia => body.inertia,
            Self::Viscous => body.viscous,
            Self::Coulomb => body.coulomb,
            Self::Offset => body.offset,
            Self::Slant => body.slant,
            Self::Spring => body.spring,
            Self::Sine => body.sine,
            Self::Cosine => body.cosine,
            Self::Transmitted => body.transmitted,
            Self::MotorInertia => body.motor_inertia / body.inertia,
            Self::Stribeck => body.stribeck * body.coulomb,
            Self::StribeckSpeed => body.stribeck_speed,
            Self::Drag => body.drag,
            Self::Along1 => body.along[0],
            Self::Along2 => body.along[1],
        }
    }

    /// Gives a body its value.
    pub(super) fn set(self, body: &mut Body, value: f64) {
        let place = match self {
            Self::Inertia => {
                let share = body.motor_inertia / body.inertia;
                body.motor_inertia = share * value;
                &mut body.inertia
            }
            Self::MotorInertia => {
                body.motor_inertia = value * body.inertia;
                return;
            }
            Self::Viscous => &mut body.viscous,
            Self::Coulomb => &mut body.coulomb,
            Self::Offset => &mut body.offset,
            Self::Slant => &mut body.slant,
            Self::Spring => &mut body.spring,
            Self::Sine => &mut body.sine,
            Self::Cosine => &mut body.cosine,
            Self::Transmitted => &mut body.transmitted,
            Self::Stribeck => {
                // As a force: it stays where the Coulomb force that a model file has it relative to goes.
                body.stribeck = value / body.coulomb;
                return;
            }
            Self::StribeckSpeed => &mut body.stribeck_speed,
            Self::Drag => &mut body.drag,
            Self::Along1 => &mut body.along[0],
            Self::Along2 => &mut body.along[1],
        };
        *place = value;
    }

    /// Its name and its unit's form, for people and for JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Inertia => "mass",
            Self::Viscous => "viscous",
            Self::Coulomb => "coulomb",
            Self::Offset => "offset",
            Self::Slant => "viscous_half_difference",
            Self::Spring => "spring",
            Self::Sine => "gravity_sine",
            Self::Cosine => "gravity_cosine",
            Self::Transmitted => "share_of_transmitted",
            Self::MotorInertia => "motor_share_of_inertia",
            Self::Stribeck => "stribeck",
            Self::StribeckSpeed => "stribeck_velocity",
            Self::Drag => "drag",
            Self::Along1 => "friction_cosine1",
            Self::Along2 => "friction_cosine2",
        }
    }
}

impl Body {
    /// The rigid body, friction and plain physics of a model with Coulomb friction.
    pub(super) fn of(model: &Model, place: &Place) -> Self {
        let mut body = Self {
            inertia: model.inertia,
            viscous: model.viscous,
            coulomb: model.friction.breakaway().unwrap_or(0.0),
            offset: model.constant_force,
            ..Self::default()
        };
        for effect in &model.effects {
            if effect.is(&form::VISCOUS_ASYMMETRY) {
                body.slant = effect.get("half_difference_N_s_per_m");
            }
            if effect.is(&form::GRAVITY) {
                let (sin, cos) = effect.get("angle_rad").sin_cos();
                body.sine = effect.get("force_N") * cos;
                body.cosine = -effect.get("force_N") * sin;
            }
            if effect.is(&form::POSITION_SPRING) {
                body.spring = effect.get("stiffness_N_per_m");
                body.offset += body.spring * (place.middle() - effect.get("centre_m"));
            }
        }
        body
    }

    /// The model file's side of it.
    pub(super) fn model(&self, place: &Place) -> Model {
        let mut effects = Vec::new();
        let mut add = |form, values: &[f64]| effects.push(Effect::of(form, values));
        if self.slant != 0.0 {
            add(&form::VISCOUS_ASYMMETRY, &[self.slant]);
        }
        if self.drag != 0.0 {
            add(&form::QUADRATIC_DRAG, &[self.drag]);
        }
        if self.stribeck > 0.0 {
            add(&form::STRIBECK, &[self.stribeck, self.stribeck_speed, 1.0]);
        }
        let mut constant_force = self.offset;
        if self.spring != 0.0 {
            let centre = place.middle() - self.offset / self.spring;
            add(&form::POSITION_SPRING, &[self.spring, centre]);
            constant_force = 0.0;
        }
        if self.sine != 0.0 || self.cosine != 0.0 {
            let size = self.sine.hypot(self.cosine);
            add(&form::GRAVITY, &[size, (-self.cosine).atan2(self.sine)]);
        }
        if self.transmitted > 0.0 {
            let values = [self.transmitted, self.motor_inertia];
            add(&form::TRANSMITTED_FRICTION, &values);
        }
        let friction = FrictionModel::Coulomb {
            coulomb: self.coulomb,
        };
        if self.along != [0.0; 2] {
            let ([from, to], [one, two]) = (place.travel, self.along);
            let map = [from, to, one, two];
            effects.push(Effect::of(&form::POSITION_FRICTION, &map));
        }
        Model {
            inertia: self.inertia,
            viscous: self.viscous,
            constant_force,
            effects,
            ..Model::of_friction(place.kind, friction)
        }
    }
}
