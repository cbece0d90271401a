//! What can stand beside the core: an effect of the catalogue, a free curve, or a change of the core.

use super::axis::Axis;
use super::change::Change;
use super::curve::Curve;
use super::effect::{ALWAYS_FREE, Effect, Scene};
use super::normal::Bound;
use super::signals::Signals;
use super::weak::Column;

/// What a term is.
#[derive(Clone, Copy)]
pub enum Subject {
    /// An effect of the catalogue.
    Effect(&'static dyn Effect),
    /// A free curve over a coordinate: physics without a name.
    Curve(Curve),
    /// A change of the hysteresis core.
    Change(Change),
}

/// Relative difference of shapes below which two ripples, vibrations or spots are one: two fits of one differ by less.
const NEAR: f64 = 0.05;

/// A subject of a given shape.
#[derive(Clone)]
pub struct Term {
    /// What it is.
    pub subject: Subject,
    /// Shape parameters.
    pub shape: Vec<f64>,
    /// Part of the user's model, or always free: kept, and not reported.
    pub given: bool,
}

impl Term {
    /// A term to be tried.
    pub fn new(subject: Subject, shape: &[f64]) -> Self {
        Self {
            subject,
            shape: shape.to_vec(),
            given: false,
        }
    }

    /// The effect, if it is one.
    pub fn effect(&self) -> Option<&'static dyn Effect> {
        match self.subject {
            Subject::Effect(effect) => Some(effect),
            _ => None,
        }
    }

    /// Whether it is the delay that every recording may have.
    pub fn is_delay(&self) -> bool {
        self.effect().is_some_and(|e| e.id() == ALWAYS_FREE.id())
    }

    /// Whether both are the same effect, curve or change, of whatever shape.
    pub fn is_like(&self, other: &Term) -> bool {
        self.subject.key() == other.subject.key()
    }

    /// Whether both are the same one: another ripple of a machine has another period.
    pub fn is_near(&self, other: &Term) -> bool {
        let own = self.shape.iter().zip(&other.shape);
        let alike = |(a, b): (&f64, &f64)| (a - b).abs() <= NEAR * a.abs().max(b.abs());
        let recurs = self.effect().is_some_and(|e| e.card().recurs);
        self.is_like(other) && (!recurs || own.into_iter().all(alike))
    }

    /// Columns at the samples.
    pub fn columns(&self, scene: &Scene) -> Vec<Column> {
        match self.subject {
            Subject::Effect(effect) => effect.columns(&self.shape, scene),
            Subject::Curve(curve) => curve.columns(scene),
            Subject::Change(change) => change.columns(scene),
        }
    }

    /// How its coefficients are bound in a fit.
    pub fn bound(&self) -> Bound {
        match self.subject {
            Subject::Effect(effect) => effect.card().bound,
            Subject::Change(change) => change.bound(),
            Subject::Curve(_) => Bound::Free,
        }
    }

    /// Whether coefficients are what the physics admits.
    pub fn admits(&self, coefficients: &[f64]) -> bool {
        match self.subject {
            Subject::Effect(effect) => effect.admits(&self.shape, coefficients),
            // What damps takes work, and never gives it.
            Subject::Change(Change::Damped) => coefficients.iter().all(|c| *c >= 0.0),
            _ => true,
        }
    }

    /// Whether it is a free curve over velocity or speed: while the machine slides nothing separates it from friction itself.
    pub fn is_free_over_speed(&self) -> bool {
        matches!(self.subject, Subject::Curve(c) if matches!(c.axis, Axis::Velocity | Axis::Speed))
    }

    /// Whether it is a change of the friction level: with friction mirrored, its force is. What it does along the motion on the whole does
    /// not tell, since a level that is higher here and lower there adds nothing to the mean.
    pub fn is_level(&self, scene: &Scene) -> bool {
        let mut mirrored = scene.core.clone();
        mirrored.friction.iter_mut().for_each(|f| *f = -*f);
        let mirrored = self.columns(&Scene {
            core: &mirrored,
            ..*scene
        });
        let flips = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| *a == -*b);
        let own = self.columns(scene);
        own.iter().zip(&mirrored).all(|(a, b)| {
            flips(&a.value, &b.value) && flips(&a.sloped, &b.sloped) && flips(&a.curved, &b.curved)
        })
    }

    /// Whether its columns are made of the effort itself.
    pub fn acts_on_effort(&self) -> bool {
        self.effect().is_some_and(|e| e.card().acts_on_effort)
    }
}

impl Subject {
    /// Its name in reports: an effect's id, or what the curve or change is.
    pub fn name(&self, s: &Signals) -> String {
        match self {
            Self::Effect(effect) => effect.id().to_owned(),
            Self::Curve(curve) => format!(
                "{} over {}",
                if curve.odd { "friction level" } else { "force" },
                curve.axis.name(s)
            ),
            Self::Change(change) => change.name().to_owned(),
        }
    }

    /// What separates one subject from another.
    pub fn key(&self) -> String {
        match self {
            Self::Effect(effect) => effect.id().to_owned(),
            Self::Curve(curve) => format!("curve {curve:?}"),
            Self::Change(change) => format!("change {change:?}"),
        }
    }
}
