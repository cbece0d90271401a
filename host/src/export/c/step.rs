//! The function that runs a tick.

use super::term::Term;
use crate::export::constants::effort_of;
use preslide_fit::effects::form::Sum;
use preslide_fit::model::Model;
use std::fmt::Write as _;

/// What is said of a force that is.
const BOUNDED: &str = " Bounded whatever the input, NAN included.";

/// `@step`, declared, and what it is.
pub(super) fn declared(model: &Model, bounded: bool) -> [String; 2] {
    let [dx, v] = ["displacement_m", "velocity_m_s"].map(|k| model.key(k));
    let (length, force) = (model.motion.unit(), effort_of(model));
    let bounded = if bounded { BOUNDED } else { "" };
    [
        format!("float @step(@state *s, float {dx}, float {v})"),
        format!(
            "The force ({force}) that holds against friction and effects: add it to the controller's before the limiter. {dx}: since the step before\n   ({length}); {v}: now ({length}/s).{bounded}"
        ),
    ]
}

/// `@step`: `F = max(0, 1 + Σ level)·F_model(x + Σ shift) + Σ force`.
pub(super) fn step(model: &Model, terms: &[Term], declared: &str) -> String {
    let [dx, v] = ["displacement_m", "velocity_m_s"].map(|key| model.key(key));
    let takes = |variable: &str| terms.iter().any(|term| term.takes(variable));
    let enter = |sum: Sum| terms.iter().any(|term| term.c.sum == sum);
    let mut body = format!("    const float v = {v};\n    float dx = {dx};\n");
    let situation = [
        (
            "temperature",
            "    const float temperature = s->temperature;\n",
        ),
        ("load", "    const float load = s->load;\n"),
        ("x", "    float x = s->position;\n"),
    ];
    let known = situation.iter().filter(|(variable, _)| takes(variable));
    body.extend(known.map(|(_, line)| *line));
    body += "    float friction;\n    float force;\n";
    if enter(Sum::Level) {
        body += "    float level = 1.0f;\n";
    }
    body += &shifted(terms);
    body += "    friction = friction_step(s, dx, v);\n    force = friction;\n";
    if enter(Sum::Level) {
        body += &added(terms, Sum::Level, "level");
        body += "    force = level > 0.0f ? force * level : 0.0f;\n";
    }
    body += &added(terms, Sum::Force, "force");
    format!("\n{declared}\n{{\n{body}    return force;\n}}\n")
}

/// The displacement that is left once the encoder's error is taken off both ends.
fn shifted(terms: &[Term]) -> String {
    let shifts = terms.iter().filter(|term| term.c.sum == Sum::Shift);
    let shifts: Vec<&str> = shifts.map(|term| term.value.as_str()).collect();
    if shifts.is_empty() {
        return String::new();
    }
    format!(
        "    if (s->located) {{\n        const float shift = {};\n        if (s->shifted) {{\n            dx += shift - s->shift;\n        }}\n        s->shift = shift;\n        s->shifted = true;\n        x += shift;\n    }}\n",
        shifts.join(" + ")
    )
}

/// The lines that add the terms of a sum, what they remember brought up to date.
fn added(terms: &[Term], sum: Sum, into: &str) -> String {
    let mut lines = String::new();
    for term in terms.iter().filter(|term| term.c.sum == sum) {
        if let Some([_, next]) = &term.memory {
            let _ = writeln!(lines, "    s->{} = {next};", term.id);
        }
        let add = format!("{into} += {};", term.value);
        let _ = match term.c.placed {
            true => writeln!(lines, "    if (s->located) {{\n        {add}\n    }}"),
            false => writeln!(lines, "    {add}"),
        };
    }
    lines
}
