//! Header and source around the code.

use super::law::Law;
use super::term::Term;
use super::{SAMPLE_TIME, define, literal};
use crate::export::constants::{Constant, inertia};
use preslide_fit::effects::form::Sum;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use std::fmt::Write as _;

/// What both files are made of.
pub(super) struct File<'a> {
    pub(super) model: &'a Model,
    /// Begins every name.
    pub(super) name: &'a str,
    /// Where the model comes from.
    pub(super) remarks: &'a [String],
    /// Constants of the header.
    pub(super) defines: String,
    /// The step, declared, and what it is.
    pub(super) step: [String; 2],
    /// Seconds between two steps are taken.
    pub(super) timed: bool,
    /// It takes `math.h`.
    pub(super) math: bool,
    pub(super) terms: &'a [Term],
    pub(super) law: &'a Law,
}

impl File<'_> {
    pub(super) fn header(&self) -> String {
        let mut defines = String::new();
        if !self.model.friction.blocks().is_empty() {
            let count = self.model.friction.blocks().len();
            defines += &define("Maxwell-slip blocks", "@@BLOCKS", &count.to_string());
        }
        defines += &self.defines;
        if let Some(Constant { name, said, value }) = inertia(self.model) {
            defines += &define(&said, &format!("@@{name}"), &literal(value));
        }
        let [declared, said] = &self.step;
        let setters = self.setters();
        let setters = setters.iter();
        let setters: String = setters
            .map(|s| format!("/* {} */\n{};\n", s.said, s.declared))
            .collect();
        let text = format!(
            "#ifndef @@H\n#define @@H\n\n#include <stdbool.h>\n#include <stdint.h>\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n{defines}\n\
             /* What the model remembers; of each axis one, set by @rest before the first step. */\ntypedef struct {{\n{}}} @state;\n\n\
             /* An axis that rests, its friction free of tension. */\nvoid @rest(@state *s);\n{setters}\
             /* {} */\n{};\n\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
            self.fields()
                .into_iter()
                .map(|(field, _)| format!("    {field}\n"))
                .collect::<String>(),
            said,
            declared,
        );
        self.named(&text)
    }

    pub(super) fn source(&self, constants: &[Constant], helpers: &str, code: &str) -> String {
        let mut defines = String::new();
        if self.timed {
            let seconds = "(1.0f / @@RATE_HZ)";
            defines += &define("Seconds between two steps", SAMPLE_TIME, seconds);
        }
        let of_terms = self.terms.iter().flat_map(|term| &term.constants);
        for Constant { name, said, value } in constants.iter().chain(of_terms) {
            defines += &define(said, name, &literal(*value));
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
        let setters = self.setters();
        let setters: String = setters
            .iter()
            .map(|s| format!("\n{}\n{{\n{}}}\n", s.declared, s.body))
            .collect();
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
        let math = if self.math {
            "#include <math.h>\n\n"
        } else {
            ""
        };
        let text = format!(
            "#include \"{}.h\"\n\n{math}{defines}{}\n{helpers}\n{code}\nvoid @rest(@state *s)\n{{\n{counter}{rest}}}\n{setters}",
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
            add("float position; /* as last set */", "s->position = 0.0f;");
            add(
                "bool located; /* the position has been set */",
                "s->located = false;",
            );
        }
        if self.terms.iter().any(|term| term.c.sum == Sum::Shift) {
            add("float shift; /* of the position */", "s->shift = 0.0f;");
            add("bool shifted; /* it has been */", "s->shifted = false;");
        }
        for (column, said) in self.measured() {
            add(
                &format!("float {column}; /* {said}, as last set */"),
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

    /// The functions that give the model what a step does not.
    fn setters(&self) -> Vec<Setter> {
        let x = self.model.key("position_m");
        let of_place = self.is_placed().then(|| Setter {
            said: "Tells where the axis is, before each step once it is homed; until then what belongs to a place is off.".to_owned(),
            declared: format!("void @set_position(@state *s, float {x})"),
            body: format!("    s->position = {x};\n    s->located = true;\n"),
        });
        let of_columns = self.measured().map(|(column, said)| Setter {
            said: format!("Tells {said}; NAN where it is not known."),
            declared: format!("void @set_{column}(@state *s, float {column})"),
            body: format!("    s->{column} = {column};\n"),
        });
        of_place.into_iter().chain(of_columns).collect()
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

    /// The text with the model's name in place of `@`, in capitals for `@@`, behind the remarks.
    fn named(&self, text: &str) -> String {
        let text = text.replace("@@", &format!("{}_", self.name.to_uppercase()));
        self.head() + &text.replace('@', &format!("{}_", self.name))
    }
}

/// A function of one line or two.
struct Setter {
    said: String,
    declared: String,
    body: String,
}
