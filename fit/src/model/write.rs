//! The text of a model file.
//!
//! Written by hand and not with `serde`: its head is comments, the axis's kind decides the keys, each block has a line, and
//! numbers stand as Rust writes them (`1e-7`), shorter than TOML's libraries do.

use super::{Model, SCHEMA};
use crate::effects::{Effect, form};
use preslide::Block;
use std::fmt::Write as _;

impl Model {
    /// The text of the model file. `remarks` become comments at its head.
    pub fn to_toml(&self, remarks: &[String]) -> String {
        let mut text = String::new();
        for line in remarks.iter().flat_map(|remark| remark.lines()) {
            let _ = writeln!(text, "# {line}");
        }
        let motion = self.motion.name();
        let _ = writeln!(text, "schema = \"{SCHEMA}\"\nmotion = \"{motion}\"");
        if let Some(unit) = self.effort_unit {
            let _ = writeln!(text, "effort_unit = \"{unit}\"");
        }
        if self.inertia > 0.0 {
            text.push_str("\n[inertia]\n");
            self.write(&mut text, "mass_kg", self.inertia);
        }
        self.write_friction(&mut text);
        if !self.mechanics.is_empty() {
            text.push_str("\n[mechanics]\n");
            for (key, value) in &self.mechanics {
                self.write(&mut text, key, *value);
            }
        }
        if self.constant_force != 0.0 {
            let constant = Effect::of(&form::CONSTANT_FORCE, &[self.constant_force]);
            self.write_effect(&mut text, &constant);
        }
        for effect in &self.effects {
            self.write_effect(&mut text, effect);
        }
        text
    }

    fn write_friction(&self, text: &mut String) {
        let _ = writeln!(text, "\n[friction]\nkind = \"{}\"", self.friction.kind());
        for (key, value) in self.friction.scalars() {
            self.write(text, key, value);
        }
        let blocks = self.friction.blocks();
        if !blocks.is_empty() {
            let stiffness_key = self.key("stiffness_N_per_m");
            text.push_str("blocks = [\n");
            for &Block { stiffness, weight } in blocks {
                let _ = writeln!(
                    text,
                    "  {{ {stiffness_key} = {}, weight = {} }},",
                    number(stiffness),
                    number(weight)
                );
            }
            text.push_str("]\n");
        }
        self.write(text, "viscous_N_s_per_m", self.viscous);
    }

    fn write_effect(&self, text: &mut String, effect: &Effect) {
        let _ = writeln!(text, "\n[[effects]]\nid = \"{}\"", effect.id());
        for (key, value) in &effect.values {
            self.write(text, key, *value);
        }
    }

    /// A key of a linear axis, in this model's words, with its value.
    fn write(&self, text: &mut String, key: &str, value: f64) {
        let _ = writeln!(text, "{} = {}", self.key(key), number(value));
    }
}

/// A float that TOML reads back as the same float.
fn number(value: f64) -> String {
    format!("{value:?}")
}
