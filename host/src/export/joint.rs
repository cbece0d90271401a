//! A model as a joint of a simulator: what the format holds, and in words what it does not.
//!
//! MuJoCo (MJCF) holds `inertia·a + damping·v + frictionloss·sgn v + stiffness·(x − springref)` with a bound of the actuator's force; URDF
//! `damping·v + friction·sgn v`; OpenUSD with PhysX's schema, as Isaac Sim has it, `armature·a + viscousFrictionCoefficient·v +
//! dynamicFrictionEffort·sgn v`, another level at rest, and a drive that is a spring or bounded.

use preslide_fit::effects::Effect;
use preslide_fit::effects::form::{self, Form};
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use preslide_fit::report::figures::quantity;
use std::fmt::Write as _;

/// Whose joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's.
    Mjcf,
    /// ROS's.
    Urdf,
    /// OpenUSD's, with PhysX's friction.
    Usd,
}

/// What a format holds beside friction in sliding and viscous friction.
struct Holds {
    inertia: bool,
    /// A level at rest of its own.
    rest: bool,
    effects: &'static [&'static Form],
}

impl Format {
    /// As its option has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mjcf => "mjcf",
            Self::Urdf => "urdf",
            Self::Usd => "usd",
        }
    }

    fn holds(self) -> Holds {
        static OF_MJCF: [&Form; 2] = [&form::POSITION_SPRING, &form::ACTUATOR_SATURATION];
        let (inertia, rest, effects) = match self {
            Self::Mjcf => (true, false, &OF_MJCF[..]),
            Self::Urdf => (false, false, &[][..]),
            Self::Usd => (true, true, &OF_MJCF[..]),
        };
        Holds {
            inertia,
            rest,
            effects,
        }
    }
}

/// A joint.
#[derive(Clone, Debug)]
pub struct Joint {
    /// What the format holds.
    pub model: Model,
    /// What it does not hold, a clause each.
    pub left_out: Vec<String>,
    format: Format,
    /// Friction (N or N·m) at rest, where the format has one of its own.
    rest: f64,
}

/// Standard gravity (m/s²), which makes a mass and a lever of a torque.
const GRAVITY: f64 = 9.806_65;

/// Time constant (s) and damping ratio of dry friction in MuJoCo. With its own, 0.02 s, a joint at rest creeps; this is the least for its own
/// time step, 2 ms.
const SOLREF: &str = "0.004 1";

impl Joint {
    /// What of a model a format holds.
    ///
    /// # Errors
    /// A friction model without a level in sliding; one whose friction may be in its constant force.
    pub fn of(model: &Model, format: Format) -> Result<Self, String> {
        if let Some(unit) = model.effort_unit {
            return Err(format!(
                "effort_unit: the model's forces are in {unit}, and a simulator's are in N or N·m; identify it again with --map force_N=K*COLUMN or torque_Nm=K*COLUMN and the drive's constant K"
            ));
        }
        let mut left_out = Vec::new();
        let holds = format.holds();
        let (mut rest, coulomb) = levels(model, &holds, &mut left_out)?;
        let unit = effort(model);
        if coulomb == 0.0 && model.constant_force != 0.0 {
            return Err(format!(
                "the model has no Coulomb friction beside its constant force of {}, and the joint would slide without any: of a motion in one direction that force is Coulomb friction and load in one; record a motion with reversals and identify it, or, if it is a load alone, give --without {}",
                quantity(model.constant_force, unit),
                form::CONSTANT_FORCE.id
            ));
        }
        if model.constant_force != 0.0 {
            left_out.push(format!(
                "constant_force, {} {unit}: add it to the actuator's force, or tilt the axis",
                model.constant_force
            ));
        }
        if !holds.inertia && model.inertia > 0.0 {
            left_out.push(format!(
                "inertia, {} {}: URDF has it in the `<inertial>` of the links that move, of which this is the whole",
                model.inertia,
                match model.motion {
                    MotionKind::Linear => "kg",
                    MotionKind::Rotary => "kg·m²",
                }
            ));
        }
        let mut held = Vec::new();
        for effect in &model.effects {
            if let Some(level) = at_rest(effect).filter(|_| holds.rest) {
                rest += level * coulomb;
                left_out.push(at_once(effect, model.motion));
                continue;
            }
            // USD's drive is a spring, which pulls, or the user's own controller, which a bound is for.
            let pushes = effect.is(&form::POSITION_SPRING) && effect.get("stiffness_N_per_m") < 0.0;
            let is_taken = format == Format::Usd && (pushes || !held.is_empty());
            match holds.effects.contains(&effect.form) && !is_taken {
                true => held.push(effect.clone()),
                false => left_out.push(words(effect, unit)),
            }
        }
        Ok(Self {
            model: Model {
                inertia: if holds.inertia { model.inertia } else { 0.0 },
                viscous: model.viscous,
                effects: held,
                mechanics: model.mechanics.clone(),
                ..Model::of_friction(model.motion, FrictionModel::Coulomb { coulomb })
            },
            left_out,
            format,
            rest,
        })
    }

    /// The joint in its format, with `remarks` and what is left out in comments above it.
    pub fn to_text(&self, remarks: &[String]) -> String {
        let model = &self.model;
        let mut text = match self.format {
            Format::Usd => "#usda 1.0\n".to_owned(),
            Format::Mjcf | Format::Urdf => String::new(),
        };
        let left_out = self
            .left_out
            .iter()
            .map(|clause| format!("Not in it: {clause}."));
        for line in remarks.iter().cloned().chain(left_out) {
            let line = line.trim();
            let _ = match self.format {
                Format::Usd => writeln!(text, "# {line}"),
                // Two hyphens end a comment.
                Format::Mjcf | Format::Urdf => {
                    writeln!(text, "<!-- {} -->", line.replace("--", "‑‑"))
                }
            };
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
            Format::Usd => self.usd(level, &mut text),
        }
        text
    }

    /// What stands in an articulation of OpenUSD. Its angles are in degrees, in coefficients, too; torques and inertias know none.
    fn usd(&self, level: f64, text: &mut String) {
        let (kind, instance, angle) = match self.model.motion {
            MotionKind::Linear => ("Prismatic", "linear", 1.0),
            MotionKind::Rotary => ("Revolute", "angular", 1_f64.to_degrees()),
        };
        let mut attributes = vec![
            ("physxJointAxis", "armature", self.model.inertia),
            ("physxJointAxis", "staticFrictionEffort", self.rest),
            ("physxJointAxis", "dynamicFrictionEffort", level),
            (
                "physxJointAxis",
                "viscousFrictionCoefficient",
                self.model.viscous / angle,
            ),
        ];
        for effect in &self.model.effects {
            if effect.is(&form::ACTUATOR_SATURATION) {
                attributes.push(("drive", "physics:maxForce", effect.get("limit_N")));
                continue;
            }
            let stiffness = effect.get("stiffness_N_per_m") / angle;
            attributes.push(("drive", "physics:stiffness", stiffness));
            let centre = effect.get("centre_m") * angle;
            attributes.push(("drive", "physics:targetPosition", centre));
        }
        let drive = match self.model.effects.is_empty() {
            true => String::new(),
            false => format!("\"PhysicsDriveAPI:{instance}\", "),
        };
        *text += "# armature is the inertia of all that moves: subtract what your bodies have. Bodies, frames and limits are yours.\n";
        *text += "# PhysX reads this friction from 5.6 on, of joints in an articulation. Its older physxJoint:jointFriction is a share of the load, no force.\n";
        let _ = write!(
            text,
            "(\n    defaultPrim = \"axis\"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1\n)\n\n\
             def Physics{kind}Joint \"axis\" (\n    prepend apiSchemas = [{drive}\"PhysxJointAxisAPI:{instance}\"]\n)\n{{\n    uniform token physics:axis = \"X\"\n"
        );
        for (of, name, value) in attributes {
            let _ = writeln!(text, "    float {of}:{instance}:{name} = {value}");
        }
        *text += "}\n";
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
            *text += "<!-- armature is the inertia of all that moves: subtract what your bodies have. -->\n";
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

/// The friction levels at rest and in sliding, and what of the law they leave out.
fn levels(model: &Model, holds: &Holds, left_out: &mut Vec<String>) -> Result<(f64, f64), String> {
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
    let coulomb = friction.sliding().map_or(breakaway, |s| s.coulomb);
    if let Some(sliding) = friction.sliding().filter(|_| coulomb != breakaway) {
        left_out.push(match holds.rest {
            true => format!(
                "the fall from {breakaway} {unit} at rest to {coulomb} {unit} with speed (Stribeck, {} {}/s): it comes at once",
                sliding.stribeck_velocity,
                match model.motion {
                    MotionKind::Linear => "m",
                    MotionKind::Rotary => "rad",
                }
            ),
            false => format!(
                "the level at rest, {breakaway} {unit}, with its fall to {coulomb} {unit} in sliding (Stribeck)"
            ),
        });
    }
    Ok((breakaway.max(coulomb), coulomb))
}

/// By how much (-) the level at rest is above that of sliding, which such an effect falls to with speed.
fn at_rest(effect: &Effect) -> Option<f64> {
    let falls = effect.is(&form::STRIBECK) || effect.is(&form::FRICTIONAL_LAG);
    falls
        .then(|| effect.get("level"))
        .filter(|level| *level > 0.0)
}

/// What a level at rest leaves out of an effect that makes it.
fn at_once(effect: &Effect, motion: MotionKind) -> String {
    format!(
        "{}: the level at rest has it, but not the fall to that of sliding with speed ({} {}/s): it comes at once",
        effect.id(),
        effect.get("velocity_m_s"),
        motion.unit()
    )
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
    } else if at_rest(effect).is_some() {
        "the friction is that of sliding, and the level at rest has no place in the format"
    } else if effect.is(&form::POSITION_SPRING) || effect.is(&form::ACTUATOR_SATURATION) {
        "the format has no place for it, or one for either a spring or a bound"
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
        let text = joint.to_text(&["by hand --mjcf".to_owned()]);
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
    fn usd_has_a_level_at_rest_and_counts_angles_in_degrees() {
        let joint = joint(SPRING, Format::Usd);
        let text = joint.to_text(&["by hand".to_owned()]);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("#usda 1.0"));
        assert!(text.contains("def PhysicsRevoluteJoint \"axis\""));
        assert!(text.contains("[\"PhysicsDriveAPI:angular\", \"PhysxJointAxisAPI:angular\"]"));
        let value = |name: &str| -> f64 {
            let line = text.lines().find(|line| line.contains(name));
            let line = line.unwrap_or_else(|| panic!("no {name}: {text}"));
            let value = line.rsplit(" = ").next().expect("a value");
            value.parse().expect("a number")
        };
        assert_eq!(value("physxJointAxis:angular:armature"), 0.004);
        assert_eq!(value("physxJointAxis:angular:staticFrictionEffort"), 0.25);
        assert_eq!(value("physxJointAxis:angular:dynamicFrictionEffort"), 0.25);
        let per_degree = |name: &str, wanted: f64| {
            assert!(
                (value(name).to_degrees() / wanted - 1.0).abs() < 1e-12,
                "{name}"
            );
        };
        per_degree("angular:viscousFrictionCoefficient", 0.03);
        per_degree("drive:angular:physics:stiffness", 0.7);
        assert_eq!(
            value("angular:physics:targetPosition"),
            0.5_f64.to_degrees()
        );
        // The spring has the drive.
        assert!(!text.contains("maxForce"));
        assert!(
            joint
                .left_out
                .iter()
                .any(|c| c.starts_with("actuator_saturation"))
        );
        let bound = SPRING.replace(
            "[[effects]]\nid = \"position_spring\"\nstiffness_Nm_per_rad = 0.7\ncentre_rad = 0.5\n",
            "",
        );
        let text = self::joint(&bound, Format::Usd).to_text(&[]);
        assert!(
            text.contains("float drive:angular:physics:maxForce = 1.5"),
            "{text}"
        );
    }

    /// 2 N in sliding and 3 N at rest, by any law or effect that says so: USD has both levels, the others say what they leave out.
    #[test]
    fn every_level_at_rest_is_held_or_said() {
        let of_law = |kind: &str, more: &str| {
            format!(
                "kind = \"{kind}\"\nbreakaway_N = 3.0\ncoulomb_N = 2.0\nstribeck_velocity_m_s = 0.01\nstribeck_exponent = 2.0\n{more}"
            )
        };
        let bristle = "stiffness_N_per_m = 1e5\ndamping_N_s_per_m = 10.0\n";
        let gms = "kind = \"gms\"\nbreakaway_N = 2.0\nblocks = [{ stiffness_N_per_m = 1e5, weight = 1.0 }]\n";
        let effect = |id: &str| {
            format!(
                "{gms}[[effects]]\nid = \"{id}\"\nlevel = 0.5\nvelocity_m_s = 0.01\nexponent = 2.0\n"
            )
        };
        for law in [
            of_law("lugre", bristle),
            of_law("elasto_plastic", &format!("{bristle}elastic_m = 1e-5\n")),
            of_law(
                "two_state",
                "attraction_N_per_s = 50.0\npresliding_m = 1e-5\n",
            ),
            effect("stribeck"),
            effect("frictional_lag") + "time_constant_s = 0.02\n",
        ] {
            let text =
                format!("schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\n{law}");
            let usd = self::joint(&text, Format::Usd);
            for level in ["static", "dynamic"].into_iter().zip([3, 2]) {
                let line = format!(
                    "physxJointAxis:linear:{}FrictionEffort = {}\n",
                    level.0, level.1
                );
                assert!(
                    usd.to_text(&[]).contains(&line),
                    "{line}: {}",
                    usd.to_text(&[])
                );
            }
            assert!(
                usd.left_out.iter().any(|c| c.contains("at once")),
                "{:?}",
                usd.left_out
            );
            for format in [Format::Mjcf, Format::Urdf] {
                let lost = self::joint(&text, format).left_out.join("\n");
                assert!(lost.contains("level at rest"), "{lost}");
            }
        }
    }

    #[test]
    fn urdf_has_friction_and_damping_alone() {
        let joint = joint(SPRING, Format::Urdf);
        let text = joint.to_text(&[]);
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

    /// Of a motion in one direction the friction stands in the constant force: no joint slides without it unless its owner says so.
    #[test]
    fn friction_in_a_constant_force_is_not_lost_without_a_word() {
        let model = |coulomb: f64, constant: f64| {
            let text = format!(
                "schema = \"preslide.model/1\"\nmotion = \"linear\"\nfriction = {{ kind = \"coulomb\", coulomb_N = {coulomb:?}, viscous_N_s_per_m = 20.0 }}\n\
                 [[effects]]\nid = \"constant_force\"\nforce_N = {constant:?}\n"
            );
            Model::parse(&text).unwrap_or_else(|e| panic!("{e}"))
        };
        let one_way = model(0.0, 30.0);
        for format in [Format::Mjcf, Format::Urdf, Format::Usd] {
            let said = Joint::of(&one_way, format).expect_err("no friction");
            for part in ["30.0 N", "reversals", "--without constant_force"] {
                assert!(said.contains(part), "{said}");
            }
            assert!(Joint::of(&model(5.0, 30.0), format).is_ok());
            let ids = [form::CONSTANT_FORCE.id.to_owned()];
            let without = preslide_fit::model::reduced(&one_way, &ids).expect("its effect");
            assert!(Joint::of(&without, format).is_ok());
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
        assert!(!joint.to_text(&[]).contains("inertial"));
        let usd = self::joint(linear, Format::Usd);
        let text = usd.to_text(&[]);
        assert!(
            text.contains("float physxJointAxis:linear:staticFrictionEffort = 3\n"),
            "{text}"
        );
        assert!(
            text.contains("float physxJointAxis:linear:dynamicFrictionEffort = 2\n"),
            "{text}"
        );
        assert!(usd.left_out[1].contains("0.01 m/s"), "{:?}", usd.left_out);
        let heavy = linear.replace("[friction]", "inertia = { mass_kg = 3.0 }\n[friction]");
        let text = self::joint(&heavy, Format::Mjcf).to_text(&[]);
        assert!(
            text.contains("mass=\"3\"") && !text.contains("armature"),
            "{text}"
        );
    }
}
