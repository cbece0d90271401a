//! A model in whole numbers, I16F16 in and out, for cores without a float unit: the bits of the library's kernel.

use super::file::File;
use super::law::{BLOCKS, Law, SHIFTS, beyond, of_each_block, whole_numbers};
use super::{C, Options, define, filled, given_rate, literal, of_rate};
use crate::export::bound::bounds;
use crate::export::constants::{FORCE_BOUND, name_of};
use crate::export::remarks;
use preslide::fixed::types::I16F16;
use preslide::{Scalar, Units, to_scalar};
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::{CONSTANT_FORCE, VISCOUS};
use preslide_fit::kernel::{Curves, Kernel, WholeNumbers};
use preslide_fit::model::Model;

/// Binary places by which a velocity is made finer: so many and one more would leave a single bit of it.
const MOST_PLACES: u32 = 30;

const FINER: &str = include_str!("law/finer.c");

pub(super) fn c_source(
    model: &Model,
    effects: &[Effect],
    options: &Options,
    name: &str,
    kernel: Kernel,
) -> Result<C, String> {
    refuse_others(effects, kernel)?;
    let rate = rate(effects, options, kernel)?;
    let units = units(model, options, rate)?;
    let numbers = whole_numbers(kernel, model, rate.map_or(1.0, f64::recip), units)?;
    let (_, velocity, _) = numbers.places;
    if velocity > MOST_PLACES {
        return Err("--count: a count a tick is far faster than where this model's Stribeck curve levels out".to_owned());
    }
    let (constants, sum) = forces(model, options, &numbers, units)?;
    let law = law(&numbers, constants);
    let [dx, v] = ["displacement_q16", "velocity_q16"];
    let declared = format!("int32_t @step(@state *s, int32_t {dx}, int32_t {v})");
    let viscous = match sum.contains("viscous") {
        true => include_str!("law/viscous.c"),
        false => "",
    };
    let code = format!(
        "{}{viscous}\n{declared}\n{{\n    return friction_step(s, {dx}, {v}){};\n}}\n",
        law.code,
        filled(&sum, &[("v", v)])
    );
    let said = format!(
        "The force that holds against friction and effects, in parts of @@ONE of its unit: add it to the controller's before the limiter.\n   {dx}: since the step before; {v}: now{}. Bounded whatever the input.",
        match rate {
            Some(_) => "",
            None => ", which plays no part here",
        }
    );
    let file = File {
        model,
        name,
        remarks: &remarks(model, options)?,
        defines: of_units(model, units, rate),
        step: [declared, said],
        timed: false,
        math: false,
        terms: &[],
        law: &law,
    };
    Ok(C {
        header: file.header(),
        source: file.source(&[], "", &code),
        rate,
    })
}

/// # Errors
/// Effects that C has in single precision alone: which, and what to do.
fn refuse_others(effects: &[Effect], kernel: Kernel) -> Result<(), String> {
    let others = effects.iter().map(Effect::id);
    let mut others: Vec<&str> = others
        .filter(|id| ![VISCOUS.id, CONSTANT_FORCE.id].contains(id))
        .collect();
    // One of an id leaves all of them out.
    others.sort_unstable();
    others.dedup();
    if others.is_empty() {
        return Ok(());
    }
    let without: Vec<String> = others.iter().map(|id| format!("--without {id}")).collect();
    Err(format!(
        "--kernel {}: in whole numbers C has no {}; leave out what can be with {}, or take --kernel {} or none, which is single precision, or Rust, which has all of them",
        kernel.name(),
        others.join(", "),
        without.join(" "),
        match kernel.has_sliding() {
            true => Kernel::GmsF32.name(),
            false => Kernel::PackedF32.name(),
        }
    ))
}

/// Ticks per second (Hz), where velocity plays a part: it counts in counts a tick.
fn rate(effects: &[Effect], options: &Options, kernel: Kernel) -> Result<Option<f64>, String> {
    let viscous = effects.iter().any(|effect| effect.id() == VISCOUS.id);
    let timed = [
        (kernel.has_sliding(), "the friction's Stribeck curve"),
        (viscous, VISCOUS.id),
    ];
    let timed = timed
        .into_iter()
        .filter_map(|(is, what)| is.then_some(what));
    given_rate(options, &timed.collect::<Vec<_>>())
}

/// The bound of viscous friction (N or N·m), where there is one.
fn limit(model: &Model, options: &Options) -> Result<Option<f64>, String> {
    let bounds = bounds(model, options)?;
    Ok(bounds.first().map(|bound| bound.value))
}

/// What 1 stands for in the numbers that go in and out: a count, a count a tick, and the power of ten of which the breakaway force is 100
/// to 1000, so that ten times that fits, as does a ten-thousandth. A bound or a constant force beyond ten times the breakaway force takes
/// its place.
fn units(model: &Model, options: &Options, rate: Option<f64>) -> Result<Units, String> {
    let length = options.count.ok_or(
        "--count: whole numbers count in encoder counts; give the length of one (m or rad)",
    )?;
    let breakaway = model.friction.breakaway().unwrap_or(1.0);
    let beside = limit(model, options)?
        .unwrap_or(0.0)
        .max(model.constant_force.abs());
    // The default bound is ten times that force but for the last bit, which must not move the power of ten.
    let largest = match beside > 10.001 * breakaway {
        true => beside / 10.0,
        false => breakaway,
    };
    Ok(Units {
        length,
        force: 10_f64.powi(largest.log10().floor() as i32 - 2),
        velocity: length * rate.unwrap_or(1.0),
    })
}

/// The units as constants of the header.
fn of_units(model: &Model, units: Units, rate: Option<f64>) -> String {
    let key = |key: &str| format!("@@{}", name_of(model, key).to_uppercase());
    let mut defines = define(
        "Displacement, velocity and force are whole numbers of which so many make 1 of the units below",
        "@@ONE",
        "65536",
    );
    defines += &define(
        "A displacement of 1 (m, or rad on a rotary axis) is an encoder count: (now - before) * @@ONE, for less than 32768 counts a step",
        &key("count_m"),
        &literal(units.length),
    );
    if let Some(rate) = rate {
        defines += &define(
            "A velocity of 1 is a count a step, as of displacements: a mean of some, where counts are coarse",
            &key("velocity_m_s"),
            &literal(units.velocity),
        );
        defines += &of_rate(rate);
    }
    let said = match model.effort_unit {
        Some(unit) => format!("A force of 1 ({unit})"),
        None => "A force of 1 (N, or N m on a rotary axis)".to_owned(),
    };
    defines + &define(&said, &key("force_N"), &literal(units.force))
}

fn law(numbers: &WholeNumbers, constants: String) -> Law {
    let (length, velocity, force) = numbers.places;
    // The library's number has 16 binary places.
    let to_force = match force - 16 {
        0 => String::new(),
        finer @ 1.. => format!(" >> {}", finer.min(31)),
        coarser => format!(" * {}", 1_i64 << -coarser),
    };
    let filled = |code: &str| filled(code, &[("to_force", &to_force)]);
    let (said, name, value) = beyond(16 - length);
    let constants = constants + &define(said, name, &value);
    match &numbers.curves {
        None => {
            let code = [BLOCKS, include_str!("law/whole.c")].concat();
            Law::of_blocks(numbers, constants, filled(&code))
        }
        Some(curves) => Law {
            memory: &[
                (
                    "int32_t remainder; /* of the path, less than a unit of length */",
                    "s->remainder = 0;",
                ),
                ("bool backward; /* it moves */", "s->backward = false;"),
                (
                    "uint32_t slipping; /* a bit for each block */",
                    "s->slipping = 0u;",
                ),
                (
                    "int32_t share[@@BLOCKS]; /* of what each block can hold */",
                    "for (i = 0; i < @@BLOCKS; ++i) {\n        s->share[i] = 0;\n    }",
                ),
            ],
            arrays: constants
                + &of_each_block(
                    numbers,
                    [
                        "Growth of each block's share in a unit of length.",
                        "What each can hold, so that the upper word of its product with the share is in units of force.",
                    ],
                    ["RATES", "WEIGHTS"],
                )
                + &of_curves(curves, 1 << velocity),
            code: filled(&[SHIFTS, "\n", FINER, "\n", include_str!("law/count_gms.c")].concat()),
            bounded: true,
        },
    }
}

/// The Stribeck curve and the lag.
fn of_curves(curves: &Curves, velocity: i32) -> String {
    let (intervals, table) = &curves.table;
    let rows: Vec<String> = table
        .iter()
        .map(|[a, b, c, d]| format!("    {{ {a}, {b}, {c}, {d} }}"))
        .collect();
    let defines = [
        (
            "Units of velocity in 1/65536",
            "VELOCITY",
            velocity.to_string(),
        ),
        (
            "The longest displacement of a step, in units of length",
            "LONGEST",
            curves.longest.to_string(),
        ),
        (
            "Rows of CURVES in 2^32 units of velocity",
            "INTERVALS",
            format!("{intervals}u"),
        ),
        (
            "Beyond the last row they are flat",
            "LAST",
            format!("{}u", rows.len() - 1),
        ),
    ];
    let defines = defines.map(|(said, name, value)| define(said, name, &value));
    format!(
        "{}/* The Stribeck curve: its value in the middle of an interval of speed and its difference across, in shares; and the same of the part of\n   its way there that a slipping block goes in a step, in 1/2^31. */\nstatic const int32_t CURVES[{}][4] = {{\n{}\n}};\n",
        defines.concat(),
        rows.len(),
        rows.join(",\n")
    )
}

/// Constants of the forces beside friction, and what adds them to it.
///
/// # Errors
/// One that does not fit.
fn forces(
    model: &Model,
    options: &Options,
    numbers: &WholeNumbers,
    units: Units,
) -> Result<(String, String), String> {
    let limit = limit(model, options)?.map(|limit| limit / units.force);
    let constant = model.constant_force / units.force;
    let most = numbers.limit + limit.unwrap_or(0.0) + constant.abs();
    if most >= I16F16::greatest() {
        return Err(format!(
            "--kernel: friction and the forces beside it reach {most:.0} times {} N or N·m, and whole numbers hold {:.0}; give a lower --limit",
            units.force,
            I16F16::greatest()
        ));
    }
    let whole = |said, name, value: f64| {
        let scalar = to_scalar::<I16F16>(said, value).map_err(|reason| reason.to_string());
        scalar.map(|scalar| define(said, name, &scalar.to_bits().to_string()))
    };
    let (mut constants, mut sum) = (String::new(), String::new());
    if let Some(limit) = limit {
        let per_velocity = model.viscous * units.velocity / units.force;
        constants += &whole(
            "Viscous friction of a velocity of 1",
            "VISCOUS",
            per_velocity,
        )?;
        constants += &whole("Its bound", FORCE_BOUND, limit)?;
        sum += " + viscous($v)";
    }
    if constant != 0.0 {
        constants += &whole("Constant force", "CONSTANT_FORCE", constant)?;
        sum += " + CONSTANT_FORCE";
    }
    Ok((constants, sum))
}
