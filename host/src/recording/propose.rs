//! Which `--map`s would read a file whose names say too little.

use super::known::{KNOWN, Known, Slot};
use super::names::{Names, Source};
use super::units::Dimension;
use super::words::{WORDS, quantity, split};
use super::{EffortRole, MotionKind, Needs};

/// How well a column would do for a role: 3 where its name is the quantity, 1 where it holds the word.
fn likely(name: &str, slot: Slot) -> u32 {
    if quantity(name).slot == Some(slot) {
        return 3;
    }
    let lower = name.to_lowercase();
    // Of two positions or efforts the measured one.
    let asked = [
        "ref", "cmd", "target", "set", "std", "error", "enable", "limit",
    ];
    if slot != Slot::Reference && asked.iter().any(|word| lower.contains(word)) {
        return 0;
    }
    let parts: Vec<&str> = lower.split(|c: char| !c.is_ascii_alphabetic()).collect();
    let word = |w: &&(&str, Slot)| w.1 == slot && parts.contains(&w.0);
    u32::from(WORDS.iter().any(|w| word(&w)))
}

/// The roles that a file must give.
fn wanted(needs: Needs) -> &'static [Slot] {
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
        let name = &names.columns[**i];
        names.unit(**i).is_none() && slots.iter().any(|&slot| likely(name, slot) > 0)
    };
    let columns = open.iter().filter(could);
    columns
        .map(|&i| format!("`{}`", names.columns[i]))
        .collect()
}

/// The `--map`s that would read the file, as far as its names let them be guessed.
pub(super) fn propose(names: &Names, sources: &[Source], open: &[usize]) -> Vec<String> {
    let best = |slot: Slot| {
        let scored = open.iter().map(|&i| (likely(&names.columns[i], slot), i));
        // Of equals the first.
        scored
            .rev()
            .max_by_key(|s| s.0)
            .filter(|s| s.0 > 0)
            .map(|s| s.1)
    };
    let rotary = is_rotary(names, sources);
    let mut maps = Vec::new();
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
        let found = best(slot);
        if slot == Slot::Time && found.is_none() {
            // Without a position it may be a table of speeds, which needs none.
            let is_table = has(Slot::Velocity) && !has(Slot::Position);
            maps.extend((!is_table).then(|| "--map dt_s=0.001".to_owned()));
            continue;
        }
        if let (Slot::Effort, None, Some(sum)) = (slot, found, of_pressures(names, open)) {
            maps.push(format!("--map {}", quoted(&sum)));
            continue;
        }
        let target = target(names, slot, found, rotary);
        let scale = found.map_or("", |i| scale(names, target, i));
        let column = found.map_or("COLUMN", |i| names.columns[i].as_str());
        maps.push(format!(
            "--map {}",
            quoted(&format!("{}={scale}{column}", target.name))
        ));
    }
    maps
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

/// What is in a unit of the target needs no factor, for it is converted; nor does a name that ends in the quantity, whose unit its reader knows.
fn scale(names: &Names, target: &Known, column: usize) -> &'static str {
    let name = &names.columns[column];
    let mut words = name.split(|c: char| !c.is_alphabetic());
    let last = words.rfind(|w| !w.is_empty());
    let is_word = last.is_some_and(|w| quantity(w).slot.is_some());
    let bare = split(name).1.is_none() && (is_word || quantity(name).slot.is_some());
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
        ["torque", "angle", "theta", "moment", "motor", "rad", "deg"]
            .iter()
            .any(|w| lower.contains(w))
    };
    by_unit.into_iter().any(angular) || names.columns.iter().any(by_word)
}

/// The column of the format that a role would be mapped to.
fn target(names: &Names, slot: Slot, column: Option<usize>, rotary: bool) -> &'static Known {
    let unit = column.and_then(|i| names.unit(i)).map(|u| u.dimension);
    let axis = match rotary {
        true => MotionKind::Rotary,
        false => MotionKind::Linear,
    };
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
