//! Plain physics beside hysteresis: inertia, viscous friction (of each direction), a constant force, a spring or gravity. All of it is
//! linear in its coefficients.

use super::regression::Regressor;
use crate::effects::{Effect, form};
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::recording::{EffortRole, MotionKind, Recording};
use crate::signal::Kinematics;
use crate::statistics::Estimate;
use nalgebra::{DMatrix, DVector};

/// A force that follows the position alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// None.
    Nowhere,
    /// `κ·(x − x0)`.
    Spring,
    /// `A·sin(q − q0)`, of a rotary axis.
    Gravity,
}

/// What acts beside hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plain {
    /// Inertia.
    pub mass: bool,
    /// Viscous friction.
    pub viscous: bool,
    /// It differs by direction.
    pub by_direction: bool,
    /// What follows the position.
    pub place: Place,
}

/// A column, by its coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Term {
    Mass,
    Viscous,
    Offset,
    /// On `|v|`: half of what viscous friction forwards has more than backwards.
    Slant,
    /// On the position from the middle of the travel.
    Spring,
    Cosine,
    Sine,
}

impl Term {
    fn name(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Viscous => "viscous",
            Self::Offset => "offset",
            Self::Slant => "viscous_half_difference",
            Self::Spring => "spring",
            Self::Cosine => "cosine",
            Self::Sine => "sine",
        }
    }
}

/// Coefficients with what a finished model makes of them: a value, and its slope over each coefficient.
type Derived = (&'static str, f64, Vec<(Term, f64)>);

impl Plain {
    /// What every fit has.
    pub fn of(inertial: bool) -> Self {
        Self {
            mass: inertial,
            viscous: true,
            by_direction: false,
            place: Place::Nowhere,
        }
    }

    fn terms(self) -> impl Iterator<Item = Term> {
        let place: &[Term] = match self.place {
            Place::Nowhere => &[],
            Place::Spring => &[Term::Spring],
            Place::Gravity => &[Term::Cosine, Term::Sine],
        };
        [
            self.mass.then_some(Term::Mass),
            self.viscous.then_some(Term::Viscous),
            Some(Term::Offset),
            self.by_direction.then_some(Term::Slant),
        ]
        .into_iter()
        .flatten()
        .chain(place.iter().copied())
    }

    /// The columns, filtered as the effort is where it contains inertia.
    pub fn columns(self, recording: &Recording, kinematics: &Kinematics) -> Vec<Regressor> {
        self.terms()
            .map(|term| column(term, recording, kinematics))
            .collect()
    }

    /// Numbers of its columns among those of [`every_column`].
    pub fn among(self, every: &[Regressor]) -> Vec<usize> {
        let number = |term: Term| every.iter().position(|c| c.name == term.name());
        self.terms().filter_map(number).collect()
    }

    /// A model of this friction with the coefficients of the columns.
    pub fn model(self, recording: &Recording, friction: FrictionModel, linear: &[f64]) -> Model {
        let of = |term| self.coefficient(linear, term);
        let mut model = Model {
            effort_unit: recording.role.other_unit(),
            inertia: of(Term::Mass),
            viscous: of(Term::Viscous),
            constant_force: of(Term::Offset),
            ..Model::of_friction(recording.kind, friction)
        };
        let derived = self.derived(recording, linear);
        let value = |name| derived.iter().find(|d| d.0 == name).map_or(0.0, |d| d.1);
        let mut add = |form, values: &[f64]| model.effects.push(Effect::of(form, values));
        if self.by_direction {
            add(&form::VISCOUS_ASYMMETRY, &[of(Term::Slant)]);
        }
        match self.place {
            Place::Nowhere => {}
            Place::Gravity => add(&form::GRAVITY, &[value("gravity"), value("gravity_angle")]),
            Place::Spring => {
                add(
                    &form::POSITION_SPRING,
                    &[value("spring"), value("spring_centre")],
                );
                // The spring's centre holds it.
                model.constant_force = 0.0;
            }
        }
        model
    }

    /// What a person reads of the coefficients, with intervals from their covariance over so many folds.
    pub fn parameters(
        self,
        recording: &Recording,
        linear: &[f64],
        covariance: Option<&DMatrix<f64>>,
        folds: usize,
    ) -> Vec<(&'static str, Estimate)> {
        let numbers: Vec<Term> = self.terms().collect();
        let error = |slopes: &[(Term, f64)]| {
            let mut slope = DVector::zeros(numbers.len());
            for (term, by) in slopes {
                slope[numbers.iter().position(|t| t == term)?] += by;
            }
            let own = covariance?.view((0, 0), (numbers.len(), numbers.len()));
            Some((own * &slope).dot(&slope).max(0.0).sqrt())
        };
        self.derived(recording, linear)
            .into_iter()
            .map(|(name, value, slopes)| {
                let mut told = Estimate::new(value, error(&slopes), folds);
                if let ("mass", Some([low, high])) = (name, &mut told.ci95) {
                    let unseen = self.coefficient(linear, Term::Viscous).abs() * held(recording);
                    (*low, *high) = (*low - unseen, *high + unseen);
                }
                (name, told)
            })
            .collect()
    }

    fn coefficient(self, linear: &[f64], term: Term) -> f64 {
        let at = self.terms().position(|t| t == term);
        at.and_then(|at| linear.get(at)).copied().unwrap_or(0.0)
    }

    fn derived(self, recording: &Recording, linear: &[f64]) -> Vec<Derived> {
        let of = |term| self.coefficient(linear, term);
        let mut derived: Vec<Derived> = Vec::new();
        for term in [Term::Mass, Term::Viscous] {
            if self.terms().any(|t| t == term) {
                derived.push((term.name(), of(term), vec![(term, 1.0)]));
            }
        }
        if self.by_direction {
            for (name, sign) in [("viscous_forward", 1.0), ("viscous_backward", -1.0)] {
                let value = of(Term::Viscous) + sign * of(Term::Slant);
                derived.push((name, value, vec![(Term::Viscous, 1.0), (Term::Slant, sign)]));
            }
        }
        match self.place {
            Place::Nowhere => derived.push(("offset", of(Term::Offset), vec![(Term::Offset, 1.0)])),
            Place::Spring => {
                let (middle, slope, offset) =
                    (middle(recording), of(Term::Spring), of(Term::Offset));
                // At the position 0.
                let slopes = vec![(Term::Offset, 1.0), (Term::Spring, -middle)];
                derived.push(("offset", offset - slope * middle, slopes));
                derived.push(("spring", slope, vec![(Term::Spring, 1.0)]));
                let slopes = vec![
                    (Term::Offset, -1.0 / slope),
                    (Term::Spring, offset / (slope * slope)),
                ];
                derived.push(("spring_centre", middle - offset / slope, slopes));
            }
            Place::Gravity => {
                derived.push(("offset", of(Term::Offset), vec![(Term::Offset, 1.0)]));
                // A·sin(q − q0) = A·cos q0·sin q − A·sin q0·cos q.
                let (c, s) = (of(Term::Cosine), of(Term::Sine));
                let amplitude = c.hypot(s);
                let slopes = vec![(Term::Cosine, c / amplitude), (Term::Sine, s / amplitude)];
                derived.push(("gravity", amplitude, slopes));
                let square = amplitude * amplitude;
                let slopes = vec![(Term::Cosine, -s / square), (Term::Sine, c / square)];
                derived.push(("gravity_angle", (-c).atan2(s), slopes));
            }
        }
        derived
    }
}

/// How late (s) an effort may act on the mean after it is written: a voltage is a command that holds until the next one. A delay `δ` of it and an
/// inertia of `viscous·δ` are one.
fn held(recording: &Recording) -> f64 {
    match recording.role {
        EffortRole::Voltage => 0.5 * recording.sample_time_s(),
        _ => 0.0,
    }
}

/// Every column that a recording could need; a fit takes some of them.
pub fn every_column(recording: &Recording, kinematics: &Kinematics) -> Vec<Regressor> {
    let inertial = recording.role.contains_inertia();
    let mut terms = vec![Term::Viscous, Term::Offset, Term::Slant, Term::Spring];
    if inertial {
        terms.insert(0, Term::Mass);
    }
    if recording.kind == MotionKind::Rotary {
        terms.extend([Term::Cosine, Term::Sine]);
    }
    terms
        .into_iter()
        .map(|term| column(term, recording, kinematics))
        .collect()
}

fn column(term: Term, recording: &Recording, kinematics: &Kinematics) -> Regressor {
    let of = |values: &[f64], f: &dyn Fn(f64) -> f64| {
        let column: Vec<f64> = values.iter().map(|v| f(*v)).collect();
        match recording.role.contains_inertia() {
            true => kinematics.filter.smooth(&column),
            false => column,
        }
    };
    let q = &recording.position;
    let middle = middle(recording);
    Regressor {
        name: term.name(),
        values: match term {
            // Noise in a regressor takes its share off the coefficient, and nothing off the force.
            Term::Mass => (kinematics.acceleration.iter())
                .map(|a| kinematics.reliable * a)
                .collect(),
            Term::Viscous => kinematics.velocity.clone(),
            Term::Offset => vec![1.0; recording.len()],
            Term::Slant => of(&kinematics.velocity, &f64::abs),
            Term::Spring => of(q, &|x| x - middle),
            Term::Cosine => of(q, &f64::cos),
            Term::Sine => of(q, &f64::sin),
        },
    }
}

fn middle(recording: &Recording) -> f64 {
    let (low, high) = recording.ends();
    0.5 * (low + high)
}
