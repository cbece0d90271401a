//! What a file must give and no plain name does, by a qualified name beside which no other column might be the same.

use super::known::{KNOWN, Known, Slot};
use super::names::Names;
use super::propose::{likely, wanted};
use super::qualified::slot;
use super::units::{Dimension, Unit};
use super::words::{parts, split};

/// Words of a current's part that makes no torque by itself: the phases, and the part along the field.
const PARTS_OF_A_CURRENT: [&str; 15] = [
    "phase", "a", "b", "c", "d", "u", "v", "w", "ia", "ib", "ic", "id", "iu", "iv", "iw",
];

/// Whether it is the part of a motor's current that makes the torque.
fn is_torque_making(name: &str) -> bool {
    let said = parts(split(name).0);
    let has = |word: &str| said.iter().any(|part| part == word);
    has("iq") || has("q") && has("current")
}

/// Whether it is a current, of which it says another part.
fn is_other_part(name: &str) -> bool {
    let said = parts(split(name).0);
    let has = |word: &&str| said.iter().any(|part| part == word);
    said.iter()
        .any(|part| part.starts_with('i') || part == "current")
        && PARTS_OF_A_CURRENT.iter().any(has)
}

/// Whether it is a voltage, which is further from the load than what it drives: of both the other is the effort.
fn is_voltage(names: &Names, column: usize) -> bool {
    let said = parts(split(&names.columns[column]).0);
    let unit = names.unit(column).map(|u| u.dimension);
    unit == Some(Dimension::Voltage) || said.iter().any(|part| part == "voltage")
}

/// Whether a column might be the same measured quantity as the one that is to be taken.
fn is_rival(names: &Names, taken: usize, other: usize, slot: Slot) -> bool {
    let (of, with) = (&names.columns[taken], &names.columns[other]);
    let is_part = is_torque_making(of) && !is_torque_making(with) && is_other_part(with);
    let is_further = is_voltage(names, other) && !is_voltage(names, taken);
    taken != other && !is_part && !is_further && likely(names, other, slot) > 1
}

/// Columns that may be taken for what the file must give and no plainer name does: one for a role, in a known unit of it, beside which no other
/// might be the same.
pub(super) fn taken(
    names: &Names,
    open: &[usize],
    is_claimed: impl Fn(Slot) -> bool,
) -> Vec<(usize, &'static Known, Unit)> {
    let missing = wanted(names.needs).iter().filter(|&&role| {
        let instead = match role {
            Slot::Time => is_claimed(Slot::Step),
            Slot::Position => is_claimed(Slot::Velocity),
            _ => false,
        };
        !is_claimed(role) && !instead
    });
    let could_be = |role: Slot| open.iter().any(|&i| likely(names, i, role) > 0);
    let role = |&role: &Slot| match role {
        Slot::Position if !could_be(role) => Slot::Velocity,
        role => role,
    };
    missing
        .map(role)
        .filter_map(|role| only(names, open, role))
        .collect()
}

/// The one column of that role.
fn only(names: &Names, open: &[usize], role: Slot) -> Option<(usize, &'static Known, Unit)> {
    let found = open.iter().find_map(|&i| {
        let unit = names
            .unit(i)
            .filter(|_| slot(&names.columns[i]) == Some(role))?;
        let fits = |k: &&Known| k.slot == role && k.dimension == Some(unit.dimension);
        Some((i, KNOWN.iter().find(fits)?, unit))
    });
    let is_alone = |i: usize| !open.iter().any(|&other| is_rival(names, i, other, role));
    found.filter(|found| is_alone(found.0))
}
