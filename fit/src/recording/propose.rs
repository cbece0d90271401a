//! Which `--map`s would read a file whose names say too little.

use super::known::{KNOWN, Known, Slot};
use super::names::{Names, Source};
use super::places::SAMPLE_TIME;
use super::units::{self, Dimension};
use super::words::{holds_word, quantity, split};
use super::{EffortRole, MotionKind, Needs, qualified};

/// Parts of names of what is asked for …
const COMMANDED: [&str; 8] = [
    "ref", "cmd", "command", "target", "set", "soll", "demand", "desired",
];
/// … of what is neither asked for nor measured of the quantity itself …
const NOT_MEASURED: [&str; 8] = [
    "std",
    "error",
    "enable",
    "limit",
    "deviation",
    "following",
    "schlepp",
    "abweichung",
];
/// … and of what feeds a drive.
const SUPPLIES: [&str; 2] = ["bus", "supply"];

/// How well a column would do for a role, by what its name says: most where it is the quantity, less where it holds its word or has a unit of it.
pub(super) fn likely(names: &Names, column: usize, slot: Slot) -> u32 {
    let name = &names.columns[column];
    let said = quantity(name);
    if said.slot == Some(slot) {
        return if said.is_count { 1 } else { 8 };
    }
    if qualified::slot(name) == Some(slot) {
        return 7;
    }
    let lower = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    if slot != Slot::Reference && has(&NOT_MEASURED) || slot == Slot::Effort && has(&SUPPLIES) {
        return 0;
    }
    let word = if holds_word(name, slot) { 4 } else { 0 };
    let unit = if is_of(names, column, slot) { 2 } else { 0 };
    // Of two positions or efforts the measured one; where an axis follows its reference closely the command is the effort.
    match slot != Slot::Reference && has(&COMMANDED) {
        true if slot == Slot::Effort => (word + unit).min(1),
        true => 0,
        false => word + unit,
    }
}

/// Whether the column's unit is one that a name without a word of the quantity gives away.
fn is_of(names: &Names, column: usize, slot: Slot) -> bool {
    let Some(unit) = names.unit(column) else {
        let unit = split(&names.columns[column]).1;
        return slot == Slot::Position && unit.is_some_and(units::is_count);
    };
    match slot {
        // What takes minutes is no clock.
        Slot::Time => {
            let is_step = holds_word(&names.columns[column], Slot::Step);
            unit.dimension == Dimension::Time && unit.factor <= 1.0 && !is_step
        }
        // Supplies have volts, too.
        Slot::Effort => matches!(
            unit.dimension,
            Dimension::Force | Dimension::Torque | Dimension::Current
        ),
        _ => KNOWN
            .iter()
            .any(|k| k.slot == slot && k.dimension == Some(unit.dimension)),
    }
}

/// The roles that a file must give.
pub(super) fn wanted(needs: Needs) -> &'static [Slot] {
    match needs {
        Needs::Both => &[Slot::Time, Slot::Position, Slot::Effort],
        Needs::Motion => &[Slot::Time, Slot::Position],
        Needs::Effort => &[Slot::Time, Slot::Effort],
        Needs::Speeds => &[Slot::Velocity, Slot::Effort],
    }
}

/// The columns that might be what is missing, did their names say the unit.
pub(super) fn without_unit(names: &Names, sources: &[Source], open: &[usize]) -> Vec<String> {
    let missing = |slot: &&Slot| !sources.iter().any(|s| s.known.slot == **slot);
    let slots: Vec<Slot> = wanted(names.needs)
        .iter()
        .filter(missing)
        .copied()
        .collect();
    let could = |i: &&usize| {
        names.unit(**i).is_none() && slots.iter().any(|&slot| likely(names, **i, slot) > 0)
    };
    let columns = open.iter().filter(could);
    columns
        .map(|&i| format!("`{}`", names.columns[i]))
        .collect()
}

/// The `--map`s that would read the file, as far as its names let them be guessed.
pub(super) fn propose(names: &Names, sources: &[Source], open: &[usize]) -> Vec<String> {
    let best = |slot: Slot| {
        let scored = open.iter().map(|&i| (likely(names, i, slot), i));
        // Of equals the first.
        scored
            .rev()
            .max_by_key(|s| s.0)
            .filter(|s| s.0 > 0)
            .map(|s| s.1)
    };
    let rotary = is_rotary(names, sources);
    let mut maps = Vec::new();
    let mut chosen: Vec<&Known> = Vec::new();
    for &slot in wanted(names.needs) {
        let has = |slot: Slot| sources.iter().any(|s| s.known.slot == slot);
        let instead = match slot {
            Slot::Position => Some(Slot::Velocity),
            Slot::Time => Some(Slot::Step),
            _ => None,
        };
        if has(slot) || instead.is_some_and(has) {
            continue;
        }
        let other = instead.filter(|other| best(slot).is_none() && best(*other).is_some());
        let slot = other.unwrap_or(slot);
        let found = best(slot);
        if slot == Slot::Time && found.is_none() {
            // Without a position it may be a table of speeds, which needs none.
            let is_table = has(Slot::Velocity) && !has(Slot::Position);
            let step = sample_time(names.sample_time);
            maps.extend((!is_table).then(|| format!("--map dt_s={step}")));
            continue;
        }
        if let (Slot::Effort, None, Some(sum)) = (slot, found, of_pressures(names, open)) {
            maps.push(format!("--map {}", quoted(&sum)));
            continue;
        }
        let mut target = target(names, slot, found, rotary);
        // A motor's torque behind a screw is taken as it is: what a newton metre is in newtons no file says.
        if slot == Slot::Effort
            && moves_along(&chosen, sources)
            && target.axis == Some(MotionKind::Rotary)
        {
            target = raw();
        }
        chosen.push(target);
        let scale = found.map_or("", |i| scale(names, target, i));
        let column = found.map_or("COLUMN", |i| names.columns[i].as_str());
        maps.push(format!(
            "--map {}",
            quoted(&format!("{}={scale}{column}", target.name))
        ));
    }
    maps
}

/// Whether the position, chosen or known, is one along an axis.
fn moves_along(chosen: &[&Known], sources: &[Source]) -> bool {
    let mut known = chosen
        .iter()
        .copied()
        .chain(sources.iter().map(|s| s.known));
    known.any(|k| k.slot == Slot::Position && k.axis == Some(MotionKind::Linear))
}

/// The effort in a unit of its own.
fn raw() -> &'static Known {
    let is_raw = |k: &&Known| k.role == Some(EffortRole::Raw);
    KNOWN.iter().find(is_raw).unwrap_or(&KNOWN[0])
}

/// The sample time that the file states, or the word for it.
pub(super) fn sample_time(told: Option<f64>) -> String {
    told.map_or_else(|| SAMPLE_TIME.to_owned(), |step| step.to_string())
}

/// A cylinder's force, of the pressures on both of its sides.
fn of_pressures(names: &Names, open: &[usize]) -> Option<String> {
    // Within a sum the numbers are taken as they stand: 0.00125 m² of 3 bar are 375 N.
    let force = |&i: &usize| {
        let unit = names.unit(i);
        let unit = unit.filter(|u| u.dimension == Dimension::Pressure)?;
        let pascals = match unit.factor {
            1.0 => String::new(),
            factor => format!("{factor:e}*"),
        };
        Some(format!("{pascals}AREA_M2*{}", names.columns[i]))
    };
    match &open.iter().filter_map(force).collect::<Vec<_>>()[..] {
        [a, b] => Some(format!("force_N={a}-{b}")),
        _ => None,
    }
}

/// What is in a unit of the target needs no factor, for it is converted; nor does a name that ends in the quantity, whose unit its reader knows, unless
/// it is a count.
fn scale(names: &Names, target: &Known, column: usize) -> &'static str {
    let name = &names.columns[column];
    let mut words = name.split(|c: char| !c.is_alphabetic());
    let last = words.rfind(|w| !w.is_empty());
    let is_quantity = |name| {
        let said = quantity(name);
        said.slot.is_some() && !said.is_count
    };
    let bare = split(name).1.is_none() && (last.is_some_and(is_quantity) || is_quantity(name));
    match names.unit(column) {
        _ if target.dimension.is_none() => "",
        Some(u) if Some(u.dimension) == target.dimension => "",
        None if bare => "",
        _ => "FACTOR*",
    }
}

/// How ROS's joint states call an effort, which is in N·m or N.
const JOINT_EFFORT: &str = ".effort";

/// As a shell wants it.
pub(super) fn quoted(map: &str) -> String {
    match map.contains([' ', '(', ')', '[', ']', '*', ';', '&', '|']) {
        true => format!("'{map}'"),
        false => map.to_owned(),
    }
}

fn is_rotary(names: &Names, sources: &[Source]) -> bool {
    if let Some(axis) = sources.iter().find_map(|s| s.known.axis) {
        return axis == MotionKind::Rotary;
    }
    let angular = |d| {
        matches!(
            d,
            Dimension::Angle | Dimension::AngularSpeed | Dimension::Torque
        )
    };
    let by_unit = (0..names.columns.len())
        .filter_map(|i| names.unit(i))
        .map(|u| u.dimension);
    let by_word = |name: &String| {
        let lower = name.to_lowercase();
        // Of a joint's state, most turn.
        if lower.ends_with(JOINT_EFFORT) {
            return true;
        }
        let words = ["torque", "angle", "theta", "moment", "motor", "rad", "deg"];
        let mut parts = lower.split(|c: char| !c.is_alphabetic());
        parts.any(|part| part == "tau") || words.iter().any(|w| lower.contains(w))
    };
    by_unit.into_iter().any(angular) || names.columns.iter().any(by_word)
}

/// The column of the format that a role would be mapped to.
fn target(names: &Names, slot: Slot, column: Option<usize>, rotary: bool) -> &'static Known {
    let unit = column.and_then(|i| names.unit(i)).map(|u| u.dimension);
    let axis = MotionKind::turning(rotary);
    let name = column.map_or("", |i| &names.columns[i]).to_lowercase();
    let told = unit.is_some() || quantity(&name).slot.is_some() || name.ends_with(JOINT_EFFORT);
    let role = if !told && column.is_some() {
        EffortRole::Raw
    } else if ["current", "iq", "strom"].iter().any(|w| name.contains(w)) {
        EffortRole::Current
    } else if name.contains("voltage") {
        EffortRole::Voltage
    } else if rotary {
        EffortRole::Torque
    } else {
        EffortRole::Force
    };
    let mut of_slot = KNOWN.iter().filter(|k| k.slot == slot);
    let by_unit = of_slot
        .clone()
        .find(|k| unit.is_some() && k.dimension == unit);
    let by_axis = of_slot.clone().find(|k| match slot {
        Slot::Effort => k.role == Some(role),
        _ => k.axis.is_none_or(|a| a == axis),
    });
    by_unit
        .or(by_axis)
        .or_else(|| of_slot.next())
        .unwrap_or(&KNOWN[0])
}
