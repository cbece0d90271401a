//! Sines in the difference, and what is like one.

use super::*;
use crate::diagnose::second_position::periodic::Periodic;
use preslide_fit::recording::load;
use preslide_host_tests::recordings;
use std::f64::consts::TAU;

/// Numbers of −1 to 1 from a seed.
struct Noise(u32);

impl Noise {
    /// Like numbers of neighbouring seeds are left behind.
    fn of(seed: u32) -> Self {
        let mut noise = Self(seed.wrapping_mul(2_654_435_761));
        (0..8).for_each(|_| _ = noise.next());
        noise
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        2.0 * f64::from(self.0) / f64::from(u32::MAX) - 1.0
    }

    /// Between two values.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + 0.5 * (high - low) * (self.next() + 1.0)
    }

    /// Values of RMS 1 of which each keeps the share `kept` of the one before.
    fn coloured(mut self, kept: f64) -> impl FnMut() -> f64 {
        let mut value = 0.0;
        move || {
            value = kept * value + (3.0 * (1.0 - kept * kept)).sqrt() * self.next();
            value
        }
    }

    /// A curve over ±0.12 m of RMS 1 that repeats and has no period: it forgets within 5 mm.
    fn curve(self) -> impl Fn(f64) -> f64 {
        const STEP: f64 = 0.5e-3;
        let mut next = self.coloured((-STEP / 5e-3_f64).exp());
        let values: Vec<f64> = (0..520).map(|_| next()).collect();
        move |x| {
            let place = (x + 0.125) / STEP;
            let (k, part) = (place as usize, place.fract());
            values[k] + part * (values[k + 1] - values[k])
        }
    }
}

/// A sine over the position (m).
fn sine(period: f64, amplitude: f64, highest_at: f64) -> impl Fn(f64) -> f64 {
    move |x| amplitude * (TAU * (x - highest_at) / period).cos()
}

/// What is found of a second position from a seed.
fn found(seed: u32, second: impl FnMut(f64, f64, f64) -> f64) -> SecondPosition {
    let recording = recorded_from(seed, "x_scale_mm", 1e3, second);
    let found = only(of(&recording));
    println!("{}", found.words(&recording));
    found
}

fn one(all: &[Periodic]) -> &Periodic {
    assert_eq!(all.len(), 1);
    &all[0]
}

/// Largest, RMS and mean of some deviations.
fn deviation(of: &[f64]) -> [f64; 3] {
    let n = of.len() as f64;
    [
        of.iter().fold(0.0, |m: f64, d| m.max(d.abs())),
        (of.iter().map(|d| d * d).sum::<f64>() / n).sqrt(),
        of.iter().sum::<f64>() / n,
    ]
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn period_and_amplitude_are_told_within_their_intervals_beside_all_else() {
    const SEEDS: std::ops::RangeInclusive<u32> = 101..=110;
    let (mut periods, mut amplitudes, mut slopes) = (Vec::new(), Vec::new(), Vec::new());
    let mut covered = 0;
    for seed in SEEDS {
        let mut draw = Noise::of(seed);
        let (period, amplitude) = (draw.between(2e-3, 8e-3), draw.between(0.6e-6, 2e-6));
        let wave = sine(period, amplitude, draw.between(-0.1, 0.1));
        let mut slow = Noise::of(seed + 1000).coloured(0.98);
        let all = found(seed, |x, f, play| {
            lead(x) + play - f / 4e6 + wave(x) + 0.3e-6 * slow()
        });
        let told = one(&all.periodic);
        let holds = |e: &Estimate, truth: f64| {
            let [low, high] = e.ci95.expect("an interval");
            usize::from((low..high).contains(&truth))
        };
        covered += holds(&told.period, period) + holds(&told.amplitude, amplitude);
        periods.push(told.period.value / period - 1.0);
        amplitudes.push(told.amplitude.value / amplitude - 1.0);
        let lead = all.lead.expect("the smooth lead");
        slopes.push(lead.slope.expect("a slope").value / SLOPE - 1.0);
        let off = (wave(told.highest_at) / amplitude - 1.0).abs();
        println!("period {period:.6e}, amplitude {amplitude:.3e}; its crest off by {off:.1e}");
        assert!(off < 0.01);
    }
    let all = [periods, amplitudes, slopes].map(|d| deviation(&d));
    println!("largest, RMS, mean: period, amplitude, slope {all:?}");
    // Of twenty 95 % intervals fewer than seventeen hold the truth once in sixty times.
    println!(
        "{covered} of {} intervals hold the truth",
        2 * SEEDS.count()
    );
    assert!(covered >= 17);
    // A line is a cycle over 60 periods wide, and noise lets a hundredth of that show: largest, RMS, mean.
    let bounds = [[5e-4, 2e-4, 1e-4], [0.04, 0.02, 0.01], [0.05, 0.02, 0.01]];
    for (deviation, bound) in all.iter().zip(bounds) {
        let within = deviation.iter().zip(bound).all(|(d, b)| d.abs() < b);
        assert!(within, "{deviation:?}, not {bound:?}");
    }
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn what_is_no_sine_is_not_told_as_one() {
    for seed in 201..=214 {
        let mut slow = Noise::of(seed).coloured(0.98);
        let curve = Noise::of(seed + 1000).curve();
        let all = found(seed, |x, f, play| {
            lead(x) + play - f / 4e6 + 0.3e-6 * slow() + 0.5e-6 * curve(x)
        });
        assert!(all.periodic.is_empty(), "seed {seed}");
        assert!(all.lead.is_some(), "seed {seed}");
    }
}

#[test]
fn a_turn_and_its_balls_are_told_where_nothing_is_smooth() {
    let (turn, balls) = (sine(5e-3, 1.2e-6, 1e-3), sine(0.83e-3, 0.5e-6, 0.0));
    let recording = recorded_from(31, "x_scale_m", 1.0, |x, _, play| play + turn(x) + balls(x));
    let found = only(of(&recording));
    let words = found.words(&recording);
    println!("{words}");
    assert!(found.lead.is_none());
    let truth = [(5e-3, 1.2e-6), (0.83e-3, 0.5e-6)];
    assert_eq!(found.periodic.len(), truth.len());
    for (told, (period, amplitude)) in found.periodic.iter().zip(truth) {
        let off = [told.period.value / period, told.amplitude.value / amplitude];
        let off = off.map(|ratio| (ratio - 1.0).abs());
        assert!(off[0] < 2e-4 && off[1] < 0.02, "{off:?}");
        let folded: Vec<f64> = told.folded.iter().map(|[x, d]| d - told.at(*x)).collect();
        let folded = deviation(&folded);
        println!("mean over a period less the sine: largest, RMS, mean {folded:?}");
        // The other sine is among what the mean is of: of 24 × 60 periods next to nothing.
        assert!(folded[0] < 6e-8 && folded[1] < 3e-8 && folded[2].abs() < 1e-8);
    }
    // What is left is the noise.
    assert!((found.left / 2.9e-7 - 1.0).abs() < 0.1, "{}", found.left);
    assert!(words.contains("no smooth lead error"));
    let form = [
        "periodic lead error, period 5.000",
        " mm, amplitude 1.",
        " µm to either side",
    ];
    form.iter()
        .for_each(|part| assert!(words.contains(part), "{part}"));
    let json = found.to_json(&recording);
    let ids = json["effects"].as_array().expect("effects").iter();
    assert!(ids.clone().all(|e| e["id"] == "periodic_lead_error"));
    assert_eq!(ids.count(), 2);
    assert_eq!(found.figures(&recording).len(), 2);
}

/// 16 strokes of 0.24 m in 1.5 s against 4 N, each before a rest of 1.5 s; `second` tells the second position less the first.
fn with_rests(seed: u32, second: impl Fn(f64) -> f64) -> Recording {
    const SAMPLES: usize = 750;
    println!("seed {seed}");
    let mut noise = Noise::of(seed);
    let mut text = "t_s,x_m,force_N,x_scale_m\n".to_owned();
    for i in 0..32 * SAMPLES {
        let (stroke, sample) = (i / (2 * SAMPLES), i % (2 * SAMPLES));
        let side = if stroke % 2 == 0 { -1.0 } else { 1.0 };
        let share = sample.min(SAMPLES) as f64 / SAMPLES as f64;
        // The Coulomb friction stays at rest.
        let force = -4.0 * side + 0.05 * noise.next();
        let x = side * 0.12 * (TAU * share / 2.0).cos();
        let y = x + second(x) + 0.5e-6 * noise.next();
        let x = x + 1e-7 * noise.next();
        text += &format!("{:.3},{x:.7},{force:.4},{y:.9}\n", i as f64 / 500.0);
    }
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
    recording.unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn an_axis_that_stands_half_of_the_time_hides_no_sine() {
    let wave = sine(5e-3, 0.4e-6, 2e-3);
    for seed in 61..=63 {
        let recording = with_rests(seed, |x| lead(x) + wave(x));
        let found = only(of(&recording));
        println!("{}", found.words(&recording));
        let told = one(&found.periodic);
        assert!((told.period.value / 5e-3 - 1.0).abs() < 2e-4);
        assert!((told.amplitude.value / 0.4e-6 - 1.0).abs() < 0.05);
        let without = only(of(&with_rests(seed, lead)));
        assert!(without.periodic.is_empty());
    }
}

#[test]
fn does_not_say_which_scale_has_the_interpolation_error() {
    const PITCH: f64 = 20e-6;
    let error = sine(PITCH, 0.4e-6, 3e-6);
    let second = recorded_from(41, "x_scale_m", 1.0, |x, _, _| x + error(x));
    let mut first = recorded_from(41, "x_scale_m", 1.0, |x, _, _| x);
    first.position.iter_mut().for_each(|x| *x += error(*x));
    for recording in [second, first] {
        let found = only(of(&recording));
        let words = found.words(&recording);
        println!("{words}");
        let told = one(&found.periodic);
        assert!((told.period.value / PITCH - 1.0).abs() < 1e-4);
        assert!((told.amplitude.value / 0.4e-6 - 1.0).abs() < 0.05);
        for part in [
            "one of the two scales, which cannot be told apart",
            "encoder interpolation error",
        ] {
            assert!(words.contains(part), "{words}");
        }
        let json = found.to_json(&recording);
        assert_eq!(json["effects"][0]["ambiguous_with"][0], "encoder_error");
    }
}

#[test]
fn counts_and_what_comes_later_are_no_sine() {
    // A scale of 5 µm, whose counting is a saw tooth of that period.
    let counted = found(51, |x, _, _| (x / 5e-6).round() * 5e-6);
    assert!(counted.periodic.is_empty());
    // In a tenth of the time only, and in a sixth of the travel only.
    let wave = sine(5e-3, 1.2e-6, 0.0);
    let mut sample = 0;
    let later = found(52, |x, _, _| {
        sample += 1;
        x + if sample > 27_000 { wave(x) } else { 0.0 }
    });
    assert!(later.periodic.is_empty());
    let here = found(53, |x, _, _| x + if x > 0.08 { wave(x) } else { 0.0 });
    assert!(here.periodic.is_empty());
}

/// A scale of our making on the motion of a real ball screw.
#[test]
fn finds_a_sine_on_a_real_motion_and_none_without_it() {
    const PERIOD: f64 = 5e-3;
    const AMPLITUDE: f64 = 1.2e-6;
    const SEED: u32 = 71;
    let Some(root) = recordings() else { return };
    let file = root.join("emps/emps_tracking.csv");
    let measured = load(&file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let wave = sine(PERIOD, AMPLITUDE, 1e-3);
    let with = |share: f64| {
        let mut noise = Noise::of(SEED);
        let scale = |x: &f64| x + SLOPE * x + share * wave(*x) + 1e-6 * noise.next();
        let mut recording = measured.clone();
        recording.extra = vec![Extra {
            name: "x_scale_m".to_owned(),
            values: measured.position.iter().map(scale).collect(),
        }];
        let found = only(of(&recording));
        println!("seed {SEED}: {}", found.words(&recording));
        found
    };
    let found = with(1.0);
    let told = one(&found.periodic);
    let parts = [
        (told.period, PERIOD, 5e-4),
        (told.amplitude, AMPLITUDE, 0.03),
    ];
    for (told, truth, off) in parts {
        let [low, high] = told.ci95.expect("an interval");
        assert!(low < truth && truth < high, "{truth}: {low}…{high}");
        assert!((told.value / truth - 1.0).abs() < off, "{}", told.value);
    }
    assert!(with(0.0).periodic.is_empty());
}
