//! Ends of recordings that were cut from a motion.

use crate::recording::Recording;
use crate::signal::not_yet_known;
use std::ops::Range;

/// Samples at the ends of files that were cut from a motion: a filter that reaches so far has nobody's samples there, and friction a state that nobody
/// saw.
pub(super) fn cut_from_a_motion(recording: &Recording, reach: usize) -> Vec<Range<usize>> {
    /// Samples in which an axis that stood has hardly moved.
    const FEW: usize = 3;
    /// Share of what it moves in as many at its fastest.
    const MOVES: f64 = 0.05;
    let moved = |i: usize| (recording.position[i + FEW] - recording.position[i]).abs();
    let of = |file: &Range<usize>| file.start..file.end.saturating_sub(FEW).max(file.start);
    let files = recording.joined.iter().filter(|file| !of(file).is_empty());
    let fastest = files.clone().flat_map(of).map(moved).fold(0.0, f64::max);
    let cut = |file: &Range<usize>| {
        let (first, last) = (file.start, file.end - FEW - 1);
        let begins = first..(first + reach).max(not_yet_known(recording, file).end);
        let ends = file.end.saturating_sub(reach).max(first)..file.end;
        [(first, begins), (last, ends)]
    };
    let cuts = files.flat_map(cut);
    let in_motion = cuts.filter(|(at, _)| moved(*at) > MOVES * fastest);
    in_motion
        .map(|(_, range)| range.start..range.end.min(recording.len()))
        .collect()
}

/// Whether a fit leaves far more there than elsewhere: a chirp that began at 25 mm/s made viscous friction 9.01 of 8 by its first fifth of a second.
pub(super) fn stands_out(
    there: &[Range<usize>],
    train: &[usize],
    effort: &[f64],
    fitted: &[f64],
) -> bool {
    /// Times as much, in root mean squares; by three it took what was sound from made recordings whose inertia it then missed more often.
    const FAR_MORE: f64 = 5.0;
    let (mut own, mut others) = ((0.0, 0.0), (0.0, 0.0));
    for &i in train {
        let is_there = there.iter().any(|range| range.contains(&i));
        let sum = if is_there { &mut own } else { &mut others };
        sum.0 += (effort[i] - fitted[i]).powi(2);
        sum.1 += 1.0;
    }
    own.1 > 0.0 && others.1 > 0.0 && own.0 / own.1 > FAR_MORE * FAR_MORE * others.0 / others.1
}
