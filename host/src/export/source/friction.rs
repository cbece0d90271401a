//! The friction model in the source: its parameters as constants, and the call that builds it from them.

use super::{Source, literal};
use crate::export::constants::of_friction;
use preslide::Block;
use preslide_fit::friction::FrictionModel;
use preslide_fit::kernel::Kernel;
use std::fmt::Write as _;

impl Source<'_> {
    /// The friction model's type, and the call that builds it.
    pub(super) fn friction(&mut self, kernel: Option<Kernel>) -> (String, String) {
        let constants = of_friction(self.model);
        constants.iter().for_each(|c| self.constant(c));
        let names: Vec<String> = constants
            .into_iter()
            .map(|c| self.parameter(c.name.clone(), &c.name))
            .collect();
        let friction = &self.model.friction;
        let blocks = match friction.blocks() {
            [] => String::new(),
            blocks => self.blocks(blocks),
        };
        if let Some(kernel) = kernel {
            let kind = kernel.source(friction.blocks().len());
            let arguments = match (kernel.has_sliding(), friction.sliding()) {
                (false, _) => format!("{blocks}, {}", names[0]),
                (true, Some(_)) => constructor(friction, &names, &blocks).1,
                (true, None) => format!(
                    "{blocks}, {0}, ::preslide::Sliding::none({0}), sample_time",
                    names[0]
                ),
            };
            let build = format!("<{kind}>::try_new({arguments}, units)");
            return (kind, build);
        }
        let (kind, arguments) = constructor(friction, &names, &blocks);
        let path = kind.split('<').next().unwrap_or(&kind);
        let build = format!("::preslide::{path}::try_new({arguments}, units)");
        (format!("::preslide::{kind}"), build)
    }

    /// The constant `BLOCKS`; the blocks as the function builds them.
    fn blocks(&mut self, blocks: &[Block]) -> String {
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
        let built = (0..n).map(|i| {
            let mut part =
                |key| self.parameter(format!("BLOCKS[{i}].{key}"), &format!("{key}_{i}"));
            let (stiffness, weight) = (part("stiffness"), part("weight"));
            format!("::preslide::Block {{ stiffness: {stiffness}, weight: {weight} }}")
        });
        let built: Vec<String> = built.collect();
        format!("&[{}]", built.join(", "))
    }
}

/// The library's type, and the arguments of its constructor but for the units; `names` are the scalars, `built` the blocks.
fn constructor(friction: &FrictionModel, names: &[String], built: &str) -> (String, String) {
    let name = |n: usize| names.get(n).map_or("", String::as_str);
    let first = |n: usize| names.get(..n).unwrap_or_default().join(", ");
    // The scalars of the Stribeck curve are the last ones of every model that has it.
    let sliding = || {
        let from = names.len().saturating_sub(4);
        format!(
            "::preslide::Sliding {{ coulomb: {}, stribeck_velocity: {}, stribeck_exponent: {}, attraction: {} }}",
            name(from),
            name(from + 1),
            name(from + 2),
            name(from + 3)
        )
    };
    match friction {
        FrictionModel::Coulomb { .. } => ("Coulomb<S>".into(), format!("{}, 0.0", first(1))),
        FrictionModel::Dahl { .. } => ("Dahl<S>".into(), first(3)),
        FrictionModel::LuGre { .. } => ("LuGre<S>".into(), format!("{}, {}", first(3), sliding())),
        FrictionModel::BoucWen { .. } => ("BoucWen<S>".into(), first(4)),
        FrictionModel::ElastoPlastic { .. } => (
            "ElastoPlastic<S>".into(),
            format!("{}, {}", first(4), sliding()),
        ),
        FrictionModel::Leuven { form, blocks, .. } => (
            format!("Leuven<{}, S>", blocks.len()),
            format!(
                "::preslide::LeuvenForm::{form:?}, {built}, {}, {}",
                first(3),
                sliding()
            ),
        ),
        FrictionModel::TwoState { .. } => (
            "TwoState<S>".into(),
            format!("{}, {}, sample_time", first(2), sliding()),
        ),
        FrictionModel::Hsieh(_) => {
            let fields = [
                "k1",
                "k2",
                "beta",
                "viscous",
                "creep",
                "hardening",
                "hardening_exponent",
            ];
            let set = |(field, name)| format!("{field}: {name}");
            let set: Vec<String> = fields.iter().zip(names).map(set).collect();
            let params = format!("&::preslide::HsiehParams {{ {} }}", set.join(", "));
            ("Hsieh<S>".into(), format!("{params}, sample_time"))
        }
        FrictionModel::Gms {
            blocks,
            sliding: None,
            ..
        } => (
            format!("QuasiStaticGms<{}, S>", blocks.len()),
            format!("{built}, {}", first(1)),
        ),
        FrictionModel::Gms { blocks, .. } => (
            format!("Gms<{}, S>", blocks.len()),
            format!("{built}, {}, {}, sample_time", first(1), sliding()),
        ),
    }
}
