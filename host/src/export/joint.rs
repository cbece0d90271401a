//! A model as a joint of a simulator: what the format holds, and in words what it does not.
//!
//! MuJoCo (MJCF) holds `inertia·a + damping·v + frictionloss·sgn v + stiffness·(x − springref)` with a bound of the actuator's force; URDF
//! `damping·v + friction·sgn v`. Both friction levels are that in sliding.

use crate::effects::Effect;
use crate::effects::form::{self, Form};
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::recording::MotionKind;
use std::fmt::Write as _;

/// Whose joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's.
    Mjcf,
    /// ROS's.
    Urdf,
}

/// A joint.
#[derive(Clone, Debug)]
pub struct Joint {
    /// What the format holds.
    pub model: Model,
    /// What it does not hold, a clause each.
    pub left_out: Vec<String>,
    format: Format,
}

/// Standard gravity (m/s²), which makes a mass and a lever of a torque.
const GRAVITY: f64 = 9.806_65;

/// Time constant (s) and damping ratio of dry friction in MuJoCo. With its own, 0.02 s, a joint at rest creeps; this is the least for its own
/// time step, 2 ms.
const SOLREF: &str = "0.004 1";

/// What a joint of MuJoCo holds beside friction and inertia.
static OF_MJCF: [&Form; 2] = [&form::POSITION_SPRING, &form::ACTUATOR_SATURATION];

impl Joint {
    /// What of a model a format holds.
    ///
    /// # Errors
    /// A friction model without a level in sliding.
    pub fn of(model: &Model, format: Format) -> Result<Self, String> {
        let mut left_out = Vec::new();
        let coulomb = level(model, &mut left_out)?;
        let unit = effort(model);
        if model.constant_force != 0.0 {
            left_out.push(format!(
                "constant_force, {} {unit}: add it to the actuator's force, or tilt the axis",
                model.constant_force
            ));
        }
        if format == Format::Urdf && model.inertia > 0.0 {
            left_out.push(format!(
                "inertia, {} {}: URDF has it in the `<inertial>` of the links that move, of which this is the whole",
                model.inertia,
                match model.motion {
                    MotionKind::Linear => "kg",
                    MotionKind::Rotary => "kg·m²",
                }
            ));
        }
        let holds = |effect: &&Effect| format == Format::Mjcf && OF_MJCF.contains(&effect.form);
        let (held, rest): (Vec<&Effect>, Vec<&Effect>) = model.effects.iter().partition(holds);
        left_out.extend(rest.into_iter().map(|effect| words(effect, unit)));
        Ok(Self {
            model: Model {
                inertia: match format {
                    Format::Mjcf => model.inertia,
                    Format::Urdf => 0.0,
                },
                viscous: model.viscous,
                effects: held.into_iter().cloned().collect(),
                mechanics: model.mechanics.clone(),
                ..Model::of_friction(model.motion, FrictionModel::Coulomb { coulomb })
            },
            left_out,
            format,
        })
    }

    /// The joint's element, with `remarks` and what is left out in comments above it.
    pub fn to_xml(&self, remarks: &[String]) -> String {
        let model = &self.model;
        let mut text = String::new();
        let left_out = self
            .left_out
            .iter()
            .map(|clause| format!("Not in it: {clause}."));
        for line in remarks.iter().cloned().chain(left_out) {
            // Two hyphens end a comment.
            let _ = writeln!(text, "<!-- {} -->", line.trim().replace("--", "‑‑"));
        }
        let level = model.friction.breakaway().unwrap_or_default();
        match self.format {
            Format::Urdf => {
                let kind = match model.motion {
                    MotionKind::Linear => "prismatic",
                    MotionKind::Rotary => "continuous",
                };
                let _ = write!(
                    text,
                    "<joint name=\"axis\" type=\"{kind}\">\n  <!-- parent, child, origin, axis and limit are yours -->\n  <dynamics damping=\"{}\" friction=\"{level}\"/>\n</joint>\n",
                    model.viscous
                );
            }
            Format::Mjcf => self.mjcf(level, &mut text),
        }
        text
    }

    /// What stands in a body of MuJoCo.
    fn mjcf(&self, level: f64, text: &mut String) {
        let Model {
            inertia, viscous, ..
        } = self.model;
        let is_linear = self.model.motion == MotionKind::Linear;
        let kind = if is_linear { "slide" } else { "hinge" };
        let mut joint = format!(
            "<joint name=\"axis\" type=\"{kind}\" frictionloss=\"{level}\" solreffriction=\"{SOLREF}\" damping=\"{viscous}\""
        );
        let mut body = String::new();
        if inertia > 0.0 && is_linear {
            // MuJoCo softens a slide's friction by the mass of its body alone, which `armature` is no part of.
            *text += "<!-- inertial is the mass of all that moves, its diaginertia without meaning: leave it out where your bodies have the mass. -->\n";
            body = format!(
                "<inertial pos=\"0 0 0\" mass=\"{inertia}\" diaginertia=\"{inertia} {inertia} {inertia}\"/>\n"
            );
        } else if inertia > 0.0 {
            *text += "<!-- armature is the inertia of all that moves: take off it what your bodies have. -->\n";
            let _ = write!(joint, " armature=\"{inertia}\"");
        }
        for effect in &self.model.effects {
            self.attributes(effect, &mut joint, text);
        }
        *text += &format!("{joint}/>\n{body}");
    }

    /// The attributes of an effect that MuJoCo's joint holds, and what is to be known of them.
    fn attributes(&self, effect: &Effect, joint: &mut String, text: &mut String) {
        if effect.is(&form::ACTUATOR_SATURATION) {
            let limit = effect.get("limit_N");
            let _ = write!(joint, " actuatorfrcrange=\"{} {limit}\"", -limit);
            return;
        }
        let centre = effect.get("centre_m");
        let centre = match self.model.motion {
            MotionKind::Linear => centre,
            MotionKind::Rotary => {
                *text += "<!-- springref is in degrees, as MJCF has angles where its compiler is not told otherwise. -->\n";
                centre.to_degrees()
            }
        };
        let stiffness = effect.get("stiffness_N_per_m");
        let _ = write!(joint, " stiffness=\"{stiffness}\" springref=\"{centre}\"");
    }
}

/// The friction level in sliding, and what of the law it leaves out.
fn level(model: &Model, left_out: &mut Vec<String>) -> Result<f64, String> {
    let friction = &model.friction;
    let unit = effort(model);
    let breakaway = friction.breakaway().ok_or_else(|| {
        format!(
            "friction \"{}\": has no level in sliding, which a simulator's joint needs; identify another model (--friction, --blocks)",
            friction.kind()
        )
    })?;
    if !matches!(friction, FrictionModel::Coulomb { .. }) {
        left_out.push(format!(
            "pre-sliding of {}: below its friction the joint does not move",
            friction.name()
        ));
    }
    let Some(sliding) = friction.sliding() else {
        return Ok(breakaway);
    };
    if sliding.coulomb != breakaway {
        left_out.push(format!(
            "the level at rest, {breakaway} {unit}, with its fall to {} {unit} in sliding (Stribeck)",
            sliding.coulomb
        ));
    }
    Ok(sliding.coulomb)
}

/// What is lost with an effect, and where it could go.
fn words(effect: &Effect, unit: &str) -> String {
    let id = effect.id();
    if effect.is(&form::GRAVITY) {
        let (torque, angle) = (effect.get("force_N"), effect.get("angle_rad"));
        return format!(
            "{id}, {torque}·sin(q − {angle}) {unit}: the weight is your bodies', mass times lever {} kg·m",
            torque / GRAVITY
        );
    }
    let rest = if effect.is(&form::VISCOUS_ASYMMETRY) {
        "damping is the mean of both directions"
    } else if effect.is(&form::TRANSMITTED_FRICTION) {
        "most of the friction may be in it; the fit of the force (`preslide identify` without --criterion) has none"
    } else if effect.is(&form::COULOMB_ASYMMETRY) {
        "the friction is the mean of both directions"
    } else {
        "the format has nothing for it"
    };
    format!("{id}: {rest}")
}

fn effort(model: &Model) -> &'static str {
    match model.motion {
        MotionKind::Linear => "N",
        MotionKind::Rotary => "N·m",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPRING: &str = "schema = \"preslide.model/1\"\nmotion = \"rotary\"\n\
        inertia = { inertia_kg_m2 = 0.004 }\n\
        friction = { kind = \"coulomb\", coulomb_Nm = 0.25, viscous_Nm_s_per_rad = 0.03 }\n\
        [[effects]]\nid = \"position_spring\"\nstiffness_Nm_per_rad = 0.7\ncentre_rad = 0.5\n\
        [[effects]]\nid = \"gravity\"\nforce_Nm = 0.980665\nangle_rad = 0.0\n\
        [[effects]]\nid = \"actuator_saturation\"\nlimit_Nm = 1.5\n";

    fn joint(text: &str, format: Format) -> Joint {
        let model = Model::parse(text).unwrap_or_else(|e| panic!("{e}"));
        Joint::of(&model, format).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn a_hinge_has_what_mujoco_holds_and_says_the_rest() {
        let joint = joint(SPRING, Format::Mjcf);
        let text = joint.to_xml(&["by hand --mjcf".to_owned()]);
        let element = text.lines().last().expect("an element");
        assert_eq!(
            element,
            format!(
                "<joint name=\"axis\" type=\"hinge\" frictionloss=\"0.25\" solreffriction=\"0.004 1\" damping=\"0.03\" armature=\"0.004\" stiffness=\"0.7\" springref=\"{}\" actuatorfrcrange=\"-1.5 1.5\"/>",
                0.5_f64.to_degrees()
            )
        );
        assert_eq!(joint.left_out.len(), 1);
        assert!(text.contains("Not in it: gravity, 0.980665·sin(q − 0) N·m"));
        assert!(text.contains("mass times lever 0.1"), "{text}");
        for line in text.lines().filter(|line| line.starts_with("<!--")) {
            assert_eq!(line.matches("--").count(), 2, "{line}");
        }
    }

    #[test]
    fn urdf_has_friction_and_damping_alone() {
        let joint = joint(SPRING, Format::Urdf);
        let text = joint.to_xml(&[]);
        assert!(text.contains("type=\"continuous\""));
        assert!(text.contains("<dynamics damping=\"0.03\" friction=\"0.25\"/>"));
        let lost = joint.left_out.join("\n");
        for part in [
            "inertia, 0.004 kg·m²",
            "position_spring",
            "gravity",
            "actuator_saturation",
        ] {
            assert!(lost.contains(part), "{part}: {lost}");
        }
    }

    #[test]
    fn the_level_is_that_of_sliding_and_pre_sliding_is_said() {
        let linear = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n\
            [friction]\nkind = \"lugre\"\nstiffness_N_per_m = 1e5\ndamping_N_s_per_m = 10.0\nbreakaway_N = 3.0\n\
            coulomb_N = 2.0\nstribeck_velocity_m_s = 0.01\nstribeck_exponent = 2.0\n";
        let joint = joint(linear, Format::Mjcf);
        assert_eq!(
            joint.model.friction,
            FrictionModel::Coulomb { coulomb: 2.0 }
        );
        assert!(joint.left_out[0].contains("pre-sliding of LuGre"));
        assert!(joint.left_out[1].contains("at rest, 3 N"));
        assert!(!joint.to_xml(&[]).contains("inertial"));
        let heavy = linear.replace("[friction]", "inertia = { mass_kg = 3.0 }\n[friction]");
        let text = self::joint(&heavy, Format::Mjcf).to_xml(&[]);
        assert!(
            text.contains("mass=\"3\"") && !text.contains("armature"),
            "{text}"
        );
    }
}
