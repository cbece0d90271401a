//! Samples without numbers: left out with a warning where they are few, an error where they are many.

use super::Warning;

/// Largest share of the samples that may be lost: a logger on a bad line loses one in a hundred; a column that lacks one in ten is another thing
/// than a measurement.
const MOST: f64 = 0.1;

/// Places that are named one by one.
const NAMED: usize = 8;

/// Whether so many are more than a recording can lose.
pub(super) fn too_many(lost: usize, kept: usize) -> bool {
    lost as f64 > MOST * (lost + kept) as f64
}

/// Says which samples are lost; `places` are lines or elements, `first` is what is wrong at the first of them.
pub(super) fn said(what: &str, places: &[u64], first: &str) -> Warning {
    let others: Vec<String> = places
        .iter()
        .skip(1)
        .take(NAMED)
        .map(u64::to_string)
        .collect();
    let more = places.len().saturating_sub(1 + NAMED);
    let others = match (others.is_empty(), more) {
        (true, _) => String::new(),
        (false, 0) => format!("; then {what} {}", others.join(", ")),
        (false, more) => format!("; then {what} {} and {more} more", others.join(", ")),
    };
    let lost = match places.len() {
        1 => "a sample is lost".to_owned(),
        n => format!("{n} samples are lost"),
    };
    warning!("lost-samples", "{lost}: {first}{others}")
}

/// Gives the values at the places what stands before them, or after them where nothing does.
pub(super) fn hold(values: &mut [f64], places: &[usize]) {
    let is_broken = |i: usize| places.binary_search(&i).is_ok();
    let first = (0..values.len()).find(|&i| !is_broken(i));
    for &i in places {
        let source = if i > 0 && first.is_some_and(|f| f < i) {
            i - 1
        } else {
            first.unwrap_or(i)
        };
        values[i] = values[source];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_held_from_before_or_from_the_first_that_there_is() {
        let mut values = [f64::NAN, f64::NAN, 1.0, 2.0, f64::NAN, f64::NAN, 3.0];
        hold(&mut values, &[0, 1, 4, 5]);
        assert_eq!(values, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0]);
    }

    #[test]
    fn one_in_ten_may_be_lost() {
        assert!(!too_many(1, 9) && too_many(2, 9) && !too_many(0, 0));
        let text = said("line", &[3, 5, 9], "line 3, column `x_m`: it is empty").message;
        assert_eq!(
            text,
            "3 samples are lost: line 3, column `x_m`: it is empty; then line 5, 9"
        );
    }
}
