//! What a column's name says of it: a quantity's word, and a unit.

use super::known::Slot;
use super::units::{self, Dimension, Unit};

/// Words of quantities: as they stand alone or before a unit.
#[rustfmt::skip]
const WORDS: [(&str, Slot); 91] = [
    ("t", Slot::Time), ("time", Slot::Time), ("timestamp", Slot::Time), ("zeit", Slot::Time), ("stamp", Slot::Time), ("ts", Slot::Time),
    ("time_stamp", Slot::Time), ("zeitstempel", Slot::Time), ("elapsed", Slot::Time), ("uptime", Slot::Time),
    ("datetime", Slot::Time), ("date_time", Slot::Time), ("uhrzeit", Slot::Time), ("heure", Slot::Time), ("temps", Slot::Time), ("horodatage", Slot::Time),
    ("hora", Slot::Time), ("tiempo", Slot::Time), ("tempo", Slot::Time), ("ora", Slot::Time), ("tijd", Slot::Time), ("время", Slot::Time), ("日時", Slot::Time),
    ("時刻", Slot::Time), ("時間", Slot::Time), ("时间", Slot::Time), ("时刻", Slot::Time), ("시간", Slot::Time), ("czas", Slot::Time),
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

/// Words of what counts: without a unit no number turns it into SI.
#[rustfmt::skip]
const COUNTERS: [(&str, Slot); 8] = [
    ("tick", Slot::Time), ("ticks", Slot::Time), ("systick", Slot::Time), ("timer", Slot::Time), ("counter", Slot::Time), ("clock", Slot::Time),
    ("encoder", Slot::Position), ("enc", Slot::Position),
];

/// Words of days: a time where nothing else is one, for beside a time of day they say what changes at midnight.
#[rustfmt::skip]
const DAYS: [&str; 9] = ["date", "datum", "fecha", "日付", "日期", "날짜", "дата", "dato", "päivä"];

/// Whether a name says that a day stands below it, and maybe the time of day.
pub(super) fn is_day(name: &str) -> bool {
    DAYS.contains(&name.trim().to_lowercase().as_str())
}

/// What a name says.
pub(super) struct Quantity {
    /// Where the whole of it but the unit is a quantity's word.
    pub(super) slot: Option<Slot>,
    pub(super) unit: Option<Unit>,
    /// It counts, and does not say what one count is worth.
    pub(super) is_count: bool,
}

/// Reads `x_mm`, `Position [mm]`, `speed (rpm)`, `torque`, `tick_us`, `micros`.
pub(super) fn quantity(name: &str) -> Quantity {
    let (stem, unit) = split(name);
    let stem = stem.trim().to_lowercase().replace([' ', '-', '.'], "_");
    // A name of a time that is its unit; a letter may be another quantity, and `min` is the least of it.
    let is_time = |u: &Unit| u.dimension == Dimension::Time && stem.len() > 1 && stem != "min";
    if let (Some(unit), None) = (units::unit(&stem).filter(is_time), unit) {
        return Quantity {
            slot: Some(Slot::Time),
            unit: Some(unit),
            is_count: false,
        };
    }
    let of = |words: &[(&str, Slot)]| words.iter().find(|w| w.0 == stem).map(|w| w.1);
    let unit = unit.and_then(units::unit);
    Quantity {
        slot: of(&WORDS).or(of(&COUNTERS)),
        unit,
        is_count: unit.is_none() && of(&COUNTERS).is_some(),
    }
}

/// The quantity of a word in small letters.
pub(super) fn word(word: &str) -> Option<Slot> {
    WORDS.iter().find(|w| w.0 == word).map(|w| w.1)
}

/// The words and numbers of a name, in small letters: `ActPos_2` has `act`, `pos` and `2`.
pub(super) fn parts(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in name.chars().filter(|c| !matches!(c, '\'' | '’')) {
        let camel = c.is_uppercase() && last.is_lowercase();
        let goes_on = last.is_alphabetic() == c.is_alphabetic() && last.is_alphanumeric();
        match parts.last_mut().filter(|_| goes_on && !camel) {
            Some(part) if c.is_alphanumeric() => part.extend(c.to_lowercase()),
            _ if c.is_alphanumeric() => parts.push(c.to_lowercase().collect()),
            _ => {}
        }
        last = c;
    }
    parts
}

/// Whether a word of the quantity is part of the name, as in `Axis1.ActPos_turns`; a letter is one only in a name without a longer word.
pub(super) fn holds_word(name: &str, slot: Slot) -> bool {
    let parts = parts(split(name).0);
    let words = || WORDS.iter().chain(&COUNTERS);
    let found: Vec<_> = words().filter(|w| parts.iter().any(|p| p == w.0)).collect();
    let long = found.iter().any(|w| w.0.len() > 1);
    found
        .iter()
        .any(|w| w.1 == slot && (w.0.len() > 1 || !long))
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
    // `Weg in mm`, `Geschwindigkeit / mm/s`; what divides a number is no name.
    for between in [" in ", "/"] {
        for (i, _) in name.match_indices(between) {
            let (stem, unit) = (&name[..i], name[i + between.len()..].trim());
            let is_name = stem.trim_end().ends_with(char::is_alphabetic);
            if is_name && !units::is_unit(name) && units::unit(unit).is_some() {
                return (stem, Some(unit));
            }
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
    // `tickUs`, `ActTorqueNm`; a letter there is as often an axis or a phase, `In` an input and `Min` the least.
    let upper = name.char_indices().rev().find(|(_, c)| c.is_uppercase());
    match upper.map(|(i, _)| name.split_at(i)) {
        Some((stem, unit))
            if stem.ends_with(|c: char| c.is_lowercase())
                && unit.len() > 1
                && !["In", "Min"].contains(&unit)
                && units::is_unit(unit) =>
        {
            (stem, Some(unit))
        }
        _ => (name, None),
    }
}
