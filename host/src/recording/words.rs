//! What a column's name says of it: a quantity's word, and a unit.

use super::known::Slot;
use super::units::{self, Unit};

/// Words of quantities: as they stand alone or before a unit.
#[rustfmt::skip]
pub(super) const WORDS: [(&str, Slot); 59] = [
    ("t", Slot::Time), ("time", Slot::Time), ("timestamp", Slot::Time), ("zeit", Slot::Time),
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
    Quantity {
        slot: WORDS.iter().find(|w| w.0 == stem).map(|w| w.1),
        unit: unit.and_then(units::unit),
    }
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
