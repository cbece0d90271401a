//! Every limit that a controller takes is one that can be exceeded, in its arithmetic and with its codes; all others are refused by
//! name.

use crate::measured::{calm, carrying, delayed, supplied};
use fixed::types::I16F16;
use preslide::control::{Axis, Coefficients, Controller, Fault, FaultLimits, Measurement, Planner};
use preslide::{Bound, Friction, Motion, ParamError, Scalar, Units};
use proptest::prelude::*;

/// Pushes with all that the number type holds.
#[derive(Clone, Debug, PartialEq)]
struct Push<S>(S);

impl<S: Scalar> Friction for Push<S> {
    type Scalar = S;
    type State = ();

    fn at_rest(&self) {}

    fn step(&self, _: &mut (), _: Motion<S>) -> S {
        self.0
    }

    fn limit(&self) -> Option<S> {
        None
    }
}

type Tested<S> = Controller<Push<S>, u16>;

/// The names by which limits are refused.
const LIMITS: [&str; 16] = [
    "top speed",
    "speed limit in counts per tick",
    "acceleration limit in 2⁻³² counts per tick²",
    "acceleration limit",
    "following error",
    "frozen duty",
    "frozen time",
    "supply time",
    "highest supply voltage",
    "largest current",
    "rated current",
    "offset of the current",
    "overruns",
    "silence of the host",
    "duty limit",
    "end of travel in counts",
];

/// So many ticks at most are tried out; counters of longer times are bounded by construction.
const PATIENCE: u32 = 70_000;

fn built<S: Scalar>(axis: &Axis, units: Units, push: f64) -> Result<Tested<S>, ParamError> {
    let push = S::try_from_f64(push.min(S::greatest())).expect("it fits");
    Coefficients::try_new(axis, Push(push), units).map(|c| Controller::new(c, 0))
}

/// Enabled, with the current sense reading `rest` so far.
fn enabled<S: Scalar>(axis: &Axis, units: Units, push: f64, rest: i16) -> Tested<S> {
    let mut controller = built(axis, units, push).expect("it was taken before");
    let measured = carrying(rest);
    for _ in 0..5000 {
        controller.tick(measured);
    }
    assert_eq!(controller.enable(), Ok(()));
    controller
}

/// The fault that comes within `ticks`, each with the given measurement.
fn comes<S: Scalar>(
    controller: &mut Tested<S>,
    ticks: u32,
    mut measure: impl FnMut(u32) -> Measurement<u16>,
) -> Option<Fault> {
    (0..ticks).find_map(|tick| {
        controller.heard();
        controller.tick(measure(tick)).fault
    })
}

/// Takes the axis, or refuses one of its limits; each limit of one that is taken finds its fault.
fn holds<S: Scalar>(axis: &Axis, units: Units) -> Result<bool, TestCaseError> {
    if let Err(error) = built::<S>(axis, units, 0.0) {
        // A number that the type does not hold is no limit.
        let named = LIMITS.contains(&error.parameter)
            || matches!(
                error.bound,
                Bound::Representable(_) | Bound::Resolvable | Bound::Rounded(_)
            );
        prop_assert!(named, "refused by another name: {error}");
        return Ok(false);
    }
    let FaultLimits {
        current_max,
        current_rated,
        current_offset,
        ..
    } = axis.watch;
    let code = |amperes: f64| (amperes / axis.hardware.current_code).floor() as i16;
    let ticks = |time: f64| (time / axis.sample_time()).ceil();
    let jump = (axis.watch.top_speed * axis.sample_time() / axis.encoder.count + 1.0) as u16;

    // What is not asked about here is made patient.
    let mut patient = *axis;
    patient.watch.frozen_time = 1e4;
    let mut cool = patient;
    cool.watch.thermal_time = 1e4;
    let mut far = enabled::<S>(&patient, units, 0.0, 0);
    let away = |tick: u32| calm((tick as u16).wrapping_mul(jump));
    let error = comes(&mut far, PATIENCE, away);
    prop_assert_eq!(error, Some(Fault::FollowingError));

    let mut jumps = enabled::<S>(&patient, units, 0.0, 0);
    let half = |_| calm(i16::MAX as u16);
    prop_assert_eq!(comes(&mut jumps, 1, half), Some(Fault::EncoderJump));

    if ticks(axis.watch.frozen_time) < f64::from(PATIENCE) {
        let mut frozen = enabled::<S>(axis, units, 1e30, 0);
        // So slow that no error results; at rest a push might be a load's.
        let creep = 1e-7 * axis.encoder.count / axis.sample_time();
        let jog = Planner::try_new(axis).and_then(|planner| planner.jog(creep));
        prop_assert_eq!(frozen.jog(jog.expect("within the limits")), Ok(()));
        let found = comes(&mut frozen, PATIENCE + 10, |_| calm(0));
        prop_assert_eq!(found, Some(Fault::EncoderFrozen));
    }
    if ticks(axis.watch.supply_time) < f64::from(PATIENCE) {
        for supply in [0, u16::MAX] {
            let mut sagging = enabled::<S>(&patient, units, 0.0, 0);
            let found = comes(&mut sagging, PATIENCE + 10, |_| supplied(supply));
            prop_assert_eq!(found, Some(Fault::SupplyOutOfRange));
        }
    }
    if axis.watch.overruns < PATIENCE {
        let mut late = enabled::<S>(&patient, units, 0.0, 0);
        let found = comes(&mut late, PATIENCE + 10, |_| delayed());
        prop_assert_eq!(found, Some(Fault::Overrun));
    }
    // At the ends of the scale, behind an offset that takes most of it away; and at the largest current that is allowed.
    let rest = code(current_offset);
    for (rest, current) in [(rest, i16::MAX), (-rest, i16::MIN)] {
        let mut large = enabled::<S>(&cool, units, 0.0, rest);
        let found = comes(&mut large, 2, |_| Measurement { current, ..calm(0) });
        prop_assert_eq!(found, Some(Fault::OverCurrent));
    }
    let (most, rated) = (
        code(current_max),
        current_rated / axis.hardware.current_code,
    );
    let heat = f64::from(most).powi(2) - rated.powi(2).floor();
    let overload = rated.powi(2) * ticks(axis.watch.thermal_time);
    prop_assert!(heat >= 1.0, "the largest current must warm the winding");
    if overload / heat < f64::from(PATIENCE) {
        let mut warm = enabled::<S>(&patient, units, 0.0, 0);
        let measured = |_| carrying(most);
        let found = comes(&mut warm, PATIENCE + 10, measured);
        prop_assert_eq!(found, Some(Fault::Overload));
    }
    let mut off = built::<S>(axis, units, 0.0).expect("it was taken before");
    for _ in 0..5000 {
        off.tick(carrying(i16::MAX));
    }
    prop_assert_eq!(off.enable(), Err(Fault::CurrentOffset));
    // The limiter cuts.
    let mut cut = enabled::<S>(&patient, units, 1e30, 0);
    let largest = (axis.duty_limit * f64::from(axis.hardware.steps)) as i32;
    prop_assert_eq!(cut.tick(calm(0)).code, largest);
    Ok(true)
}

/// 10 to the power of anything between two.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.log10()..high.log10()).prop_map(|power| 10_f64.powf(power))
}

/// The paper's axis with another count and limits over many decades. Speeds come in counts, so that most can be.
fn axes() -> impl Strategy<Value = Axis> {
    let lengths = (decades(1e-10, 1e-5), decades(1.0, 5e4), decades(1.0, 5e4));
    let duties = (0.01..1.0, 0.01..1.2, decades(1e-4, 1e6), decades(1e-4, 1e6));
    let currents = (decades(1e-2, 5.0), decades(1e-3, 3.0), decades(1e-3, 1.0));
    let others = (
        6.0..80.0,
        decades(1e-3, 1e6),
        prop::sample::select(vec![0, 2, 2, 1000, u32::MAX]),
    );
    (lengths, duties, currents, others).prop_map(|(lengths, duties, currents, others)| {
        let mut axis = Axis::PAPER_AXIS;
        let (count, speed, error) = lengths;
        axis.encoder.count = count;
        axis.watch.top_speed = speed * count / axis.sample_time();
        axis.limits.speed = 0.5 * axis.watch.top_speed;
        axis.limits.travel = None;
        axis.watch.following_error = error * count;
        (axis.duty_limit, axis.watch.frozen_duty) = (duties.0, duties.1 * duties.0);
        (axis.watch.frozen_time, axis.watch.supply_time) = (duties.2, duties.3);
        let watch = &mut axis.watch;
        (watch.current_max, watch.current_rated, watch.current_offset) = currents;
        (watch.supply_max, axis.silence, watch.overruns) = others;
        axis
    })
}

/// A displacement of 1 is a count, a force of 1 a millinewton, as in the firmware; the velocity's unit holds the speed.
fn counts(axis: &Axis) -> Units {
    Units {
        length: axis.encoder.count,
        force: 1e-3,
        velocity: 1e-3_f64.max(axis.limits.acceleration / 1e4),
    }
}

fn every_limit<S: Scalar>(units: fn(&Axis) -> Units) {
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        cases: 600,
        ..ProptestConfig::default()
    });
    let taken = std::cell::Cell::new(0);
    let run = runner.run(&axes(), |axis| {
        // Gains in the same proportion to the count, so that they are not what is refused.
        let mut axis = axis;
        let scale = Axis::PAPER_AXIS.encoder.count / axis.encoder.count;
        axis.gains.proportional *= scale;
        axis.gains.integral *= scale;
        // More than the duty limit takes, where the type holds it.
        axis.feed_forward.limit = (0.999 * S::greatest() * units(&axis).force).min(1e3);
        taken.set(taken.get() + u32::from(holds::<S>(&axis, units(&axis))?));
        Ok(())
    });
    if let Err(error) = run {
        panic!("{error}\n{runner}");
    }
    println!("{} of 600 axes taken", taken.get());
    // Some 25 are; by chance now and then fewer than 20.
    assert!(taken.get() >= 10, "too few are taken to say anything");
}

#[test]
fn every_limit_in_single_precision_is_reachable_or_refused() {
    every_limit::<f32>(|_| Units::SI);
}

#[test]
fn every_limit_in_fixed_point_is_reachable_or_refused() {
    every_limit::<I16F16>(counts);
}

/// The shipped limits with an encoder of 1 nm: the error ends at 32768 counts, below the 50 µm that were asked for.
#[test]
fn refuses_a_following_error_that_cannot_be_reached() {
    let mut axis = Axis::PAPER_AXIS;
    axis.encoder.count = 1e-9;
    let error = built::<f32>(&axis, Units::SI, 0.0).expect_err("out of reach");
    assert_eq!(error.parameter, "following error");
    assert!(
        error.to_string().contains("must be below 0.0000327"),
        "{error}"
    );
    axis.watch.following_error = 32e-6;
    assert!(built::<f32>(&axis, Units::SI, 0.0).is_ok());
}
