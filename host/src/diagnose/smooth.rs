//! Friction that reverses with the speed, as `tanh(v/v₀)`: a law that no model file has. Parameters that are refitted on another law are bent to what
//! that lacks, and so nothing of them is written.

use super::null_model::{Hypothesis, NullModel};
use preslide_fit::effects::form;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;

/// Share of the friction level that must follow the speed for the law to be another.
const MOST: f64 = 0.5;

/// What the core finds where friction reverses with the speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothLaw {
    /// Speed over which it reverses (m/s or rad/s).
    pub(super) speed: f64,
    /// The friction level (N or N·m).
    pub(super) coulomb: f64,
    /// Inertia, where the effort has it.
    pub(super) inertia: Option<f64>,
    pub(super) viscous: Option<f64>,
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
