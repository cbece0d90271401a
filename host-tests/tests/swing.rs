//! `diagnose` on a load that swings on a spring behind a motor which has the encoder: strokes at random, whose accelerations jump, make it ring. The
//! machine is integrated here, in steps of 50 µs; friction, four blocks of it and a viscous part, holds the load alone.

use preslide_host_tests::answer::Diagnosis;
use preslide_host_tests::judge::table::{Recording, Table};
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::trials::draw::Draw;
use std::f64::consts::TAU;

const SAMPLE_S: f64 = 1e-3;
const FINER: usize = 20;
const SAMPLES: usize = 60_000;
const MASS_KG: f64 = 10.0;
const DAMPING_RATIO: f64 = 0.04;
/// Friction of each block (N) and its yield (m).
const BLOCKS: [[f64; 2]; 4] = [[1.5, 2e-6], [1.5, 8e-6], [1.5, 3e-5], [1.5, 1e-4]];
const VISCOUS_N_S_PER_M: f64 = 8.0;
const ENCODER_M: f64 = 10e-9;
const NOISE_N: f64 = 0.02;
/// Bandwidth of the controller's speed loop (Hz).
const LOOP_HZ: f64 = 8.0;
/// Friction wanders by so much over so long a way (m).
const WANDERS: [f64; 2] = [0.03, 2e-3];

/// The motor's share of the inertia, and the frequency (Hz) at which motor and load swing.
struct Drive {
    motor_share: f64,
    swing_hz: f64,
    /// Play between the two (m).
    gap_m: f64,
}

/// Commanded velocities of strokes to random places, with rests between them.
fn commanded(draw: &mut Draw) -> Vec<f64> {
    let mut between = |low, high| draw.uniform(low, high);
    let mut velocity = vec![0.0; 500];
    let mut place = 0.0;
    while velocity.len() < SAMPLES - 1500 {
        let way = if between(0.0, 1.0) < 0.5 {
            between(-0.05, 0.05) - place
        } else {
            between(-0.003, 0.003)
        };
        let acceleration = between(0.5, 4.0);
        let top = between(0.005, 0.12).min((way.abs() * acceleration).sqrt());
        let ramp = ((top / acceleration / SAMPLE_S) as usize).max(2);
        let level = (way.abs() - top * top / acceleration).max(0.0) / top / SAMPLE_S;
        let up: Vec<f64> = (0..ramp)
            .map(|i| top * i as f64 / (ramp - 1) as f64)
            .collect();
        let stroke = up
            .iter()
            .copied()
            .chain(std::iter::repeat_n(top, level as usize));
        let stroke: Vec<f64> = stroke
            .chain(up.iter().rev().copied())
            .map(|v| v.copysign(way))
            .collect();
        place += stroke.iter().sum::<f64>() * SAMPLE_S;
        velocity.extend(stroke);
        velocity.extend(std::iter::repeat_n(0.0, between(50.0, 400.0) as usize));
    }
    velocity.resize(SAMPLES, 0.0);
    velocity
}

impl Drive {
    /// What a motion of the motor (m) takes (N), where friction does not wander.
    fn asks(&self, motor: &[f64]) -> Vec<f64> {
        let load = (1.0 - self.motor_share) * MASS_KG;
        let stiffness = self.stiffness();
        let damping = 2.0 * DAMPING_RATIO * (stiffness * load * self.motor_share).sqrt();
        let h = SAMPLE_S / FINER as f64;
        let at = |i: usize| motor[i.min(SAMPLES - 1)];
        assert_eq!(self.gap_m, 0.0);
        let (mut x, mut v, mut held) = (motor[0], 0.0, [0.0; BLOCKS.len()]);
        let mut asked = Vec::new();
        for i in 0..SAMPLES {
            let speed = (at(i + 1) - at(i)) / SAMPLE_S;
            let gains = at(i + 1) - 2.0 * at(i) + at(i.max(1) - 1);
            let inertia = self.motor_share * MASS_KG * gains / (SAMPLE_S * SAMPLE_S);
            asked.push(inertia + stiffness * (at(i) - x) + damping * (speed - v));
            for step in 0..FINER {
                let ahead = at(i) + speed * h * step as f64 - x;
                let mut resists = VISCOUS_N_S_PER_M * v;
                for (z, [most, yields]) in held.iter_mut().zip(BLOCKS) {
                    *z = (*z + v * h * most / yields).clamp(-most, most);
                    resists += *z;
                }
                v += h * (stiffness * ahead + damping * (speed - v) - resists) / load;
                x += h * v;
            }
        }
        asked
    }

    fn stiffness(&self) -> f64 {
        let reduced = MASS_KG * self.motor_share * (1.0 - self.motor_share);
        reduced * (TAU * self.swing_hz).powi(2)
    }

    fn recording(&self, seed: u64) -> Recording {
        let mut draw = Draw::new(seed, 0);
        let wanted = commanded(&mut draw);
        let masses = [self.motor_share, 1.0 - self.motor_share].map(|share| share * MASS_KG);
        let stiffness = self.stiffness();
        let damping = 2.0 * DAMPING_RATIO * (stiffness * masses[0] * masses[1] / MASS_KG).sqrt();
        let w = TAU * LOOP_HZ;
        let h = SAMPLE_S / FINER as f64;
        let (mut x, mut v) = ([0.0; 2], [0.0; 2]);
        let (mut place, mut speed, mut last, mut sum, mut level) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut held = [0.0; BLOCKS.len()];
        let (mut positions, mut forces) = (Vec::new(), Vec::new());
        for i in 0..SAMPLES {
            place += wanted[i] * SAMPLE_S;
            let read = (x[0] / ENCODER_M).floor() * ENCODER_M;
            speed += 0.5 * ((read - last) / SAMPLE_S - speed);
            last = read;
            let next = wanted.get(i + 1).copied().unwrap_or(0.0);
            let acceleration = (next - wanted[i.max(1) - 1]) / (2.0 * SAMPLE_S);
            let off = MASS_KG * w * (wanted[i] + 0.2 * w * (place - read) - speed);
            let force = MASS_KG * acceleration + off + sum;
            sum += 10.0 * off * SAMPLE_S;
            positions.push(read);
            forces.push(force + NOISE_N * draw.normal());
            for _ in 0..FINER {
                let apart = x[0] - x[1];
                let pressed = apart - apart.clamp(-0.5 * self.gap_m, 0.5 * self.gap_m);
                let passed = if self.gap_m > 0.0 && pressed == 0.0 {
                    0.0
                } else {
                    stiffness * pressed + damping * (v[0] - v[1])
                };
                let mut friction = 0.0;
                for (z, [most, yields]) in held.iter_mut().zip(BLOCKS) {
                    *z = (*z + v[1] * h * most / yields).clamp(-most, most);
                    friction += *z;
                }
                let gone = v[1].abs() * h / WANDERS[1];
                level += -level * gone + WANDERS[0] * (2.0 * gone).sqrt() * draw.normal();
                let resists = friction * (1.0 + level) + VISCOUS_N_S_PER_M * v[1];
                v[0] += h * (force - passed - 2.0 * v[0]) / masses[0];
                v[1] += h * (passed - resists) / masses[1];
                x = [x[0] + h * v[0], x[1] + h * v[1]];
            }
        }
        let table = Table {
            names: ["t_s", "x_m", "force_N"].map(String::from).to_vec(),
            columns: vec![
                (0..SAMPLES).map(|i| i as f64 * SAMPLE_S).collect(),
                positions,
                forces,
            ],
        };
        Recording::new("swing", table, None)
    }

    fn diagnosed(&self, seed: u64) -> Diagnosis {
        self.told(&self.recording(seed), seed)
    }

    /// What is said of a recording of this drive.
    fn told(&self, recording: &Recording, seed: u64) -> Diagnosis {
        println!(
            "seed {seed}, {} Hz, {:.3e} N/m",
            self.swing_hz,
            self.stiffness()
        );
        Tool::told(recording)
    }
}

/// Whether the interval of a parameter of the drive holds a value.
fn holds(found: &Diagnosis, key: &str, truth: f64) -> bool {
    let (low, high) = found.interval("drive_compliance", key);
    low <= truth && truth <= high
}

#[test]
fn a_load_that_swings_behind_the_encoder_is_named_with_its_spring() {
    let drive = Drive {
        motor_share: 0.25,
        swing_hz: 55.0,
        gap_m: 0.0,
    };
    let found = drive.diagnosed(104);
    // Its viscous friction is in the fit.
    assert_eq!(found.confident_ids(), ["drive_compliance", "viscous"]);
    let (low, high) = found.interval("viscous", "viscous_N_s_per_m");
    assert!((low..high).contains(&VISCOUS_N_S_PER_M), "{low} to {high}");
    assert!(holds(&found, "frequency_Hz", drive.swing_hz));
    assert!(holds(&found, "stiffness_N_per_m", drive.stiffness()));
    assert!(holds(&found, "motor_share", drive.motor_share));
    let (before, after) = found.nmse_test.expect("NMSE");
    assert!(after < 0.1 * before, "{before} → {after} %");
}

/// Strokes without jumps: averaged twice over 12 ms, where the motor is at each sample (m).
fn smooth_motion(draw: &mut Draw) -> Vec<f64> {
    const OVER: usize = 12;
    let average = |own: Vec<f64>| -> Vec<f64> {
        let mean = |i: usize| own[i.saturating_sub(OVER)..=i].iter().sum::<f64>() / OVER as f64;
        (0..SAMPLES).map(mean).collect()
    };
    let velocity = average(average(commanded(draw)));
    let mut place = 0.0;
    let moved = velocity.iter().map(|v| {
        place += v * SAMPLE_S;
        place
    });
    moved.collect()
}

/// A simulation that has the spring, softer or stiffer than it is, gets both reported. The motor moves alike in both, without jumps of its acceleration: where
/// those ring on for long, as in the recordings above, the two cannot be separated.
#[test]
fn reports_the_simulation_spring_beside_the_machines() {
    the_simulation_spring_is_reported(&[(401, 45.0, 60.0)]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn reports_a_simulation_spring_that_is_softer() {
    the_simulation_spring_is_reported(&[(402, 60.0, 50.0)]);
}

/// Seed, and the frequencies (Hz) of the machine and of its simulation.
fn the_simulation_spring_is_reported(springs: &[(u64, f64, f64)]) {
    for &(seed, hz, in_simulation) in springs {
        let [drive, simulation] = [hz, in_simulation].map(|swing_hz| Drive {
            motor_share: 0.3,
            swing_hz,
            gap_m: 0.0,
        });
        let mut draw = Draw::new(seed, 0);
        let motor = smooth_motion(&mut draw);
        let measured = drive.asks(&motor).into_iter();
        let measured = measured.map(|f| f + NOISE_N * draw.normal());
        let read = motor.iter().map(|x| (x / ENCODER_M).round() * ENCODER_M);
        let names = ["t_s", "x_m", "force_N", "force_sim_N"];
        let table = Table {
            names: names.map(String::from).to_vec(),
            columns: vec![
                (0..SAMPLES).map(|i| i as f64 * SAMPLE_S).collect(),
                read.collect(),
                measured.collect(),
                simulation.asks(&motor),
            ],
        };
        let mut recording = Recording::new("springs", table, None);
        recording.arguments = ["--simulated", "force_sim_N"].map(String::from).to_vec();
        let found = drive.told(&recording, seed);
        assert_eq!(found.verdict, "parameters-differ");
        let ids = found.confident_ids();
        assert!(ids.contains(&"drive_compliance") && !ids.contains(&"backlash"));
        assert!(holds(&found, "stiffness_N_per_m", drive.stiffness()));
        let own = simulation.stiffness();
        assert!(holds(&found, "simulated_stiffness_N_per_m", own));
    }
}

/// These seeds first ran when the engine already knew four of them.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn most_springs_are_named() {
    let drives = [
        (101, 0.3, 45.0),
        (102, 0.5, 28.0),
        (103, 0.4, 38.0),
        (104, 0.25, 55.0),
        (105, 0.35, 75.0),
    ];
    let (mut named, mut stiff) = (0, 0);
    for (seed, motor_share, swing_hz) in drives {
        let drive = Drive {
            motor_share,
            swing_hz,
            gap_m: 0.0,
        };
        let found = drive.diagnosed(seed);
        if found.confident_ids().contains(&"drive_compliance") {
            assert!(holds(&found, "frequency_Hz", swing_hz), "seed {seed}");
            named += 1;
            stiff += usize::from(holds(&found, "stiffness_N_per_m", drive.stiffness()));
        }
    }
    assert!(
        named == 5 && stiff >= 3,
        "{named} named, {stiff} stiffnesses"
    );
}

/// Play behind a motor that has the encoder, and a load that swings on its flanks: how many are named, with widths in their intervals, and false names.
fn gaps(drives: impl IntoIterator<Item = (u64, Drive)>) -> [usize; 3] {
    let (mut named, mut held, mut false_names) = (0, 0, 0);
    for (seed, drive) in drives {
        let gap_m = drive.gap_m;
        let found = drive.diagnosed(seed);
        let ids = found.confident_ids();
        println!("gap {gap_m:.1e} m: {ids:?}, NMSE {:?} %", found.nmse_test);
        let plain = ["backlash", "viscous"];
        false_names += ids.iter().filter(|id| !plain.contains(id)).count();
        if ids.contains(&"backlash") {
            named += 1;
            let (low, high) = found.interval("backlash", "gap_m");
            println!("  {low:.2e} to {high:.2e} m");
            held += usize::from(low <= gap_m && gap_m <= high);
        }
    }
    [named, held, false_names]
}

#[test]
fn a_gap_behind_which_the_load_swings_is_named_with_its_width() {
    let drive = Drive {
        motor_share: 0.4,
        swing_hz: 60.0,
        gap_m: 3e-4,
    };
    assert_eq!(gaps([(501, drive)]), [1, 1, 0]);
}

/// Random drives, first run when all rules of the engine were final: it was developed on other seeds.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn most_gaps_are_named() {
    let drives = (511..=518).map(|seed| {
        let mut draw = Draw::new(seed, 1);
        let mut between = |low: f64, high: f64| low * (high / low).powf(draw.uniform(0.0, 1.0));
        let drive = Drive {
            motor_share: between(0.25, 0.6),
            swing_hz: between(40.0, 110.0),
            gap_m: between(5e-5, 1.5e-3),
        };
        (seed, drive)
    });
    let [named, held, false_names] = gaps(drives);
    println!("{named} named, {held} widths held, {false_names} false names");
    assert!(named >= 3 && held == named && false_names <= 1);
}
