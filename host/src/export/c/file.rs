//! Header and source around the code.

use super::law::Law;
use super::literal;
use super::term::Term;
use crate::effects::form::Sum;
use crate::export::constants::{Constant, inertia};
use crate::model::Model;
use crate::recording::MotionKind;
use std::fmt::Write as _;

/// What both files are made of.
pub(super) struct File<'a> {
    pub(super) model: &'a Model,
    /// Begins every name.
    pub(super) name: &'a str,
    /// Where the model comes from.
    pub(super) remarks: &'a [String],
    /// Ticks per second (Hz), where time plays a part.
    pub(super) rate: Option<f64>,
    pub(super) terms: &'a [Term],
    pub(super) law: &'a Law,
}

impl File<'_> {
    pub(super) fn header(&self) -> String {
        let unit = |linear, rotary| match self.model.motion {
            MotionKind::Linear => linear,
            MotionKind::Rotary => rotary,
        };
        let (length, force) = (unit("m", "rad"), unit("N", "N m"));
        let [dx, v, x] =
            ["displacement_m", "velocity_m_s", "position_m"].map(|k| self.model.key(k));
        let mut defines = String::new();
        if !self.model.friction.blocks().is_empty() {
            let count = self.model.friction.blocks().len();
            let _ = writeln!(
                defines,
                "/* Maxwell-slip blocks. */\n#define @BLOCKS {count}"
            );
        }
        let rate = self.rate.map(|rate| Constant {
            name: "RATE_HZ".to_owned(),
            said: "Calls of @step per second".to_owned(),
            value: rate,
        });
        for Constant { name, said, value } in inertia(self.model).into_iter().chain(rate) {
            let _ = writeln!(defines, "/* {said}. */\n#define @{name} {}", literal(value));
        }
        let mut setters = String::new();
        if self.is_placed() {
            let _ = write!(
                setters,
                "/* Tells where the axis is, before each step once it is homed; until then what belongs to a place is off. */\nvoid @set_position(@state *s, float {x});\n"
            );
        }
        for (column, said) in self.measured() {
            let _ = write!(
                setters,
                "/* Tells {said}; NAN where it is not known. */\nvoid @set_{column}(@state *s, float {column});\n"
            );
        }
        let text = format!(
            "#ifndef @GUARD\n#define @GUARD\n\n#include <stdbool.h>\n#include <stdint.h>\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n{defines}\n\
             /* What the model remembers; of each axis one, set by @rest before the first step. */\ntypedef struct {{\n{}}} @state;\n\n\
             /* An axis that rests, its friction free of tension. */\nvoid @rest(@state *s);\n{setters}\
             /* The force ({force}) that holds against friction and effects: add it to the controller's before the limiter. {dx}: since the step before\n   ({length}); {v}: now ({length}/s).{} */\nfloat @step(@state *s, float {dx}, float {v});\n\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
            self.fields()
                .into_iter()
                .map(|(field, _)| format!("    {field}\n"))
                .collect::<String>(),
            match self.law.bounded {
                true => " Bounded whatever the input, NAN included.",
                false => "",
            }
        );
        self.named(&text)
    }

    pub(super) fn source(&self, constants: &[Constant], helpers: &str, code: &str) -> String {
        let mut defines = String::new();
        if self.rate.is_some() {
            defines +=
                "/* Seconds between two steps. */\n#define SAMPLE_TIME_S (1.0f / @RATE_HZ)\n";
        }
        let of_terms = self.terms.iter().flat_map(|term| &term.constants);
        for Constant { name, said, value } in constants.iter().chain(of_terms) {
            let _ = writeln!(defines, "/* {said}. */\n#define {name} {}", literal(*value));
        }
        for (name, cosines) in self.terms.iter().filter_map(|term| term.map.as_ref()) {
            let list: Vec<String> = cosines.iter().map(|c| literal(*c)).collect();
            let _ = writeln!(
                defines,
                "static const float {name}[{}] = {{ {} }};",
                cosines.len(),
                list.join(", ")
            );
        }
        let mut setters = String::new();
        let x = self.model.key("position_m");
        if self.is_placed() {
            let _ = write!(
                setters,
                "\nvoid @set_position(@state *s, float {x})\n{{\n    s->position = {x};\n    s->located = true;\n}}\n"
            );
        }
        for (column, _) in self.measured() {
            let _ = write!(
                setters,
                "\nvoid @set_{column}(@state *s, float {column})\n{{\n    s->{column} = {column};\n}}\n"
            );
        }
        let fields = self.fields();
        let rest: String = fields
            .iter()
            .map(|(_, rest)| format!("    {rest}\n"))
            .collect();
        let counter = if rest.contains("(i = 0") {
            "    int i;\n"
        } else {
            ""
        };
        let text = format!(
            "#include \"{}.h\"\n\n#include <math.h>\n\n{defines}{}\n{helpers}\n{code}\nvoid @rest(@state *s)\n{{\n{counter}{rest}}}\n{setters}",
            self.name, self.law.arrays,
        );
        self.named(&text)
    }

    /// Each field of the state, and the statement that sets it to rest.
    fn fields(&self) -> Vec<(String, String)> {
        let own = self.law.memory.iter();
        let mut fields: Vec<(String, String)> = own
            .map(|(f, r)| ((*f).to_owned(), (*r).to_owned()))
            .collect();
        let mut add = |field: &str, rest: &str| fields.push((field.to_owned(), rest.to_owned()));
        if self.is_placed() {
            add("float position; /* as last told */", "s->position = 0.0f;");
            add("bool located; /* it was told */", "s->located = false;");
        }
        if self.terms.iter().any(|term| term.c.sum == Sum::Shift) {
            add("float shift; /* of the position */", "s->shift = 0.0f;");
            add("bool shifted; /* it has been */", "s->shifted = false;");
        }
        for (column, said) in self.measured() {
            add(
                &format!("float {column}; /* {said}, as last told */"),
                &format!("s->{column} = NAN;"),
            );
        }
        for term in self.terms {
            if let (Some(memory), Some([at_rest, _])) = (term.c.memory, &term.memory) {
                add(
                    &format!("{} {};", memory.kind, term.id),
                    &format!("s->{} = {at_rest};", term.id),
                );
            }
        }
        if fields.is_empty() {
            // C has no empty structure.
            fields.push(("char nothing;".to_owned(), "s->nothing = 0;".to_owned()));
        }
        fields
    }

    fn is_placed(&self) -> bool {
        self.terms.iter().any(|term| term.c.placed)
    }

    /// What must be measured beside the motion, with its unit.
    fn measured(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let load = match self.model.motion {
            MotionKind::Linear => "the load (N)",
            MotionKind::Rotary => "the load (N m)",
        };
        let columns = [("temperature", "the temperature (C)"), ("load", load)];
        let takes = |column: &str| self.terms.iter().any(|term| term.takes(column));
        columns.into_iter().filter(move |(column, _)| takes(column))
    }

    fn head(&self) -> String {
        let lines = self.remarks.iter().flat_map(|remark| remark.lines());
        let lines = lines.map(|line| format!("/* {} */\n", line.trim().replace("*/", "")));
        lines.chain(["\n".to_owned()]).collect()
    }

    /// The text with the model's name in every name, behind the remarks.
    fn named(&self, text: &str) -> String {
        let upper = self.name.to_uppercase();
        let mut named = text.replace("@GUARD", &format!("{upper}_H"));
        for capital in ["@BLOCKS", "@RATE_HZ", "@MASS_KG", "@INERTIA_KG_M2"] {
            named = named.replace(capital, &format!("{upper}_{}", &capital[1..]));
        }
        self.head() + &named.replace('@', &format!("{}_", self.name))
    }
}
