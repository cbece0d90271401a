//! Names that say more than the quantity, such as whose it is or that it was measured: `current_iq_A`, `Motor current(A)`, `Velocity actual value [rpm]`.

use super::known::{KNOWN, Known, Slot};
use super::names::Names;
use super::propose::{likely, wanted};
use super::units::{Dimension, Unit};
use super::words::{self, parts, split};

/// Words that leave a quantity what it is: an axis has one motor, and what is recorded was measured.
#[rustfmt::skip]
const QUALIFIERS: [&str; 21] = [
    "motor", "mot", "moteur", "motore", "drive", "servo", "actuator", "axis", "actual", "act", "measured", "meas", "mesure", "feedback", "fbk", "fb",
    "value", "val", "ist", "istwert", "wert",
];

/// Words that are of a quantity where no other column is; elsewhere too little.
#[rustfmt::skip]
const PHRASES: [(&str, Slot); 37] = [
    ("current_iq", Slot::Effort), ("iq_current", Slot::Effort), ("current_q", Slot::Effort), ("q_current", Slot::Effort), ("i_q", Slot::Effort),
    ("active_current", Slot::Effort), ("quadrature_current", Slot::Effort), ("torque_current", Slot::Effort),
    ("torque_generating_current", Slot::Effort), ("torque_producing_current", Slot::Effort), ("current_torque_generating", Slot::Effort),
    ("curr", Slot::Effort), ("cur", Slot::Effort), ("trq", Slot::Effort), ("torq", Slot::Effort),
    ("motorstrom", Slot::Effort), ("stromistwert", Slot::Effort), ("motormoment", Slot::Effort), ("momentenistwert", Slot::Effort),
    ("drehmomentistwert", Slot::Effort), ("kraftistwert", Slot::Effort), ("courant", Slot::Effort), ("couple", Slot::Effort),
    ("corrente", Slot::Effort), ("coppia", Slot::Effort), ("corriente", Slot::Effort),
    ("encoder_position", Slot::Position), ("position_encoder", Slot::Position), ("encoder_angle", Slot::Position), ("motorposition", Slot::Position),
    ("lageistwert", Slot::Position), ("positionsistwert", Slot::Position),
    ("velo", Slot::Velocity), ("vitesse", Slot::Velocity), ("motordrehzahl", Slot::Velocity), ("drehzahlistwert", Slot::Velocity),
    ("geschwindigkeitsistwert", Slot::Velocity),
];

/// Words of a current's part that makes no torque by itself: the phases, and the part along the field.
const PARTS_OF_A_CURRENT: [&str; 15] = [
    "phase", "a", "b", "c", "d", "u", "v", "w", "ia", "ib", "ic", "id", "iu", "iv", "iw",
];

/// The quantity of a name whose other words change nothing.
pub(super) fn slot(name: &str) -> Option<Slot> {
    let said = parts(split(name).0);
    let (qualifiers, rest): (Vec<&str>, Vec<&str>) = said
        .iter()
        .map(String::as_str)
        .partition(|part| QUALIFIERS.contains(part));
    let rest = rest.join("_");
    // A drive's voltage is as often that of its supply.
    if rest == "voltage" && !qualifiers.contains(&"motor") {
        return None;
    }
    let phrase = PHRASES.iter().find(|p| p.0 == rest).map(|p| p.1);
    phrase.or_else(|| words::word(&rest))
}

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
