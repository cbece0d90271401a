//! The prefix of a unit that suits the data: micrometres for 2·10⁻⁵ m.

use super::units::symbol;

/// A unit to show values in.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// The unit with its prefix, such as "µm".
    pub unit: String,
    /// What a value in the unprefixed unit is multiplied by: 10⁶ for µm.
    pub factor: f64,
}

/// Units that take the small prefixes only; nobody reads kiloseconds.
const SMALL: [&str; 8] = ["m", "s", "rad", "m/s", "rad/s", "A", "g", "g·m²"];
/// Units that take small and large prefixes.
const SMALL_AND_LARGE: [&str; 12] = [
    "N",
    "N·m",
    "N/m",
    "N·m/rad",
    "N·s/m",
    "N·m·s/rad",
    "m/s²",
    "rad/s²",
    "V",
    "Pa",
    "J",
    "W",
];
/// Prefix and the power of ten that it stands for, descending.
const PREFIXES: [(&str, f64, f64); 8] = [
    ("G", 1e9, 1e-9),
    ("M", 1e6, 1e-6),
    ("k", 1e3, 1e-3),
    ("", 1.0, 1.0),
    ("m", 1e-3, 1e3),
    ("µ", 1e-6, 1e6),
    ("n", 1e-9, 1e9),
    ("p", 1e-12, 1e12),
];

/// Chooses the prefix for data in `unit` whose largest magnitude is `largest` (same unit; zero or not finite: none).
///
/// The largest value shown then lies in 1…1000, save that values from 0.1 up keep the unit itself where it is no length or speed: 0.9 N, not
/// 900 mN, but 246 mm.
/// Units other than the known mechanical and electrical ones stay as they are.
pub fn display_unit(unit: &str, largest: f64) -> DisplayUnit {
    let (unit, largest) = (symbol(unit), largest.abs());
    // The kilogram has a prefix already: from 0.1 on it stays, and below it is one of the gram's.
    if let Some(area @ ("" | "·m²")) = unit.strip_prefix("kg").filter(|_| largest < 0.1) {
        let of_grams = display_unit(&format!("g{area}"), 1e3 * largest);
        return match largest > 0.0 {
            true => DisplayUnit {
                factor: 1e3 * of_grams.factor,
                ..of_grams
            },
            false => DisplayUnit {
                unit: unit.to_owned(),
                factor: 1.0,
            },
        };
    }
    let small_only = SMALL.contains(&unit);
    let known = small_only || SMALL_AND_LARGE.contains(&unit);
    let fits = |&&(prefix, power, _): &&(&str, f64, f64)| {
        let least = match prefix.is_empty() && !unit.starts_with('m') {
            true => 0.1,
            false => power,
        };
        (power <= 1.0 || !small_only) && largest >= least
    };
    let (prefix, factor) = if known && largest.is_finite() && largest > 0.0 {
        let smallest = PREFIXES.last();
        PREFIXES
            .iter()
            .find(fits)
            .or(smallest)
            .map_or(("", 1.0), |&(prefix, _, factor)| (prefix, factor))
    } else {
        ("", 1.0)
    };
    DisplayUnit {
        unit: format!("{prefix}{unit}"),
        factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefix_follows_the_largest_value() {
        for (unit, largest, shown, factor) in [
            ("m", 4e-5, "µm", 1e6),
            ("m", -2.5e-8, "nm", 1e9),
            ("m", 0.246, "mm", 1e3),
            ("Nm", 0.19, "N·m", 1.0),
            ("m", 5e3, "m", 1.0),
            ("N", 0.9, "N", 1.0),
            ("N", 0.05, "mN", 1e3),
            ("N", 2.7e4, "kN", 1e-3),
            ("N·m", 2e-3, "mN·m", 1e3),
            ("m/s", 1e-4, "µm/s", 1e6),
            ("rad", 1e-14, "prad", 1e12),
            ("s", 190.0, "s", 1.0),
            ("kg", 0.3, "kg", 1.0),
            ("kg", 0.02, "g", 1e3),
            ("kg·m²", 4e-6, "mg·m²", 1e6),
            ("kg·m²", 0.0, "kg·m²", 1.0),
            ("%", 1e-4, "%", 1.0),
            ("m", 0.0, "m", 1.0),
            ("m", f64::NAN, "m", 1.0),
        ] {
            let got = display_unit(unit, largest);
            assert_eq!(
                got,
                DisplayUnit {
                    unit: shown.into(),
                    factor
                },
                "{largest} {unit}"
            );
        }
    }
}
