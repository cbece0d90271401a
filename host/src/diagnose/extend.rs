//! The model file that a diagnosis ends in: the confident effects on the refitted core.

use super::parameters::parameters;
use super::verdict::Diagnosis;
use crate::friction::{FrictionModel, MOST_BLOCKS};
use crate::model::Model;
use crate::recording::Recording;

impl Diagnosis {
    /// The extended model, and the effects that no model file can hold, with the reason. Against a simulation the effects are what it
    /// lacks, and inertia and friction are the recording's own, which their levels refer to.
    pub fn extended_model(
        &self,
        recording: &Recording,
        user: Option<&Model>,
    ) -> (Model, Vec<String>) {
        let ground = &self.ground;
        let mut terms = self.states[1].terms.clone();
        for term in &mut terms {
            if let Some(effect) = term.effect() {
                term.shape = effect.storable(&term.shape);
            }
        }
        let refitted = ground.fit(&terms);
        let state = refitted.as_ref().unwrap_or(&self.states[1]);
        let inertia = match state.normal.coefficients.first() {
            Some(_) if ground.core.corrects => ground.baseline.mass,
            Some(mass) if ground.rows.inertial => *mass,
            _ => 0.0,
        };
        let mut blocks = if ground.core.corrects {
            ground.baseline.blocks.clone()
        } else {
            ground.blocks(state)
        };
        // The library takes so many blocks: the weakest give way.
        blocks.sort_by(|a, b| (b.0 * b.1).total_cmp(&(a.0 * a.1)));
        blocks.truncate(MOST_BLOCKS);
        blocks.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (stiffness, yields): (Vec<f64>, Vec<f64>) = blocks.into_iter().unzip();
        let mut model = Model {
            inertia,
            mechanics: user.map(|m| m.mechanics.clone()).unwrap_or_default(),
            ..Model::of_friction(
                recording.kind,
                FrictionModel::maxwell_slip(&stiffness, &yields),
            )
        };
        let mut refused = Vec::new();
        for (index, term) in state.terms.iter().enumerate() {
            let Some(effect) = term.effect() else {
                continue;
            };
            let values = parameters(ground, state, index);
            if let Err(reason) = effect.extend(&values, &mut model) {
                refused.push(format!("{}: {reason}", effect.id()));
            }
        }
        (model, refused)
    }
}
