//! A model as Rust source.

mod effects;
mod friction;

use super::constants::{Constant, inertia, layout, parameters};
use super::{Options, fitting, no_refused, remarks};
use preslide_fit::kernel::{Arithmetic, Kernel};
use preslide_fit::model::Model;
use std::fmt::Write as _;

/// Effects that one tuple holds.
const TUPLE: usize = 8;

/// The source of a model.
///
/// # Errors
/// Effects that no controller can use, each with the reason; a bound that is needed and cannot be taken from the model.
pub fn rust_source(model: &Model, options: &Options) -> Result<String, String> {
    no_refused(model)?;
    let kernel = fitting(options.kernel, model)?;
    let mut source = Source {
        model,
        constants: String::new(),
        parameters: Vec::new(),
        terms: Vec::new(),
    };
    source.rigid_body();
    let (friction, build) = source.friction(kernel);
    source.effects(options)?;

    let mut text = String::new();
    for line in remarks(model, options)?
        .iter()
        .flat_map(|remark| remark.lines())
    {
        let _ = writeln!(text, "// {}", line.trim_end());
    }
    let _ = writeln!(text, "\n{}", source.constants);
    let layout = layout(&parameters(model));
    let (listed, names) = source.listed();
    let count = source.parameters.len();
    let _ = write!(
        text,
        "/// The parameters in the order in which a running controller can be sent others.\n\
         pub const PARAMETERS: [f64; {count}] = {listed};\n\
         /// Which they are: the same for models of the same parts.\n\
         #[allow(dead_code)] // for firmware that takes models over the link\n\
         pub const LAYOUT: u32 = 0x{layout:08X};\n\n"
    );
    let timed = |code: &str| code.contains("sample_time");
    let (unused, ticks) = if timed(&build) || source.terms.iter().any(|t| timed(&t.build)) {
        ("", "for ticks that are `sample_time` (s) apart")
    } else {
        ("_", "in which the sample time plays no part")
    };
    let numbers = kernel.map_or(Arithmetic::F32, Kernel::arithmetic).source();
    let (types, body) = composed(&friction, &build, &source.terms, numbers);
    let _ = write!(
        text,
        "{types}\
         /// Builds the model, {ticks}, computing in `units`.\n\
         ///\n\
         /// # Errors\n\
         /// The parameter that does not fit the number type in `units`.\n\
         pub fn model<S: ::preslide::Scalar>(\n    sample_time: f64,\n    units: ::preslide::Units,\n) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {{\n    with(&PARAMETERS, sample_time, units)\n}}\n\n\
         /// The same with other parameters.\n\
         ///\n\
         /// # Errors\n\
         /// As of `model`.\n\
         pub fn with<S: ::preslide::Scalar>(\n    parameters: &[f64; {count}],\n    {unused}sample_time: f64,\n    units: ::preslide::Units,\n) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {{\n    let {names} = *parameters;\n{body}}}\n"
    );
    Ok(text)
}

/// The friction model, built by `build`, with the effects beside it: the types, and the body of the function that builds them.
/// `numbers` is the type of the controller that it is for.
fn composed(friction: &str, build: &str, terms: &[Term], numbers: &str) -> (String, String) {
    if terms.is_empty() {
        let types =
            format!("/// The friction model.\npub type Model<S = {numbers}> = {friction};\n\n");
        return (types, format!("    {build}\n"));
    }
    (
        format!(
            "/// The effects beside the friction model.\npub type Effects<S = {numbers}> = {};\n\n\
             /// The friction model with its effects.\npub type Model<S = {numbers}> = ::preslide::effects::With<{friction}, Effects<S>>;\n\n",
            nested(terms, 0, |t| &t.kind)
        ),
        format!(
            "    let friction = {build}?;\n    let effects = {};\n    ::preslide::effects::With::try_new(friction, effects)\n",
            nested(terms, 4, |t| &t.build)
        ),
    )
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
    /// As the constants have them, and their names in the function that builds the model from them.
    parameters: Vec<(String, String)>,
    terms: Vec<Term>,
}

impl Source<'_> {
    fn rigid_body(&mut self) {
        if let Some(inertia) = inertia(self.model) {
            let _ = writeln!(
                self.constants,
                "#[allow(dead_code)] // for the settings of the feed-forward"
            );
            self.constant(&inertia);
        }
    }

    /// Takes a parameter; its name in the function.
    fn parameter(&mut self, constant: String, name: &str) -> String {
        let name = name.to_lowercase();
        self.parameters.push((constant, name.clone()));
        name
    }

    /// The list of all, of the constants and of the names.
    fn listed(&self) -> (String, String) {
        let list = |of: fn(&(String, String)) -> &str| {
            let items = self.parameters.iter().map(|p| format!("    {},\n", of(p)));
            items.collect::<String>()
        };
        let (constants, names) = (list(|p| &p.0), list(|p| &p.1));
        let names = names.replace("    ", "        ");
        (format!("[\n{constants}]"), format!("[\n{names}    ]"))
    }

    fn constant(&mut self, Constant { name, said, value }: &Constant) {
        let _ = writeln!(
            self.constants,
            "/// {said}.\npub const {name}: f64 = {};",
            literal(*value)
        );
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
