//! Lengths, angles and speeds as people type them.

/// A number as it was typed, in SI. What it is of shows by its unit; whether the axis has such, by its kind, which is known later.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// In m or rad, per s or s² where it is a speed or an acceleration.
    pub value: f64,
    /// It is of an angle; `None` where it has no unit.
    turns: Option<bool>,
    typed: String,
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self {
            value,
            turns: None,
            typed: value.to_string(),
        }
    }
}

/// Sees to it that what is given for an axis, which turns or not as `axis` says in words, is in units of its kind: 4 mm are no 4 mrad.
///
/// # Errors
/// Every option that is not.
pub fn check(turns: bool, axis: &str, given: &[(&str, Option<&Quantity>)]) -> Result<(), String> {
    let (other, wanted) = match turns {
        true => ("length", "deg, mrad or rad"),
        false => ("angle", "nm, um, mm or m"),
    };
    let is_other = |q: &&Quantity| q.turns == Some(!turns);
    let wrong = given.iter().filter_map(|(option, q)| {
        let typed = &q.filter(is_other)?.typed;
        Some(format!(
            "{option} {typed} has a unit of {other}, but {axis}: give it in {wanted}"
        ))
    });
    let wrong: Vec<String> = wrong.collect();
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(wrong.join("\n")),
    }
}

/// A length in m: `1.5mm`, `20um`, `-300nm`, `0.001`; of a rotary axis in rad: `90deg`, `1mrad`.
///
/// # Errors
/// What would be understood.
pub fn length(text: &str) -> Result<Quantity, String> {
    let units = [
        ("mrad", 1e-3, Some(true)),
        ("urad", 1e-6, Some(true)),
        ("µrad", 1e-6, Some(true)),
        ("rad", 1.0, Some(true)),
        ("deg", std::f64::consts::PI / 180.0, Some(true)),
        ("mm", 1e-3, Some(false)),
        ("um", 1e-6, Some(false)),
        ("µm", 1e-6, Some(false)),
        ("nm", 1e-9, Some(false)),
        ("m", 1.0, Some(false)),
        ("", 1.0, None),
    ];
    let text = text.trim();
    let read = |(unit, scale, turns): (&str, f64, Option<bool>)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        number.is_finite().then(|| Quantity {
            value: number * scale,
            turns,
            typed: text.to_owned(),
        })
    };
    let found = units.into_iter().find_map(read);
    found.ok_or_else(|| format!("`{text}` is not a length; give it as 1.5mm, 20um, 300nm or 90deg"))
}

/// A speed: a length or an angle per s, or turns a minute; a number alone is in SI.
///
/// # Errors
/// What would be understood.
pub fn speed(text: &str) -> Result<Quantity, String> {
    let of_turns = || {
        let number: f64 = text.trim().strip_suffix("rpm")?.trim().parse().ok()?;
        number.is_finite().then(|| Quantity {
            value: number * std::f64::consts::TAU / 60.0,
            turns: Some(true),
            typed: text.trim().to_owned(),
        })
    };
    of_turns()
        .or_else(|| per(text, &["/s"]))
        .ok_or_else(|| format!("`{text}` is not a speed; give it as 5mm/s, 90deg/s or 60rpm"))
}

/// An acceleration: a length or an angle per s²; a number alone is in SI.
///
/// # Errors
/// What would be understood.
pub fn acceleration(text: &str) -> Result<Quantity, String> {
    per(text, &["/s2", "/s²", "/s^2"])
        .ok_or_else(|| format!("`{text}` is not an acceleration; give it as 0.1m/s2 or 720deg/s2"))
}

/// A length with one of these ends; a length without is no speed.
fn per(text: &str, ends: &[&str]) -> Option<Quantity> {
    let text = text.trim();
    let bare = ends.iter().find_map(|end| text.strip_suffix(end));
    let length = length(bare.unwrap_or(text)).ok()?;
    (bare.is_some() || length.turns.is_none()).then(|| Quantity {
        typed: text.to_owned(),
        ..length
    })
}

/// What such a reader reads, above zero.
///
/// # Errors
/// What would be understood.
pub fn positive(read: Result<Quantity, String>) -> Result<Quantity, String> {
    match read? {
        quantity if quantity.value > 0.0 => Ok(quantity),
        _ => Err("give a number above zero".to_owned()),
    }
}

/// As [`length`], above zero.
///
/// # Errors
/// What would be understood.
pub fn positive_length(text: &str) -> Result<Quantity, String> {
    positive(length(text))
}

/// The unit of a controller's parameter, of an axis whose lengths are in m or rad; nothing for a share or a ratio.
pub fn of_parameter(name: &str, length: &str) -> String {
    let rotary = length == "rad";
    let force = if rotary { "N·m" } else { "N" };
    match name.rsplit('.').next().unwrap_or(name) {
        "proportional" => format!("{force}/{length}"),
        "integral" => format!("{force}/({length}·s)"),
        "derivative" => format!("{force}·s/{length}"),
        "integral_limit" | "limit" => force.to_owned(),
        "mass" if rotary => "kg·m²".to_owned(),
        "mass" => "kg".to_owned(),
        "deadband" | "following_error" | "travel_low" | "travel_high" => length.to_owned(),
        "speed" | "top_speed" => format!("{length}/s"),
        "acceleration" => format!("{length}/s²"),
        "jerk" => format!("{length}/s³"),
        "frequency" => "Hz".to_owned(),
        "torque_constant" => "N·m/A".to_owned(),
        "resistance" => "Ω".to_owned(),
        "inductance" => "H".to_owned(),
        "screw_lead" => format!("{length}/turn"),
        "supply" | "supply_min" | "supply_max" | "diode_drop" => "V".to_owned(),
        "current_max" | "current_rated" | "current_offset" => "A".to_owned(),
        "silence" => "s".to_owned(),
        time if time.ends_with("_time") => "s".to_owned(),
        _ => String::new(),
    }
}

/// A length or speed as people read it, to a nanometre or nanoradian: `100.5 µm`.
pub fn shown(value: f64, unit: &str) -> String {
    let (prefix, scale, decimals) = match value.abs() {
        size if size >= 1.0 => ("", 1.0, 9),
        size if size >= 1e-3 => ("m", 1e3, 6),
        _ => ("µ", 1e6, 3),
    };
    let figures = format!("{:.decimals$}", value * scale);
    let figures = figures.trim_end_matches('0').trim_end_matches('.');
    format!("{figures} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_the_unit_of_their_axis() {
        for (name, linear, rotary) in [
            ("gains.derivative", "N·s/m", "N·m·s/rad"),
            ("watch.top_speed", "m/s", "rad/s"),
            ("feed_forward.mass", "kg", "kg·m²"),
            ("watch.thermal_time", "s", "s"),
            ("duty_limit", "", ""),
        ] {
            assert_eq!(
                [of_parameter(name, "m"), of_parameter(name, "rad")],
                [linear, rotary]
            );
        }
    }

    #[test]
    fn lengths_and_rates_are_read_with_their_units() {
        let near = |read: Result<Quantity, String>, value: f64| {
            let read = read.unwrap_or_else(|e| panic!("{e}"));
            assert!((read.value - value).abs() < 1e-12, "{read:?}");
        };
        for (text, value) in [
            ("1.5mm", 1.5e-3),
            ("-20um", -20e-6),
            ("300 nm", 300e-9),
            ("0.001", 1e-3),
            ("2m", 2.0),
            ("90deg", std::f64::consts::FRAC_PI_2),
        ] {
            near(length(text), value);
        }
        near(speed("5mm/s"), 5e-3);
        near(acceleration("0.1m/s2"), 0.1);
        for text in ["", "mm", "1.5 furlongs", "nan", "inf"] {
            assert!(length(text).is_err(), "{text}");
        }
        near(speed("60rpm"), std::f64::consts::TAU);
        near(speed("0.005"), 5e-3);
        for wrong in [
            speed("0.1m/s2"),
            speed("2mm"),
            acceleration("5mm/s"),
            acceleration("720deg"),
        ] {
            assert!(wrong.is_err(), "{wrong:?}");
        }
        assert!(positive(speed("-1mm/s")).is_err());
        for (value, text) in [(1.005e-4, "100.5 µm"), (-0.0125, "-12.5 mm"), (0.0, "0 µm")] {
            assert_eq!(shown(value, "m"), text);
        }
    }

    #[test]
    fn what_is_of_the_other_kind_of_axis_is_refused_all_at_once() {
        let read = [length("4mm"), speed("90deg/s"), length("0.1")].map(|q| q.expect("read"));
        let [travel, speed, bare] = read.each_ref().map(Some);
        let given = [
            ("--travel", travel),
            ("--speed", speed),
            ("--back-off", bare),
        ];
        let refused = |turns| check(turns, "AXIS", &given).expect_err("of the other kind");
        assert!(refused(true).starts_with("--travel 4mm has a unit of length, but AXIS: give"));
        assert!(refused(false).starts_with("--speed 90deg/s has a unit of angle, but AXIS: give"));
        assert_eq!(refused(true).lines().count(), 1);
        let all = [("--travel", travel), ("--smallest", travel)];
        let all = check(true, "", &all).expect_err("both");
        assert_eq!(all.lines().count(), 2);
        assert!(
            check(
                true,
                "",
                &[("--speed", speed), ("--x", bare), ("--y", None)]
            )
            .is_ok()
        );
    }
}
