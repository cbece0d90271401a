//! Which column is what: columns that claim the same role, and what is missing.

use super::error::Problem;
use super::expression::Term;
use super::known::{KNOWN, Known, Slot};
use super::names::{Names, Source};
use super::propose::{propose, quoted, without_unit};
use super::units::{SECOND, Unit};
use super::words::{is_day, quantity, split, stamp_in_parts};
use super::{EffortRole, MotionKind, Needs, Warning, alone};
use std::cmp::Ordering;

/// What to read from a file and what it means.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) kind: MotionKind,
    pub(super) role: EffortRole,
    /// The file's columns, by name.
    pub(super) names: Vec<String>,
    pub(super) sources: Vec<Source>,
    /// Columns that have no role.
    pub(super) unused: Vec<usize>,
    pub(super) warnings: Vec<Warning>,
}

/// Decides what each column is.
///
/// # Errors
/// Everything that is missing or ambiguous at once, with the `--map`s that would read the file.
pub(super) fn plan(names: &Names) -> Result<Plan, Problem> {
    if let Some(name) = names
        .ignore
        .iter()
        .find(|name| !names.columns.contains(name))
    {
        return Err(Problem::Ignore {
            name: name.clone(),
            listing: names.listing.into(),
        });
    }
    let mut warnings = Vec::new();
    let mut sources = names.mapped(&mut warnings)?;
    let mut open: Vec<usize> = (0..names.columns.len())
        .filter(|i| {
            !names.ignore.contains(&names.columns[*i])
                && !sources.iter().any(|s| s.columns().any(|c| c == *i))
        })
        .collect();
    let mut complaints = Vec::new();
    open.retain(|&i| {
        let Some(k) = KNOWN.iter().find(|k| k.name == names.columns[i]) else {
            return true;
        };
        let Some(first) = sources.iter_mut().find(|s| s.known.slot == k.slot) else {
            sources.push(Source::new(k, i, None));
            return false;
        };
        if first.mapped {
            return true;
        }
        let mut left = k.name;
        match k.steps_to_the_load().cmp(&first.known.steps_to_the_load()) {
            Ordering::Equal => {
                let (one, other, role) = (first.known.name, k.name, k.slot.words());
                let remedy = match one == other {
                    true => "rename or remove one of them in the header".to_owned(),
                    false => {
                        format!("choose one with `--map {one}={one}` or `--map {other}={other}`")
                    }
                };
                complaints.push(format!(
                    "columns `{one}` and `{other}` both give the {role}; {remedy}"
                ));
                return false;
            }
            Ordering::Less => {
                left = first.known.name;
                *first = Source::new(k, i, None);
            }
            Ordering::Greater => {}
        }
        warnings.push(warning!(
            "effort-chosen",
            "`{0}` is the {1}; `{left}` gives it too, and is left out (`--map {left}={left} --ignore {0}` takes it instead)",
            first.known.name,
            k.slot.words()
        ));
        false
    });
    stamp(names, &mut sources, &mut open, &mut warnings);
    by_unit(names, &mut sources, &mut open, &mut warnings);
    one_clock(&mut sources, &mut open);

    let (kind, role) = axis_and_role(names, &sources, &mut complaints);
    if !complaints.is_empty() {
        let unsaid = without_unit(names, &sources, &open);
        if !unsaid.is_empty() {
            complaints.push(format!("no known unit at {}", unsaid.join(", ")));
        }
        let maps = propose(names, &sources, &open);
        return Err(Problem::columns(
            &complaints.join("; "),
            names.listing,
            maps,
        ));
    }
    other_axis(kind, &mut sources, &mut open, &mut warnings);
    open.sort_unstable();
    let (named, nameless): (Vec<usize>, Vec<usize>) =
        open.iter().partition(|i| !names.columns[**i].is_empty());
    if let Some(first) = nameless.first() {
        warnings.push(warning!(
            "nameless-column",
            "{} of the columns, the first of them number {}, have no name in the header and are left out; name what is to be used",
            nameless.len(),
            first + 1
        ));
    }
    Ok(Plan {
        kind,
        role,
        names: names.columns.to_vec(),
        sources,
        unused: named,
        warnings,
    })
}

/// Takes the two parts of a stamp for the time, where nothing else is.
fn stamp(
    names: &Names,
    sources: &mut Vec<Source>,
    open: &mut Vec<usize>,
    warnings: &mut Vec<Warning>,
) {
    let has_time = sources.iter().any(|s| s.known.slot == Slot::Time);
    let Some((whole, part, seconds)) = stamp_in_parts(names.columns).filter(|_| !has_time) else {
        return;
    };
    let known = KNOWN.iter().find(|k| k.slot == Slot::Time);
    let (Some(known), true) = (known, [whole, part].iter().all(|i| open.contains(i))) else {
        return;
    };
    let mut source = Source::new(known, whole, None);
    source.terms.push(Term {
        factor: seconds,
        columns: vec![part],
    });
    sources.push(source);
    open.retain(|i| ![whole, part].contains(i));
    warnings.push(warning!(
        "columns-taken",
        "a stamp in two parts: {}={}+{seconds:e}*{}",
        known.name,
        names.columns[whole],
        names.columns[part]
    ));
}

/// Of a time and a time step one is the clock: what was mapped, or else the time.
fn one_clock(sources: &mut Vec<Source>, open: &mut Vec<usize>) {
    let of = |slot: Slot| sources.iter().find(|s| s.known.slot == slot);
    let (Some(time), Some(step)) = (of(Slot::Time), of(Slot::Step)) else {
        return;
    };
    let left = match step.mapped && !time.mapped {
        true => Slot::Time,
        false => Slot::Step,
    };
    sources.retain(|s| {
        let out = s.known.slot == left;
        if out {
            open.extend(s.columns());
        }
        !out
    });
}

/// Takes columns whose name says the quantity and a known unit, where nothing else has the role.
fn by_unit(
    names: &Names,
    sources: &mut Vec<Source>,
    open: &mut Vec<usize>,
    warnings: &mut Vec<Warning>,
) {
    let mut taken: Vec<(usize, &'static Known, Unit)> = Vec::new();
    let is_time = |i: &usize| quantity(&names.columns[*i]).slot == Some(Slot::Time);
    let has_time = open.iter().any(is_time);
    for &i in open.iter() {
        let name = &names.columns[i];
        let said = quantity(name);
        let day = (is_day(name) && !has_time).then_some(Slot::Time);
        let Some(slot) = said.slot.or(day) else {
            continue;
        };
        // Time without a unit is in seconds, which the warning says.
        let clock = matches!(slot, Slot::Time | Slot::Step) && !said.is_count;
        let bare = (clock && split(name).1.is_none()).then_some(SECOND);
        let Some(unit) = names.unit(i).or(bare) else {
            continue;
        };
        let fits = |k: &&Known| k.slot == slot && k.dimension == Some(unit.dimension);
        if let Some(known) = KNOWN.iter().find(fits) {
            taken.push((i, known, unit));
        }
    }
    let alone = |(_, known, _): &(usize, &'static Known, Unit)| {
        let rivals = taken.iter().filter(|t| t.1.slot == known.slot).count();
        let has_time = sources.iter().any(|s| s.known.slot == Slot::Time)
            || taken.iter().any(|t| t.1.slot == Slot::Time);
        rivals == 1
            && !sources.iter().any(|s| s.known.slot == known.slot)
            && !(known.slot == Slot::Step && has_time)
    };
    let is_claimed = |slot: Slot| {
        sources.iter().any(|s| s.known.slot == slot) || taken.iter().any(|t| t.1.slot == slot)
    };
    let more = alone::taken(names, open, is_claimed);
    let mut taken: Vec<_> = taken.iter().filter(|t| alone(t)).copied().collect();
    taken.extend(more);
    let said: Vec<String> = taken
        .iter()
        .map(|(i, known, unit)| match unit {
            Unit {
                factor: 1.0,
                offset: 0.0,
                ..
            } => format!(
                "{}={}{}",
                known.name,
                names.columns[*i],
                match known.slot {
                    _ if names.unit(*i).is_some() => "",
                    Slot::Time =>
                        " (no unit: taken as seconds, or as the date or time of day that it is)",
                    Slot::Step => " (no unit: taken as seconds)",
                    _ => "",
                }
            ),
            Unit {
                factor,
                offset: 0.0,
                ..
            } => format!("{}={factor}*{}", known.name, names.columns[*i]),
            Unit { offset, .. } => format!("{}={} {offset:+}", known.name, names.columns[*i]),
        })
        .collect();
    if !said.is_empty() {
        warnings.push(warning!(
            "columns-taken",
            "by their names and units: {}",
            said.join(", ")
        ));
    }
    open.retain(|i| !taken.iter().any(|t| t.0 == *i));
    sources.extend(taken.into_iter().map(|(i, known, unit)| Source {
        stated: names.unit(i).is_some(),
        ..Source::new(known, i, Some(unit))
    }));
}

/// The kind of axis and the effort's role; what is missing or does not fit goes to the complaints.
fn axis_and_role(
    names: &Names,
    sources: &[Source],
    complaints: &mut Vec<String>,
) -> (MotionKind, EffortRole) {
    let of = |slot: Slot| sources.iter().find(|s| s.known.slot == slot);
    let effort = of(Slot::Effort);
    let motion = of(Slot::Position).or(of(Slot::Velocity));
    let needs = names.needs;
    match (needs, effort.map(|e| e.known.axis)) {
        (Needs::Both | Needs::Speeds, None) => complaints.push("no effort (`force_N`, `friction_N`, `torque_Nm`, `current_A`, `voltage_V` or `effort_raw`)".into()),
        (Needs::Effort, None | Some(None)) => complaints.push("no force or torque (`force_N` or `torque_Nm`)".into()),
        _ => {}
    }
    if needs != Needs::Effort && motion.is_none() {
        complaints
            .push("no position (`x_m` or `q_rad`, else velocity `v_m_s` or `qd_rad_s`)".into());
    }
    if needs != Needs::Speeds && of(Slot::Time).or(of(Slot::Step)).is_none() {
        complaints.push(match (of(Slot::Position), of(Slot::Velocity)) {
            (None, Some(_)) => "no time (`t_s`, or the step between samples `dt_s`, which may be a number; a table of speed and effort without time is for `preslide identify`)".into(),
            _ => "no time (`t_s`, or the step between samples `dt_s`, which may be a number)".into(),
        });
    }
    let by_time = [Slot::Time, Slot::Step, Slot::Position]
        .into_iter()
        .find_map(of);
    if let (Needs::Speeds, Some(clock)) = (needs, by_time) {
        complaints.push(format!(
            "no table without time, for it has `{}`",
            clock.known.name
        ));
    }
    let by_effort = effort.and_then(|e| e.known.axis);
    let by_motion = motion.and_then(|m| m.known.axis);
    let kind = match needs {
        Needs::Effort => by_effort.or(by_motion),
        _ => by_motion.or(by_effort),
    };
    let kind = kind.unwrap_or(MotionKind::Linear);
    if let (Some(e), Some(m)) = (effort, motion)
        && needs != Needs::Effort
        && e.known.axis.is_some_and(|axis| axis != kind)
    {
        let named = |source: &Source| {
            let column = source.columns().next();
            column.map_or(source.known.name, |i| names.columns[i].as_str())
        };
        let (target, factor) = match kind {
            MotionKind::Linear => ("force_N", "2π over the screw's lead (m)"),
            MotionKind::Rotary => ("torque_Nm", "the lever arm (m)"),
        };
        let effort = named(e);
        complaints.push(format!(
            "no effort of the {kind} position `{motion}`: take `{effort}` as it is with --map {raw}, or convert it with --map {converted}, where FACTOR is {factor}",
            kind = kind.name(),
            motion = named(m),
            raw = quoted(&format!("effort_raw={effort}")),
            converted = quoted(&format!("{target}=FACTOR*{effort}")),
        ));
    }
    let role = effort.and_then(|s| s.known.role).unwrap_or(match kind {
        MotionKind::Linear => EffortRole::Force,
        MotionKind::Rotary => EffortRole::Torque,
    });
    (kind, role)
}

/// A motor's angle beside the stage's displacement: of no use as a motion without a ratio.
fn other_axis(
    kind: MotionKind,
    sources: &mut Vec<Source>,
    open: &mut Vec<usize>,
    warnings: &mut Vec<Warning>,
) {
    let mut other = Vec::new();
    sources.retain(|s| {
        let fits = s.known.slot == Slot::Effort || s.known.axis.is_none_or(|axis| axis == kind);
        if !fits {
            other.push(s.known.name);
            open.extend(s.columns());
        }
        fits
    });
    if !other.is_empty() {
        warnings.push(warning!(
            "other-axis",
            "{} not taken as the motion, which is {}; to use it, give `--map` with a ratio",
            other.join(", "),
            kind.name()
        ));
    }
}

#[cfg(test)]
mod tests;
