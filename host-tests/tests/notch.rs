//! The notch against its transfer function, worked out here with complex numbers; in every arithmetic.

use fixed::types::I16F16;
use nalgebra::Complex;
use preslide::control::{Axis, Coefficients, NoFriction, Notch, NotchFilter, NotchState};
use preslide::{Bound, Scalar, Units};
use preslide_sim::stage::StageConfig;
use preslide_sim::tracking::notch::study;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

const RATE: f64 = 20_000.0;

fn filter<S: Scalar>(notch: &Notch) -> NotchFilter<S> {
    let filter = NotchFilter::try_new(notch, 1.0 / RATE).expect("valid");
    filter.expect("a frequency above 0")
}

/// Ticks in which its slowest part decays to e⁻²⁰: it does so as e^{−π·f·width·t} far below half the rate, and slower near it.
fn settled(notch: &Notch) -> u32 {
    let g = (PI * notch.frequency / RATE).tan();
    (20.0 * (1.0 + g * g) / (notch.width * g)) as u32
}

/// `(s² + (1 − depth)·width·s + 1)/(s² + width·s + 1)` with `s = j·tan(πf/rate)/tan(πf₀/rate)`: the analogue notch, its axis bent so that
/// half the rate is infinity.
fn response(notch: &Notch, hz: f64) -> Complex<f64> {
    let s = Complex::new(
        0.0,
        (PI * hz / RATE).tan() / (PI * notch.frequency / RATE).tan(),
    );
    let above = s * s + s * (1.0 - notch.depth) * notch.width + 1.0;
    above / (s * s + s * notch.width + 1.0)
}

/// Largest, RMS and mean deviation from the analogue notch's answer to a sine of that amplitude, once settled, of the amplitude (-).
fn deviation<S: Scalar>(notch: &Notch, hz: f64, amplitude: f64) -> [f64; 3] {
    let filter = filter::<S>(notch);
    let mut state = NotchState::new();
    let expected = response(notch, hz);
    let settled = settled(notch);
    let (mut largest, mut squares, mut sum) = (0.0_f64, 0.0, 0.0);
    let looks = 20_000;
    for tick in 0..settled + looks {
        let turn = Complex::from_polar(amplitude, TAU * hz * f64::from(tick) / RATE);
        let force = S::try_from_f64(turn.im).expect("it fits");
        let left = force.to_f64() - filter.step(&mut state, force).to_f64();
        if tick >= settled {
            let off = (left - (expected * turn).im) / amplitude;
            largest = largest.max(off.abs());
            squares += off * off;
            sum += off;
        }
    }
    let looks = f64::from(looks);
    [largest, (squares / looks).sqrt(), (sum / looks).abs()]
}

fn notches() -> impl Strategy<Value = Notch> {
    (1.5..3.9_f64, 0.1..1.0_f64, 0.0..=1.0_f64).prop_map(|(decade, width, depth)| Notch {
        frequency: 10_f64.powf(decade),
        width,
        depth,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// In `f32` within 10⁻³ of the amplitude: its coefficients are good to 10⁻⁷, which a mode of 32 Hz multiplies by the rate over its
    /// bandwidth. In fixed point a sine of 1000 mN within what a frequency and a width that are a hundredth off may make, where they are
    /// held at all.
    #[test]
    fn the_notch_answers_as_the_analogue_one(notch in notches(), at in 0.3..3.0_f64) {
        let hz = (at * notch.frequency).min(0.49 * RATE);
        let [largest, rms, mean] = deviation::<f32>(&notch, hz, 1.0);
        prop_assert!(largest < 1e-3 && rms < 5e-4 && mean < 1e-4, "{largest} {rms} {mean}");
        if let Ok(Some(_)) = NotchFilter::<I16F16>::try_new(&notch, 1.0 / RATE) {
            // By a hundredth of the frequency the notch's flank moves by 0.02 of 1/width.
            let bound = notch.depth * (0.012 + 0.022 / notch.width) + 1e-4;
            let [largest, rms, mean] = deviation::<I16F16>(&notch, hz, 1000.0);
            prop_assert!(largest < bound && rms < 0.75 * bound && mean < 1e-4, "{largest} {rms} {mean} of {bound}");
        }
    }

    /// Whatever came before, at all of the type's range, a constant force passes afterwards: to the bit of a force in `f32`, and to 0.05 mN,
    /// a hundredth of a PWM code, in fixed point. Nothing swings on by itself.
    #[test]
    fn a_constant_force_passes_whatever_came_before(
        notch in notches(), wild in prop::collection::vec(-32_000.0..32_000.0_f64, 50..400), force in -30_000.0..30_000.0_f64,
    ) {
        fn taken<S: Scalar>(notch: &Notch, wild: &[f64], force: f64) -> Option<f64> {
            let filter = NotchFilter::<S>::try_new(notch, 1.0 / RATE).ok()??;
            let mut state = NotchState::new();
            let input = |force: f64| S::try_from_f64(force).expect("it fits");
            for &force in wild {
                filter.step(&mut state, input(force));
            }
            // From the range's end to below the least bit.
            for _ in 0..2 * settled(notch) {
                filter.step(&mut state, input(force));
            }
            let looks = (0..4000).map(|_| filter.step(&mut state, input(force)).to_f64().abs());
            Some(looks.fold(0.0, f64::max))
        }
        let float = taken::<f32>(&notch, &wild, force).expect("valid");
        prop_assert!(float <= 1e-6 * force.abs() * RATE / (notch.frequency * notch.width), "{float} of {force}");
        if let Some(fixed) = taken::<I16F16>(&notch, &wild, force) {
            prop_assert!(fixed <= 0.05, "{fixed} of {force}");
        }
    }

    /// What fixed point holds is a hundredth off at most; what it does not is refused by name, and so is a frequency that no tick shows.
    #[test]
    fn a_notch_is_held_or_refused_by_name(decade in -1.0..4.5_f64, width in -3.0..0.5_f64, depth in -0.5..1.5_f64) {
        let notch = Notch { frequency: 10_f64.powf(decade), width: 10_f64.powf(width), depth };
        let mut axis = Axis::PAPER_AXIS;
        axis.notch = notch;
        match NotchFilter::<I16F16>::try_new(&notch, 1.0 / RATE) {
            Ok(filter) => {
                prop_assert!(filter.is_some() && notch.frequency < 0.5 * RATE && notch.width <= 1.0);
                prop_assert!((0.0..=1.0).contains(&depth));
                prop_assert!(Coefficients::try_new(&axis, NoFriction::<f32>::new(), Units::SI).is_ok());
            }
            Err(error) => {
                prop_assert!(error.parameter.contains("notch"), "{error}");
                let usual = notch.frequency > 100.0 && notch.frequency < 5000.0 && (0.1..1.0).contains(&notch.width);
                prop_assert!(!(usual && (0.01..1.0).contains(&depth)), "{error}");
            }
        }
    }
}

#[test]
fn reports_what_is_wrong_with_a_notch() {
    let refused = |frequency, width, depth| {
        let mut axis = Axis::PAPER_AXIS;
        axis.notch = Notch {
            frequency,
            width,
            depth,
        };
        let error = Coefficients::try_new(&axis, NoFriction::<f32>::new(), Units::SI);
        let error = error.expect_err("refused");
        (error.parameter, error.bound)
    };
    let (frequency, width, depth) = (
        "frequency of the notch",
        "width of the notch",
        "depth of the notch",
    );
    assert_eq!(
        refused(10_000.0, 0.5, 0.9),
        (frequency, Bound::Reachable(10_000.0))
    );
    assert_eq!(refused(-1.0, 0.5, 0.9), (frequency, Bound::NotNegative));
    // Off as well: it is switched on by its frequency alone.
    assert_eq!(refused(0.0, 1.1, 0.9), (width, Bound::AtMost(1.0)));
    assert_eq!(refused(0.0, 0.0, 0.9), (width, Bound::Positive));
    assert_eq!(refused(0.0, 0.5, 1.1), (depth, Bound::AtMost(1.0)));
    assert_eq!(refused(370.0, 0.5, f64::NAN), (depth, Bound::NotNegative));
    let (parameter, bound) = refused(370.0, 1e-8, 0.9);
    assert!(parameter == width && matches!(bound, Bound::Rounded(_)));
}

/// On the stage with a drive of half the mode's frequency, in fixed point: the gains may grow, and half of what they may leaves less error.
#[test]
fn a_notch_lets_the_gains_of_a_soft_drive_grow() {
    let rows = study::<I16F16>(
        &Axis::PAPER_AXIS,
        &StageConfig::default(),
        preslide_sim::tracking::FIXED_UNITS,
        [&[0.25], &[0.0, 1.0]],
        &[101],
    );
    let rows = rows.expect("it runs");
    let [without, with] = [rows[0], rows[1]];
    println!("{without:?}\n{with:?}");
    assert!(with.margin > 1.3 * without.margin);
    assert!(with.half.alone_m < 0.8 * without.half.alone_m);
}
