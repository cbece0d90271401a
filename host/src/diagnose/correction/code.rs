//! A correction as code that is added to one's own force: Python, C, MATLAB.

use super::{Blocks, Correction};
use crate::diagnose::core::SLIPS;
use crate::diagnose::expr::{Expr, Input};
use std::fmt::Write as _;
use std::path::Path;

/// A language that a correction is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// A class.
    Python,
    /// C99, a header of static functions.
    C,
    /// A function of a state.
    Matlab,
}

impl Language {
    /// By the ending of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "py" => Some(Self::Python),
            "c" | "h" => Some(Self::C),
            "m" => Some(Self::Matlab),
            _ => None,
        }
    }

    /// A formula in it.
    fn formula(self, formula: &Expr) -> String {
        let text = formula.to_string();
        match self {
            Self::Python => text,
            Self::C => text.replace("abs(", "fabs("),
            Self::Matlab => text.replace("pow(", "power("),
        }
    }

    fn comment(self) -> &'static str {
        match self {
            Self::Python => "#",
            Self::C => "//",
            Self::Matlab => "%",
        }
    }
}

/// Further arguments of the function, where a formula needs them.
const MEASURED: [Input; 2] = [Input::Temperature, Input::Load];

impl Correction {
    /// The code, headed by `remarks`.
    pub fn code(&self, language: Language, remarks: &[String]) -> String {
        let mark = language.comment();
        let mut text = String::new();
        for line in remarks.iter().flat_map(|r| r.lines()).chain(USAGE.lines()) {
            let _ = writeln!(text, "{mark} {line}");
        }
        for term in self.terms.iter().filter(|t| t.formula.is_none()) {
            let _ = writeln!(
                text,
                "{mark} Not here: {} ({}); it is no force of the motion at one instant.",
                term.id, term.words
            );
        }
        text.push_str(&match language {
            Language::Python => self.python(),
            Language::C => self.c(),
            Language::Matlab => self.matlab(),
        });
        text
    }

    /// Terms that are formulas: id, and the formula in a language.
    fn formulas(&self, language: Language) -> Vec<(&str, String)> {
        let own = (self.terms.iter()).filter_map(|t| Some((t.id.as_str(), t.formula.as_ref()?)));
        own.map(|(id, formula)| (id, language.formula(formula)))
            .collect()
    }

    fn needs(&self, input: Input) -> bool {
        let mut own = self.terms.iter().filter_map(|t| t.formula.as_ref());
        own.any(|f| f.uses(input))
    }

    /// Arguments behind the acceleration, each with what stands before its name.
    fn measured(&self, before: &str) -> String {
        let own = MEASURED.into_iter().filter(|i| self.needs(*i));
        own.map(|i| format!(", {before}{}", i.name())).collect()
    }

    fn python(&self) -> String {
        let list = |blocks: &Blocks| -> String {
            blocks
                .iter()
                .map(|(k, d)| format!("        ({k:?}, {d:?}),\n"))
                .collect()
        };
        let terms: String = self
            .formulas(Language::Python)
            .iter()
            .map(|(id, formula)| format!("            \"{id}\": {formula},\n"))
            .collect();
        format!(
            "from math import cos, exp, sin, tanh

class Correction:
    BLOCKS = [
{}    ]
    DIRECTION = [
{}    ]

    def __init__(self):
        self.reset()

    def reset(self):
        self.z = [0.0] * len(self.BLOCKS)
        self.w = [0.0] * len(self.DIRECTION)
        self.last = None
        self.path = 0.0

    @staticmethod
    def _slip(blocks, deflections, moved):
        for i, (_, d) in enumerate(blocks):
            deflections[i] = min(max(deflections[i] + moved, -d), d)

    def terms(self, t, x, v, a{}):
        moved = 0.0 if self.last is None else x - self.last
        self.last = x
        self.path += abs(moved)
        self._slip(self.BLOCKS, self.z, moved)
        self._slip(self.DIRECTION, self.w, moved)
        path = self.path
        blocks = sum(k * z for (k, _), z in zip(self.BLOCKS, self.z))
        direction = sum(k * w for (k, _), w in zip(self.DIRECTION, self.w))
        slipping = sum(k * w for (k, d), w in zip(self.DIRECTION, self.w) if abs(w) >= {SLIPS:?} * d)
        return {{
{terms}        }}

    def force(self, t, x, v, a{}):
        return sum(self.terms(t, x, v, a{}).values())
",
            list(&self.blocks),
            list(&self.direction),
            self.measured(""),
            self.measured(""),
            self.measured(""),
        )
    }

    fn c(&self) -> String {
        let list = |name: &str, blocks: &Blocks| -> String {
            // C has no empty arrays.
            let blocks = if blocks.is_empty() {
                &vec![(0.0, 1.0)]
            } else {
                blocks
            };
            let rows: String = blocks
                .iter()
                .map(|(k, d)| format!("    {{{k:?}, {d:?}}},\n"))
                .collect();
            format!(
                "static const double PRESLIDE_{name}[{}][2] = {{\n{rows}}};\n",
                blocks.len()
            )
        };
        let terms: String = self
            .formulas(Language::C)
            .iter()
            .map(|(id, formula)| format!("    force += {formula}; // {id}\n"))
            .collect();
        format!(
            "#ifndef PRESLIDE_CORRECTION_H
#define PRESLIDE_CORRECTION_H
#include <math.h>

{}{}
struct preslide_correction {{
    double z[{}];
    double w[{}];
    double last;
    double path;
    int started;
}};

// Zero-initialise the state: struct preslide_correction state = {{0}};
static double preslide_correction_force(struct preslide_correction *s, double t, double x, double v, double a{}) {{
    const double moved = s->started ? x - s->last : 0.0;
    double blocks = 0.0, direction = 0.0, slipping = 0.0, force = 0.0;
    s->started = 1;
    s->last = x;
    s->path += fabs(moved);
    const double path = s->path;
    for (unsigned i = 0; i < sizeof s->z / sizeof s->z[0]; i++) {{
        const double d = PRESLIDE_BLOCKS[i][1];
        s->z[i] = fmin(fmax(s->z[i] + moved, -d), d);
        blocks += PRESLIDE_BLOCKS[i][0] * s->z[i];
    }}
    for (unsigned i = 0; i < sizeof s->w / sizeof s->w[0]; i++) {{
        const double d = PRESLIDE_DIRECTION[i][1];
        s->w[i] = fmin(fmax(s->w[i] + moved, -d), d);
        direction += PRESLIDE_DIRECTION[i][0] * s->w[i];
        slipping += fabs(s->w[i]) >= {SLIPS:?} * d ? PRESLIDE_DIRECTION[i][0] * s->w[i] : 0.0;
    }}
    (void)t; (void)x; (void)v; (void)a; (void)path; (void)blocks; (void)direction; (void)slipping;
{terms}    return force;
}}
#endif
",
            list("BLOCKS", &self.blocks),
            list("DIRECTION", &self.direction),
            self.blocks.len().max(1),
            self.direction.len().max(1),
            self.measured("double "),
        )
    }

    fn matlab(&self) -> String {
        let list = |blocks: &Blocks| -> String {
            let rows: Vec<String> = blocks.iter().map(|(k, d)| format!("{k:?} {d:?}")).collect();
            match rows.is_empty() {
                true => "zeros(0, 2)".to_owned(),
                false => format!("[{}]", rows.join("; ...\n    ")),
            }
        };
        let terms: String = self
            .formulas(Language::Matlab)
            .iter()
            .map(|(id, formula)| format!("force = force + {formula}; % {id}\n"))
            .collect();
        format!(
            "function [force, state] = preslide_correction(state, t, x, v, a{})
% state = [] at the first sample.
own = {};
dir = {};
if isempty(state)
    state = struct('z', zeros(size(own, 1), 1), 'w', zeros(size(dir, 1), 1), 'last', x, 'path', 0);
end
moved = x - state.last;
state.last = x;
state.path = state.path + abs(moved);
state.z = min(max(state.z + moved, -own(:, 2)), own(:, 2));
state.w = min(max(state.w + moved, -dir(:, 2)), dir(:, 2));
path = state.path;
blocks = sum(own(:, 1) .* state.z);
direction = sum(dir(:, 1) .* state.w);
slipping = sum(dir(:, 1) .* state.w .* (abs(state.w) >= {SLIPS:?} * dir(:, 2)));
force = 0;
{terms}end
",
            self.measured(""),
            list(&self.blocks),
            list(&self.direction),
        )
    }
}

/// How to use the code.
const USAGE: &str = "Add its force to your simulation's own. Call it once for every sample, in order: friction remembers where it turned.
SI units. t: time, x: position, v: velocity, a: acceleration; blocks: the difference of the friction, spring by spring, each of which
slips at its yield; direction: the friction over its level, between -1 and 1; slipping: its part in springs that slip.";
