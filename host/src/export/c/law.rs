//! The friction model in C: what it remembers, and its code.

use super::{define, filled, literal};
use crate::export::constants::of_friction;
use preslide::Units;
use preslide_fit::friction::FrictionModel;
use preslide_fit::kernel::{Kernel, WholeNumbers};
use preslide_fit::model::Model;
use std::fmt::Write as _;

/// A friction model.
pub(super) struct Law {
    /// What it remembers: declarations, and the statements that set it to rest.
    pub(super) memory: &'static [(&'static str, &'static str)],
    /// Stiffnesses and yields of its blocks, as arrays.
    pub(super) arrays: String,
    /// Its functions.
    pub(super) code: String,
    /// Whether its force is, whatever the input: damping of bristles grows with speed.
    pub(super) bounded: bool,
}

const SLIDING: &str = include_str!("law/sliding.c");
pub(super) const SHIFTS: &str = include_str!("law/shifts.c");
/// Slip-reserve blocks in whole numbers.
pub(super) const BLOCKS: &str = concat!(
    include_str!("law/shifts.c"),
    "\n",
    include_str!("law/blocks.c")
);
const DEFLECTIONS: (&str, &str) = (
    "float deflection[@@BLOCKS]; /* of each block */",
    "for (i = 0; i < @@BLOCKS; ++i) {\n        s->deflection[i] = 0.0f;\n    }",
);

/// A constant: what is said of it, its name, and its value.
pub(super) type Constant = (&'static str, &'static str, String);

pub(super) fn beyond(places: u32) -> Constant {
    let said = "Binary places of a path beyond its units of length";
    (said, "BEYOND", places.to_string())
}

impl Law {
    /// The packed kernel's, a block after the other: the same bits.
    ///
    /// # Errors
    /// A model that it cannot hold.
    pub(super) fn packed(model: &Model) -> Result<Self, String> {
        let numbers = whole_numbers(Kernel::PackedF32, model, 1.0, Units::SI)?;
        let (length, _, force) = numbers.places;
        let units = [
            (
                "Parts of 1/65536 of a unit of length in a metre or radian",
                "PER_LENGTH",
                literal(65536.0 * 2_f64.powi(length as i32)),
            ),
            beyond(16),
            (
                match model.effort_unit {
                    Some(_) => "A unit of force, in the model's effort_unit",
                    None => "A unit of force (N or N m)",
                },
                "FORCE",
                literal(2_f64.powi(-force)),
            ),
        ];
        let units = units.map(|(said, name, value)| define(said, name, &value));
        let code = [BLOCKS, include_str!("law/packed.c")].concat();
        Ok(Self::of_blocks(&numbers, units.concat(), code))
    }

    /// Slip-reserve blocks in whole numbers, behind other constants.
    pub(super) fn of_blocks(numbers: &WholeNumbers, constants: String, code: String) -> Self {
        let limit: i32 = numbers.blocks.iter().map(|[full, k]| full / 2 * k).sum();
        let limit = define(
            "All blocks slipping, in units of force",
            "LIMIT",
            &limit.to_string(),
        );
        let said = [
            "Twice the displacement at which each slips, in units of length.",
            "Stiffness of each block, in units of force per unit of length.",
        ];
        Self {
            memory: &[
                (
                    "int32_t remainder; /* of the path, less than a unit of length */",
                    "s->remainder = 1 << (BEYOND - 1);",
                ),
                ("bool backward; /* it moves */", "s->backward = false;"),
                (
                    "int32_t reserve[@@BLOCKS]; /* of each block before it slips */",
                    "for (i = 0; i < @@BLOCKS; ++i) {\n        s->reserve[i] = FULLS[i] / 2;\n    }",
                ),
            ],
            arrays: constants + &limit + &of_each_block(numbers, said, ["FULLS", "STIFFNESSES"]),
            code,
            bounded: true,
        }
    }

    /// # Errors
    /// A model that C has not.
    pub(super) fn of(model: &Model) -> Result<Self, String> {
        let lag = |attraction: f64| match attraction {
            f64::INFINITY => include_str!("law/no_lag.c"),
            _ => include_str!("law/lag.c"),
        };
        let (memory, parts): (&'static [(&str, &str)], Vec<&str>) = match &model.friction {
            FrictionModel::Coulomb { .. } => (&[], vec![include_str!("law/coulomb.c")]),
            FrictionModel::Dahl { .. } => (
                &[(
                    "float share; /* of the Coulomb force */",
                    "s->share = 0.0f;",
                )],
                vec![include_str!("law/dahl.c")],
            ),
            FrictionModel::LuGre { .. } => (
                &[(
                    "float deflection; /* of the bristles */",
                    "s->deflection = 0.0f;",
                )],
                vec![SLIDING, include_str!("law/lugre.c")],
            ),
            FrictionModel::Gms { sliding: None, .. } => {
                (&[DEFLECTIONS], vec![include_str!("law/quasi_static.c")])
            }
            FrictionModel::Gms {
                sliding: Some(sliding),
                ..
            } => (
                &[
                    DEFLECTIONS,
                    (
                        "uint32_t slipping; /* a bit for each block */",
                        "s->slipping = 0u;",
                    ),
                    ("float direction; /* 1 or -1 */", "s->direction = 1.0f;"),
                ],
                vec![SLIDING, lag(sliding.attraction), include_str!("law/gms.c")],
            ),
            other => {
                return Err(format!(
                    "C has no {} yet; `preslide export` without --lang writes it in Rust, `preslide identify` finds a GMS model, which C has",
                    other.kind()
                ));
            }
        };
        let constants = of_friction(model);
        let scalars = model.friction.scalars();
        let keys: Vec<(&str, &str)> = scalars
            .iter()
            .zip(&constants)
            .map(|((key, _), constant)| (*key, constant.name.as_str()))
            .collect();
        Ok(Self {
            memory,
            arrays: arrays(&model.friction),
            code: filled(&parts.join("\n"), &keys),
            bounded: !matches!(model.friction, FrictionModel::LuGre { damping, .. } if damping != 0.0),
        })
    }
}

/// What a kernel computes with.
///
/// # Errors
/// Why it cannot run the model.
pub(super) fn whole_numbers(
    kernel: Kernel,
    model: &Model,
    sample_time: f64,
    units: Units,
) -> Result<WholeNumbers, String> {
    let numbers = kernel.whole_numbers(&model.friction, sample_time, units);
    let numbers = numbers.ok_or("only Maxwell slip has whole numbers")?;
    numbers.map_err(|reason| format!("--kernel {} cannot run this model: {reason}", kernel.name()))
}

/// Two arrays of the blocks in whole numbers.
pub(super) fn of_each_block(numbers: &WholeNumbers, said: [&str; 2], names: [&str; 2]) -> String {
    let array = |of: usize| {
        let values: Vec<String> = numbers.blocks.iter().map(|b| b[of].to_string()).collect();
        let (said, name, values) = (said[of], names[of], values.join(", "));
        format!("/* {said} */\nstatic const int32_t {name}[@@BLOCKS] = {{ {values} }};\n")
    };
    array(0) + &array(1)
}

/// The blocks in the numbers that are computed with.
fn arrays(friction: &FrictionModel) -> String {
    let FrictionModel::Gms {
        breakaway, blocks, ..
    } = friction
    else {
        return String::new();
    };
    let mut text = String::new();
    let mut array = |said: &str, name: &str, of: &dyn Fn(&preslide::Block) -> f64| {
        let values: Vec<String> = blocks.iter().map(|b| literal(of(b))).collect();
        let _ = writeln!(
            text,
            "/* {said} */\nstatic const float {name}[@@BLOCKS] = {{ {} }};",
            values.join(", ")
        );
    };
    array("Stiffness of each block.", "STIFFNESSES", &|b| b.stiffness);
    array("Displacement at which each slips.", "YIELDS", &|b| {
        b.yield_displacement(*breakaway)
    });
    text
}
