//! What models and controllers make of random motions, orders and faults, to the bit as it was when blessed: other tests leave room for
//! rounding, and a change within that room is one that somebody meant. `BLESS=1 cargo test -p preslide-host-tests --test all bits::`

use crate::laws::{self, AnyLaw, LAGGING, built};
use fixed::types::I16F16;
use preslide::control::learning::{Adaptation, MismatchWatch};
use preslide::control::{
    Axis, Basics, Coefficients, Controller, Hardware, Learning, LearningSettings, Measurement,
    NoFriction, Notch, Observed, ObserverSettings, Planner, VelocitySource,
};
use preslide::{Coulomb, Friction, Gms, ParamError, QuasiStaticGms, Scalar, Units};
use preslide_host_tests::path::{COUNT, COUNTS, SAMPLE_TIME, motion, random_reversals};
use preslide_host_tests::table3::blocks;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::{Debug, Write};

const BLESSED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bits.txt");

/// FNV-1a over all outputs.
struct Bits(u64);

impl Bits {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, told: impl Debug) {
        for byte in format!("{told:?}").bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

fn told(things: impl IntoIterator<Item = impl Debug>) -> u64 {
    let mut bits = Bits::new();
    things.into_iter().for_each(|thing| bits.add(thing));
    bits.0
}

/// 0 to 1, most often small; by products alone, which are the same everywhere.
fn cube(rng: &mut ChaCha8Rng) -> f64 {
    let one: f64 = rng.random();
    one * one * one
}

/// Forces of a model over a random motion.
fn forces<M: Friction>(model: Result<M, ParamError>, units: Units) -> u64 {
    let model = model.expect("valid");
    let mut state = model.at_rest();
    let scalar = |value: f64| M::Scalar::try_from_f64(value).expect("it fits");
    let path = random_reversals(45, 3000, 3000.0, 40.0);
    told(path.into_iter().map(|counts| {
        let way = f64::from(counts) * COUNT;
        let motion = motion(
            scalar(way / units.length),
            scalar(way / SAMPLE_TIME / units.velocity),
        );
        model.step(&mut state, motion).to_f64()
    }))
}

/// Commands of a controller on a mass with friction of its own and noise, under random orders and faults.
fn commands<F: Friction>(axis: &Axis, friction: Result<F, ParamError>, units: Units) -> u64 {
    let coefficients = Coefficients::try_new(axis, friction.expect("valid"), units).expect("valid");
    let mut controller = Controller::new(coefficients.clone(), 0_u32);
    let mut planner = Planner::try_new(axis).expect("valid");
    let mut rng = ChaCha8Rng::seed_from_u64(45);
    let mut bits = Bits::new();
    let (mut place, mut speed, mut since) = (0.0, 0.0, 0_u32);
    let (mut shift, mut sags) = (0_u32, 0_u32);
    for tick in 0..12_000_u32 {
        if rng.random_range(0..4) != 0 {
            controller.heard();
        }
        since += 1;
        if controller.fault().is_some() && since > 60 {
            controller.acknowledge();
        }
        if !controller.is_enabled() && tick > 300 && rng.random_range(0..20) == 0 {
            bits.add(controller.enable());
        }
        match rng.random_range(0..600) {
            0..8 if controller.is_idle() => {
                let far = 1e-3 * cube(&mut rng) * f64::from(rng.random_range(-1..2));
                let next = planner.by(far, 1e-4 + 14e-3 * cube(&mut rng), 0.5);
                bits.add(next.map(|next| controller.start(next)));
            }
            8 => bits.add(
                planner
                    .jog(rng.random_range(-5e-3..5e-3))
                    .map(|jog| controller.jog(jog)),
            ),
            9 => controller.stop(),
            10 => controller.swap(&coefficients),
            11 => controller.set_position(controller.position(), i64::from(tick)),
            12 if tick > 4000 => shift = shift.wrapping_add(rng.random_range(0..300)),
            13 => sags = rng.random_range(0..60),
            14 if rng.random_range(0..40) == 0 => controller.disable(),
            _ => {}
        }
        sags = sags.saturating_sub(1);
        let count = ((place / COUNT).round() as i64 as u32)
            .wrapping_add(shift)
            .wrapping_add(rng.random_range(0..2));
        let supply = if sags > 0 {
            3800
        } else {
            rng.random_range(5900..6100)
        };
        let amperes = speed * 3.0 + f64::from(rng.random_range(-20..20)) * 1e-3;
        let command = controller.tick(Measurement {
            count,
            supply,
            current: (amperes * 1e4) as i16,
            late: rng.random_range(0..200) == 0,
        });
        if command.fault.is_none() {
            since = 0;
        }
        bits.add(command);
        if tick % 16 == 0 {
            bits.add((
                controller.condition(),
                controller.current_at_rest(),
                controller.resistance_share(),
            ));
            bits.add((
                controller.is_standing(),
                controller.is_located(),
                controller.is_silent(),
            ));
        }
        // 35 N at full duty against the back-EMF, and a friction that is not the model's.
        let force = 35.0 * f64::from(command.code) / 8500.0 - 150.0 * speed;
        let held = 0.8 * (speed / 1e-5).clamp(-1.0, 1.0);
        speed += (force - held) / 4.0 * SAMPLE_TIME;
        place += speed * SAMPLE_TIME;
    }
    bits.0
}

fn of_models() -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for law in laws::all() {
        let (double, single) = (built(&law.stage, Units::SI), built(&law.stage, Units::SI));
        all.push((
            format!("{}, f64", law.name),
            forces::<AnyLaw<f64>>(double, Units::SI),
        ));
        all.push((
            format!("{}, f32", law.name),
            forces::<AnyLaw<f32>>(single, Units::SI),
        ));
    }
    let [double, single] = [
        forces(Coulomb::<f64>::try_new(0.9, 5.0, Units::SI), Units::SI),
        forces(Coulomb::<f32>::try_new(0.9, 5.0, Units::SI), Units::SI),
    ];
    let whole = Gms::<4, I16F16>::try_new(&blocks(), 0.9, LAGGING, SAMPLE_TIME, COUNTS);
    all.extend([
        ("Coulomb, f64".to_owned(), double),
        ("Coulomb, f32".to_owned(), single),
        ("Gms, I16F16".to_owned(), forces(whole, COUNTS)),
    ]);
    all
}

fn of_controllers() -> Vec<(&'static str, u64)> {
    let axis = Axis::PAPER_AXIS;
    let mut other = axis;
    other.notch = Notch {
        frequency: 180.0,
        ..Notch::NONE
    };
    other.motor.resistance_span = 0.3;
    other.feed_forward.drive = VelocitySource::Measured;
    other.hardware = other.hardware.with_dead_time(500e-9, 0.7);
    other.encoder.reversed = true;
    let blocks = &blocks::<4>();
    let float = || Gms::<4, f32>::try_new(blocks, 0.9, LAGGING, SAMPLE_TIME, Units::SI);
    let double = || QuasiStaticGms::<4, f64>::try_new(blocks, 0.9, Units::SI);
    let whole = || QuasiStaticGms::<4, I16F16>::try_new(blocks, 0.9, COUNTS);
    let mut learning = LearningSettings::PAPER_AXIS;
    learning.block = 14;
    learning.watch.window = 0.05;
    let observer = ObserverSettings::PAPER_AXIS;
    let both = |model| {
        Learning::<_, (Adaptation<f64>, MismatchWatch<f64>)>::try_new(model, &learning, Units::SI)
    };
    let observed = |model| Observed::try_new(model, &observer, SAMPLE_TIME, Units::SI);
    vec![
        (
            "none",
            commands(&axis, Ok(NoFriction::<f64>::new()), Units::SI),
        ),
        ("Gms, f32", commands(&axis, float(), Units::SI)),
        ("I16F16", commands(&axis, whole(), COUNTS)),
        (
            "learning",
            commands(&axis, double().and_then(both), Units::SI),
        ),
        (
            "observed",
            commands(&axis, float().and_then(observed), Units::SI),
        ),
        ("other axis", commands(&other, double(), Units::SI)),
        ("other axis, I16F16", commands(&other, whole(), COUNTS)),
    ]
}

/// Axes of random machines, with all that follows from ten numbers.
fn of_basics() -> u64 {
    let mut rng = ChaCha8Rng::seed_from_u64(45);
    told((0..300).map(|_| {
        let mut any = |least: f64, most: f64| least + (most - least) * cube(&mut rng);
        let hardware = [
            Hardware::edge_aligned(170_000_000, 20_000),
            Hardware::centre_aligned(160_000_000, 10_000),
        ];
        let basics = Basics {
            hardware: hardware[usize::from(any(1.0, 4.0) > 2.0)],
            count: any(1e-9, 1e-6),
            mass: any(0.1, 50.0),
            force_per_ampere: any(2.0, 100.0),
            resistance: any(0.3, 10.0),
            supply: any(5.0, 48.0),
            current: any(0.3, 6.0),
            speed: any(1e-3, 0.2),
            travel: None,
        };
        let axis = basics.axis().map_err(|error| error.to_string());
        axis.map(|axis| {
            let parts = (
                axis.sample_time(),
                axis.sampling_phase(),
                axis.motor.force_per_volt(),
            );
            (
                axis,
                parts,
                Coefficients::try_new(&axis, NoFriction::<f64>::new(), Units::SI),
            )
        })
    }))
}

#[test]
fn nothing_changes_by_a_bit_unnoticed() {
    let mut lines = String::new();
    for (name, bits) in of_models().into_iter().chain(
        of_controllers()
            .into_iter()
            .chain([("basics", of_basics())])
            .map(|(name, bits)| (name.to_owned(), bits)),
    ) {
        writeln!(lines, "{name}: {bits:016x}").expect("a string takes it");
    }
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(BLESSED, &lines).expect("writable");
    }
    let blessed = std::fs::read_to_string(BLESSED).unwrap_or_default();
    let changed: Vec<_> = lines
        .lines()
        .zip(blessed.lines())
        .filter(|(now, then)| now != then)
        .collect();
    assert!(
        changed.is_empty() && lines.lines().count() == blessed.lines().count(),
        "{changed:#?}"
    );
}
