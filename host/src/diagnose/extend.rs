//! The model file that a diagnosis ends in: the confident effects on the refitted baseline.

use super::conclude::Diagnosis;
use super::parameters::parameters;
use super::study::{State, Study};
use crate::effects::Effect;
use crate::friction::{FrictionModel, MOST_BLOCKS};
use crate::model::Model;
use crate::recording::Recording;
use std::f64::consts::FRAC_PI_2;

impl Diagnosis {
    /// The extended model, and the effects that no model file can hold, with the reason.
    pub fn extended_model(
        &self,
        study: &Study,
        recording: &Recording,
        user: Option<&Model>,
    ) -> (Model, Vec<String>) {
        let tabulable = tabulable(study, &self.states[1]);
        let state = tabulable.as_ref().unwrap_or(&self.states[1]);
        let mut blocks = study.blocks(&state.fit);
        // The library takes so many blocks: the weakest give way.
        blocks.sort_by(|a, b| (b.0 * b.1).total_cmp(&(a.0 * a.1)));
        blocks.truncate(MOST_BLOCKS);
        blocks.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (stiffness, yields): (Vec<f64>, Vec<f64>) = blocks.into_iter().unzip();
        let mut model = Model {
            inertia: if study.inertial {
                state.fit.coefficients[0]
            } else {
                0.0
            },
            mechanics: user.map(|m| m.mechanics.clone()).unwrap_or_default(),
            ..Model::of_friction(
                recording.kind,
                FrictionModel::maxwell_slip(&stiffness, &yields),
            )
        };
        let mut refused = Vec::new();
        for (index, term) in state.terms.iter().enumerate() {
            let estimates = parameters(study, state, index);
            // The mean of a map of force.
            model.constant_force += estimates
                .iter()
                .filter(|(key, _)| key == "constant_N")
                .map(|(_, e)| e.value)
                .sum::<f64>();
            let values: Vec<(&str, f64)> = estimates
                .iter()
                .filter(|(key, _)| !INTERNAL.contains(&(term.id, key.as_str())))
                .map(|(key, e)| {
                    // The catalogue's vibration is a sine.
                    let sine = term.id == "external_vibration" && key == "phase_rad";
                    (key.as_str(), e.value + if sine { FRAC_PI_2 } else { 0.0 })
                })
                .collect();
            match (term.id, values.first()) {
                ("viscous", Some((_, value))) => model.viscous += value,
                ("constant_force", Some((_, value))) => model.constant_force += value,
                (id, _) => match Effect::new(id, &values) {
                    Ok(effect) => model.effects.push(effect),
                    Err(reason) => refused.push(format!("{id}: {reason}")),
                },
            }
        }
        (model, refused)
    }
}

/// The hypothesis with Stribeck exponents that the library tabulates, 1 and above, all coefficients fitted again; `None` where
/// all are.
fn tabulable(study: &Study, state: &State) -> Option<State> {
    let mut terms = state.terms.clone();
    let mut steep = terms
        .iter_mut()
        .filter(|t| matches!(t.id, "stribeck" | "frictional_lag") && t.shape[1] < 1.0)
        .peekable();
    steep.peek()?;
    steep.for_each(|term| term.shape[1] = 1.0);
    study.fit_with(&terms, state.noise.clone())
}

/// Keys of the diagnosis that a model file has no use for.
const INTERNAL: [(&str, &str); 8] = [
    ("position_force", "constant_N"),
    ("stribeck", "slipping_only"),
    ("position_force", "terms"),
    ("position_friction", "terms"),
    ("drive_compliance", "stiffness_N_per_m"),
    ("drive_compliance", "motor_share"),
    ("actuator_saturation", "share"),
    ("backlash", "share"),
];
