//! `diagnose` on two bodies whose load has the encoder, as a scale on the slide: a motor that nobody measures drives it through a gap, a
//! spring or stiffly. The machine is integrated here, in steps of 20 µs, under a controller that holds its force between samples.

use crate::simulated::dragged;
use preslide_host_tests::answer::Diagnosis;
use preslide_host_tests::dice::Dice;
use preslide_host_tests::judge::table::{Recording, Table};
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::made::sines;
use std::f64::consts::TAU;

const SEED: u64 = 23;
const RATE_HZ: f64 = 1000.0;
const FINER: usize = 50;
const STEP_S: f64 = 1.0 / (RATE_HZ * FINER as f64);
const SAMPLES: usize = (40.0 * RATE_HZ) as usize;
const MOTOR_KG: f64 = 0.9;
const LOAD_KG: f64 = 2.1;
const DAMPING_RATIO: f64 = 0.03;
const FRICTION_N: f64 = 4.0;
const PRESLIDING_M: f64 = 60e-6;
const ENCODER_M: f64 = 10e-9;
/// The controller's bandwidth, and that of its speed (Hz); its integrator takes a tenth of a second.
const LOOP_HZ: f64 = 6.0;
const SPEED_HZ: f64 = 40.0;
const INTEGRAL_S: f64 = 0.1;

/// Between motor and load: the play, and the frequency at which the two swing against each other in contact.
#[derive(Clone, Copy)]
struct Joint {
    gap_m: f64,
    contact_hz: f64,
}

/// Position and velocity that the controller asks for.
fn reference(t: f64) -> [f64; 2] {
    let [x, v, _] = sines(&[[1e-3, 2.6, 0.0], [4e-4, 19.7, 0.0], [1e-4, 48.4, 0.0]], t);
    [x, v]
}

/// Friction in units of its level after a displacement in presliding lengths.
type Law = Box<dyn FnMut(f64) -> f64>;

/// Jenkins elements with uniform yields (Iwan 1966).
fn jenkins() -> Law {
    const COUNT: usize = 30;
    let mut elements = [0.0; COUNT];
    Box::new(move |ds| {
        let shares = elements
            .iter_mut()
            .enumerate()
            .map(|(i, z): (_, &mut f64)| {
                let limit = 3.0 * (i as f64 + 0.5) / COUNT as f64;
                *z = (*z + ds).clamp(-limit, limit);
                *z / limit
            });
        shares.sum::<f64>() / COUNT as f64
    })
}

fn lugre() -> Law {
    let mut bristle = 0.0;
    Box::new(move |ds| {
        bristle = dragged(bristle, ds);
        bristle
    })
}

/// PID on the encoder, the speed smoothed.
#[derive(Default)]
struct Controller {
    last: f64,
    speed: f64,
    sum: f64,
}

impl Controller {
    fn force(&mut self, sample: usize, read: f64) -> f64 {
        let (mass, w) = (MOTOR_KG + LOAD_KG, TAU * LOOP_HZ);
        let [wanted, wanted_speed] = reference(sample as f64 / RATE_HZ);
        let smooth = 1.0 - (-TAU * SPEED_HZ / RATE_HZ).exp();
        self.speed += smooth * ((read - self.last) * RATE_HZ - self.speed);
        self.last = read;
        self.sum += (wanted - read) / RATE_HZ;
        let position = wanted - read + self.sum / INTEGRAL_S;
        mass * (w * w * position + 1.4 * w * (wanted_speed - self.speed))
    }
}

impl Joint {
    /// Position of the load as its encoder reads it, and the force on the motor, at the samples.
    fn recording(self, mut law: Law, dice: &mut Dice) -> [Vec<f64>; 2] {
        let reduced = MOTOR_KG * LOAD_KG / (MOTOR_KG + LOAD_KG);
        let w = TAU * self.contact_hz;
        let (stiffness, damping) = (reduced * w * w, 2.0 * DAMPING_RATIO * reduced * w);
        let mut controller = Controller::default();
        let ([mut motor, mut load], mut speeds) = ([0.0; 2], [reference(0.0)[1]; 2]);
        let mut level = 1.0;
        let (mut positions, mut forces) = (Vec::new(), Vec::new());
        for i in 0..SAMPLES {
            // Friction wanders by 2 % and forgets its level within a tenth of a second.
            level += (1.0 - level) * 0.01 + 0.02 * (2.0 * 0.01_f64).sqrt() * dice.normal();
            let read = (load / ENCODER_M).round() * ENCODER_M;
            let force = controller.force(i, read);
            positions.push(read);
            forces.push(force + 0.01 * dice.normal());
            for _ in 0..FINER {
                let apart: f64 = motor - load;
                let pressed = apart - apart.clamp(-0.5 * self.gap_m, 0.5 * self.gap_m);
                let touches = f64::from(pressed != 0.0 || self.gap_m == 0.0);
                let passed = stiffness * pressed + touches * damping * (speeds[0] - speeds[1]);
                let held = level * law(speeds[1] * STEP_S / PRESLIDING_M);
                let friction = FRICTION_N * held;
                speeds[0] += (force - passed) / MOTOR_KG * STEP_S;
                speeds[1] += (passed - friction) / LOAD_KG * STEP_S;
                motor += speeds[0] * STEP_S;
                load += speeds[1] * STEP_S;
            }
        }
        [positions, forces]
    }

    fn diagnosed(self, law: Law) -> Diagnosis {
        let [position, force] = self.recording(law, &mut Dice::new(SEED));
        let time = (0..SAMPLES).map(|i| i as f64 / RATE_HZ).collect();
        let table = Table {
            names: ["t_s", "x_m", "force_N"].map(String::from).to_vec(),
            columns: vec![time, position, force],
        };
        println!("seed {SEED}");
        Tool::told(&Recording::new("two-bodies", table, None))
    }
}

#[test]
fn a_gap_ahead_of_the_encoder_is_named_with_its_width() {
    let joint = Joint {
        gap_m: 24e-6,
        contact_hz: 150.0,
    };
    let found = joint.diagnosed(jenkins());
    assert_eq!(found.confident_ids(), ["backlash"]);
    let value = found.value("backlash", "gap_m");
    let (low, high) = found.interval("backlash", "gap_m");
    assert!(low <= joint.gap_m && joint.gap_m <= high, "{low}…{high}");
    assert!((value / joint.gap_m).ln().abs() < 0.5, "{value}");
}

/// Its inertial force is a thousandth of the effort: nothing is named in its place, nor is it.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_spring_ahead_of_the_encoder_has_no_other_name() {
    let joint = Joint {
        gap_m: 0.0,
        contact_hz: 90.0,
    };
    let found = joint.diagnosed(jenkins());
    assert_eq!(found.confident_ids(), [""; 0]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_stiff_drive_has_neither() {
    for (name, law) in [("Jenkins", jenkins()), ("LuGre", lugre())] {
        let joint = Joint {
            gap_m: 0.0,
            contact_hz: 600.0,
        };
        let found = joint.diagnosed(law);
        assert_eq!(found.confident_ids(), [""; 0], "{name}");
        let moved = ["backlash", "drive_compliance"];
        assert!(
            found
                .effects
                .iter()
                .all(|e| !moved.contains(&e.id.as_str()))
        );
    }
}
