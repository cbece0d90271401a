//! The text of the source.

use super::refused;
use crate::effects::Effect;
use crate::friction::FrictionModel;
use crate::model::Model;
use preslide::Block;
use std::fmt::Write as _;

/// Most by which a measured temperature or load may change the friction level of an exported model (-).
const LEVEL_LIMIT: f64 = 0.5;

/// The bound of forces that grow with speed or position, in breakaway forces, where none is given: far above what the
/// terms give on a healthy axis, and below what a drive could take for a fault.
const BREAKAWAYS: f64 = 10.0;

/// Effects that one tuple holds.
const TUPLE: usize = 8;

/// What to write beside the parameters.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Comments at the head: where the model comes from.
    pub remarks: Vec<String>,
    /// Bound on each force that grows with speed or position (N or N·m); ten times the breakaway force without it.
    pub limit: Option<f64>,
}

/// The source of a model.
///
/// # Errors
/// Effects that no controller can use, each with the reason; a bound that is needed and cannot be taken from the model.
pub fn rust_source(model: &Model, options: &Options) -> Result<String, String> {
    let refused = refused(model);
    if !refused.is_empty() {
        let list: Vec<String> = refused
            .iter()
            .map(|(id, reason)| format!("{id} ({reason})"))
            .collect();
        let remedy: Vec<String> = refused
            .iter()
            .map(|(id, _)| format!("--without {id}"))
            .collect();
        return Err(format!(
            "no controller can compensate {}; export the rest with {}",
            list.join("; "),
            remedy.join(" ")
        ));
    }
    let mut source = Source {
        model,
        constants: String::new(),
        terms: Vec::new(),
    };
    source.rigid_body();
    let (friction, build) = source.friction();
    source.effects(options)?;

    let mut text = String::new();
    for line in options.remarks.iter().flat_map(|remark| remark.lines()) {
        let _ = writeln!(text, "// {}", line.trim_end());
    }
    let _ = writeln!(text, "\n{}", source.constants);
    let timed = |code: &str| code.contains("sample_time");
    let (unused, ticks) = if timed(&build) || source.terms.iter().any(|t| timed(&t.build)) {
        ("", "for ticks that are `sample_time` (s) apart")
    } else {
        ("_", "in which the sample time plays no part")
    };
    let result = if source.terms.is_empty() {
        let _ = writeln!(
            text,
            "/// The friction model.\npub type Model<S = f32> = {friction};\n"
        );
        format!("    {build}\n")
    } else {
        let tuple = |indent, of: fn(&Term) -> &str| nested(&source.terms, indent, of);
        let _ = writeln!(
            text,
            "/// The effects beside the friction model.\npub type Effects<S = f32> = {};\n",
            tuple(0, |t| &t.kind)
        );
        let _ = writeln!(
            text,
            "/// The friction model with its effects.\npub type Model<S = f32> = ::preslide::effects::With<{friction}, Effects<S>>;\n"
        );
        format!(
            "    let friction = {build}?;\n    let effects = {};\n    ::preslide::effects::With::try_new(friction, effects)\n",
            tuple(4, |t| &t.build)
        )
    };
    let _ = write!(
        text,
        "/// Builds the model, {ticks}, computing in `units`.\n\
         ///\n\
         /// # Errors\n\
         /// The parameter that does not fit the number type in `units`.\n\
         pub fn model<S: ::preslide::Scalar>(\n    {unused}sample_time: f64,\n    units: ::preslide::Units,\n) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {{\n{result}}}\n"
    );
    Ok(text)
}

/// What stands beside the friction model in a controller: the viscous term, the constant force, the effects.
pub fn carried(model: &Model) -> Vec<Effect> {
    let alone = |id, key: &str, value: f64| Effect {
        id,
        values: vec![(key.to_owned(), value)],
    };
    let mut effects = Vec::new();
    if model.viscous != 0.0 {
        effects.push(alone("viscous", "viscous_N_s_per_m", model.viscous));
    }
    if model.constant_force != 0.0 {
        effects.push(alone("constant_force", "force_N", model.constant_force));
    }
    effects.extend(model.effects.iter().cloned());
    effects
}

/// A tuple, nested where there are more than [`TUPLE`], in lines indented by `indent`.
fn nested(terms: &[Term], indent: usize, of: fn(&Term) -> &str) -> String {
    let list = |terms: &[Term], indent: usize| {
        let margin = " ".repeat(indent);
        let items: String = terms
            .iter()
            .map(|t| format!("\n{margin}    {},", of(t)))
            .collect();
        format!("({items}\n{margin})")
    };
    if terms.len() <= TUPLE {
        return list(terms, indent);
    }
    let margin = " ".repeat(indent);
    let groups: String = terms
        .chunks(TUPLE)
        .map(|group| format!("\n{margin}    {},", list(group, indent + 4)))
        .collect();
    format!("({groups}\n{margin})")
}

/// An effect in the source.
struct Term {
    kind: String,
    build: String,
}

struct Source<'a> {
    model: &'a Model,
    constants: String,
    terms: Vec<Term>,
}

impl Source<'_> {
    fn rigid_body(&mut self) {
        if self.model.inertia > 0.0 {
            let key = self.model.key("mass_kg");
            let _ = writeln!(
                self.constants,
                "#[allow(dead_code)] // for the settings of the feed-forward"
            );
            self.constant(
                &key.to_uppercase(),
                &format!("`{key}` of the moving part"),
                self.model.inertia,
            );
        }
    }

    fn constant(&mut self, name: &str, said: &str, value: f64) {
        let _ = writeln!(
            self.constants,
            "/// {said}.\npub const {name}: f64 = {};",
            literal(value)
        );
    }

    /// The friction model's type, and the call that builds it.
    fn friction(&mut self) -> (String, String) {
        let kind = self.model.friction.kind();
        let mut names = Vec::new();
        for (key, value) in self.model.friction.scalars() {
            let key = self.model.key(key);
            let name = format!("{kind}_{key}").to_uppercase();
            self.constant(&name, &format!("`{key}` of `{kind}`"), value);
            names.push(name);
        }
        let name = |n: usize| names.get(n).cloned().unwrap_or_default();
        let sliding = |from: usize| {
            format!(
                "::preslide::Sliding {{ coulomb: {}, stribeck_velocity: {}, stribeck_exponent: {}, attraction: {} }}",
                name(from),
                name(from + 1),
                name(from + 2),
                name(from + 3)
            )
        };
        let path = |kind: &str, arguments: &str| {
            (
                format!("::preslide::{kind}"),
                format!(
                    "::preslide::{}::try_new({arguments})",
                    kind.split('<').next().unwrap_or(kind)
                ),
            )
        };
        match &self.model.friction {
            FrictionModel::Coulomb { .. } => {
                path("Coulomb<S>", &format!("{}, 0.0, units", name(0)))
            }
            FrictionModel::Dahl { .. } => path(
                "Dahl<S>",
                &format!("{}, {}, {}, units", name(0), name(1), name(2)),
            ),
            FrictionModel::LuGre { .. } => path(
                "LuGre<S>",
                &format!(
                    "{}, {}, {}, {}, units",
                    name(0),
                    name(1),
                    name(2),
                    sliding(3)
                ),
            ),
            FrictionModel::BoucWen { .. } => path(
                "BoucWen<S>",
                &format!("{}, {}, {}, {}, units", name(0), name(1), name(2), name(3)),
            ),
            FrictionModel::ElastoPlastic { .. } => path(
                "ElastoPlastic<S>",
                &format!(
                    "{}, {}, {}, {}, {}, units",
                    name(0),
                    name(1),
                    name(2),
                    name(3),
                    sliding(4)
                ),
            ),
            FrictionModel::Leuven { form, blocks, .. } => {
                self.blocks(blocks);
                path(
                    &format!("Leuven<{}, S>", blocks.len()),
                    &format!(
                        "::preslide::LeuvenForm::{form:?}, &BLOCKS, {}, {}, {}, {}, units",
                        name(0),
                        name(1),
                        name(2),
                        sliding(3)
                    ),
                )
            }
            FrictionModel::TwoState { .. } => path(
                "TwoState<S>",
                &format!(
                    "{}, {}, {}, sample_time, units",
                    name(0),
                    name(1),
                    sliding(2)
                ),
            ),
            FrictionModel::Hsieh(_) => path(
                "Hsieh<S>",
                &format!(
                    "&::preslide::HsiehParams {{ k1: {}, k2: {}, beta: {}, viscous: {}, creep: {}, hardening: {}, hardening_exponent: {} }}, sample_time, units",
                    name(0),
                    name(1),
                    name(2),
                    name(3),
                    name(4),
                    name(5),
                    name(6)
                ),
            ),
            FrictionModel::Gms {
                blocks,
                sliding: curve,
                ..
            } => {
                let n = blocks.len();
                self.blocks(blocks);
                match curve {
                    None => path(
                        &format!("QuasiStaticGms<{n}, S>"),
                        &format!("&BLOCKS, {}, units", name(0)),
                    ),
                    Some(_) => path(
                        &format!("Gms<{n}, S>"),
                        &format!("&BLOCKS, {}, {}, sample_time, units", name(0), sliding(1)),
                    ),
                }
            }
        }
    }

    /// The constant `BLOCKS`.
    fn blocks(&mut self, blocks: &[Block]) {
        let n = blocks.len();
        let list: String = blocks
            .iter()
            .map(|b| {
                format!(
                    "\n    ::preslide::Block {{ stiffness: {}, weight: {} }},",
                    literal(b.stiffness),
                    literal(b.weight)
                )
            })
            .collect();
        let unit = self.model.key("stiffness_N_per_m");
        let _ = writeln!(
            self.constants,
            "/// Maxwell-slip blocks: `{unit}` and weight.\npub const BLOCKS: [::preslide::Block; {n}] = [{list}\n];"
        );
    }

    fn effects(&mut self, options: &Options) -> Result<(), String> {
        let model = self.model;
        let effects = carried(model);

        if effects.iter().any(|e| shape(e).1.contains(&FORCE_LIMIT)) {
            let limit = options
                .limit
                .or(model.friction.breakaway().map(|f| BREAKAWAYS * f));
            let limit = limit.filter(|l| l.is_finite() && *l > 0.0).ok_or(
                "--limit: give the bound of each force that grows with speed or position, above zero (N or N·m); this model has no breakaway force to take it from",
            )?;
            self.constant(
                FORCE_LIMIT,
                "Bound of each force that grows with speed or position (N or N·m)",
                limit,
            );
        }
        if effects.iter().any(|e| shape(e).1.contains(&LEVEL_BOUND)) {
            self.constant(
                LEVEL_BOUND,
                "Most by which temperature or load may change the friction level (-)",
                LEVEL_LIMIT,
            );
        }
        for (i, effect) in effects.iter().enumerate() {
            let before = effects[..i].iter().filter(|e| e.id == effect.id).count();
            let id = if before == 0 {
                effect.id.to_owned()
            } else {
                format!("{}_{}", effect.id, before + 1)
            };
            self.effect(effect, &id);
        }
        Ok(())
    }

    fn effect(&mut self, effect: &Effect, id: &str) {
        let (kind, arguments) = shape(effect);
        let named = |key: &str| {
            let key = key.to_uppercase();
            match key.starts_with(&id.to_uppercase()) {
                true => key,
                false => format!("{}_{key}", id.to_uppercase()),
            }
        };
        let mut build = Vec::new();
        for &argument in arguments {
            build.push(match argument {
                FORCE_LIMIT | LEVEL_BOUND | "sample_time" | "units" | "2.0" => argument.to_owned(),
                "cosines" => {
                    let name = named("COSINES");
                    let cosines: Vec<String> = effect.cosines().into_iter().map(literal).collect();
                    let _ = writeln!(
                        self.constants,
                        "/// The cosines of `{}`.\npub const {name}: [f64; {}] = [{}];",
                        effect.id,
                        cosines.len(),
                        cosines.join(", ")
                    );
                    name
                }
                key => {
                    let own = self.model.key(key);
                    let name = named(&own);
                    self.constant(
                        &name,
                        &format!("`{own}` of `{}`", effect.id),
                        effect.get(key),
                    );
                    name
                }
            });
        }
        let of_terms = match effect.cosines().len() {
            0 => "S".to_owned(),
            n => format!("{n}, S"),
        };
        self.terms.push(Term {
            kind: format!("::preslide::effects::{kind}<{of_terms}>"),
            build: format!(
                "::preslide::effects::{kind}::try_new({})?",
                build.join(", ")
            ),
        });
    }
}

const FORCE_LIMIT: &str = "FORCE_LIMIT";
const LEVEL_BOUND: &str = "LEVEL_LIMIT";

/// The library's type, and the arguments of its constructor: keys, and what is no key.
fn shape(effect: &Effect) -> (&'static str, &'static [&'static str]) {
    match effect.id {
        "viscous" => ("Viscous", &["viscous_N_s_per_m", FORCE_LIMIT, "units"]),
        "constant_force" => ("ConstantForce", &["force_N", "units"]),
        "coulomb_asymmetry" => ("CoulombAsymmetry", &["asymmetry"]),
        "quadratic_drag" => ("QuadraticDrag", &["drag_N_s2_per_m2", FORCE_LIMIT, "units"]),
        "stribeck" => ("Stribeck", &["level", "velocity_m_s", "exponent", "units"]),
        "frictional_lag" => (
            "FrictionalLag",
            &[
                "level",
                "velocity_m_s",
                "exponent",
                "time_constant_s",
                "sample_time",
                "units",
            ],
        ),
        "position_spring" => (
            "PositionSpring",
            &["stiffness_N_per_m", "centre_m", FORCE_LIMIT, "units"],
        ),
        "position_force" => ("PositionForce", &["from_m", "to_m", "cosines", "units"]),
        "position_friction" => ("PositionFriction", &["from_m", "to_m", "cosines", "units"]),
        "local_friction_spot" => (
            "LocalFrictionSpot",
            &["level", "position_m", "width_m", "units"],
        ),
        "periodic_force" => (
            "PeriodicForce",
            &["force_N", "period_m", "phase_rad", "units"],
        ),
        "gravity" => ("Gravity", &["force_N", "angle_rad", "units"]),
        "periodic_friction" => (
            "PeriodicFriction",
            &["level", "period_m", "phase_rad", "units"],
        ),
        "encoder_error" => (
            "EncoderError",
            &["error_m", "period_m", "phase_rad", "units"],
        ),
        "thermal_drift" if effect.has("level_per_K") => (
            "ThermalDrift",
            &["level_per_K", "temperature_C", LEVEL_BOUND],
        ),
        "thermal_drift" => ("WarmUp", &["level", "time_constant_s", "sample_time"]),
        // Two decades of ageing: what single precision adds up in ticks of 50 µs, for time constants up to some seconds.
        "dwell_aging" => (
            "DwellAging",
            &[
                "level_per_decade",
                "time_constant_s",
                "erasing_path_m",
                "2.0",
                "sample_time",
                "units",
            ],
        ),
        "load_dependent_friction" => (
            "LoadDependentFriction",
            &["level_per_N", "load_N", LEVEL_BOUND, "units"],
        ),
        // `refused` was asked before; the source of an id that neither knows does not compile, and a test compiles all.
        _ => ("EffectWithoutType", &[]),
    }
}

/// A float as Rust reads it back.
fn literal(value: f64) -> String {
    if value == f64::INFINITY {
        "f64::INFINITY".to_owned()
    } else {
        format!("{value:?}")
    }
}
