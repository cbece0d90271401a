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
                let passed = stiffness * (x[0] - x[1]) + damping * (v[0] - v[1]);
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
        let tool = Tool::of_workspace().unwrap_or_else(|e| panic!("{e}"));
        let found = tool.diagnose(&self.recording(seed)).0;
        let found = found.unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let (ids, told) = (found.confident_ids(), &found.effects[0].parameters);
        let [hz, k] = [self.swing_hz, self.stiffness()];
        let nmse = found.nmse_test;
        println!("seed {seed}, {hz} Hz, {k:.3e} N/m: {ids:?} {told:?}, NMSE % {nmse:?}");
        found
    }
}

/// Whether the interval of a parameter of what stands first holds a value.
fn holds(found: &Diagnosis, key: &str, truth: f64) -> bool {
    let told = found.effects[0].parameters.iter().find(|p| p.0 == key);
    let interval = told.and_then(|(_, _, interval)| *interval);
    interval.is_some_and(|(low, high)| low <= truth && truth <= high)
}

#[test]
fn a_load_that_swings_behind_the_encoder_is_named_with_its_spring() {
    let drive = Drive {
        motor_share: 0.25,
        swing_hz: 55.0,
    };
    let found = drive.diagnosed(104);
    assert_eq!(found.confident_ids(), ["drive_compliance"]);
    assert!(holds(&found, "frequency_Hz", drive.swing_hz));
    assert!(holds(&found, "stiffness_N_per_m", drive.stiffness()));
    assert!(holds(&found, "motor_share", drive.motor_share));
    let (before, after) = found.nmse_test.expect("NMSE");
    assert!(after < 0.1 * before, "{before} → {after} %");
}

/// The one of 45 Hz is told as an end of the command, which is false, and the stiffness of the softest a little low. These seeds were first asked once
/// the engine stood; it knew none of the five before.
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
        };
        let found = drive.diagnosed(seed);
        if found.confident_ids().contains(&"drive_compliance") {
            assert!(holds(&found, "frequency_Hz", swing_hz), "seed {seed}");
            named += 1;
            stiff += usize::from(holds(&found, "stiffness_N_per_m", drive.stiffness()));
        }
    }
    assert!(
        named >= 4 && stiff >= 3,
        "{named} named, {stiff} stiffnesses"
    );
}
