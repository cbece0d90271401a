//! What a controller cannot use, and leaving it out by name.

use super::Model;
use crate::effects::{Effect, form};

/// The effects of a model that no controller can use, each once with the reason.
pub fn refused(model: &Model) -> Vec<(&'static str, &'static str)> {
    let mut refused = Vec::new();
    for form in model.effects.iter().map(|effect| effect.form) {
        let of_form = form
            .controller
            .as_ref()
            .err()
            .map(|reason| (form.id, *reason));
        refused.extend(of_form.filter(|of_form| !refused.contains(of_form)));
    }
    refused
}

/// The model without the effects named in `without`.
///
/// # Errors
/// A name that is not among the model's effects.
pub fn reduced(model: &Model, without: &[String]) -> Result<Model, String> {
    let mut reduced = model.clone();
    for id in without {
        let before = reduced.effects.len();
        reduced.effects.retain(|effect| effect.id() != id);
        let constant = id == form::CONSTANT_FORCE.id && model.constant_force != 0.0;
        if constant {
            reduced.constant_force = 0.0;
        }
        if !constant && reduced.effects.len() == before {
            let constant = (model.constant_force != 0.0).then_some(form::CONSTANT_FORCE.id);
            let own: Vec<&str> = model
                .effects
                .iter()
                .map(Effect::id)
                .chain(constant)
                .collect();
            let own = if own.is_empty() {
                "none".to_owned()
            } else {
                own.join(", ")
            };
            return Err(format!(
                "--without {id}: the model has no such effect; it has {own}"
            ));
        }
    }
    Ok(reduced)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The option that the refusal names works, however often the model has the effect.
    #[test]
    fn an_effect_is_refused_once() {
        let mut model = Model::parse("schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 1.0\n").unwrap();
        for period in [1e-3, 2e-3] {
            model
                .effects
                .push(Effect::of(&form::TORQUE_RIPPLE, &[0.01, period, 0.0]));
        }
        let ids: Vec<String> = refused(&model).iter().map(|r| r.0.to_owned()).collect();
        assert_eq!(ids, ["torque_ripple"]);
        assert!(reduced(&model, &ids).unwrap().effects.is_empty());
    }
}
