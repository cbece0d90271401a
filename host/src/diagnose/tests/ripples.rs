//! What has a fixed period in position: of a force, of the friction level, of all that the motor gives.

use super::*;

/// Viscous friction (N·s/m), a twentieth of the effort.
const VISCOUS: f64 = 8.0;

fn wave(x: f64, period: f64, phase: f64) -> f64 {
    (std::f64::consts::TAU * x / period + phase).cos()
}

/// A recording of a motor that gives more for its current here than there.
fn with_torque_ripple(mut recording: Recording, ripple: impl Fn(f64) -> f64) -> Recording {
    let commands = recording.effort.iter().zip(&recording.position);
    recording.effort = commands.map(|(f, x)| f / (1.0 + ripple(*x))).collect();
    recording
}

/// The only line of a diagnosis, its amplitude, phase and period within `reach` of what is true.
fn told(recording: &Recording, truth: [f64; 3], reach: [f64; 3]) -> &'static str {
    let found = diagnose(recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
    println!("{}", found.verdict_words(recording));
    let lines: Vec<_> = found.confident().filter(|e| e.is_narrow()).collect();
    assert_eq!(lines.len(), 1, "one line");
    println!("{:?}", lines[0].parameters);
    for (((key, own), truth), reach) in lines[0].parameters.iter().zip(truth).zip(reach) {
        assert!((own.value - truth).abs() < reach, "{key} {own:?}");
    }
    // What is named takes something off, and all together no more than there was.
    let whole = found.baseline.test;
    assert!(found.budget.iter().all(|item| item.nmse > 0.0));
    assert!(found.budget.iter().map(|item| item.nmse).sum::<f64>() <= whole);
    lines[0].id()
}

/// Cogging is a force; torque ripple is a share of whatever the motor gives: here of a spring's force, of friction and of inertia.
#[test]
fn a_ripple_in_proportion_to_the_effort_is_no_cogging() {
    let spring = |x: f64| 300.0 * x;
    let ripple = |x: f64| 0.1 * wave(x, 0.004, 0.5);
    let recording = with_torque_ripple(made(|_, x, _| spring(x)), ripple);
    let cogging = made(|_, x, _| spring(x) + 5.0 * ripple(x));
    let within = [0.01, 0.1, 4e-6];
    assert_eq!(told(&recording, [0.1, 0.5, 0.004], within), "torque_ripple");
    assert_eq!(
        told(&cogging, [0.5, 0.5, 0.004], [0.05, 0.1, 4e-6]),
        "periodic_force"
    );
}

/// Where friction is most of the effort, a ripple of the one is nearly a ripple of the other: what inertia and viscous friction take part in tells.
#[test]
fn a_motor_ripple_is_not_taken_for_a_friction_ripple() {
    let ripple = |x: f64| 0.1 * wave(x, 0.009, 0.5);
    let of_the_motor = with_torque_ripple(made(|_, _, v| VISCOUS * v), ripple);
    let mut of_friction = made(|_, _, v| VISCOUS * v);
    let level = friction(&of_friction.position);
    for ((f, x), level) in of_friction
        .effort
        .iter_mut()
        .zip(&of_friction.position)
        .zip(level)
    {
        *f += ripple(*x) * level;
    }
    let within = [0.01, 0.1, 3e-5];
    assert_eq!(
        told(&of_the_motor, [0.1, 0.5, 0.009], within),
        "torque_ripple"
    );
    assert_eq!(
        told(&of_friction, [0.1, 0.5, 0.009], within),
        "periodic_friction"
    );
}

/// A tenth of a metre of travel: a wave of 62 mm does not come twice, and one of 20 mm comes five times.
#[test]
fn a_single_period_is_a_map_not_a_ripple() {
    for (period, named) in [(0.062, "position_force"), (0.02, "periodic_force")] {
        let recording = made(|_, x, _| 0.5 * wave(x, period, 0.7));
        let found = diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
        println!("{}", found.verdict_words(&recording));
        // A map has a mean over the travel, too.
        let missing = found.confident().filter(|e| e.id() != "constant_force");
        let missing: Vec<&str> = missing.map(|e| e.id()).collect();
        assert_eq!(missing, [named], "{period}");
    }
}
