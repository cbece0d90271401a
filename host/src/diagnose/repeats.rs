//! What differs from one repeat of a motion to the next: no law of the motion takes it, whatever it is.

use super::rows::Rows;
use std::ops::Range;

/// Share of the travel within which two passes are one motion: what they leave differs by their friction, then, and not by where they went.
const ALIKE: f64 = 0.02;
/// Share of the longer pass that the shorter one must last.
const AS_LONG: f64 = 0.9;
/// Places at which two passes are compared.
const PLACES: usize = 400;
/// Share of the rows that must have been passed again to speak for all.
const COVERED: f64 = 0.5;
/// Spacings of rows over which a pass is interpolated.
const NEAR: f64 = 1.5;

/// Rows of a pass: when it began, its rows' times since then (s), and the first of them.
struct Pass {
    samples: Range<usize>,
    since: Vec<f64>,
    first: usize,
}

/// Mean square (N² or (N·m)²) of what is `left` at the rows and differs between repeats of one motion; `None` where most rows were passed once.
/// Rows of the other passes are interpolated, which smooths white noise: it is a lower bound.
pub(super) fn unrepeated(rows: &Rows, left: &[f64]) -> Option<f64> {
    let mut motions: Vec<Vec<Pass>> = Vec::new();
    for pass in passes(rows) {
        match motions
            .iter_mut()
            .find(|m| is_alike(rows, &m[0].samples, &pass.samples))
        {
            Some(motion) => motion.push(pass),
            None => motions.push(vec![pass]),
        }
    }
    let squares: Vec<f64> = motions
        .iter()
        .filter(|motion| motion.len() > 1)
        .flat_map(|motion| between(rows, left, motion))
        .collect();
    let enough = squares.len() as f64 >= COVERED * left.len() as f64;
    enough.then(|| squares.iter().sum::<f64>() / squares.len() as f64)
}

/// The passes of a recording, one a run of equal numbers in the column that counts repeats.
fn passes(rows: &Rows) -> Vec<Pass> {
    let (s, centres) = (&rows.s, &rows.weak.centres);
    let mut begin = 0;
    let runs = s.repeat.chunk_by(|a, b| a == b).map(|run| {
        begin += run.len();
        begin - run.len()..begin
    });
    runs.map(|samples| {
        let first = centres.partition_point(|c| *c < samples.start);
        let own = &centres[first..centres.partition_point(|c| *c < samples.end)];
        let since = own.iter().map(|c| s.t[*c] - s.t[samples.start]).collect();
        Pass {
            samples,
            since,
            first,
        }
    })
    .collect()
}

/// Whether two passes are one motion.
fn is_alike(rows: &Rows, a: &Range<usize>, b: &Range<usize>) -> bool {
    let (short, long) = (a.len().min(b.len()), a.len().max(b.len()));
    let near = |k: usize| {
        let i = k * short / PLACES;
        (rows.s.smooth[a.start + i] - rows.s.smooth[b.start + i]).abs() <= ALIKE * rows.s.travel()
    };
    short as f64 >= AS_LONG * long as f64 && (0..PLACES).all(near)
}

/// The variance between passes of one motion at each of their rows that others passed, too.
fn between(rows: &Rows, left: &[f64], motion: &[Pass]) -> Vec<f64> {
    let reach = NEAR * rows.weak.spacing as f64 * rows.s.dt;
    let at = |pass: &Pass, since: f64| -> Option<f64> {
        let after = pass.since.partition_point(|s| *s < since);
        let (from, to) = (after.checked_sub(1)?, pass.since.get(after)?);
        let step = to - pass.since[from];
        let share = (since - pass.since[from]) / step;
        let values = [left[pass.first + from], left[pass.first + after]];
        (step <= reach).then(|| values[0] + share * (values[1] - values[0]))
    };
    let mut found = Vec::new();
    for (own, pass) in motion.iter().enumerate() {
        for (row, since) in pass.since.iter().enumerate() {
            let others = motion.iter().enumerate().filter(|(j, _)| *j != own);
            let others = others.filter_map(|(_, other)| at(other, *since));
            let all: Vec<f64> = others.chain([left[pass.first + row]]).collect();
            if all.len() < 2 {
                continue;
            }
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let square = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            found.push(square / (all.len() - 1) as f64);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_fit::recording::{LoadOptions, load_csv};
    use std::f64::consts::TAU;
    use std::fmt::Write as _;

    const STEP_S: f64 = 2e-3;
    const PERIOD_S: f64 = 5.0;
    const REPEATS: usize = 6;

    /// Rows of a motion that begins anew every `PERIOD_S`, its amplitude (m) as `amplitude` has it of the repeat.
    fn rows(amplitude: impl Fn(usize) -> f64) -> Rows {
        let mut text = String::from("t_s,x_m,force_N,repeat\n");
        for i in 0..(REPEATS as f64 * PERIOD_S / STEP_S) as usize {
            let t = i as f64 * STEP_S;
            let repeat = (t / PERIOD_S) as usize;
            let phase = TAU * t / PERIOD_S;
            let x = amplitude(repeat) * ((3.0 * phase).sin() + 0.4 * (7.0 * phase).sin());
            let force = 2.0 * (3.0 * phase).cos().signum();
            writeln!(text, "{t:.6},{x:.12},{force:.9},{repeat}").expect("a string");
        }
        let recording =
            load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("a recording");
        Rows::new(&recording, &[]).expect("rows")
    }

    #[test]
    fn what_repeats_is_no_difference_and_what_does_not_has_its_size() {
        let rows = rows(|_| 0.01);
        let time: Vec<f64> = rows.weak.centres.iter().map(|c| rows.s.t[*c]).collect();
        // Repeated: a wave of 1 N in phase with the motion. Not: one of 0.1 N whose period no repeat holds a whole number of.
        let repeated = |t: &f64| (2.0 * TAU * t / PERIOD_S).sin();
        let wanders = |t: &f64| 0.1 * (TAU * t / (0.37 * PERIOD_S)).sin();
        let of = |force: &dyn Fn(&f64) -> f64| {
            let left: Vec<f64> = time.iter().map(force).collect();
            unrepeated(&rows, &left).expect("passed again")
        };
        // Interpolation between rows 12.5 ms apart bends a wave of 2.5 s by 1e-4 of it.
        assert!(of(&repeated) < 1e-7, "{}", of(&repeated));
        let mixed = of(&|t| repeated(t) + wanders(t));
        // Six phases of a wave: a²/2·(n − |Σ exp(iφ)|²/n)/(n − 1) in the mean over a period.
        let phases = (0..REPEATS).map(|k| TAU * k as f64 / 0.37);
        let (re, im) = phases.fold((0.0, 0.0), |(re, im), p| (re + p.cos(), im + p.sin()));
        let n = REPEATS as f64;
        let expected = 0.5 * 0.1_f64.powi(2) * (n - (re * re + im * im) / n) / (n - 1.0);
        // Most of it is what lies before friction is known in the first repeat.
        assert!((mixed / expected - 1.0).abs() < 0.02, "{mixed} {expected}");
    }

    #[test]
    fn passes_of_other_motions_prove_nothing() {
        let rows = rows(|repeat| 0.01 + 0.001 * repeat as f64);
        assert_eq!(unrepeated(&rows, &vec![1.0; rows.force.len()]), None);
    }
}
