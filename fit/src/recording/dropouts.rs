//! Stretches in which one signal stays exactly as it is while the axis moves: a logger that lost its channel.

use std::ops::Range;

use super::MotionKind;
use super::frame::Frame;
use super::known::Slot;
use crate::statistics::{LeastSquares, bounds, quantile};

/// Samples for which a position stays exactly as it is while it drops out …
const POSITION: usize = 20;
/// … and how many times longer that is than it usually stays.
const POSITION_USUAL: f64 = 5.0;
/// A position that comes back from a dropout steps by this many times what all but 1 % of its steps are …
const JUMP_HELD: f64 = 5.0;
/// … and was moving: the step before exceeds this share of that. An axis that comes to rest and then gets its position set jumps, too.
const MOVING: f64 = 0.1;
/// The same for an effort. What the motion takes tells it from one that is truly constant ([`takes`]), so that fewer samples suffice:
/// 0.05 s at 200 Hz are ten.
const EFFORT: usize = 8;
const EFFORT_USUAL: f64 = 2.0;
/// A coarse effort stays at every level longer than at zero, which it passes as the motion turns: there a dropout is this many times
/// longer than half of its stays.
const ZERO_USUAL: f64 = 5.0;
/// Within this share of its range from an end an effort may be at its limit.
const LIMIT: f64 = 0.05;
/// The motion takes another effort than the one that is written where the two differ by this many times the usual misfit. An axis that
/// coasts with its motor off reaches 0.75.
const OTHER: f64 = 1.2;
/// Share of a stretch's motion that may fall into its second half where the axis coasts to rest.
const AT_REST: f64 = 0.05;
/// Stretches that a recording is cut into, to see what its motion takes …
const STRETCHES: usize = 1000;
/// … and the fewest, in coefficients.
const FEWEST: usize = 5;

/// Stretches of the `pieces` in which position or effort drops out, ascending and apart. Where the drive is `off` no effort does.
pub(super) fn dropouts(
    frame: &mut Frame,
    pieces: &[Range<usize>],
    kind: MotionKind,
    off: &[Range<usize>],
) -> Vec<Range<usize>> {
    let Some(x) = frame.column(Slot::Position).cloned() else {
        return Vec::new();
    };
    let (jumps, moves) = (
        steps_over(JUMP_HELD, &x, pieces),
        steps_over(MOVING, &x, pieces),
    );
    let mut found = runs(&x, pieces);
    let usual = POSITION_USUAL * length(found.iter(), 0.99);
    let is_long = |r: &Range<usize>| r.len() >= POSITION && r.len() as f64 >= usual;
    found.retain(|r| is_long(r) && moves(r.start) && jumps(r.end));
    if let Some(f) = frame.column(Slot::Effort).cloned() {
        let is_off = |r: &Range<usize>| off.iter().any(|o| o.start < r.end && r.start < o.end);
        let lost = of_effort(&frame.t_s, &x, &f, pieces, kind).into_iter();
        found.extend(lost.filter(|r| !is_off(r)));
    }
    found.sort_by_key(|r| r.start);
    let mut merged: Vec<Range<usize>> = Vec::new();
    for range in found {
        match merged.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
}

/// Where the effort `f` stays exactly as it is and the motion takes another one.
fn of_effort(
    t: &[f64],
    x: &[f64],
    f: &[f64],
    pieces: &[Range<usize>],
    kind: MotionKind,
) -> Vec<Range<usize>> {
    let (low, high) = bounds(f);
    // A saturated effort stays at its limit, which sags with the supply. Zero is none: an axis that carries a weight never gets there.
    let limit = LIMIT * (high - low);
    let limited = |v: f64| v != 0.0 && (v - low <= limit || high - v <= limit);
    let travel = bounds(x).1 - bounds(x).0;
    let fast = MOVING * usual_step(x);
    let moves = |r: &Range<usize>| {
        let (low, high) = bounds(&x[r.clone()]);
        high - low > (0.01 * travel).min(fast * r.len() as f64)
    };
    let runs = runs(f, pieces);
    let zeros = runs.iter().filter(|r| f[r.start] == 0.0);
    let zeros = ZERO_USUAL * length(zeros, 0.5);
    let usual = EFFORT_USUAL * length(runs.iter(), 0.99);
    let is_long = |r: &Range<usize>| {
        let length = r.len() as f64;
        r.len() >= EFFORT && (length >= usual || f[r.start] == 0.0 && length >= zeros)
    };
    let found = runs.into_iter();
    let mut found: Vec<Range<usize>> = found
        .filter(|r| is_long(r) && moves(r) && !limited(f[r.start]))
        .filter(|r| f[r.start] != 0.0 || !coasts(x, r))
        .collect();
    let Some(shortest) = found.iter().map(Range::len).min() else {
        return found;
    };
    let shortest = shortest.min((f.len() / STRETCHES).max(EFFORT));
    let stretch = |start: usize| Stretch::new(t, x, f, start..start + shortest, kind);
    let mut others = Vec::new();
    let mut next = found.iter().peekable();
    for piece in pieces {
        let mut start = piece.start;
        while start + shortest <= piece.end {
            while next.next_if(|r| r.end <= start).is_some() {}
            match next.peek() {
                Some(r) if r.start < start + shortest => start = r.end,
                _ => {
                    others.push(stretch(start));
                    start += shortest;
                }
            }
        }
    }
    let Some(takes) = takes(&others) else {
        return Vec::new();
    };
    let usual = misfit(&others, &takes);
    found.retain(|r| {
        let within = (r.start..=r.end - shortest).step_by(shortest);
        misfit(&within.map(stretch).collect::<Vec<_>>(), &takes) > OTHER * usual
    });
    found
}

/// Whether the axis comes to rest within a stretch and stays there: with its motor off it coasts, and no channel was lost.
fn coasts(x: &[f64], stretch: &Range<usize>) -> bool {
    let half = &x[(stretch.start + stretch.end) / 2..stretch.end];
    let reach = |x: &[f64]| bounds(x).1 - bounds(x).0;
    reach(half) <= AT_REST * reach(&x[stretch.clone()])
}

/// Coefficients of what the motion takes.
const TERMS: usize = 6;

/// The motion over some samples, and the mean effort there.
struct Stretch {
    motion: [f64; TERMS],
    effort: f64,
}

impl Stretch {
    fn new(t: &[f64], x: &[f64], f: &[f64], rows: Range<usize>, kind: MotionKind) -> Self {
        let (first, middle, last) = (rows.start, (rows.start + rows.end) / 2, rows.end - 1);
        let slope = |a: usize, b: usize| (x[b] - x[a]) / (t[b] - t[a]);
        let velocity = slope(first, last);
        let acceleration =
            2.0 * (slope(middle, last) - slope(first, middle)) / (t[last] - t[first]);
        let path: f64 = x[rows.clone()]
            .windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .sum();
        let weight = match kind {
            MotionKind::Linear => [x[middle], 0.0],
            MotionKind::Rotary => [x[middle].sin(), x[middle].cos()],
        };
        let effort = &f[rows];
        Self {
            motion: [
                1.0,
                acceleration,
                velocity,
                (x[last] - x[first]) / path.max(f64::MIN_POSITIVE),
                weight[0],
                weight[1],
            ],
            effort: effort.iter().sum::<f64>() / effort.len() as f64,
        }
    }
}

/// What the motion takes by inertia, friction and a spring or a weight; `None` where there are too few stretches.
fn takes(stretches: &[Stretch]) -> Option<Vec<f64>> {
    if stretches.len() < FEWEST * TERMS {
        return None;
    }
    let column = |k: usize| stretches.iter().map(|s| s.motion[k]).collect();
    let columns: [Vec<f64>; TERMS] = std::array::from_fn(column);
    let effort: Vec<f64> = stretches.iter().map(|s| s.effort).collect();
    Some(LeastSquares::of(&columns.each_ref().map(Vec::as_slice))?.coefficients(&effort))
}

/// RMS of the effort that is written less the one that the motion takes.
fn misfit(stretches: &[Stretch], takes: &[f64]) -> f64 {
    let squares = stretches.iter().map(|s| {
        let taken: f64 = s.motion.iter().zip(takes).map(|(m, t)| m * t).sum();
        (s.effort - taken).powi(2)
    });
    (squares.sum::<f64>() / stretches.len().max(1) as f64).sqrt()
}

/// Where a signal stays exactly as it is.
fn runs(values: &[f64], pieces: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    for piece in pieces {
        let mut start = piece.start;
        for run in values[piece.clone()].chunk_by(|a, b| a == b) {
            runs.push(start..start + run.len());
            start += run.len();
        }
    }
    runs
}

/// The length that the share `q` of some runs does not exceed.
fn length<'a>(runs: impl Iterator<Item = &'a Range<usize>>, q: f64) -> f64 {
    let mut lengths: Vec<f64> = runs.map(|r| r.len() as f64).collect();
    quantile(&mut lengths, q).unwrap_or(0.0)
}

/// What all but 1 % of the steps between samples are at most.
fn usual_step(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> = values.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    quantile(&mut steps, 0.99).unwrap_or(0.0)
}

/// Tells of a sample whether the step to it exceeds `times` what all but 1 % of the steps are. Where a piece begins or ends it tells
/// nothing: what stands still there may rest.
fn steps_over<'a>(
    times: f64,
    values: &'a [f64],
    pieces: &'a [Range<usize>],
) -> impl Fn(usize) -> bool + 'a {
    let long = times * usual_step(values);
    let inside = |i: usize| pieces.iter().any(|p| p.start < i && i < p.end);
    move |i| inside(i) && (values[i] - values[i - 1]).abs() > long
}

#[cfg(test)]
mod tests {
    use super::super::Recording;
    use super::super::tests::{read, said, warns};

    /// A swing of 20 mm against 5 N and noise of 20 mN at 1 kHz, `change` put upon it.
    fn load(change: impl Fn(usize, &mut [f64; 2])) -> Recording {
        let mut seed = 14_u32;
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..10_000_usize {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let phase = i as f64 * 0.003;
            let noise = 0.04 * (f64::from(seed) / f64::from(u32::MAX) - 0.5);
            let mut row = [
                0.02 * phase.sin(),
                5.0 * (20.0 * phase.cos()).tanh() + noise,
            ];
            change(i, &mut row);
            text += &format!("{:.3},{:.8},{:.5}\n", i as f64 * 1e-3, row[0], row[1]);
        }
        read(&text)
    }

    #[test]
    fn half_a_second_of_nothing_is_left_out_whatever_nothing_is() {
        let lost = 4000..4500_usize;
        let phase = 4000.0 * 0.003;
        let held = [
            0.02 * f64::sin(phase),
            5.0 * (20.0 * f64::cos(phase)).tanh(),
        ];
        let both = |to: [f64; 2]| {
            let lost = lost.clone();
            move |i: usize, row: &mut [f64; 2]| {
                if lost.contains(&i) {
                    *row = to;
                }
            }
        };
        // The effort comes back where it is zero anyway: it jumps as it stops only.
        let effort = |i: usize, row: &mut [f64; 2]| match i {
            4000..4500 => row[1] = 0.0,
            4500..4520 => row[1] *= 0.05 * (i - 4499) as f64,
            _ => (),
        };
        for (name, recording) in [
            ("zero", load(both([0.0; 2]))),
            ("held", load(both(held))),
            ("effort", load(effort)),
        ] {
            let dropout = said(&recording, "dropout");
            assert!(
                dropout.contains("from line 4002 to line 4501"),
                "{name}: {dropout}"
            );
            let left = (recording.len(), recording.pieces.len());
            assert_eq!(left, (9500, 2), "{name}");
        }
        assert!(!warns(&load(|_, _| ()), "dropout"));
        // It slows down, rests at a reversal, and is told where it is.
        let homed = load(|i, row| {
            let phase = match i {
                0..4712 => i as f64 * 0.003,
                _ => 4712.0 * 0.003,
            };
            if i < 6000 {
                row[0] = 0.02 * phase.sin();
            } else {
                row[0] += 0.3;
            }
        });
        assert!(!warns(&homed, "dropout"), "{:?}", homed.warnings);
    }

    /// What an axis of 3 kg does and takes against 4 N and 6 N·s/m, with noise of 20 mN or rounded to `coarse`, beside a weight (N):
    /// rows of time, position and effort over 40 s.
    fn axis(rate_hz: usize, weight: f64, coarse: Option<f64>) -> Vec<[f64; 3]> {
        const SEED: u32 = 9;
        println!("seed {SEED}");
        let mut seed = SEED;
        let mut block = 0.0_f64;
        let mut last = 0.0;
        let waves = [(0.03, std::f64::consts::PI), (0.006, 10.7)];
        let sum = |of: &dyn Fn(f64, f64) -> f64| waves.iter().map(|(a, w)| of(*a, *w)).sum::<f64>();
        let row = |i: usize| {
            let t = i as f64 / rate_hz as f64;
            let x = sum(&|a, w| a * (w * t).sin());
            let v = sum(&|a, w| a * w * (w * t).cos());
            let acceleration = -sum(&|a, w| a * w * w * (w * t).sin());
            // A block that yields over 0.5 mm.
            let level = 4.0 * v.signum();
            block = level + (block - level) * (-((x - last) / 5e-4).abs()).exp();
            last = x;
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = 0.07 * (f64::from(seed) / f64::from(u32::MAX) - 0.5);
            let force = 3.0 * acceleration + block + 6.0 * v + weight + noise;
            let force = coarse.map_or(force, |step| (force / step).round() * step);
            [t, (x / 1e-6).round() * 1e-6, force]
        };
        (0..40 * rate_hz).map(row).collect()
    }

    fn of_rows(rows: &[[f64; 3]]) -> Recording {
        let line = |[t, x, f]: &[f64; 3]| format!("{t:.4},{x:.7},{f:.5}\n");
        let text: String = rows.iter().map(line).collect();
        read(&format!("t_s,x_m,force_N\n{text}"))
    }

    fn mass(recording: &Recording) -> f64 {
        let found = crate::identify::identify(
            recording,
            &crate::identify::Options::default(),
            &crate::progress::Progress::new("", 0),
        );
        let found = found.unwrap_or_else(|e| panic!("{e}"));
        found.candidates[found.recommended].model.inertia
    }

    #[test]
    fn a_lost_effort_is_left_out_and_the_mass_stays() {
        the_mass_stays(&[(200, 0.0, None, &[0.05]), (200, 30.0, None, &[0.2])]);
    }

    #[test]
    #[ignore = "long study: cargo xtask test --all"]
    fn a_lost_effort_is_left_out_of_fast_and_coarse_recordings() {
        the_mass_stays(&[
            (1000, 0.0, None, &[0.05, 0.5]),
            (1000, 30.0, None, &[0.2]),
            (1000, 0.0, Some(0.5), &[0.2]),
        ]);
    }

    /// Rate (Hz), weight (N), steps of the effort (N), and how long the effort is lost (s).
    type Axis<'a> = (usize, f64, Option<f64>, &'a [f64]);

    fn the_mass_stays(axes: &[Axis]) {
        // Each mass takes a whole identification, so an axis of its own is identified once.
        for &(rate, weight, coarse, losses_s) in axes {
            let rows = axis(rate, weight, coarse);
            let clean = of_rows(&rows);
            let of_clean = mass(&clean);
            for &lost_s in losses_s {
                let name = format!("{rate} Hz, {weight} N, {coarse:?}, {lost_s} s");
                assert!(!warns(&clean, "dropout"), "{name}");
                let length = (lost_s * rate as f64) as usize;
                let lossy = of_rows(&without_effort(&rows, rate, length));
                println!("{name}: {}", said(&lossy, "dropout"));
                // One near a reversal may pass for what the motion takes.
                let left_out = (clean.len() - lossy.len()) / length;
                assert!((6..=8).contains(&left_out), "{name}: {left_out} of 8");
                let own = mass(&lossy);
                println!("{name}: {own:.4} kg, {of_clean:.4} kg clean");
                assert!(
                    (own / of_clean - 1.0).abs() < 0.01,
                    "{name}: {own} kg, {of_clean} kg clean"
                );
            }
        }
    }

    /// The rows without their effort in eight stretches of `length`.
    fn without_effort(rows: &[[f64; 3]], rate_hz: usize, length: usize) -> Vec<[f64; 3]> {
        let mut lossy = rows.to_vec();
        for k in 0..8 {
            let start = (rate_hz as f64 * (4.5 * k as f64 + 1.618 * (k % 3) as f64 + 0.9)) as usize;
            for row in &mut lossy[start..start + length] {
                row[2] = 0.0;
            }
        }
        lossy
    }

    /// A motor that is off while its axis coasts, and a force in steps without any friction.
    #[test]
    fn an_effort_that_is_truly_constant_is_kept() {
        for (name, coulomb, viscous) in [("coasting", 4.0, 6.0), ("without friction", 0.0, 0.0)] {
            let dt = 1e-3;
            let (mut x, mut v) = (0.0_f64, 0.0_f64);
            let row = |i: usize| {
                let t = i as f64 * dt;
                let wave = 0.03 * (std::f64::consts::PI * t).sin();
                let force = match (name, i % 5000) {
                    ("coasting", 0..400) => 0.0,
                    ("coasting", _) => 8000.0 * (wave - x) - 300.0 * v,
                    _ if (i / 2000).is_multiple_of(2) => 2.0 * (std::f64::consts::TAU * t).sin(),
                    _ => 0.0,
                };
                let free = v + dt * (force - viscous * v) / 3.0;
                v = free.signum() * (free.abs() - dt * coulomb / 3.0).max(0.0);
                x += dt * v;
                [t, (x / 1e-6).round() * 1e-6, force]
            };
            let kept = of_rows(&(0..40_000).map(row).collect::<Vec<_>>());
            assert!(!warns(&kept, "dropout"), "{name}: {:?}", kept.warnings);
        }
    }
}
