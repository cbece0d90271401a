//! The encoder: wrapping counts, and a velocity that is usable from one count per second to full speed.

use fixed::types::I32F32;
use preslide::{CountTracker, EncoderScale, Units};
use preslide_host_tests::reference::SteadyMotion;
use proptest::prelude::*;

const COUNT: f64 = 25e-9;
const SAMPLE_TIME: f64 = 50e-6;
/// Ticks of the velocity window and of the timeout below.
const WINDOW: i64 = 20;
const TIMEOUT: i64 = 40_000;

fn scale() -> EncoderScale<f64> {
    EncoderScale::try_new(COUNT, SAMPLE_TIME, 1e-3, 2.0, Units::SI).expect("valid")
}

/// Velocity estimates in counts per tick at the ticks `1..=ticks`, starting from rest.
fn estimates(position: impl Fn(i64) -> i64, ticks: i64) -> Vec<f64> {
    let scale = scale();
    let mut timing = scale.at_rest();
    (1..=ticks)
        .map(|tick| {
            let counts = (position(tick) - position(tick - 1)) as i32;
            scale.step(&mut timing, counts).velocity * SAMPLE_TIME / COUNT
        })
        .collect()
}

/// Largest relative error of the estimate once two edges a window apart have been seen.
fn largest_error(motion: SteadyMotion) -> f64 {
    let edge = (motion.ticks / motion.counts.abs()).max(1);
    let settled = 2 * (edge + WINDOW) + 2;
    let velocity = motion.velocity();
    estimates(|tick| motion.reading(tick), settled + 6 * edge.max(WINDOW))
        .iter()
        .skip(settled as usize)
        .map(|estimate| (estimate / velocity - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn sixteen_bit_counts_wrap_in_both_directions() {
    let mut tracker = CountTracker::new(65_530_u16);
    assert_eq!(tracker.update(4), 10);
    assert_eq!(tracker.update(65_530), -10);
    assert_eq!(tracker.position(), 0);
    assert_eq!(tracker.update(65_530_u16.wrapping_add(32_767)), 32_767);
    assert_eq!(tracker.update(65_530), -32_767);
}

#[test]
fn thirty_two_bit_counts_wrap_in_both_directions() {
    let mut tracker = CountTracker::new(u32::MAX - 5);
    assert_eq!(tracker.update(4), 10);
    assert_eq!(tracker.update(u32::MAX - 5), -10);
    assert_eq!(tracker.position(), 0);
    assert_eq!(
        tracker.update((u32::MAX - 5).wrapping_add(i32::MAX as u32)),
        i32::MAX
    );
    assert_eq!(tracker.update(u32::MAX - 5), -i32::MAX);
}

#[test]
fn one_count_per_second_is_measured_to_a_tick_in_a_second() {
    // 20,000 ticks a count; and a speed at which the edges do not fall on ticks.
    for motion in [
        SteadyMotion {
            counts: 1,
            ticks: 20_000,
            phase: 7_777,
        },
        SteadyMotion {
            counts: -1,
            ticks: 20_000,
            phase: 7_777,
        },
        SteadyMotion {
            counts: 3,
            ticks: 59_999,
            phase: 0,
        },
    ] {
        let error = largest_error(motion);
        println!(
            "{} counts in {} ticks: relative error {error:.1e}",
            motion.counts, motion.ticks
        );
        assert!(error <= 1.01 / 20_000.0, "{motion:?}: {error:e}");
    }
}

#[test]
fn high_speed_is_measured_to_a_count_in_a_window() {
    for (counts, ticks) in [
        (1, 1),
        (7, 3),
        (101, 10),
        (12_345, 7),
        (-12_345, 7),
        (32_000, 1),
    ] {
        let motion = SteadyMotion {
            counts,
            ticks,
            phase: ticks / 2,
        };
        let bound = 1.0 / (motion.velocity().abs() * WINDOW as f64) + 1e-6;
        let error = largest_error(motion);
        println!("{counts} counts in {ticks} ticks: relative error {error:.1e}");
        assert!(error <= bound, "{motion:?}: {error:e} > {bound:e}");
    }
}

/// Mean of `(v − v̂)/a` over a ramp (ticks): by how much the estimate is behind.
fn mean_lag(window: f64, top: f64) -> f64 {
    let scale = EncoderScale::<f64>::try_new(COUNT, SAMPLE_TIME, window, 2.0, Units::SI);
    let scale = scale.expect("valid");
    // From `top` to three times that, in counts per tick, over 20 windows; the first edge in a thousand phases.
    let ticks = (20.0 * window / SAMPLE_TIME) as i64;
    let slope = 2.0 * top / ticks as f64;
    let (mut sum, mut samples) = (0.0, 0.0);
    for phase in 0..1000 {
        let mut timing = scale.at_rest();
        let position = |tick: i64| {
            let t = tick as f64;
            (top * t + 0.5 * slope * t * t + f64::from(phase) * 1e-3).floor() as i64
        };
        for tick in 1..=ticks {
            let counts = (position(tick) - position(tick - 1)) as i32;
            let estimate = scale.step(&mut timing, counts).velocity * SAMPLE_TIME / COUNT;
            if tick > ticks / 5 {
                sum += (top + slope * tick as f64 - estimate) / slope;
                samples += 1.0;
            }
        }
    }
    sum / samples
}

/// Half the window, not the whole one that estimates from one window after the other have.
#[test]
fn the_mean_lag_is_at_most_0_55_windows_where_edges_are_faster() {
    println!("window (ms)  counts/tick  mean lag (windows)");
    for window in [1e-3, 2e-3, 5e-3, 10e-3] {
        // From ten edges in a window up.
        for top in [10.0 * SAMPLE_TIME / window, 1.0, 3.7, 30.0, 500.0] {
            let lag = mean_lag(window, top) * SAMPLE_TIME / window;
            println!("{:>11} {top:>12} {lag:>19.3}", window * 1e3);
            assert!((0.4..=0.55).contains(&lag), "{window} {top}: {lag}");
        }
    }
}

/// What the controller takes off the mass is computed from this: half a tick less than the lag behind the speed of the instant. Over
/// a parabola, with edges in every tick; in windows that are no multiple of the distance of remembered edges, too.
#[test]
fn reports_the_measured_delay() {
    println!("window (ticks)  told (ticks)  measured (ticks)");
    for window in [1, 2, 3, 7, 20, 30, 31, 45, 100, 199] {
        let window_s = f64::from(window) * SAMPLE_TIME;
        let scale = EncoderScale::<f64>::try_new(COUNT, SAMPLE_TIME, window_s, 2.0, Units::SI);
        let told = scale.expect("valid").delay();
        let measured = mean_lag(window_s, 30.0) - 0.5;
        println!("{window:>14} {told:>13} {measured:>17.4}");
        // The mean is over a count's thousand phases, and whole updates but for one.
        assert!(
            (told - measured).abs() < 0.002,
            "{window}: {told}, {measured}"
        );
    }
}

#[test]
fn one_count_per_second_survives_fixed_point_units() {
    let units = Units {
        length: COUNT,
        force: 1e-3,
        velocity: 1e-3,
    };
    let scale =
        EncoderScale::<I32F32>::try_new(COUNT, SAMPLE_TIME, 1e-3, 2.0, units).expect("valid");
    let mut timing = scale.at_rest();
    let mut velocity = I32F32::ZERO;
    for tick in 1..=60_000 {
        velocity = scale
            .step(&mut timing, i32::from(tick % 20_000 == 0))
            .velocity;
    }
    assert!(
        (velocity.to_num::<f64>() / 25e-6 - 1.0).abs() < 1e-4,
        "{velocity}"
    );
}

#[test]
fn a_reversal_reads_zero_then_the_new_velocity_with_its_sign() {
    // Two ticks a count, up for 1,000 ticks, then down.
    let estimate = estimates(
        |tick| {
            if tick <= 1_000 {
                tick / 2
            } else {
                1_000 - tick / 2
            }
        },
        2_000,
    );
    assert!((estimate[999] - 0.5).abs() < 0.03);
    let first_down = 1_001;
    assert_eq!(estimate[first_down], 0.0);
    assert!(
        estimate[first_down..]
            .iter()
            .all(|&velocity| velocity <= 0.0)
    );
    assert!((estimate[first_down + WINDOW as usize + 2] + 0.5).abs() < 0.03);
}

#[test]
fn a_stop_decays_as_one_count_over_the_time_since_and_ends_at_zero() {
    // Ten counts per tick for 1,000 ticks.
    let estimate = estimates(|tick| 10 * tick.min(1_000), 1_000 + TIMEOUT + 10);
    assert!((estimate[999] - 10.0).abs() < 1e-5);
    for quiet in 1..TIMEOUT {
        let velocity = estimate[(999 + quiet) as usize];
        assert!(
            velocity > 0.0 && velocity <= 1.000_001 / quiet as f64,
            "{quiet}: {velocity}"
        );
    }
    assert_eq!(estimate[(999 + TIMEOUT) as usize], 0.0);
}

#[test]
fn the_first_edge_after_standstill_does_not_read_as_speed() {
    let estimate = estimates(|tick| i64::from(tick >= 100_000), 100_100);
    assert!(estimate.iter().all(|&velocity| velocity <= 1.0 / 99_000.0));
}

#[test]
fn motion_after_standstill_is_measured_a_window_later() {
    let start = 100_000;
    let estimate = estimates(|tick| (tick - start).max(0), start + 200);
    let settled = (start + 2 * WINDOW) as usize;
    assert!(
        estimate[settled..]
            .iter()
            .all(|&velocity| (velocity - 1.0).abs() < 0.06)
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn jitter_of_one_count_at_rest_never_reads_as_speed(
        flips in prop::collection::vec(1..300_i64, 1..100),
    ) {
        // An edge under the encoder's mark: 0, 1, 0, 1, … at random times.
        let mut at = 50_000;
        let edges: Vec<i64> = flips.iter().map(|gap| { at += gap; at }).collect();
        let estimate = estimates(|tick| edges.iter().filter(|&&edge| edge <= tick).count() as i64 % 2, at + 10);
        let largest = estimate.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        prop_assert!(largest <= 1.0 / 49_999.0, "{largest}");
    }

    #[test]
    fn steady_motion_is_measured_to_a_tick_in_the_time_between_edges(
        counts in 1..400_i64, ticks in 1..4_000_i64, phase in 0..4_000_i64, backward: bool,
    ) {
        let motion = SteadyMotion {
            counts: if backward { -counts } else { counts },
            ticks,
            phase: phase % ticks,
        };
        let between = (ticks / counts).max(WINDOW) as f64;
        let bound = 1.0 / (between * motion.velocity().abs().max(1.0)) + 1e-6;
        let error = largest_error(motion);
        prop_assert!(error <= bound * (1.0 + bound) + 1e-6, "{error} > {bound}");
    }

    #[test]
    fn a_tracker_recovers_any_travel_below_half_the_range(
        first: u16, steps in prop::collection::vec(-32_768..32_768_i64, 1..200),
    ) {
        let mut tracker = CountTracker::new(first);
        let mut position = 0_i64;
        for step in steps {
            position += step;
            let reading = (i64::from(first) + position).rem_euclid(65_536) as u16;
            prop_assert_eq!(i64::from(tracker.update(reading)), step);
            prop_assert_eq!(tracker.position(), position);
        }
    }

    #[test]
    fn no_count_sequence_breaks_the_estimate(
        counts in prop::collection::vec(prop_oneof![any::<i32>(), -2..3_i32], 1..300),
        window in 1e-9..1.0_f64,
    ) {
        let scale = EncoderScale::<f32>::try_new(COUNT, SAMPLE_TIME, window, 2.0, Units::SI).expect("valid");
        let mut timing = scale.at_rest();
        for count in counts {
            let motion = scale.step(&mut timing, count);
            prop_assert!(motion.velocity.is_finite() && motion.displacement.is_finite());
        }
    }
}
