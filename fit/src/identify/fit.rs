//! The fit that every command reports: its parameters, its law, what it leaves.

use super::Identification;
use crate::model::{key_of, keys_of};
use crate::recording::{MotionKind, Recording};
use crate::report::figures::{estimate, left};
use crate::report::units::name_and_unit;
use crate::signal::StickSlip;
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Key of an answer for machines for a parameter of a fit.
pub(super) fn key(kind: MotionKind, name: &str) -> String {
    let unit = match name {
        "mass" => "kg",
        "drag" => "N_s2_per_m2",
        "share_of_transmitted"
        | "motor_share_of_inertia"
        | "friction_cosine1"
        | "friction_cosine2"
        | "stribeck_exponent" => return name.to_owned(),
        _ if name.starts_with("viscous") => "N_s_per_m",
        "spring" => "N_per_m",
        "spring_centre" => "m",
        "gravity_angle" => "rad",
        "stribeck_velocity" => "m_s",
        _ => "N",
    };
    key_of(kind, &format!("{name}_{unit}"))
}

/// Unit of a rigid body parameter, for people.
pub(super) fn unit(recording: &Recording, name: &str) -> String {
    name_and_unit(&key(recording.kind, name), recording.effort_unit()).1
}

/// A rigid body parameter's name for people.
pub(super) fn shown(recording: &Recording, name: &str) -> String {
    match (name, recording.kind) {
        ("mass", MotionKind::Rotary) => "inertia".to_owned(),
        (name, _) => name.replace('_', " "),
    }
}

impl Identification {
    /// What every command reports of a fit: the error that the recommended law leaves of what was held out (%), its parameters with their
    /// intervals, the law by its kind and number of blocks, and the rows that were fitted.
    pub fn fit_json(&self, recording: &Recording) -> Value {
        let best = self.best();
        let answer = json!({
            "law": best.model.friction.name(),
            "kind": best.model.friction.kind(),
            "blocks": best.size(),
            "nmse_held_out": best.nmse_test,
            "parameters": self.parameters_json(recording),
            "rows": self.split.folds.iter().map(Vec::len).sum::<usize>(),
            "stick_slip": self.stick_slip,
            "saturation": self.channel.saturation,
            "delay": self.channel.delay,
            "between": self.between.iter().map(|change| change.to_json(recording.kind)).collect::<Vec<_>>(),
        });
        keys_of(recording.kind, answer)
    }

    /// The fit in one sentence, without its full stop.
    pub fn in_words(&self, recording: &Recording) -> String {
        let parameter = |(name, e): (&'static str, Estimate)| {
            let unit = unit(recording, name);
            let size = estimate(e.value, e.ci95, &unit);
            format!("{} {size}", shown(recording, name))
        };
        let parameters: Vec<String> = self.parameters().map(parameter).collect();
        let best = self.best();
        format!(
            "{}, {} of the variance left on held-out data; {}",
            best.model.friction.name(),
            left(best.nmse_test),
            parameters.join(", ")
        )
    }

    /// Of the rigid body, and of stick and slip.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&'static str, Estimate)> {
        let levels = self.stick_slip.iter().flat_map(StickSlip::parameters);
        self.best().rigid_body.iter().copied().chain(levels)
    }

    pub(super) fn parameters_json(&self, recording: &Recording) -> serde_json::Map<String, Value> {
        self.parameters()
            .map(|(name, estimate)| (key(recording.kind, name), json!(estimate)))
            .collect()
    }
}
