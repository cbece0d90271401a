//! The parts of `identify` against brute force: the search against exhaustive enumeration, the refinement
//! against finite differences, the zero-phase filter against what a sine must become.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use preslide_fit::identify::refine::refine;
use preslide_fit::identify::regression::{Exact, Gram, Regression, Regressor, solve_normal};
use preslide_fit::identify::search::best_choices;
use preslide_fit::identify::weights::Weights;
use preslide_fit::recording::{LoadOptions, Recording, load_csv};
use preslide_fit::signal::Deflection;
use preslide_fit::signal::ZeroPhase;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SAMPLES: usize = 3000;

/// All samples in one piece.
fn whole() -> Vec<std::ops::Range<usize>> {
    std::iter::once(0..SAMPLES).collect()
}

/// A random motion with reversals of all sizes, and the force of four blocks off the grid, with noise.
fn problem(seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut x, mut speed) = (0.0_f64, 1.0);
    let position: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            if rng.random::<f64>() < 0.02 {
                speed = rng.random_range(-1.0..1.0);
            }
            x = 0.999 * x + 0.05 * speed;
            x
        })
        .collect();
    let mut force = vec![0.3; SAMPLES];
    for (k, d) in [(4.0, 0.07), (2.0, 0.23), (1.0, 0.61), (0.4, 1.9)] {
        let z = Deflection::along(&position, &whole(), d).z;
        for (f, z) in force.iter_mut().zip(z) {
            *f += k * z;
        }
    }
    for f in &mut force {
        *f += rng.random_range(-0.2..0.2);
    }
    (position, force)
}

fn regression<'a>(
    position: &'a [f64],
    pieces: &'a [std::ops::Range<usize>],
    force: Vec<f64>,
) -> Regression<'a> {
    Regression {
        position,
        pieces,
        force,
        columns: vec![Regressor {
            name: "offset",
            values: vec![1.0; SAMPLES],
        }],
        filter: Box::new(<[f64]>::to_vec),
        folds: (0..10)
            .map(|fold| (fold * SAMPLES / 10..(fold + 1) * SAMPLES / 10).collect())
            .collect(),
        weights: Weights::default(),
    }
}

/// Squared error of the best fit with these columns, `None` unless every stiffness is positive.
fn error_with(gram: &Gram, yields: &[usize]) -> Option<f64> {
    let chosen: Vec<usize> = std::iter::once(0)
        .chain(yields.iter().map(|j| j + 1))
        .collect();
    let (matrix, right) = gram.normal(&chosen);
    let solution = solve_normal(&matrix, &right)?;
    (solution.iter().skip(1).all(|&k| k > 0.0)).then(|| gram.squared_error(&chosen, &solution))
}

fn subsets(grid: usize, size: usize) -> Vec<Vec<usize>> {
    if size == 0 {
        return vec![Vec::new()];
    }
    subsets(grid, size - 1)
        .into_iter()
        .flat_map(|subset| {
            let from = subset.last().map_or(0, |last| last + 1);
            (from..grid).map(move |j| [subset.clone(), vec![j]].concat())
        })
        .collect()
}

#[test]
fn the_search_finds_what_exhaustive_enumeration_finds() {
    const GRID: usize = 18;
    for seed in 0..6 {
        let (position, force) = problem(seed);
        let pieces = whole();
        let regression = regression(&position, &pieces, force);
        let yields: Vec<f64> = (0..GRID)
            .map(|j| 0.02 * 200f64.powf(j as f64 / (GRID - 1) as f64))
            .collect();
        let gram = Gram::sum(&regression.grams(&yields)).expect("samples");
        let found = best_choices(&gram, 1, 4);
        for size in 1..=4 {
            let best = subsets(GRID, size)
                .into_iter()
                .filter_map(|subset| Some((error_with(&gram, &subset)?, subset)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match (best, found[size - 1].first()) {
                (Some((error, subset)), Some(choice)) => {
                    assert_eq!(choice.yields, subset, "seed {seed}, {size} blocks");
                    assert!((choice.squared_error / error - 1.0).abs() < 1e-6);
                }
                (None, None) => {}
                (best, found) => panic!("seed {seed}, {size} blocks: {best:?}, found {found:?}"),
            }
        }

        // Samples in another order are the same samples.
        let mut reversed = regression.grams(&yields);
        reversed.reverse();
        let again = best_choices(&Gram::sum(&reversed).expect("samples"), 1, 4);
        for (a, b) in found.iter().zip(&again) {
            let first =
                |c: &[preslide_fit::identify::search::Choice]| c.first().map(|c| c.yields.clone());
            assert_eq!(first(a), first(b));
        }
    }
}

#[test]
fn the_derivative_of_a_block_is_that_of_finite_differences() {
    let (position, _) = problem(7);
    let pieces = [0..1700, 1700..SAMPLES];
    for d in [0.05, 0.3, 1.1] {
        let exact = Deflection::along(&position, &pieces, d);
        let h = 1e-7 * d;
        let above = Deflection::along(&position, &pieces, d + h).z;
        let below = Deflection::along(&position, &pieces, d - h).z;
        let wrong = (0..SAMPLES)
            .filter(|&i| ((above[i] - below[i]) / (2.0 * h) - exact.slope[i]).abs() > 1e-3)
            .count();
        // A slip that the step itself starts or prevents has no derivative; it lasts until the next slip.
        assert!(wrong <= SAMPLES / 500, "{wrong} samples at D = {d}");
    }
}

/// Squared error of the best stiffnesses with these yields.
fn profile(regression: &Regression, yields: &[f64]) -> f64 {
    let gram = Gram::sum(&regression.grams(yields)).expect("samples");
    let all: Vec<usize> = (0..yields.len()).collect();
    error_with(&gram, &all).expect("positive stiffnesses")
}

#[test]
fn the_refinement_ends_where_the_error_is_stationary() {
    let (position, force) = problem(11);
    let pieces = whole();
    let regression = regression(&position, &pieces, force);
    let start = vec![0.05, 0.3, 0.8, 1.5];
    let rows = regression.folds.concat();
    let exact = Exact {
        regression: &regression,
        rows: &rows,
    };
    let fit = refine(&exact, start.clone(), (0.01, 4.0)).expect("a fit");
    let slope = |yields: &[f64], i: usize| {
        let at = |factor: f64| {
            let mut moved = yields.to_vec();
            moved[i] *= factor;
            profile(&regression, &moved)
        };
        (at(1.0 + 1e-4) - at(1.0 - 1e-4)) / 2e-4
    };
    assert!((profile(&regression, &fit.yields) / fit.squared_error - 1.0).abs() < 1e-6);
    for i in 0..start.len() {
        let (before, after) = (slope(&start, i), slope(&fit.yields, i));
        assert!(
            after.abs() < 0.02 * before.abs().max(1.0),
            "block {i}: {after}, at the start {before}"
        );
    }
    for (found, truth) in fit.yields.iter().zip([0.07, 0.23, 0.61, 1.9]) {
        assert!(
            (found / truth - 1.0).abs() < 0.15,
            "{found} instead of {truth}"
        );
    }
    // Out of bounds it does not go, and nonsense it refuses.
    let bounded = refine(&exact, vec![0.3], (0.25, 0.35)).expect("a fit");
    assert!((0.25..=0.35).contains(&bounded.yields[0]));
    assert!(refine(&exact, vec![0.3, 0.3], (0.01, 4.0)).is_none());
}

/// A recording of these positions at these times.
fn recorded(samples: impl IntoIterator<Item = (f64, f64)>) -> Recording {
    let text = samples.into_iter().enumerate().fold(
        "t_s,x_m,friction_N\n".to_owned(),
        |mut text, (i, (t, x))| {
            writeln!(text, "{t:.9},{x:.12},{}", i % 5).expect("memory");
            text
        },
    );
    let options = LoadOptions {
        sign: Some(1.0),
        ..LoadOptions::default()
    };
    load_csv(text.as_bytes(), "sine.csv", &options).unwrap_or_else(|e| panic!("{e}"))
}

const RATE: f64 = 500.0;

/// Largest differences over the samples from a tenth to nine tenths, relative to the amplitude of what was
/// expected.
fn differences(filter: &ZeroPhase, recording: &Recording, hz: f64) -> [f64; 3] {
    let w = TAU * hz;
    let middle = recording.len() / 10..9 * recording.len() / 10;
    [0, 1, 2].map(|order| {
        let got = filter.derivative(&recording.position, order);
        middle
            .clone()
            .map(|i| {
                let phase = w * recording.t_s[i];
                let expected = [phase.sin(), phase.cos(), -phase.sin()][order as usize];
                (got[i] / w.powi(order as i32) - expected).abs()
            })
            .fold(0.0, f64::max)
    })
}

#[test]
fn a_sine_in_the_band_keeps_amplitude_and_phase_and_has_exact_derivatives() {
    let sine = |hz: f64| {
        recorded((0..4000).map(move |i| (i as f64 / RATE, (TAU * hz * i as f64 / RATE).sin())))
    };
    let (slow, edge, fast) = (sine(2.0), sine(20.0), sine(80.0));
    let filter = |r: &Recording| ZeroPhase::new(r, 20.0);
    for difference in differences(&filter(&slow), &slow, 2.0) {
        assert!(difference < 1e-4, "{difference}");
    }
    // At the cut-off half is left, in phase; two octaves above nothing is.
    let smooth = filter(&edge).smooth(&edge.position);
    let worst = (1000..3000)
        .map(|i| (smooth[i] - 0.5 * edge.position[i]).abs())
        .fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst}");
    let smooth = filter(&fast).smooth(&fast.position);
    assert!(smooth[1000..3000].iter().all(|v| v.abs() < 1e-3));
}

#[test]
fn uneven_time_stamps_and_gaps_do_not_shift_the_phase() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let times: Vec<f64> = (0..4000)
        .map(|i| (f64::from(i) + rng.random_range(-0.3..0.3)) / RATE)
        .collect();
    let uneven = recorded(times.iter().map(|&t| (t, (TAU * 2.0 * t).sin())));
    for difference in differences(&ZeroPhase::new(&uneven, 20.0), &uneven, 2.0) {
        assert!(difference < 5e-3, "{difference}");
    }
    let gap = recorded((0..4000).map(|i| {
        let t = f64::from(i) / RATE + if i < 2000 { 0.0 } else { 1.7 };
        (t, (TAU * 2.0 * t).sin())
    }));
    assert_eq!(gap.pieces.len(), 2);
    let velocity = ZeroPhase::new(&gap, 20.0).derivative(&gap.position, 1);
    for i in (400..1600).chain(2400..3600) {
        let expected = TAU * 2.0 * (TAU * 2.0 * gap.t_s[i]).cos();
        assert!((velocity[i] - expected).abs() < 1e-2, "{i}");
    }
    // Beside the gap there is no ringing from the jump in position.
    let top = velocity.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    assert!(top < 1.5 * TAU * 2.0, "{top}");
}

#[test]
fn pieces_of_one_two_and_three_samples_are_filtered_without_panic() {
    let cuts = [1000, 1001, 1003, 1006];
    let recording = recorded((0..2000).map(|i| {
        let t = f64::from(i) / RATE + cuts.iter().filter(|&&c| i >= c).count() as f64;
        (t, (TAU * t).sin())
    }));
    let lengths: Vec<usize> = recording
        .pieces
        .iter()
        .map(ExactSizeIterator::len)
        .collect();
    assert_eq!(lengths, [1000, 1, 2, 3, 994]);
    for filter in [
        ZeroPhase::choose(&recording),
        ZeroPhase::new(&recording, 5.0),
    ] {
        for order in 0..3 {
            let out = filter.derivative(&recording.position, order);
            assert!(out.iter().all(|v| v.is_finite()));
        }
        // A single sample keeps its value and has no slope.
        assert!(
            (filter.smooth(&recording.position)[1000] - recording.position[1000]).abs() < 1e-12
        );
        assert!(filter.derivative(&recording.position, 1)[1000].abs() < 1e-9);
    }
}

#[test]
fn the_band_narrows_with_the_encoder_and_stays_above_the_motion() {
    let band = |count: f64| {
        let recording = recorded((0..20_000).map(|i| {
            let t = f64::from(i) / RATE;
            let x = (TAU * 0.5 * t).sin() + 0.2 * (TAU * 3.1 * t).sin();
            (
                t,
                if count > 0.0 {
                    (x / count).round() * count
                } else {
                    x
                },
            )
        }));
        ZeroPhase::choose(&recording).cutoff_hz()
    };
    let bands = [0.0, 1e-5, 1e-4, 1e-3].map(band);
    println!("{bands:?}");
    assert!(bands[0] > 0.1 * RATE, "{bands:?}");
    assert!(bands.windows(2).all(|pair| pair[1] <= pair[0]), "{bands:?}");
    assert!(bands[3] < 0.8 * bands[0] && bands[3] > 3.1, "{bands:?}");
    // What it promises: the acceleration that the encoder adds is at most 0.1 % in power, here with a reserve of
    // two for noise that is not white.
    let at = |i: i32| f64::from(i) / RATE;
    let x = |t: f64| (TAU * 0.5 * t).sin() + 0.2 * (TAU * 3.1 * t).sin();
    let coarse = recorded((0..20_000).map(|i| (at(i), (x(at(i)) / 1e-3).round() * 1e-3)));
    let filter = ZeroPhase::choose(&coarse);
    let found = filter.derivative(&coarse.position, 2);
    let exact = filter.derivative(&(0..20_000).map(|i| x(at(i))).collect::<Vec<_>>(), 2);
    let power = |of: &dyn Fn(usize) -> f64| (2000..18_000).map(|i| of(i).powi(2)).sum::<f64>();
    let share = power(&|i| found[i] - exact[i]) / power(&|i| exact[i]);
    println!("share of noise {share}");
    assert!(share < 2e-3, "{share}");
    // Nothing to see: the widest or the narrowest band, but a band.
    let still = recorded((0..500).map(|i| (f64::from(i) / RATE, 1.0)));
    assert!(ZeroPhase::choose(&still).cutoff_hz() > 0.0);
}
