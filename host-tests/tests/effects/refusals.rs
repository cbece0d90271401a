//! Parameters that cannot be.

use super::*;
use fixed::types::I16F16;
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, DwellAging, EncoderError, ExternalVibration, PeriodicForce,
    PositionForce, Stribeck, Viscous, With,
};

#[test]
fn what_cannot_be_is_refused_by_name() {
    let u = Units::SI;
    let refused = |error: Option<preslide::ParamError>, part: &str| {
        let error = error.expect("refused").to_string();
        assert!(error.contains(part), "`{part}` is not in: {error}");
    };
    refused(Viscous::<f32>::try_new(f64::NAN, 1.0, u).err(), "viscous");
    refused(Viscous::<f32>::try_new(1.0, 0.0, u).err(), "limit");
    refused(
        Stribeck::<f32>::try_new(0.1, 1e-3, 0.5, u).err(),
        "exponent",
    );
    refused(
        Stribeck::<f32>::try_new(f64::NAN, 1e-3, 2.0, u).err(),
        "level",
    );
    refused(
        Stribeck::<f32>::try_new(0.1, -1.0, 2.0, u).err(),
        "velocity",
    );
    refused(CoulombAsymmetry::<f32>::try_new(1.5).err(), "asymmetry");
    refused(
        PeriodicForce::<f32>::try_new(0.1, 0.0, 0.0, u).err(),
        "period",
    );
    refused(
        EncoderError::<f32>::try_new(2e-6, 1e-5, 0.0, u).err(),
        "encoder error",
    );
    refused(
        PositionForce::<1, f32>::try_new(1.0, 1.0, [0.1], u).err(),
        "travel",
    );
    refused(
        ExternalVibration::<f32>::try_new(0.1, 600.0, 0.0, 1e-3, u).err(),
        "frequency",
    );
    refused(
        DwellAging::<f32>::try_new(0.1, 10.0, 1e-5, 6.0, 50e-6, u).err(),
        "ageing",
    );
    // Periods that I16F16 cannot resolve in counts, a frequency that it would put out of step.
    refused(
        PeriodicForce::<I16F16>::try_new(0.1, 16.7, 0.0, COUNTS).err(),
        "turns",
    );
    refused(
        PeriodicForce::<I16F16>::try_new(0.1, 5e-3, 0.0, COUNTS).err(),
        "turns",
    );
    refused(
        ExternalVibration::<I16F16>::try_new(0.1, 33.0, 0.0, SAMPLE_TIME, COUNTS).err(),
        "turns",
    );
    let huge = ConstantForce::<I16F16>::try_new(32.7, COUNTS).expect("alone it fits");
    refused(With::try_new(gms::<I16F16>(COUNTS), huge).err(), "composed");
}
