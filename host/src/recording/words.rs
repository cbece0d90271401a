//! What a column's name says of it: a quantity's word, and a unit.

use super::known::Slot;
use super::units::{self, Unit};

/// Words of quantities: as they stand alone or before a unit.
#[rustfmt::skip]
pub(super) const WORDS: [(&str, Slot); 68] = [
    ("t", Slot::Time), ("time", Slot::Time), ("timestamp", Slot::Time), ("zeit", Slot::Time), ("stamp", Slot::Time), ("ts", Slot::Time),
    ("dt", Slot::Step), ("delta_t", Slot::Step), ("timestep", Slot::Step), ("time_step", Slot::Step), ("sample_time", Slot::Step), ("zeitschritt", Slot::Step),
    ("dtime", Slot::Step),
    ("x", Slot::Position), ("q", Slot::Position), ("pos", Slot::Position), ("position", Slot::Position), ("angle", Slot::Position),
    ("theta", Slot::Position), ("displacement", Slot::Position), ("weg", Slot::Position), ("lage", Slot::Position), ("winkel", Slot::Position),
    ("istposition", Slot::Position), ("istlage", Slot::Position), ("actual_position", Slot::Position), ("position_actual", Slot::Position),
    ("v", Slot::Velocity), ("qd", Slot::Velocity), ("dq", Slot::Velocity), ("vel", Slot::Velocity), ("velocity", Slot::Velocity), ("speed", Slot::Velocity),
    ("omega", Slot::Velocity), ("actual_velocity", Slot::Velocity), ("geschwindigkeit", Slot::Velocity), ("drehzahl", Slot::Velocity),
    ("x_ref", Slot::Reference), ("q_ref", Slot::Reference), ("position_ref", Slot::Reference), ("pos_ref", Slot::Reference), ("target_position", Slot::Reference),
    ("setpoint", Slot::Reference),
    ("f", Slot::Effort), ("effort", Slot::Effort), ("force", Slot::Effort), ("torque", Slot::Effort), ("friction", Slot::Effort), ("current", Slot::Effort), ("voltage", Slot::Effort),
    ("tau", Slot::Effort), ("iq", Slot::Effort), ("moment", Slot::Effort), ("kraft", Slot::Effort), ("drehmoment", Slot::Effort),
    ("strom", Slot::Effort), ("istkraft", Slot::Effort), ("istmoment", Slot::Effort), ("istdrehmoment", Slot::Effort), ("iststrom", Slot::Effort), ("actual_torque", Slot::Effort), ("actual_current", Slot::Effort),
    ("temperature", Slot::Temperature), ("temp", Slot::Temperature), ("temperatur", Slot::Temperature), ("normal", Slot::Load), ("load", Slot::Load), ("pressure", Slot::Pressure),
];

/// Names of a time that are its unit: of counters as microcontrollers have them, and of stamps in parts.
#[rustfmt::skip]
const TIME_UNITS: [(&str, &str); 17] = [
    ("seconds", "s"), ("secs", "s"), ("sec", "s"),
    ("milliseconds", "ms"), ("millisec", "ms"), ("millis", "ms"), ("msec", "ms"), ("ms", "ms"),
    ("microseconds", "us"), ("microsec", "us"), ("micros", "us"), ("usec", "us"), ("us", "us"),
    ("nanoseconds", "ns"), ("nanosec", "ns"), ("nsec", "ns"), ("ns", "ns"),
];

/// What a name says.
pub(super) struct Quantity {
    /// Where the whole of it but the unit is a quantity's word.
    pub(super) slot: Option<Slot>,
    pub(super) unit: Option<Unit>,
}

/// Reads `x_mm`, `Position [mm]`, `speed (rpm)`, `torque`.
pub(super) fn quantity(name: &str) -> Quantity {
    let (stem, unit) = split(name);
    let stem = stem.trim().to_lowercase().replace([' ', '-', '.'], "_");
    let by_unit = TIME_UNITS.iter().find(|u| u.0 == stem);
    if let (Some((_, unit)), None) = (by_unit, unit) {
        return Quantity {
            slot: Some(Slot::Time),
            unit: units::unit(unit),
        };
    }
    Quantity {
        slot: WORDS.iter().find(|w| w.0 == stem).map(|w| w.1),
        unit: unit.and_then(units::unit),
    }
}

/// What a name says of the part of a time stamp that it holds: what stands before the part's name, and the seconds of one of it.
fn part_of_stamp(name: &str) -> Option<(String, f64)> {
    let name = name.trim().to_lowercase();
    let letters = name.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let (before, word) = name.split_at(letters.len());
    let word = word
        .strip_suffix('s')
        .filter(|w| w.ends_with("sec"))
        .unwrap_or(word);
    let seconds = match word {
        "sec" => 1.0,
        "usec" | "microsec" => 1e-6,
        "nsec" | "nanosec" => 1e-9,
        _ => return None,
    };
    Some((before.to_owned(), seconds))
}

/// The columns of a stamp in two parts, such as `stamp.sec` and `stamp.nanosec`, and the seconds of one of the second; where there is one.
pub(super) fn stamp_in_parts(names: &[String]) -> Option<(usize, usize, f64)> {
    let parts: Vec<_> = names.iter().map(|n| part_of_stamp(n)).collect();
    let whole = |i: &usize| parts[*i].as_ref().is_some_and(|p| p.1 == 1.0);
    let mut found = (0..names.len()).filter(whole).flat_map(|i| {
        let before = parts[i].as_ref().map(|p| &p.0);
        let fits = move |p: &(String, f64)| Some(&p.0) == before && p.1 < 1.0;
        let parts = &parts;
        (0..parts.len()).filter_map(move |j| {
            let part = parts[j].as_ref().filter(|p| fits(p))?;
            Some((i, j, part.1))
        })
    });
    found.next().filter(|_| found.next().is_none())
}

/// A name without its unit, and the unit.
pub(super) fn split(name: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        let inside = name.trim_end().strip_suffix(close);
        if let Some((stem, unit)) = inside.and_then(|i| i.rsplit_once(open)) {
            return (stem, Some(unit));
        }
    }
    // The longest unit at the end: `v_mm_s` is in mm/s, not in s.
    let ends = name
        .char_indices()
        .filter(|(_, c)| *c == '_')
        .map(|(i, _)| i);
    for i in ends {
        if units::is_unit(&name[i + 1..]) {
            return (&name[..i], Some(&name[i + 1..]));
        }
    }
    (name, None)
}
