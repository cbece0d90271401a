//! What a controller cannot use, and leaving it out by name.

use super::Model;
use crate::effects::{Effect, form};

/// The effects of a model that no controller can use, each with the reason.
pub fn refused(model: &Model) -> Vec<(&'static str, &'static str)> {
    let forms = model.effects.iter().map(|effect| effect.form);
    forms
        .filter_map(|form| Some((form.id, form.controller.as_ref().err().copied()?)))
        .collect()
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
            let own: Vec<&str> = model.effects.iter().map(Effect::id).collect();
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
