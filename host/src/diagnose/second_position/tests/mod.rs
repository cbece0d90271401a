mod periodic;

use super::*;
use preslide_fit::recording::{LoadOptions, load_csv};
use preslide_host_tests::made::sines;

const SLOPE: f64 = 60e-6;

/// Slope and bow over ±0.12 m.
fn lead(x: f64) -> f64 {
    SLOPE * x + 4e-6 * (std::f64::consts::PI * x / 0.12).cos()
}

/// 60 s over 0.24 m against 4 N and 20 N·s/m, 3 kg; `second` tells a second position from the first, the effort and the play of a
/// backlash of 10 µm, beside 0.3 µm of noise. `scale` is what its column is multiplied by.
fn recorded(name: &str, scale: f64, second: impl FnMut(f64, f64, f64) -> f64) -> Recording {
    const SEED: u32 = 5;
    recorded_from(SEED, name, scale, second)
}

/// The same from a seed.
fn recorded_from(
    mut seed: u32,
    name: &str,
    scale: f64,
    mut second: impl FnMut(f64, f64, f64) -> f64,
) -> Recording {
    println!("seed {seed}");
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    };
    let mut text = format!("t_s,x_m,force_N,{name}\n");
    let mut play = 0.0_f64;
    for i in 0..30_000 {
        let t = f64::from(i) / 500.0;
        let [x, v, a] = sines(&[[0.09, 2.1, 0.0], [0.03, 5.3, 0.0]], t);
        let force = 3.0 * a + 4.0 * (v / 1e-3).tanh() + 20.0 * v + 0.05 * noise();
        play = play.clamp(x - 5e-6, x + 5e-6);
        let y = second(x, force, play) + 1e-6 * noise();
        let x = (x / 1e-7).round() * 1e-7;
        text += &format!("{t:.3},{x:.8},{force:.4},{:.9}\n", scale * y + 0.4);
    }
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
    recording.unwrap_or_else(|e| panic!("{e}"))
}

/// What is found in such a recording.
fn made(name: &str, scale: f64, second: impl Fn(f64, f64, f64) -> f64) -> Vec<SecondPosition> {
    let recording = recorded(name, scale, second);
    let all = of(&recording);
    all.iter().for_each(|p| println!("{}", p.words(&recording)));
    all
}

fn only(all: Vec<SecondPosition>) -> SecondPosition {
    assert_eq!(all.len(), 1);
    all.into_iter().next().expect("one")
}

#[test]
fn reports_a_lead_error_beside_backlash_and_compliance() {
    let found = only(made("x_scale_mm", 1e3, |x, f, play| {
        lead(x) + play - f / 4e6
    }));
    let lead_error = found.lead.expect("a lead error");
    let slope = lead_error.slope.expect("one unit").value;
    assert!((slope / SLOPE - 1.0).abs() < 0.03, "slope {slope}");
    let off: Vec<f64> = lead_error.curve.iter().map(|[x, d]| d - lead(*x)).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let most = off.iter().fold(0.0, |m: f64, d| m.max((d - mean).abs()));
    let rms = (off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt();
    println!("curve: largest {most:.1e} m, RMS {rms:.1e} m");
    // Of 7 µm each way; the noise of the second position is 0.3 µm RMS.
    assert!(most < 5e-7 && rms < 2e-7, "largest {most}, RMS {rms}");
    assert!(lead_error.share > 0.5, "{}", lead_error.share);
    let width = found.lost_motion.expect("backlash").value;
    assert!((width / 10e-6 - 1.0).abs() < 0.05, "width {width}");
    let compliance = found.compliance.expect("compliance").value;
    assert!(
        (compliance * 4e6 - 1.0).abs() < 0.1,
        "compliance {compliance}"
    );
}

#[test]
fn reports_backlash_and_compliance_with_their_intervals() {
    let recording = recorded("x_scale_m", 1.0, |_, f, play| play - f / 4e6);
    let found = only(of(&recording));
    let words = found.words(&recording);
    println!("{words}");
    // The value and what stands behind ± in the clause that ends in `end`, in the unit `unit`.
    let told = |start: &str, end: &str, units: &[(&str, f64)]| -> [f64; 2] {
        let clause = words.split(start).nth(1).expect(start);
        let clause = clause.split(end).next().expect(end);
        let (figures, unit) = clause.rsplit_once(' ').expect("a unit");
        let (_, factor) = units.iter().find(|(u, _)| *u == unit).expect(unit);
        let (value, reach) = figures.split_once(" ± ").expect("an interval");
        [value, reach].map(|figure| factor * figure.parse::<f64>().expect("a figure"))
    };
    let units = [("µm", 1e-6), ("nm", 1e-9)];
    for (estimate, [value, reach]) in [
        (
            found.compliance.expect("compliance"),
            told("behind the effort by ", " a N (compliance)", &units),
        ),
        (
            found.lost_motion.expect("backlash"),
            told("it stays behind by ", " (backlash", &units),
        ),
    ] {
        let [low, high] = estimate.ci95.expect("an interval");
        // Two figures of the interval, three of the value.
        assert!((value / estimate.value - 1.0).abs() < 6e-3, "{value}");
        assert!((2.0 * reach / (high - low) - 1.0).abs() < 0.06, "{reach}");
    }
}

#[test]
fn backlash_compliance_and_nothing_are_no_lead_error() {
    let found = only(made("x_scale_m", 1.0, |_, _, play| play));
    assert!(found.lead.is_none());
    let width = found.lost_motion.expect("backlash").value;
    assert!((width / 10e-6 - 1.0).abs() < 0.05, "width {width}");

    let found = only(made("x_scale_m", 1.0, |x, f, _| x - f / 4e6));
    assert!(found.lead.is_none());
    let compliance = found.compliance.expect("compliance").value;
    assert!(
        (compliance * 4e6 - 1.0).abs() < 0.05,
        "compliance {compliance}"
    );

    let found = only(made("x_scale_m", 1.0, |x, _, _| x));
    assert!(found.lead.is_none() && found.lost_motion.is_none() && found.compliance.is_none());
    assert!((found.left / 2.9e-7 - 1.0).abs() < 0.1, "{}", found.left);
}

#[test]
fn units_and_mirrored_scales_change_nothing() {
    let of = |name: &str, scale: f64| {
        let found = only(made(name, scale, |x, _, play| lead(x) + play));
        let slope = found.lead.and_then(|l| l.slope).expect("a slope");
        let gap = found.lost_motion.expect("backlash");
        let [low, high] = slope.ci95.expect("an interval");
        assert!((low..high).contains(&SLOPE), "{low} to {high}");
        [slope.value, gap.value]
    };
    let metres = of("x_scale_m", 1.0);
    for other in [of("x_scale_um", 1e6), of("x_scale_mm", -1e3)] {
        for (a, b) in metres.iter().zip(other) {
            // The file has nine decimals: 1 nm in metres.
            assert!((b / a - 1.0).abs() < 1e-3, "{a} and {b}");
        }
    }
}

#[test]
fn beside_a_gear_reports_the_bow_but_no_slope() {
    let found = only(made("motor_counts", 12_345.6, |x, _, _| x + lead(x)));
    let lead_error = found.lead.expect("a lead error");
    assert!(lead_error.slope.is_none() && found.ratio.is_some());
    // Of the cosine 8 µm, and what the best straight line leaves of it.
    assert!(
        (lead_error.bow / 8e-6 - 1.0).abs() < 0.1,
        "{}",
        lead_error.bow
    );
}

/// A scale read at every tenth of a travel of 0.2 m, six times to and fro, at rest: 60 ppm, 30 µm of lost motion, 0.3 µm of noise.
#[test]
fn a_scale_read_in_steps_is_a_second_position() {
    const STEPS: u32 = 20;
    const LOST: f64 = 30e-6;
    let mut seed = 11_u32;
    println!("seed {seed}");
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    };
    let mut text = "t_s,x_m,force_N,x_scale_m\n".to_owned();
    for i in 0..12 * (STEPS + 1) {
        let (pass, step) = (i / (STEPS + 1), i % (STEPS + 1));
        let (place, direction) = if pass % 2 == 0 {
            (step, 1.0)
        } else {
            (STEPS - step, -1.0)
        };
        let x = 0.01 * f64::from(place);
        let y = x * (1.0 + SLOPE) - 0.5 * LOST * direction + 1e-6 * noise();
        let force = 12.0 * direction + noise();
        text += &format!("{},{x:.3},{force:.4},{y:.9}\n", 3 * i);
    }
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
    let recording = recording.unwrap_or_else(|e| panic!("{e}"));
    let found = only(of(&recording));
    println!("{}", found.words(&recording));
    let lost = found.lost_motion.expect("lost motion");
    // Friction turns with the motion, too: what the scale stays behind by and what gives way under the force are told apart by its noise alone.
    assert!((lost.value / LOST - 1.0).abs() < 0.1, "{lost:?}");
    assert!(
        lost.ci95
            .is_some_and(|[low, high]| (low..=high).contains(&LOST))
    );
    let slope = found.lead.and_then(|lead| lead.slope).expect("a slope");
    assert!((slope.value / SLOPE - 1.0).abs() < 0.2, "{slope:?}");
}
