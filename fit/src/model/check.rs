//! What a model file may say: numbers that a machine can have, and parameters that the library takes.

use super::Model;
use crate::effects::form;
use crate::friction::Path;
use crate::recording::MotionKind;

/// Largest magnitude of a parameter, in SI: what is beyond is a broken number, and its products are infinite.
const ABSURD: f64 = 1e15;

/// The key that is wrong, and why.
type Wrong = (String, String);

fn wrong(key: &str, reason: String) -> Result<(), Wrong> {
    Err((key.to_owned(), reason))
}

impl Model {
    /// The first key that is wrong, in the words of a linear axis, and why.
    pub(super) fn check(&self) -> Result<(), Wrong> {
        self.body()?;
        self.magnitudes()?;
        self.lengths()?;
        if self.motion == MotionKind::Linear && self.of(&form::GRAVITY).next().is_some() {
            return wrong(
                "effects.id",
                "gravity changes with the angle of a rotary axis; on a linear one it is a constant_force with force_N".to_owned(),
            );
        }
        // The library is the judge of the friction parameters; one step of no motion builds the model.
        let still = Path {
            position: &[0.0],
            velocity: &[0.0],
            pieces: std::slice::from_ref(&(0..1)),
            sample_time: 1e-3,
        };
        match self.friction.force(still) {
            Ok(_) => Ok(()),
            Err(e) => wrong("friction", e.to_string()),
        }
    }

    /// The rigid body's parameters are numbers, and its inertia is not negative.
    fn body(&self) -> Result<(), Wrong> {
        if !(self.inertia.is_finite() && self.inertia >= 0.0) {
            return wrong(
                "inertia.mass_kg",
                format!("{} must be finite and not negative", self.inertia),
            );
        }
        for (key, value) in [
            ("friction.viscous_N_s_per_m", self.viscous),
            ("effects.force_N", self.constant_force),
        ] {
            if !value.is_finite() {
                return wrong(key, format!("{value} must be finite"));
            }
        }
        Ok(())
    }

    /// No parameter is beyond [`ABSURD`]; one without end is let through: an attraction of a friction model without lag.
    fn magnitudes(&self) -> Result<(), Wrong> {
        let effects = self.effects.iter().enumerate();
        let of_effects = effects.flat_map(|(i, e)| {
            let named =
                move |(key, value): &(String, f64)| (format!("effects[{}].{key}", i + 1), *value);
            e.values.iter().map(named)
        });
        let of_blocks = self
            .friction
            .blocks()
            .iter()
            .map(|b| ("friction.blocks.stiffness_N_per_m".to_owned(), b.stiffness));
        let scalars = self.friction.scalars().into_iter();
        let mut named = scalars
            .map(|(key, value)| (format!("friction.{key}"), value))
            .chain(of_blocks)
            .chain(of_effects)
            .chain([
                ("inertia.mass_kg".to_owned(), self.inertia),
                ("friction.viscous_N_s_per_m".to_owned(), self.viscous),
                ("effects.force_N".to_owned(), self.constant_force),
            ]);
        match named.find(|(_, value)| value.is_finite() && value.abs() > ABSURD) {
            Some((key, value)) => wrong(
                &key,
                format!(
                    "{value:e} is beyond {ABSURD:e}, which no machine has; check the number and its unit"
                ),
            ),
            None => Ok(()),
        }
    }

    /// The known lengths of the drive are lengths.
    fn lengths(&self) -> Result<(), Wrong> {
        let length = |value: f64| value.is_finite() && value > 0.0;
        match self.mechanics.iter().find(|(_, value)| !length(*value)) {
            Some((key, value)) => wrong(
                &format!("mechanics.{key}"),
                format!("{value} must be finite and above zero"),
            ),
            None => Ok(()),
        }
    }
}
