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
    let scalars = friction.scalars();
    let set = |fields: &str, names: &[String]| {
        let set = fields.split(' ').zip(names);
        let set: Vec<String> = set
            .map(|(field, name)| format!("{field}: {name}"))
            .collect();
        set.join(", ")
    };
    let argument = |argument: &str| match (argument.trim_start_matches(['&', ' ']), friction) {
        ("blocks", _) => built.to_owned(),
        ("form", FrictionModel::Leuven { form, .. }) => {
            format!("::preslide::LeuvenForm::{form:?}")
        }
        ("params", _) => {
            let fields = "k1 k2 beta viscous creep hardening hardening_exponent";
            format!("&::preslide::HsiehParams {{ {} }}", set(fields, names))
        }
        ("sliding", _) => {
            let fields = "coulomb stribeck_velocity stribeck_exponent attraction";
            // The scalars of the Stribeck curve are the last ones.
            let from = names.len().saturating_sub(4);
            format!("::preslide::Sliding {{ {} }}", set(fields, &names[from..]))
        }
        // A key is its field's name with the unit; what is no field stands for itself.
        (field, _) => {
            let of_key = |key: &str| {
                key.strip_prefix(field)
                    .is_some_and(|unit| unit.is_empty() || unit.starts_with('_'))
            };
            let at = scalars.iter().position(|(key, _)| of_key(key));
            at.map_or(field, |at| &names[at]).to_owned()
        }
    };
    let (law, arguments) = friction.constructor();
    let arguments: Vec<String> = arguments.iter().copied().map(argument).collect();
    let kind = match friction.blocks().len() {
        0 => format!("{law}<S>"),
        blocks => format!("{law}<{blocks}, S>"),
    };
    (kind, arguments.join(", "))
}
