//! A model as a pair of C99 files, in single precision and SI units or in whole numbers: no heap, no library but `math.h`.
//!
//! The laws are those of the Rust library, written once more as templates: `law/*.c`, and an expression beside each effect's
//! [form](preslide_fit::effects::form). What holds the two together are the program's tests, which compile the C and run both along a million steps.

mod file;
mod law;
mod step;
mod term;
mod whole;

use super::constants::{Constant, of_bounds, of_friction};
use super::terms::{carried, numbered};
use super::{Options, fitting, no_refused, remarks};
use file::File;
use law::Law;
use preslide_fit::kernel::{Arithmetic, Kernel};
use preslide_fit::model::Model;
use term::Term;

/// Functions that a term may call, each used or left out, those that call others behind them.
const HELPERS: &str = include_str!("helpers.c");
/// What stands for the sample time in the code.
const SAMPLE_TIME: &str = "SAMPLE_TIME_S";

/// The pair of files.
#[derive(Clone, Debug)]
pub struct C {
    /// `NAME.h`.
    pub header: String,
    /// `NAME.c`.
    pub source: String,
    /// Ticks per second (Hz) that it is for, where time plays a part in it.
    pub rate: Option<f64>,
}

/// A model as C, all names beginning with `name`.
///
/// # Errors
/// A name that is none in C; effects or friction that C has not; a bound or a rate that is needed and not given.
pub fn c_source(model: &Model, options: &Options, name: &str) -> Result<C, String> {
    check_name(name)?;
    no_refused(model)?;
    let effects = carried(model);
    let law = match fitting(options.kernel, model)? {
        Some(kernel) if kernel.arithmetic() == Arithmetic::I16F16 => {
            return whole::c_source(model, &effects, options, name, kernel);
        }
        Some(Kernel::PackedF32) => Law::packed(model)?,
        _ => Law::of(model)?,
    };
    let terms: Vec<Term> = numbered(&effects)
        .map(|(id, effect)| Term::of(model, effect, id))
        .collect::<Result<_, String>>()?;
    let step = step::declared(model, law.bounded);
    let code = format!("{}{}", law.code, step::step(model, &terms, &step[0]));
    let mut constants: Vec<Constant> = of_friction(model);
    constants.extend(of_bounds(model, options)?);
    let rate = rate(options, &law, &terms)?;
    let file = File {
        model,
        name,
        remarks: &remarks(model, options)?,
        defines: rate.map_or_else(String::new, of_rate),
        step,
        timed: rate.is_some(),
        math: true,
        terms: &terms,
        law: &law,
    };
    Ok(C {
        header: file.header(),
        source: file.source(&constants, &helpers(&code), &code),
        rate,
    })
}

fn check_name(name: &str) -> Result<(), String> {
    let letter = |c: char| c.is_ascii_lowercase() || c == '_';
    let is_one = name.starts_with(letter) && name.chars().all(|c| letter(c) || c.is_ascii_digit());
    is_one.then_some(()).ok_or_else(|| {
        format!("-o {name}.c: the file's name begins the names in the code; give one of small letters, digits and `_`, such as stage_model.c")
    })
}

/// Ticks per second (Hz), where time plays a part.
fn rate(options: &Options, law: &Law, terms: &[Term]) -> Result<Option<f64>, String> {
    let friction = law
        .code
        .contains(SAMPLE_TIME)
        .then_some("the friction's attraction");
    let effects = terms.iter().filter(|t| t.is_timed()).map(|t| t.id.as_str());
    given_rate(
        options,
        &friction.into_iter().chain(effects).collect::<Vec<_>>(),
    )
}

/// The same, where it does in what is `timed`.
fn given_rate(options: &Options, timed: &[&str]) -> Result<Option<f64>, String> {
    match options.rate {
        Some(rate) if !(rate.is_finite() && rate > 0.0) => {
            Err("--rate: give the ticks per second, above zero (Hz)".to_owned())
        }
        None if !timed.is_empty() => Err(format!(
            "--rate: give the ticks per second (Hz) at which the code is stepped; time plays a part in {}",
            timed.join(", ")
        )),
        rate => Ok(rate.filter(|_| !timed.is_empty())),
    }
}

fn of_rate(rate: f64) -> String {
    define("Calls of @step per second", "@@RATE_HZ", &literal(rate))
}

/// The helpers that the code calls, and those that these call.
fn helpers(code: &str) -> String {
    let mut needed: Vec<&str> = Vec::new();
    for helper in HELPERS.rsplit("---\n") {
        let named = helper
            .split_once("static float ")
            .map_or("", |(_, rest)| rest);
        let call = format!("{}(", named.split('(').next().unwrap_or_default());
        if code.contains(&call) || needed.iter().any(|n| n.contains(&call)) {
            needed.push(helper);
        }
    }
    needed.reverse();
    needed.join("\n")
}

/// A template with the constants of its keys, the longest key first: one may begin another.
fn filled(text: &str, keys: &[(&str, &str)]) -> String {
    let mut keys = keys.to_vec();
    keys.sort_by_key(|(key, _)| std::cmp::Reverse(key.len()));
    keys.iter().fold(text.to_owned(), |text, (key, name)| {
        text.replace(&format!("${key}"), name)
    })
}

/// A number in single precision as C reads it back.
fn literal(value: f64) -> String {
    match value as f32 {
        f32::INFINITY => "INFINITY".to_owned(),
        single => format!("{single:?}f"),
    }
}

/// A constant, and what it is.
fn define(said: &str, name: &str, value: &str) -> String {
    format!("/* {said}. */\n#define {name} {value}\n")
}
