//! Friction that reverses with the speed, as `tanh(v/v₀)`: a law that no model file has. Parameters that are refitted on another law are bent to what
//! that lacks, and so nothing of them is written.

use super::given::{Given, Refitted};
use super::null_model::{Hypothesis, Nmse, NullModel};
use super::verdict::Diagnosis;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;
use preslide_fit::statistics::Estimate;

/// Share of the friction level that must follow the speed for the law to be another.
const MOST: f64 = 0.5;
/// Times what the core leaves that another law must leave at least …
const WORSE: f64 = 2.0;
/// … and by so much more (NMSE, %).
const NOTICED: f64 = 0.1;

/// What the core finds where friction reverses with the speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothLaw {
    /// Speed over which it reverses (m/s or rad/s).
    pub(super) speed: f64,
    /// The friction level (N or N·m).
    coulomb: f64,
    /// Inertia, where the effort has it.
    inertia: Option<f64>,
    viscous: Option<f64>,
}

impl SmoothLaw {
    /// That of a hypothesis on the core; `None` where friction follows the path.
    pub(super) fn of(null: &NullModel, state: &Hypothesis) -> Option<Self> {
        let core = &null.core;
        if !core.follows_velocity() {
            return None;
        }
        let first = core.first_of_friction();
        let own = state.normal.coefficients.get(first..core.rows.len())?;
        let (mut coulomb, mut smooth, mut logarithm) = (0.0, 0.0, 0.0);
        for ((share, reach), column) in own.iter().zip(core.reaches()).zip(0..) {
            coulomb += share * reach;
            if let Some(speed) = core.smooth_of(column) {
                smooth += share;
                logarithm += share * speed.ln();
            }
        }
        let viscous = state.terms.iter().position(|t| {
            let id = t.effect().map(|e| e.id());
            id == Some(form::VISCOUS.id)
        });
        let viscous = viscous.and_then(|index| state.coefficients(index).first().copied());
        let law = Self {
            speed: (logarithm / smooth).exp(),
            coulomb,
            inertia: (first > 0).then(|| state.normal.coefficients[0]),
            viscous,
        };
        (smooth > MOST * coulomb).then_some(law)
    }

    /// The law, where a model that is `judged` has another and lacks it, beside what the core leaves (NMSE, %).
    fn is_lacked(&self, judged: &Given, core: f64) -> bool {
        let own = judged.refitted.test.min(judged.stands);
        own > WORSE * core && own - core > NOTICED
    }

    /// A judgement of a model with another law: as it stands, with the values that its parameters have beside this one.
    pub(super) fn judge(&self, judged: Given, model: &Model, core: f64) -> Given {
        if !self.is_lacked(&judged, core) {
            return judged;
        }
        let stands = judged.stands;
        let beside = |mut p: Refitted| {
            if let Some(value) = self.value_of(&p) {
                p.found = Estimate { value, ci95: None };
            }
            p.differs = false;
            p
        };
        Given {
            refitted: Nmse {
                train: stands,
                test: stands,
            },
            parameters: judged.parameters.into_iter().map(beside).collect(),
            model: model.clone(),
            law: Some(*self),
            ..judged
        }
    }

    fn value_of(&self, parameter: &Refitted) -> Option<f64> {
        match parameter.key.as_str() {
            key if key.starts_with("mass") || key.starts_with("inertia") => self.inertia,
            key if key.starts_with("viscous_N") => self.viscous,
            key if key.starts_with("viscous_half") => None,
            _ if parameter.is_level() => Some(self.coulomb),
            _ => None,
        }
    }

    /// In a clause.
    pub(super) fn words(&self, recording: &Recording) -> String {
        let unit = recording.effort_unit();
        let x = recording.position_unit();
        let speed = quantity(self.speed, &format!("{x}/s"));
        let [inertia, viscous] = [
            ("mass_kg", self.inertia),
            ("viscous_N_s_per_m", self.viscous),
        ]
        .map(|(key, value)| named(recording, key, value?));
        let level = Some(format!("Coulomb {}", quantity(self.coulomb, unit)));
        let own: Vec<String> = [inertia, viscous, level].into_iter().flatten().collect();
        format!(
            "the friction law is another: friction reverses with the speed, over about {speed}, as tanh(v/v0), and not along the path. No model file has this law; beside it {}, and any other law bends these",
            own.join(", ")
        )
    }
}

/// A parameter by its key in model files of linear axes.
fn named(recording: &Recording, key: &str, value: f64) -> Option<String> {
    use preslide_fit::model::key_of;
    use preslide_fit::report::units::name_and_unit;
    let (name, unit) = name_and_unit(&key_of(recording.kind, key), recording.effort_unit());
    Some(format!("{name} {}", quantity(value, &unit)))
}

impl Diagnosis {
    /// The law of the recording's friction, where it reverses with the speed.
    pub(super) fn smooth_law(&self) -> Option<SmoothLaw> {
        SmoothLaw::of(&self.null, &self.states[1])
    }

    /// The same, where the user's model, or the fit's, has another.
    pub(super) fn lacks_law(&self, recording: &Recording) -> Option<SmoothLaw> {
        match &self.given_model {
            Some(given) => given.law,
            None if self.fit.is_some() => {
                let law = self.smooth_law()?;
                let written = self.extended_model(recording);
                written.is_of_another_law.then_some(law)
            }
            None => None,
        }
    }
}
