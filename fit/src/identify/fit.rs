//! The fit that every command reports: its parameters, its law, what it leaves.

use super::Identification;
use crate::recording::{MotionKind, Recording};
use crate::report::figures::{estimate, left};
use crate::report::units::name_and_unit;
use crate::signal::StickSlip;
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Keys of the JSON output for a rigid body parameter.
pub(super) fn key(kind: MotionKind, name: &str) -> &'static str {
    let [linear, rotary] = match name {
        "mass" => ["mass_kg", "inertia_kg_m2"],
        "viscous" => ["viscous_N_s_per_m", "viscous_Nm_s_per_rad"],
        "viscous_forward" => ["viscous_forward_N_s_per_m", "viscous_forward_Nm_s_per_rad"],
        "viscous_backward" => [
            "viscous_backward_N_s_per_m",
            "viscous_backward_Nm_s_per_rad",
        ],
        "coulomb" => ["coulomb_N", "coulomb_Nm"],
        "spring" => ["spring_N_per_m", "spring_Nm_per_rad"],
        "spring_centre" => ["spring_centre_m", "spring_centre_rad"],
        "gravity" => ["gravity_N", "gravity_Nm"],
        "gravity_angle" => ["gravity_angle_rad", "gravity_angle_rad"],
        "breakaway_forward" => ["breakaway_forward_N", "breakaway_forward_Nm"],
        "breakaway_backward" => ["breakaway_backward_N", "breakaway_backward_Nm"],
        "kinetic_forward" => ["kinetic_forward_N", "kinetic_forward_Nm"],
        "kinetic_backward" => ["kinetic_backward_N", "kinetic_backward_Nm"],
        "coulomb_and_inertia" => ["coulomb_and_inertia_N", "coulomb_and_inertia_Nm"],
        "static" => ["static_N", "static_Nm"],
        "stribeck_velocity" => ["stribeck_velocity_m_s", "stribeck_velocity_rad_s"],
        "coulomb_and_offset" => ["coulomb_and_offset_N", "coulomb_and_offset_Nm"],
        _ => ["offset_N", "offset_Nm"],
    };
    match kind {
        MotionKind::Linear => linear,
        MotionKind::Rotary => rotary,
    }
}

/// Unit of a rigid body parameter, for people.
pub(super) fn unit(recording: &Recording, name: &str) -> String {
    name_and_unit(key(recording.kind, name), recording.effort_unit()).1
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
        json!({
            "law": best.model.friction.name(),
            "kind": best.model.friction.kind(),
            "blocks": best.size(),
            "nmse_held_out": best.nmse_test,
            "parameters": self.parameters_json(recording),
            "rows": self.split.folds.iter().map(Vec::len).sum::<usize>(),
            "stick_slip": self.stick_slip,
            "saturation": self.channel.saturation,
            "delay": self.channel.delay,
            "between": self.between,
        })
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
            .map(|(name, estimate)| (key(recording.kind, name).to_owned(), json!(estimate)))
            .collect()
    }
}
