//! What a controller cannot use, and leaving it out by name.

use super::Model;

/// Why a controller cannot use an effect; `None` where it can.
fn reason(id: &str) -> Option<&'static str> {
    Some(match id {
        "channel_delay" => {
            "it is a matter of the recording: the force was sampled later than the position"
        }
        "drive_compliance" => "it needs the second derivative of the friction force",
        "backlash" => "crossing the gap takes a move of the motor, not a force",
        "creep" => "its feed-forward would push an axis that rests",
        "actuator_dead_zone" | "actuator_saturation" => {
            "it is a property of the drive; set it in the controller's settings"
        }
        "external_vibration" => {
            "its phase is that of the recording's clock, which the controller does not know"
        }
        "run_in" => {
            "it counts from the first sample of the recording and would begin anew whenever the controller starts"
        }
        _ => return None,
    })
}

/// The effects of a model that no controller can use, each with the reason.
pub fn refused(model: &Model) -> Vec<(&'static str, &'static str)> {
    let of = |id| reason(id).map(|reason| (id, reason));
    model.effects.iter().filter_map(|e| of(e.id)).collect()
}

/// The model without the effects named in `without`.
///
/// # Errors
/// A name that is not among the model's effects.
pub fn reduced(model: &Model, without: &[String]) -> Result<Model, String> {
    let mut reduced = model.clone();
    for id in without {
        let before = reduced.effects.len();
        reduced.effects.retain(|effect| effect.id != id);
        let constant = id == "constant_force" && model.constant_force != 0.0;
        if constant {
            reduced.constant_force = 0.0;
        }
        if !constant && reduced.effects.len() == before {
            let own: Vec<&str> = model.effects.iter().map(|e| e.id).collect();
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
