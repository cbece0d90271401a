//! What a unit is called changes nothing: a model and a controller in other units give the forces and the codes that they give in SI.
//!
//! The other units are powers of two, by which `f64` rounds alike.

use crate::laws::{self, built};
use preslide::control::learning::{Adaptation, MismatchWatch};
use preslide::control::{
    Axis, Coefficients, Controller, Learning, LearningSettings, Measurement, Move, NoFriction,
    Observed, ObserverSettings, VelocitySource,
};
use preslide::{Coulomb, Friction, ParamError, QuasiStaticGms, Units};
use preslide_host_tests::path::{COUNT, motion, random_reversals};
use preslide_host_tests::table3::blocks;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const OTHER: Units = Units {
    length: 1.0 / (1 << 25) as f64,
    force: 1.0 / 64.0,
    velocity: 1.0 / 1024.0,
};

/// The model that `build` makes, in SI and in other units, over the same 20,000 ticks of reversals, rests and speeds; and that what it says of its
/// limit is `limit` (N).
fn alike<M: Friction<Scalar = f64>>(
    what: &str,
    limit: Option<f64>,
    build: impl Fn(Units) -> Result<M, ParamError>,
) {
    let [si, other] = [Units::SI, OTHER].map(|units| build(units).expect("valid"));
    let (told, again) = (si.limit(), other.limit().map(|limit| limit * OTHER.force));
    assert_eq!(told, again, "{what}");
    // The weights of Table 3 are rounded.
    let near = |(told, limit): (f64, f64)| (told - limit).abs() < 2e-3;
    assert!(
        told.is_some() == limit.is_some() && told.zip(limit).is_none_or(near),
        "{what}: {told:?}"
    );
    let (mut states, mut largest) = ((si.at_rest(), other.at_rest()), 0.0_f64);
    for (tick, counts) in random_reversals(9, 20_000, 4_000.0, 200.0)
        .into_iter()
        .enumerate()
    {
        let displacement = f64::from(counts) * COUNT;
        let velocity = [0.0, 2e-4, 3e-3][tick / 50 % 3] * f64::from(counts.signum());
        let motion = |units: Units| motion(displacement / units.length, velocity / units.velocity);
        let force = si.step(&mut states.0, motion(Units::SI));
        let again = other.step(&mut states.1, motion(OTHER)) * OTHER.force;
        assert!(
            (force - again).abs() < 1e-11,
            "{what}, tick {tick}: {force} N and {again} N"
        );
        largest = largest.max(force.abs());
    }
    assert!(largest > 0.5, "{what}: {largest} N");
}

#[test]
fn a_model_is_the_same_in_other_units() {
    alike("Coulomb", None, |units| Coulomb::try_new(0.8, 30.0, units));
    for model in laws::all().iter().flat_map(|law| &law.models) {
        let scalars = model.scalars();
        let damped = scalars
            .iter()
            .any(|(key, value)| key.starts_with("damping") && *value > 0.0);
        let limit = model.breakaway().filter(|_| !damped);
        alike(&format!("{model:?}"), limit, |units| built(model, units));
    }
}

/// The winding's resistance over the configured one.
const WARM: f64 = 1.15;

/// An axis on which all that a controller can do beside is on.
fn axis() -> Axis {
    let mut axis = Axis::PAPER_AXIS;
    axis.motor.gear_ratio = 1.5;
    axis.motor.efficiency = 0.8;
    axis.motor.resistance_span = 0.4;
    axis.notch.frequency = 370.0;
    axis.hardware = axis.hardware.with_dead_time(500e-9, 0.7);
    axis.limits.travel = Some((-8e-3, 8e-3));
    axis
}

/// The codes of a controller on a mass with friction of its own that is read in counts, and the friction level that it learned; moves, supplies
/// and swaps at random. A second one, which takes no tick for an ordinary one, commands the same.
fn codes<F: Friction<Scalar = f64> + Clone>(
    axis: &Axis,
    friction: F,
    units: Units,
) -> (Vec<i32>, Option<f64>) {
    let mut coefficients = Coefficients::try_new(axis, friction.clone(), units).expect("valid");
    let mut controller = Controller::new(coefficients.clone(), 0_u32);
    let mut thorough = controller.clone();
    let (mut rng, mut axis) = (ChaCha8Rng::seed_from_u64(7), *axis);
    let (mut position, mut velocity, mut current, mut codes) = (0.0, 0.0, 0.0, Vec::new());
    let (motor, hardware) = (axis.motor, axis.hardware);
    for tick in 0..60_000 {
        for controller in [&mut controller, &mut thorough] {
            match tick {
                100 => controller.set_position(0, 40),
                300 => assert_eq!(controller.enable(), Ok(())),
                _ => controller.heard(),
            }
        }
        if tick % 1500 == 400 {
            let distance = rng.random_range(-1e-3..1e-3);
            let next = Move::plan(distance, 15e-3, 0.95, axis.grid()).expect("a move");
            assert_eq!(controller.start(next), thorough.start(next));
        }
        if tick % 5000 == 4500 {
            axis.gains.proportional *= 1.1;
            axis.gains.integral_limit *= 0.8;
            coefficients = Coefficients::try_new(&axis, friction.clone(), units).expect("valid");
            for controller in [&mut controller, &mut thorough] {
                controller.swap(&coefficients);
            }
        }
        let supply = rng.random_range(5800..6200_u16);
        let measured = Measurement {
            count: ((position / axis.encoder.count).floor() as i64) as u32,
            supply,
            // One tick above what is too much is no fault, and is forgotten.
            current: match tick % 3000 {
                50 => 20_000,
                _ => (current / hardware.current_code).round() as i16,
            },
            late: tick % 5000 == 3000,
        };
        let command = controller.tick(measured);
        assert_eq!(command, thorough.any_tick(measured), "tick {tick}");
        assert_eq!(command.fault, None, "tick {tick}");
        if !command.enabled {
            assert_eq!(command.reference, command.position << 16);
        }
        let volts = f64::from(command.code) / f64::from(hardware.steps) * f64::from(supply) * 1e-3;
        current = (volts - motor.torque_constant * motor.transmission() * velocity)
            / (WARM * motor.resistance);
        let force = current * motor.force_per_volt() * motor.resistance
            - 0.5 * (velocity / 1e-4_f64).clamp(-1.0, 1.0);
        velocity += force / 4.0 * axis.sample_time();
        position += velocity * axis.sample_time();
        codes.push(command.code);
    }
    let share = f64::from(controller.resistance_share()) / 65_536.0;
    // What makes up for a dead time that the mass's bridge has not passes for less resistance.
    let follows = hardware.dead_time > 0.0 || (share - WARM).abs() < 0.03;
    assert!(follows && share > 1.02, "{share}");
    (codes, controller.condition().level)
}

fn same_codes<F: Friction<Scalar = f64> + Clone>(
    axis: &Axis,
    friction: impl Fn(Units) -> Result<F, ParamError>,
) {
    let [(si, level), (other, again)] =
        [Units::SI, OTHER].map(|units| codes(axis, friction(units).expect("valid"), units));
    assert_eq!(level, again);
    assert!(level != Some(1.0), "nothing was learned");
    let first = si.iter().zip(&other).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
    assert!(si.iter().any(|code| code.abs() > 1000));
}

#[test]
fn a_controller_commands_the_same_in_other_units() {
    let model = |units| QuasiStaticGms::<3, f64>::try_new(&blocks::<3>(), 0.5, units);
    same_codes(&axis(), |_| Ok(NoFriction::<f64>::new()));
    same_codes(&axis(), |units| {
        type Both = (MismatchWatch<f64>, Adaptation<f64>);
        let settings = LearningSettings {
            block: 8,
            ..LearningSettings::PAPER_AXIS
        };
        Learning::<_, Both>::try_new(model(units)?, &settings, units)
    });
    let mut measured = axis();
    measured.feed_forward.drive = VelocitySource::Measured;
    measured.feed_forward.limit = 0.3;
    measured.hardware.dead_time = 0.0;
    same_codes(&measured, |units| {
        Observed::try_new(model(units)?, &ObserverSettings::PAPER_AXIS, 50e-6, units)
    });
}
