//! Figures as people read them.

use super::display_unit;

/// A value in the prefix that suits it: `-266 µN`.
pub fn quantity(value: f64, unit: &str) -> String {
    let shown = display_unit(unit, value);
    let value = value * shown.factor;
    // What has no prefix may be smaller than three decimals show.
    let figures = match value != 0.0 && value.abs() < 0.01 {
        true => format!("{value:.2e}"),
        false => three(value),
    };
    format!("{figures} {}", shown.unit).trim_end().to_owned()
}

/// A value and how far it may be off, to two figures of that, in the prefix that suits the larger: `5.0002 ± 0.0011 mm`.
pub fn within(value: f64, reach: f64, unit: &str) -> String {
    let shown = display_unit(unit, value.abs().max(reach));
    let reach = reach * shown.factor;
    let decimals = decimals(reach);
    let value = format!("{:.decimals$}", value * shown.factor).replace('-', "−");
    format!("{value} ± {reach:.decimals$} {}", shown.unit)
}

/// A value with its interval, where it has one: `5.0002 ± 0.0011 mm`, or, where one side is half as long again as the other, `0.41 (0.05 to 1.30) N`.
pub fn estimate(value: f64, interval: Option<[f64; 2]>, unit: &str) -> String {
    const UNEVEN: f64 = 1.5;
    let Some([low, high]) = interval else {
        return quantity(value, unit);
    };
    let (below, above) = (value - low, high - value);
    if above.max(below) <= UNEVEN * above.min(below).max(0.0) {
        return within(value, 0.5 * (high - low), unit);
    }
    let shown = display_unit(unit, low.abs().max(high.abs()));
    let [mut all, finer] = [
        [value, low, high].map(|v| three(v * shown.factor)),
        cells(value, interval, shown.factor),
    ];
    if all[1] == all[2] {
        all = finer;
    }
    let [value, low, high] = all;
    format!("{value} ({low} to {high}) {}", shown.unit)
        .trim_end()
        .to_owned()
}

/// Two values in the prefix that suits the larger: `−0.5 and 0.1 mm`.
pub fn between(from: f64, to: f64, unit: &str) -> String {
    let (from, to, unit) = ends(from, to, unit);
    format!("between {from} and {to} {unit}")
}

/// From one value to the other in the prefix that suits the larger: `−0.5 to 0.1 mm`.
pub fn range(from: f64, to: f64, unit: &str) -> String {
    let (from, to, unit) = ends(from, to, unit);
    format!("{from} to {to} {unit}")
}

fn ends(from: f64, to: f64, unit: &str) -> (String, String, String) {
    let shown = display_unit(unit, from.abs().max(to.abs()));
    let [from, to] = [from, to].map(|value| three(value * shown.factor));
    (from, to, shown.unit)
}

/// A value and its interval times `factor`, for the cells of a table: to two figures of the interval's half, or three without one.
pub fn cells(value: f64, interval: Option<[f64; 2]>, factor: f64) -> [String; 3] {
    let Some([low, high]) = interval else {
        return [three(value * factor), "–".to_owned(), "–".to_owned()];
    };
    let decimals = decimals(0.5 * (high - low) * factor);
    [value, low, high].map(|v| format!("{:.decimals$}", v * factor).replace('-', "−"))
}

/// Decimals of two figures of how far a value may be off.
fn decimals(reach: f64) -> usize {
    /// That a double still has.
    const MOST: f64 = 9.0;
    (1.0 - reach.max(1e-300).log10().floor()).clamp(0.0, MOST) as usize
}

/// Three figures.
pub fn three(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        s if s >= 100.0 || s == 0.0 => 0,
        s if s >= 10.0 => 1,
        s if s >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}").replace('-', "−")
}

/// Five significant digits.
pub fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-2..1e5).contains(&size) {
        return format!("{value:.4e}");
    }
    let decimals = 4 - size.log10().floor().clamp(-4.0, 4.0) as i32;
    format!("{value:.*}", decimals.max(0) as usize)
}

/// Two figures, and never certainty: the weights behind it are known no better.
pub fn probability(p: f64) -> String {
    format!("{:.2}", p.clamp(0.01, 0.99))
}

/// A sentence, its first letter large.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

/// In seconds, or minutes where they are many.
pub fn duration(seconds: f64) -> String {
    const MANY: f64 = 300.0;
    match seconds < MANY {
        true => format!("{} s", three(seconds)),
        false => format!("{} minutes", three(seconds / 60.0)),
    }
}

/// A share in per cent.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share.clamp(0.0, 1.0))
}

/// What of a variance is left, given in %: nothing that can be read is no nought.
pub fn left(nmse: f64) -> String {
    const LEAST: f64 = 0.001;
    if nmse > 0.0 && nmse < 0.5 * LEAST {
        format!("< {LEAST} %")
    } else {
        format!("{nmse:.3} %")
    }
}
