//! What belongs to a place, once the axis knows where it is.

use super::*;
use crate::measured::calm;
use preslide::control::{Coefficients, Controller, Settings};
use preslide::effects::{
    ConstantForce, EncoderError, LocalFrictionSpot, PeriodicForce, PositionSpring, With,
};
use preslide::{Friction, Motion, QuasiStaticGms};
use preslide_host_tests::path::motion;

/// The control task takes the composed model by type, and gives it the axis's position once that is known.
#[test]
fn the_controller_places_the_model() {
    let settings = Settings::PAPER_AXIS;
    let u = Units::SI;
    let force = |x0: i32, homed: bool| {
        let friction =
            QuasiStaticGms::<3, f32>::try_new(&table3::blocks::<3>(), 0.9, u).expect("valid");
        let model = With::try_new(
            friction,
            PositionSpring::try_new(500.0, 0.0, 2.0, u).expect("valid"),
        )
        .expect("fits");
        let coefficients = Coefficients::try_new(&settings, model, u).expect("valid");
        let mut controller = Controller::new(coefficients, 0_u32);
        let mut code = 0;
        if homed {
            controller.set_position(0, 0);
        }
        // Carried slowly to x0 by hand before it is enabled.
        let mut at = 0;
        let measurement = |at: i32| calm(at.cast_unsigned());
        while at != x0 {
            at += (x0 - at).signum() * (x0 - at).abs().min(20);
            assert!(!controller.tick(measurement(at)).enabled);
        }
        assert_eq!(controller.enable(), Ok(()));
        for _ in 0..200 {
            code = controller.tick(measurement(at)).code;
        }
        assert_eq!(controller.fault(), None);
        f64::from(code)
    };
    let (left, middle, right) = (force(-40_000, true), force(0, true), force(40_000, true));
    let lost = force(40_000, false);
    assert!(lost.abs() <= 1.0, "{lost}");
    assert!(middle.abs() <= 1.0, "{middle}");
    assert!(
        right > 100.0 && (right + left).abs() < 2.0,
        "{left} {right}"
    );
}

/// What belongs to a place acts once the place is known: alone, in a tuple, in a nested tuple; what does not acts at once.
#[test]
fn effects_of_place_wait_until_the_axis_is_located() {
    let gms = || {
        QuasiStaticGms::<3, f64>::try_new(&table3::blocks::<3>(), 0.9, Units::SI).expect("valid")
    };
    let cogging = || PeriodicForce::<f64>::try_new(0.03, 2.857e-4, 0.0, Units::SI).expect("valid");
    let spot = || LocalFrictionSpot::<f64>::try_new(0.5, 0.0, 1e-4, Units::SI).expect("valid");
    let constant = || ConstantForce::<f64>::try_new(0.2, Units::SI).expect("valid");
    let error = || EncoderError::<f64>::try_new(50e-9, 10e-6, 0.3, Units::SI).expect("valid");
    let motion = motion(1e-3, 1e-3);
    fn both<F: Friction<Scalar = f64>>(model: &F, motion: Motion<f64>) -> [f64; 2] {
        [false, true].map(|placed| {
            let mut state = model.at_rest();
            if placed {
                model.set_position(&mut state, 0.0);
            }
            model.step(&mut state, motion)
        })
    }
    let [alone, _] = both(&gms(), motion);
    // The library's waves and bells are approximations, good to 1e-4 of their level.
    let close = |a: f64, b: f64| assert!((a - b).abs() < 5e-5, "{a} {b}");
    let single = With::try_new(gms(), cogging()).expect("valid");
    let [off, on] = both(&single, motion);
    close(off, alone);
    close(on, alone + 0.03);
    let nested = With::try_new(gms(), (constant(), (spot(), cogging()), error())).expect("valid");
    let [off, on] = both(&nested, motion);
    close(off, alone + 0.2);
    close(on, (1.5 * alone) + 0.2 + 0.03);
}
