//! What of a model a controller computes beside its friction.

use preslide_fit::effects::Effect;
use preslide_fit::effects::form;
use preslide_fit::model::Model;

/// What stands beside the friction model in a controller: the viscous term, the constant force, the effects.
pub fn carried(model: &Model) -> Vec<Effect> {
    let mut effects = Vec::new();
    if model.viscous != 0.0 {
        effects.push(Effect::of(&form::VISCOUS, &[model.viscous]));
    }
    if model.constant_force != 0.0 {
        effects.push(Effect::of(&form::CONSTANT_FORCE, &[model.constant_force]));
    }
    effects.extend(model.effects.iter().cloned());
    effects
}

/// The same, each with a name of its own: the second of an id has a 2 behind it.
pub(super) fn numbered(effects: &[Effect]) -> impl Iterator<Item = (String, &Effect)> {
    effects.iter().enumerate().map(|(i, effect)| {
        let before = effects[..i].iter().filter(|e| e.id() == effect.id());
        match before.count() {
            0 => (effect.id().to_owned(), effect),
            n => (format!("{}_{}", effect.id(), n + 1), effect),
        }
    })
}
