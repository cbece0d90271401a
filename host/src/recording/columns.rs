//! Which column is what: names with SI units, `--map`, and columns that claim the same role.

use super::error::Problem;
use super::{EffortRole, MotionKind, Needs, Warning};

/// A role that a column can have in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    Time,
    Position,
    Reference,
    Velocity,
    Effort,
    Temperature,
    Load,
    Pressure,
    Segment,
    Repeat,
}

impl Slot {
    fn words(self) -> &'static str {
        match self {
            Slot::Time => "time",
            Slot::Position => "position",
            Slot::Reference => "reference position",
            Slot::Velocity => "velocity",
            Slot::Effort => "effort (force, friction, torque, current or voltage)",
            Slot::Temperature => "temperature",
            Slot::Load => "normal load",
            Slot::Pressure => "pressure",
            Slot::Segment => "segment",
            Slot::Repeat => "repeat",
        }
    }
    /// Segment and repeat hold numbers of parts, not physical quantities.
    pub(super) fn is_label(self) -> bool {
        matches!(self, Slot::Segment | Slot::Repeat)
    }
}

/// A column name that is understood.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) name: &'static str,
    /// The quantity: the name without its unit.
    stem: &'static str,
    pub(super) slot: Slot,
    axis: Option<MotionKind>,
    role: Option<EffortRole>,
}

const fn known(
    name: &'static str,
    stem: &'static str,
    slot: Slot,
    axis: Option<MotionKind>,
    role: Option<EffortRole>,
) -> Known {
    Known {
        name,
        stem,
        slot,
        axis,
        role,
    }
}

const LINEAR: Option<MotionKind> = Some(MotionKind::Linear);
const ROTARY: Option<MotionKind> = Some(MotionKind::Rotary);

/// The format's column names (design, "Recording").
#[rustfmt::skip]
const KNOWN: [Known; 18] = [
    known("t_s", "t", Slot::Time, None, None),
    known("x_m", "x", Slot::Position, LINEAR, None),
    known("q_rad", "q", Slot::Position, ROTARY, None),
    known("x_ref_m", "x_ref", Slot::Reference, LINEAR, None),
    known("q_ref_rad", "q_ref", Slot::Reference, ROTARY, None),
    known("v_m_s", "v", Slot::Velocity, LINEAR, None),
    known("qd_rad_s", "qd", Slot::Velocity, ROTARY, None),
    known("force_N", "force", Slot::Effort, LINEAR, Some(EffortRole::Force)),
    known("friction_N", "friction", Slot::Effort, LINEAR, Some(EffortRole::Friction)),
    known("torque_Nm", "torque", Slot::Effort, ROTARY, Some(EffortRole::Torque)),
    known("current_A", "current", Slot::Effort, None, Some(EffortRole::Current)),
    known("voltage_V", "voltage", Slot::Effort, None, Some(EffortRole::Voltage)),
    known("temperature_C", "temperature", Slot::Temperature, None, None),
    known("normal_N", "normal", Slot::Load, None, None),
    known("load_N", "load", Slot::Load, None, None),
    known("pressure_Pa", "pressure", Slot::Pressure, None, None),
    known("segment", "segment", Slot::Segment, None, None),
    known("repeat", "repeat", Slot::Repeat, None, None),
];

/// Words that units are made of, so that `v_mm_s` is a velocity in a wrong unit, while
/// `torque_std_Nm` is another quantity.
const UNIT_WORDS: &[&str] = &[
    "m", "mm", "um", "nm", "cm", "km", "in", "inch", "ft", "s", "ms", "us", "ns", "min", "h",
    "sec", "rad", "mrad", "urad", "deg", "rev", "rpm", "hz", "n", "mn", "kn", "lbf", "kgf", "nmm",
    "mnm", "a", "ma", "v", "mv", "c", "k", "f", "pa", "kpa", "mpa", "bar", "mbar", "psi", "per",
    "counts", "count",
];

const NO_UNIT: &str = "has no unit";

/// What a column's name says.
enum Reading {
    Known(&'static Known),
    /// A known quantity whose unit is missing or unknown.
    Unit(&'static Known, String),
    Other,
}

fn read_name(name: &str) -> Reading {
    if let Some(k) = KNOWN.iter().find(|k| k.name == name) {
        return Reading::Known(k);
    }
    let lower = name.to_ascii_lowercase();
    let suffix_of = |k: &Known| -> Option<&str> {
        let rest = lower.strip_prefix(k.stem)?;
        if rest.is_empty() {
            Some("")
        } else {
            rest.strip_prefix('_')
        }
    };
    // The longest quantity wins: `x_ref_mm` is a reference, not a position in `ref_mm`.
    let Some((k, suffix)) = KNOWN
        .iter()
        .filter(|k| !k.slot.is_label())
        .filter_map(|k| suffix_of(k).map(|s| (k, s)))
        .max_by_key(|(k, _)| k.stem.len())
    else {
        return Reading::Other;
    };
    if suffix.is_empty() {
        return Reading::Unit(k, NO_UNIT.into());
    }
    let words: Vec<&str> = suffix.split('_').collect();
    if words.len() > 1 && !words.iter().all(|w| UNIT_WORDS.contains(w)) {
        return Reading::Other;
    }
    let spelt = name.get(k.stem.len() + 1..).unwrap_or(suffix);
    let reason = if lower == k.name.to_ascii_lowercase() {
        "is not spelt as expected (case matters in units)".to_string()
    } else {
        format!("has the unknown unit `{spelt}`")
    };
    Reading::Unit(k, reason)
}

/// A column of the recording: the product of a number and columns of the file.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) known: &'static Known,
    pub(super) factor: f64,
    /// Indices of the file's columns; at least one.
    pub(super) columns: Vec<usize>,
    /// Chosen by `--map`; then text labels are accepted for segments and repeats.
    pub(super) mapped: bool,
}

/// What to read from a file and what it means.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) kind: MotionKind,
    pub(super) role: EffortRole,
    pub(super) sources: Vec<Source>,
    /// Columns that have no role.
    pub(super) unused: Vec<usize>,
    pub(super) warnings: Vec<Warning>,
}

/// Reads `35.1507*vir` as a number times columns. A column may itself be called `a*b`.
fn read_product(map: &str, text: &str, columns: &[String]) -> Result<(f64, Vec<usize>), Problem> {
    let find = |name: &str| columns.iter().position(|c| c == name);
    let text = text.trim();
    if let Some(i) = find(text) {
        return Ok((1.0, vec![i]));
    }
    let (mut factor, mut used) = (1.0, Vec::new());
    for part in text.split('*').map(str::trim) {
        if let Some(i) = find(part) {
            used.push(i);
        } else if let Some(number) = part.parse::<f64>().ok().filter(|n| n.is_finite()) {
            factor *= number;
        } else {
            return Err(Problem::Map {
                map: map.into(),
                reason: format!(
                    "there is no column `{part}`; the file has {}",
                    columns.join(", ")
                ),
            });
        }
    }
    if used.is_empty() {
        return Err(Problem::Map {
            map: map.into(),
            reason: "names no column; write COLUMN or FACTOR*COLUMN to the right of `=`".into(),
        });
    }
    Ok((factor, used))
}

/// Decides what each column is. `listing` describes the file's columns in messages.
pub(super) fn plan(
    columns: &[String],
    listing: &str,
    map: &[(String, String)],
    needs: Needs,
    ignore: &[String],
) -> Result<Plan, Problem> {
    if let Some(name) = ignore.iter().find(|name| !columns.contains(name)) {
        return Err(Problem::Ignore {
            name: name.clone(),
            listing: listing.into(),
        });
    }
    let mut sources: Vec<Source> = Vec::new();
    let mut taken = vec![false; columns.len()];
    for (target, expression) in map {
        let text = format!("{target}={expression}");
        let Some(known) = KNOWN.iter().find(|k| k.name == target.trim()) else {
            return Err(Problem::Map {
                map: text,
                reason: format!(
                    "`{target}` is no column of a recording; choose one of {}",
                    KNOWN.map(|k| k.name).join(", ")
                ),
            });
        };
        if let Some(other) = sources.iter().find(|s| s.known.slot == known.slot) {
            return Err(Problem::Map {
                map: text,
                reason: format!(
                    "the {} is already mapped as `{}`; keep one of them",
                    known.slot.words(),
                    other.known.name
                ),
            });
        }
        let (factor, used) = read_product(&text, expression, columns)?;
        if known.slot.is_label() && (used.len() > 1 || factor != 1.0) {
            return Err(Problem::Map {
                map: text,
                reason:
                    "segments and repeats are numbers of parts; map one column without a factor"
                        .into(),
            });
        }
        for &i in &used {
            if let Some(t) = taken.get_mut(i) {
                *t = true;
            }
        }
        sources.push(Source {
            known,
            factor,
            columns: used,
            mapped: true,
        });
    }
    let mut unused = Vec::new();
    for (i, name) in columns.iter().enumerate() {
        if taken.get(i) == Some(&true) || ignore.contains(name) {
            continue;
        }
        let slot_mapped = |k: &Known| sources.iter().any(|s| s.mapped && s.known.slot == k.slot);
        match read_name(name) {
            Reading::Known(k) if !slot_mapped(k) => {
                if let Some(first) = sources.iter().find(|s| s.known.slot == k.slot) {
                    return Err(Problem::TwoColumns {
                        role: k.slot.words(),
                        first: first.known.name.into(),
                        second: name.clone(),
                        target: first.known.name,
                        other_target: k.name,
                    });
                }
                sources.push(Source {
                    known: k,
                    factor: 1.0,
                    columns: vec![i],
                    mapped: false,
                });
            }
            Reading::Unit(k, reason) if !slot_mapped(k) => {
                return Err(Problem::Unit {
                    column: name.clone(),
                    accepted: k.name,
                    example: match reason.as_str() {
                        NO_UNIT => format!("{}={name}", k.name),
                        _ => format!("{}=FACTOR*{name}", k.name),
                    },
                    reason,
                });
            }
            _ => unused.push(i),
        }
    }
    let mut warnings = Vec::new();
    let effort = sources.iter().find(|s| s.known.slot == Slot::Effort);
    let (kind, position) = match (needs, effort.and_then(|s| s.known.axis)) {
        (Needs::Effort, Some(axis)) if sources.iter().any(|s| s.known.slot == Slot::Time) => {
            (axis, axis.name())
        }
        (Needs::Effort, _) => return Err(missing(&sources, listing, needs)),
        _ => axis_of(&sources, listing, needs)?,
    };
    if effort.is_none() && needs != Needs::Motion {
        return Err(missing(&sources, listing, needs));
    }
    if let Some(effort) = effort.filter(|s| s.known.axis.is_some_and(|axis| axis != kind)) {
        return Err(Problem::AxisMismatch {
            effort: effort.known.name.into(),
            axis: kind.name(),
            position: position.into(),
            target: if kind == MotionKind::Linear {
                "force_N"
            } else {
                "torque_Nm"
            },
        });
    }
    let role = effort.and_then(|s| s.known.role).unwrap_or(match kind {
        MotionKind::Linear => EffortRole::Force,
        MotionKind::Rotary => EffortRole::Torque,
    });
    // A motor's angle beside the stage's displacement: of no use here without a ratio.
    let mut other_axis = Vec::new();
    sources.retain(|s| {
        let fits = s.known.slot == Slot::Effort || s.known.axis.is_none_or(|axis| axis == kind);
        if !fits {
            other_axis.push(s.known.name);
            unused.extend(&s.columns);
        }
        fits
    });
    if !other_axis.is_empty() {
        warnings.push(Warning::new(
            "other-axis",
            format!(
                "{} not taken as the motion: the position `{position}` is {}; give `--map` with a ratio to use it so",
                other_axis.join(", "),
                kind.name()
            ),
        ));
    }
    unused.sort_unstable();
    Ok(Plan {
        kind,
        role,
        sources,
        unused,
        warnings,
    })
}

/// The kind of axis and the column that says so: the position, or the velocity where there is none.
fn axis_of(
    sources: &[Source],
    listing: &str,
    needs: Needs,
) -> Result<(MotionKind, &'static str), Problem> {
    let has_time = sources.iter().any(|s| s.known.slot == Slot::Time);
    [Slot::Position, Slot::Velocity]
        .iter()
        .find_map(|slot| sources.iter().find(|s| s.known.slot == *slot))
        .and_then(|s| s.known.axis.map(|axis| (axis, s.known.name)))
        .filter(|_| has_time)
        .ok_or_else(|| missing(sources, listing, needs))
}

/// Everything that is missing, in one message.
fn missing(sources: &[Source], listing: &str, needs: Needs) -> Problem {
    let has = |slot: Slot| sources.iter().any(|s| s.known.slot == slot);
    let mut missing = Vec::new();
    let mut example = "t_s";
    if needs == Needs::Effort {
        let is_force = |s: &&Source| s.known.slot == Slot::Effort && s.known.axis.is_some();
        if sources.iter().find(is_force).is_none() {
            missing.push("force or torque (`force_N` or `torque_Nm`)");
            example = "force_N";
        }
    } else if !has(Slot::Effort) && needs == Needs::Both {
        missing.push("effort (`force_N`, `friction_N`, `torque_Nm`, `current_A` or `voltage_V`)");
        let rotary = sources.iter().any(|s| s.known.axis == ROTARY);
        example = if rotary { "torque_Nm" } else { "force_N" };
    }
    if needs != Needs::Effort && !has(Slot::Position) && !has(Slot::Velocity) {
        missing.push("position (`x_m` or `q_rad`, else velocity `v_m_s` or `qd_rad_s`)");
        example = "x_m";
    }
    if !has(Slot::Time) {
        missing.push("time (`t_s`)");
        example = "t_s";
    }
    Problem::Missing {
        missing: missing.join(", no "),
        listing: listing.into(),
        example,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &str) -> Vec<String> {
        list.split(',').map(str::to_string).collect()
    }
    fn plan_of(list: &str, map: &[(&str, &str)]) -> Result<Plan, Problem> {
        let map: Vec<_> = map
            .iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect();
        plan(&names(list), list, &map, Needs::Both, &[])
    }

    #[test]
    fn other_quantities_are_not_mistaken_for_known_ones() {
        for name in [
            "voltage_cmd_V",
            "voltage_uq_raw",
            "vsupply_raw",
            "pos_error_rad",
            "qd_ref_rad_s",
            "torque_std_Nm",
            "torque_mean_Nm",
            "current_iq_A",
            "pulse_flag",
            "anticogging_on",
            "time_of_day",
            "x2_m",
            "run",
        ] {
            assert!(matches!(read_name(name), Reading::Other), "{name}");
        }
    }

    #[test]
    fn a_known_quantity_with_a_missing_or_unknown_unit_is_an_error_that_names_the_spelling() {
        for (name, accepted) in [
            ("x", "x_m"),
            ("force", "force_N"),
            ("x_furlong", "x_m"),
            ("t_ms", "t_s"),
            ("v_mm_s", "v_m_s"),
            ("x_ref_mm", "x_ref_m"),
            ("qd_rpm", "qd_rad_s"),
            ("qd_rad_per_s", "qd_rad_s"),
            ("Force_n", "force_N"),
            ("torque_mNm", "torque_Nm"),
            ("temperature_K", "temperature_C"),
            ("pressure_bar", "pressure_Pa"),
        ] {
            let error = plan_of(&format!("t_s,x_m,friction_N,{name}"), &[]).expect_err(name);
            let Problem::Unit {
                column,
                accepted: told,
                ..
            } = &error
            else {
                panic!("{name}: {error}")
            };
            assert_eq!((column.as_str(), *told), (name, accepted), "{error}");
            assert!(error.to_string().contains("--map"), "{error}");
        }
    }

    #[test]
    fn a_mapping_chooses_between_two_columns_and_scales() {
        let error = plan_of("t_s,x_m,force_N,friction_N", &[]).expect_err("two efforts");
        assert!(matches!(error, Problem::TwoColumns { .. }), "{error}");
        assert!(
            error.to_string().contains("--map friction_N=friction_N"),
            "{error}"
        );
        let plan = plan_of(
            "t_s,x_m,force_N,friction_N",
            &[("friction_N", "friction_N")],
        )
        .expect("chosen");
        assert_eq!(plan.role, EffortRole::Friction);
        assert_eq!(plan.unused, [2]);
        let plan = plan_of(
            "t,x_mm,vir,gtau",
            &[
                ("t_s", "t"),
                ("x_m", "1e-3*x_mm"),
                ("force_N", "-2 * gtau*vir"),
            ],
        )
        .expect("scaled");
        let products: Vec<_> = plan
            .sources
            .iter()
            .map(|s| (s.factor, s.columns.as_slice()))
            .collect();
        assert_eq!(products, [(1.0, &[0][..]), (1e-3, &[1]), (-2.0, &[3, 2])]);
    }

    #[test]
    fn mappings_that_cannot_be_followed_say_what_would_work() {
        for (map, hint) in [
            (vec![("force", "f")], "force_N"),
            (vec![("force_N", "g")], "t_s, x_m, f"),
            (vec![("force_N", "2")], "FACTOR*COLUMN"),
            (vec![("force_N", "")], "no column ``"),
            (
                vec![("force_N", "f"), ("friction_N", "f")],
                "already mapped",
            ),
            (
                vec![("force_N", "f"), ("segment", "2*f")],
                "without a factor",
            ),
        ] {
            let error = plan_of("t_s,x_m,f", &map).expect_err(hint);
            assert!(error.to_string().contains(hint), "{error}");
        }
    }

    #[test]
    fn all_that_is_missing_is_named_at_once() {
        let error = plan_of("qd_rad_s,torque_mean_Nm,torque_std_Nm", &[])
            .expect_err("no time")
            .to_string();
        assert!(
            error.contains("t_s") && error.contains("torque_Nm") && error.contains("torque_std_Nm"),
            "{error}"
        );
    }

    #[test]
    fn axes_do_not_mix() {
        let error = plan_of("t_s,x_m,torque_Nm", &[]).expect_err("torque on a slide");
        assert!(
            error.to_string().contains("--map force_N=FACTOR*torque_Nm"),
            "{error}"
        );
        let plan = plan_of("t_s,x_m,qd_rad_s,force_N", &[]).expect("position decides");
        assert!(plan.warnings.iter().any(|w| w.code == "other-axis"));
        assert_eq!(plan.kind, MotionKind::Linear);
        assert!(matches!(
            plan_of("t_s,x_m,q_rad,force_N", &[]),
            Err(Problem::TwoColumns { .. })
        ));
        assert!(matches!(
            plan_of("t_s,x_m,x_m,force_N", &[]),
            Err(Problem::TwoColumns { .. })
        ));
    }
}
