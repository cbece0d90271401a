//! Figures as people read them.

use super::display_unit;

/// A value in the prefix that suits it: `-266 µN`.
pub fn quantity(value: f64, unit: &str) -> String {
    /// What rounding leaves of a difference of doubles that is none.
    const DUST: f64 = 1e-14;
    let value = if value.abs() < DUST { 0.0 } else { value };
    let shown = display_unit(unit, value);
    let figures = number(value * shown.factor);
    format!("{figures} {}", shown.unit).trim_end().to_owned()
}

/// Three figures; what has no prefix may be smaller than three decimals show.
fn number(value: f64) -> String {
    match value != 0.0 && value.abs() < 0.01 {
        true => format!("{value:.2e}"),
        false => three(value),
    }
}

/// A value and how far it may be off, to two figures of that, in the prefix that suits the larger: `5.0002 ± 0.0011 mm`.
/// One without end, or one that only rounding left, is left out.
pub fn within(value: f64, reach: f64, unit: &str) -> String {
    if !tells(value, reach) {
        return quantity(value, unit);
    }
    let shown = display_unit(unit, value.abs().max(reach));
    let reach = reach * shown.factor;
    let decimals = decimals(reach);
    let value = fixed(value * shown.factor, decimals);
    format!("{value} ± {reach:.decimals$} {}", shown.unit)
}

/// A value with its interval, where it has one: `5.0002 ± 0.0011 mm`, or, where one side is half as long again as the other, `0.41 (0.05 to 1.30) N`.
pub fn estimate(value: f64, interval: Option<[f64; 2]>, unit: &str) -> String {
    const UNEVEN: f64 = 1.5;
    let Some([low, high]) = interval.filter(|ends| tells(value, 0.5 * (ends[1] - ends[0]))) else {
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

/// Two values and the unit with the prefix that suits the larger.
pub fn ends(from: f64, to: f64, unit: &str) -> (String, String, String) {
    let shown = display_unit(unit, from.abs().max(to.abs()));
    let [from, to] = [from, to].map(|value| value * shown.factor);
    // Three figures of the larger, and two of what lies between them.
    let between = decimals((to - from).abs()).min(6);
    let places = places(from.abs().max(to.abs())).max(between);
    (fixed(from, places), fixed(to, places), shown.unit)
}

/// A value and its interval times `factor`, for the cells of a table: to two figures of the interval's half, or three without one.
pub fn cells(value: f64, interval: Option<[f64; 2]>, factor: f64) -> [String; 3] {
    let Some([low, high]) = interval.filter(|ends| tells(value, 0.5 * (ends[1] - ends[0]))) else {
        return [number(value * factor), "–".to_owned(), "–".to_owned()];
    };
    let decimals = decimals(0.5 * (high - low) * factor);
    [value, low, high].map(|v| fixed(v * factor, decimals))
}

/// Whether it tells anything that a value may be off so far: rounding is no uncertainty, and 0 ± 0 was never measured.
fn tells(value: f64, reach: f64) -> bool {
    /// Of a value; what a fit on doubles leaves of an exact one.
    const ROUNDING: f64 = 1e-9;
    /// Of nothing, which has no size of its own.
    const DUST: f64 = 1e-12;
    reach.is_finite() && reach > (ROUNDING * value.abs()).max(DUST)
}

/// Decimals of two figures of how far a value may be off.
fn decimals(reach: f64) -> usize {
    /// That a double still has.
    const MOST: f64 = 9.0;
    (1.0 - reach.max(1e-300).log10().floor()).clamp(0.0, MOST) as usize
}

/// Three figures.
pub fn three(value: f64) -> String {
    fixed(value, places(value.abs()))
}

/// Decimals of three figures of a size.
fn places(size: f64) -> usize {
    match size {
        s if s >= 100.0 || s == 0.0 => 0,
        s if s >= 10.0 => 1,
        s if s >= 1.0 => 2,
        _ => 3,
    }
}

/// So many decimals, with a minus as long as a plus; what rounds to nothing is 0.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.parse() == Ok(0.0) {
        true => "0".to_owned(),
        false => text.replace('-', "−"),
    }
}

/// Three significant digits, however small: errors of models lie decades apart.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 12);
    fixed(value, decimals as usize)
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

/// A ratio in per cent; of more than the whole, how many times.
pub fn times(ratio: f64) -> String {
    match ratio {
        r if r < 1.0 => format!("{:.0} %", 100.0 * r),
        r if r < 10.0 => format!("{r:.1} times"),
        r => format!("{r:.0} times"),
    }
}

/// What of a variance is left, given in %: nothing that can be read is no nought.
pub fn left(nmse: f64) -> String {
    const LEAST: f64 = 0.001;
    if nmse > 0.0 && nmse < 0.5 * LEAST {
        format!("< {LEAST} %")
    } else {
        format!("{} %", three(nmse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_have_the_same_decimals() {
        for (from, to, unit, told) in [
            (-1.9e-5, 0.0739, "m", "between 0 and 73.9 mm"),
            (-2.6e-3, 0.0739, "m", "between −2.6 and 73.9 mm"),
            (0.1, 0.10004, "m", "between 100.000 and 100.040 mm"),
            (-1.0, 1.0, "rad/s", "between −1.00 and 1.00 rad/s"),
        ] {
            assert_eq!(between(from, to, unit), told);
        }
    }

    #[test]
    fn an_interval_that_only_rounding_left_is_none() {
        for (value, reach, told) in [
            (0.0, 0.0, "0 N"),
            (25.0, 0.0, "25.0 N"),
            (25.0, 1e-12, "25.0 N"),
            (0.0, 1e-14, "0 N"),
            (25.0, 1e-6, "25.0000000 ± 0.0000010 N"),
        ] {
            assert_eq!(within(value, reach, "N"), told);
            let ends = Some([value - reach, value + reach]);
            assert_eq!(estimate(value, ends, "N"), told);
            let is_one = told.contains('±');
            assert_eq!(cells(value, ends, 1.0)[1] != "–", is_one, "{told}");
        }
    }

    #[test]
    fn more_than_the_whole_is_so_many_times_and_dust_is_nothing() {
        assert_eq!(
            [0.71, 1.32, 23.4].map(times),
            ["71 %", "1.3 times", "23 times"]
        );
        assert_eq!(quantity(-1.1e-16, "N"), "0 N");
        assert_eq!(three(-0.0002), "0");
        assert_eq!(quantity(-2.66e-4, "N"), "−266 µN");
    }
}
