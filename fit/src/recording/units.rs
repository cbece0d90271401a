//! The units that other people's files are written in: one table, in SI.

use super::{EffortRole, MotionKind};

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dimension {
    Time,
    Length,
    Angle,
    Speed,
    AngularSpeed,
    Force,
    Torque,
    Current,
    Voltage,
    Temperature,
    Pressure,
}

impl Dimension {
    /// Of such an effort; one of a unit that nobody said is like a voltage.
    pub(super) fn of_effort(role: EffortRole) -> Self {
        match role {
            EffortRole::Force | EffortRole::Friction => Force,
            EffortRole::Torque => Torque,
            EffortRole::Current => Current,
            EffortRole::Voltage | EffortRole::Raw => Voltage,
        }
    }

    /// Of a position along or about an axis.
    pub(super) fn of_position(kind: MotionKind) -> Self {
        match kind {
            MotionKind::Linear => Length,
            MotionKind::Rotary => Angle,
        }
    }
}

use Dimension::{
    Angle, AngularSpeed, Current, Force, Length, Pressure, Speed, Temperature, Time, Torque,
    Voltage,
};

/// A unit: `SI value = factor·value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub(super) dimension: Dimension,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// The second.
pub(super) const SECOND: Unit = Unit {
    dimension: Time,
    factor: 1.0,
    offset: 0.0,
};

const TURN: f64 = std::f64::consts::TAU;
const DEGREE: f64 = TURN / 360.0;
const INCH: f64 = 0.0254;
/// NIST SP 811: pound-force and standard gravity.
const POUND_FORCE: f64 = 4.448_221_615_260_5;
const GRAVITY: f64 = 9.806_65;

/// Spelling without blanks, `·` and `*`; `_` and `_per_` between words are `/`.
#[rustfmt::skip]
const UNITS: &[(&str, Dimension, f64)] = &[
    ("s", Time, 1.0), ("sec", Time, 1.0), ("secs", Time, 1.0), ("seconds", Time, 1.0), ("min", Time, 60.0), ("h", Time, 3600.0),
    ("ms", Time, 1e-3), ("msec", Time, 1e-3), ("millis", Time, 1e-3), ("millisec", Time, 1e-3), ("milliseconds", Time, 1e-3),
    ("us", Time, 1e-6), ("usec", Time, 1e-6), ("micros", Time, 1e-6), ("microsec", Time, 1e-6), ("microseconds", Time, 1e-6),
    ("ns", Time, 1e-9), ("nsec", Time, 1e-9), ("nanos", Time, 1e-9), ("nanosec", Time, 1e-9), ("nanoseconds", Time, 1e-9),
    ("m", Length, 1.0), ("mm", Length, 1e-3), ("um", Length, 1e-6), ("nm", Length, 1e-9), ("cm", Length, 1e-2), ("km", Length, 1e3),
    ("in", Length, INCH), ("inch", Length, INCH), ("ft", Length, 12.0 * INCH),
    ("rad", Angle, 1.0), ("mrad", Angle, 1e-3), ("urad", Angle, 1e-6), ("deg", Angle, DEGREE), ("degree", Angle, DEGREE), ("degrees", Angle, DEGREE), ("°", Angle, DEGREE),
    ("rev", Angle, TURN), ("turn", Angle, TURN), ("turns", Angle, TURN),
    ("m/s", Speed, 1.0), ("mm/s", Speed, 1e-3), ("um/s", Speed, 1e-6), ("nm/s", Speed, 1e-9), ("cm/s", Speed, 1e-2),
    ("mm/min", Speed, 1e-3 / 60.0), ("m/min", Speed, 1.0 / 60.0), ("in/s", Speed, INCH),
    ("rad/s", AngularSpeed, 1.0), ("mrad/s", AngularSpeed, 1e-3), ("deg/s", AngularSpeed, DEGREE), ("°/s", AngularSpeed, DEGREE),
    ("rev/s", AngularSpeed, TURN), ("rps", AngularSpeed, TURN), ("rpm", AngularSpeed, TURN / 60.0), ("1/min", AngularSpeed, TURN / 60.0),
    ("rev/min", AngularSpeed, TURN / 60.0), ("u/min", AngularSpeed, TURN / 60.0),
    ("N", Force, 1.0), ("mN", Force, 1e-3), ("uN", Force, 1e-6), ("kN", Force, 1e3), ("lbf", Force, POUND_FORCE), ("kgf", Force, GRAVITY),
    ("Nm", Torque, 1.0), ("mNm", Torque, 1e-3), ("uNm", Torque, 1e-6), ("kNm", Torque, 1e3), ("Nmm", Torque, 1e-3), ("Ncm", Torque, 1e-2),
    ("A", Current, 1.0), ("mA", Current, 1e-3), ("V", Voltage, 1.0), ("mV", Voltage, 1e-3),
    ("C", Temperature, 1.0), ("°C", Temperature, 1.0), ("degC", Temperature, 1.0),
    ("Pa", Pressure, 1.0), ("hPa", Pressure, 1e2), ("kPa", Pressure, 1e3), ("MPa", Pressure, 1e6), ("bar", Pressure, 1e5), ("mbar", Pressure, 1e2), ("psi", Pressure, POUND_FORCE / (INCH * INCH)),
];

/// Units that a number alone does not turn into SI: what one of them is worth is the drive's matter.
const UNSCALED: &[&str] = &["raw", "%", "percent", "-", "1"];
/// The same of an encoder or an input.
const COUNTS: &[&str] = &["counts", "count", "cnt", "inc", "incr", "lsb"];

/// The unit's spelling in the table.
fn plain(text: &str) -> String {
    let text = text.trim().trim_matches(|c| "[]()".contains(c)).trim();
    let text = text.replace("_per_", "/").replace([' ', '·', '*', '.'], "");
    text.replace('_', "/").replace(['µ', 'μ'], "u")
}

/// The unit of that spelling. Case matters where two units differ by it alone (`mN` and `MN`, `nm` and `Nm`).
pub(super) fn unit(text: &str) -> Option<Unit> {
    let text = plain(text);
    if text == "K" {
        return Some(Unit {
            dimension: Temperature,
            factor: 1.0,
            offset: -273.15,
        });
    }
    let exact = UNITS.iter().find(|u| u.0 == text);
    let loose = || {
        let mut alike = UNITS.iter().filter(|u| u.0.eq_ignore_ascii_case(&text));
        alike.next().filter(|_| alike.next().is_none())
    };
    exact.or_else(loose).map(|&(_, dimension, factor)| Unit {
        dimension,
        factor,
        offset: 0.0,
    })
}

/// Whether a number is what a unit of that dimension is worth.
pub(super) fn is_factor(dimension: Option<Dimension>, factor: f64) -> bool {
    let mut same = UNITS.iter().filter(|u| Some(u.1) == dimension);
    same.any(|u| (factor.abs() / u.2 - 1.0).abs() < 1e-6)
}

/// Whether the text is a unit of any kind, or the sign for none.
pub(super) fn is_unit(text: &str) -> bool {
    unit(text).is_some() || is_unscaled(text)
}

/// Whether it is a unit that only the drive's own constant turns into SI.
pub(super) fn is_unscaled(text: &str) -> bool {
    let text = plain(text);
    let mut units = UNSCALED.iter().chain(COUNTS);
    units.any(|u| u.eq_ignore_ascii_case(&text))
}

/// Whether it is a count.
pub(super) fn is_count(text: &str) -> bool {
    let text = plain(text);
    COUNTS.iter().any(|u| u.eq_ignore_ascii_case(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_in_the_spellings_of_drives() {
        for (text, dimension, factor) in [
            ("mm", Length, 1e-3),
            ("[mm]", Length, 1e-3),
            ("µm", Length, 1e-6),
            ("mm_s", Speed, 1e-3),
            ("rad_per_s", AngularSpeed, 1.0),
            ("Rad/S", AngularSpeed, 1.0),
            ("N·m", Torque, 1.0),
            ("Nm", Torque, 1.0),
            ("nm", Length, 1e-9),
            ("rpm", AngularSpeed, TURN / 60.0),
            ("(deg)", Angle, DEGREE),
            ("mbar", Pressure, 100.0),
        ] {
            let found = unit(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(
                (found.dimension, found.factor),
                (dimension, factor),
                "{text}"
            );
        }
        assert_eq!(unit("K").map(|u| u.offset), Some(-273.15));
        for text in ["furlong", "", "iq_A", "NM"] {
            assert!(unit(text).is_none(), "{text}");
        }
        assert!(is_unit("counts") && is_unit("-") && !is_unit("position"));
    }
}
