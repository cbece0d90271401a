//! Lengths and speeds as people type them.

/// A length in m: `1.5mm`, `20um`, `-300nm`, `0.001`; of a rotary axis in rad: `90deg`, `1mrad`.
///
/// # Errors
/// What would be understood.
pub fn length(text: &str) -> Result<f64, String> {
    let units = [
        ("mrad", 1e-3),
        ("urad", 1e-6),
        ("rad", 1.0),
        ("deg", std::f64::consts::PI / 180.0),
        ("mm", 1e-3),
        ("um", 1e-6),
        ("µm", 1e-6),
        ("nm", 1e-9),
        ("m", 1.0),
        ("", 1.0),
    ];
    let text = text.trim();
    let read = |(unit, scale): (&str, f64)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        number.is_finite().then_some(number * scale)
    };
    let found = units.into_iter().find_map(read);
    found.ok_or_else(|| {
        format!("`{text}` is not a length; give 1.5mm, 20um, 300nm, 0.001 (m) or 90deg")
    })
}

/// A speed or acceleration: a length per s or s², whose `/s` or `/s2` may be left out.
///
/// # Errors
/// What would be understood.
pub fn rate(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let bare = ["/s2", "/s²", "/s^2", "/s"]
        .iter()
        .find_map(|end| text.strip_suffix(end));
    length(bare.unwrap_or(text)).map_err(|_| {
        format!("`{text}` is not a speed or acceleration; give 5mm/s, 0.1m/s2 or 0.005")
    })
}

/// As [`length`], above zero.
///
/// # Errors
/// What would be understood.
pub fn positive_length(text: &str) -> Result<f64, String> {
    length(text).and_then(positive)
}

/// As [`rate`], above zero.
///
/// # Errors
/// What would be understood.
pub fn positive_rate(text: &str) -> Result<f64, String> {
    rate(text).and_then(positive)
}

fn positive(value: f64) -> Result<f64, String> {
    match value > 0.0 {
        true => Ok(value),
        false => Err("give a number above zero".to_owned()),
    }
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
        for (text, value) in [
            ("1.5mm", 1.5e-3),
            ("-20um", -20e-6),
            ("300 nm", 300e-9),
            ("0.001", 1e-3),
            ("2m", 2.0),
        ] {
            assert!((length(text).expect(text) - value).abs() < 1e-15, "{text}");
        }
        assert!((length("90deg").expect("deg") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((rate("5mm/s").expect("speed") - 5e-3).abs() < 1e-15);
        assert!((rate("0.1m/s2").expect("acceleration") - 0.1).abs() < 1e-15);
        for text in ["", "mm", "1.5 furlongs", "nan", "inf"] {
            assert!(length(text).is_err(), "{text}");
        }
        assert!(positive_rate("-1mm/s").is_err());
        for (value, text) in [(1.005e-4, "100.5 µm"), (-0.0125, "-12.5 mm"), (0.0, "0 µm")] {
            assert_eq!(shown(value, "m"), text);
        }
    }
}
