//! A column that is polled more slowly than the rows are written repeats its last reading: only the rows of new readings are measured.

use super::Warning;
use super::decimate::{blackman_sinc, low_passed};
use super::frame::Frame;
use super::known::Slot;
use super::table::Location;
use crate::statistics::quantile_between_ranks;
use std::collections::BTreeMap;
use std::ops::Range;

/// Fewest readings that suffice.
const FEWEST: usize = 40;
/// Share of the readings that come in step, the rest being late ones.
const IN_STEP: f64 = 0.95;
/// Share of the readings that follow the one before after the shortest wait: an axis that rests repeats what it reads, too.
const MOVING: f64 = 0.5;
/// Smallest over largest usual change of a reading, above which it may be one count each time: that is an axis at one speed under a coarse encoder.
const ALIKE: f64 = 0.5;

/// How a column is read: every so many rows, from a row on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    rows: usize,
    first: usize,
}

/// Keeps the rows at which the slower of position and effort is read; what is read more often is low-passed to them.
pub(super) fn keep_readings(frame: &mut Frame, place: &mut Location, warnings: &mut Vec<Warning>) {
    let names = [(Slot::Position, "position"), (Slot::Effort, "effort")];
    let pieces = frame.pieces.clone();
    let read = names.into_iter().filter_map(|(slot, name)| {
        let values = frame.column(slot)?;
        Some((slot, name, held(values, &pieces)?))
    });
    let Some((slot, name, held)) = read.max_by_key(|(_, _, held)| held.rows) else {
        return;
    };
    let samples = frame.t_s.len();
    let weights = blackman_sinc(held.rows);
    for (other, values) in &mut frame.numbers {
        if *other != slot && self::held(values, &pieces).is_none() {
            smooth(values, &pieces, held, &weights);
        }
    }
    let is_read: Vec<bool> = (0..samples).map(|i| i % held.rows == held.first).collect();
    frame.keep(&is_read);
    place.keep(&is_read);
    warnings.push(warning!(
        "held",
        "the {name} is read every {} rows only and repeated in between: {} of {samples} samples are kept",
        held.rows,
        frame.t_s.len()
    ));
}

/// How a column is held, if it is.
fn held(values: &[f64], pieces: &[Range<usize>]) -> Option<Held> {
    let mut readings = Vec::new();
    let mut waits = BTreeMap::<usize, usize>::new();
    for piece in pieces {
        let own = (piece.start + 1..piece.end).filter(|&i| values[i] != values[i - 1]);
        let own: Vec<usize> = own.collect();
        for pair in own.windows(2) {
            *waits.entry(pair[1] - pair[0]).or_default() += 1;
        }
        readings.extend(own);
    }
    let (&rows, &count) = waits.iter().max_by_key(|(_, count)| **count)?;
    if rows < 2 || readings.len() < FEWEST || (count as f64) < MOVING * readings.len() as f64 {
        return None;
    }
    let mut steps = vec![0; rows];
    readings.iter().for_each(|i| steps[i % rows] += 1);
    let (first, &most) = steps.iter().enumerate().max_by_key(|(_, count)| **count)?;
    let changes: Vec<f64> = readings
        .iter()
        .map(|&i| (values[i] - values[i - 1]).abs())
        .collect();
    let [low, high] = [0.1, 0.9].map(|q| quantile_between_ranks(&changes, q));
    let in_step = most as f64 >= IN_STEP * readings.len() as f64;
    (in_step && low < ALIKE * high).then_some(Held { rows, first })
}

/// Low-passes a column for the rows that are kept.
fn smooth(values: &mut [f64], pieces: &[Range<usize>], held: Held, weights: &[f64]) {
    for piece in pieces {
        let into = (piece.start % held.rows + held.rows - held.first) % held.rows;
        let first = piece.start + (held.rows - into) % held.rows;
        if first >= piece.end {
            continue;
        }
        let kept = low_passed(&values[first..piece.end], held.rows, weights);
        for (k, value) in kept.into_iter().enumerate() {
            values[first + k * held.rows] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(rows: usize) -> Vec<f64> {
        let at = |i: usize| (0.01 * (i / rows * rows) as f64).sin();
        (0..4000).map(|i| at(i.max(1500) - 1)).collect()
    }

    #[test]
    fn a_column_that_repeats_in_step_is_held_and_a_coarse_encoder_is_not() {
        let whole = std::slice::from_ref(&(0..4000));
        assert_eq!(held(&moved(10), whole), Some(Held { rows: 10, first: 1 }));
        assert_eq!(held(&moved(1), whole), None);
        let coarse: Vec<f64> = moved(1).iter().map(|x| (50.0 * x).round()).collect();
        assert_eq!(held(&coarse, whole), None);
        // One speed, one count every five rows.
        let steady: Vec<f64> = (0..4000).map(|i| f64::from(i / 5)).collect();
        assert_eq!(held(&steady, whole), None);
    }

    #[test]
    fn what_is_read_more_often_is_smoothed_to_the_rows_that_stay() {
        let mut line: Vec<f64> = (0..400).map(f64::from).collect();
        let held = Held { rows: 8, first: 3 };
        smooth(&mut line, &[0..190, 190..400], held, &blackman_sinc(8));
        let off = (0..400).map(|i| (line[i] - i as f64).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9);
    }
}
