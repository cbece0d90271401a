//! What the effects cost beside a friction model: `With<Gms<4>, (Effect,)>`, to be compared with the bare `Gms<4>`.
//!
//! Typical parameters of the paper's axis; only the number of cosines of a map changes an instruction. Temperature and load are
//! told once: reading such a sensor is not the effect's cost. Effects that I16F16 cannot resolve at this sample time are measured
//! in `f32` only.

use fixed::types::I16F16;
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, DwellAging, Effect, EncoderError, ExternalVibration,
    FrictionalLag, LoadDependentFriction, LocalFrictionSpot, PeriodicForce, PeriodicFriction,
    PositionForce, PositionFriction, PositionSpring, QuadraticDrag, RunIn, Stribeck, ThermalDrift,
    Viscous, ViscousAsymmetry, WarmUp, With,
};
use preslide::{Gms, ParamError, Scalar, Units};

use crate::kernels::{BREAKAWAY, COUNTS, SLIDING, blocks, built};
use crate::motion::SAMPLE_TIME;
use crate::stub;

type Composed<S, E> = With<Gms<4, S>, E>;

fn beside_gms<S: Scalar, E: Effect<S>>(
    effects: Result<E, ParamError>,
    units: Units,
) -> Composed<S, E> {
    let gms = Gms::try_new(&blocks(), BREAKAWAY, SLIDING, SAMPLE_TIME, units);
    built(With::try_new(built(gms), built(effects)))
}

/// One effect, in `f32` and I16F16 or in the one that is named.
macro_rules! effect {
    ($id:literal, $effect:ident $(<$j:literal>)?, |$units:ident| $make:expr) => {
        effect!(f32, $id, $effect $(<$j>)?, |$units| $make);
        effect!(I16F16, $id, $effect $(<$j>)?, |$units| $make);
    };
    (f32, $id:literal, $effect:ident $(<$j:literal>)?, |$units:ident| $make:expr) => {
        effect!(@ concat!("with_", $id, "_f32"), f32, Units::SI, $effect<$($j,)? f32>, $units, $make);
    };
    (I16F16, $id:literal, $effect:ident $(<$j:literal>)?, |$units:ident| $make:expr) => {
        effect!(@ concat!("with_", $id, "_i16f16"), I16F16, COUNTS, $effect<$($j,)? I16F16>, $units, $make);
    };
    (@ $kernel:expr, $scalar:ident, $in:expr, $effect:ty, $units:ident, $make:expr) => {{
        let $units = $in;
        let effect = $make.map(|effect| (effect,));
        stub!($kernel, 4, Composed<$scalar, ($effect,)>, $units, beside_gms(effect, $units), |state| {
            state.temperature = Some($scalar::from_int(21));
            state.load = Some($scalar::from_int(31));
        });
    }};
}

pub fn run() {
    stub!("with_nothing_f32", 4, Composed<f32, ()>, Units::SI, beside_gms(Ok(()), Units::SI));
    stub!("with_nothing_i16f16", 4, Composed<I16F16, ()>, COUNTS, beside_gms(Ok(()), COUNTS));
    effect!("constant_force", ConstantForce, |u| ConstantForce::try_new(
        0.05, u
    ));
    effect!("viscous", Viscous, |u| Viscous::try_new(12.0, 0.5, u));
    effect!("viscous_asymmetry", ViscousAsymmetry, |u| {
        ViscousAsymmetry::try_new(12.0, 0.5, u)
    });
    effect!("quadratic_drag", QuadraticDrag, |u| QuadraticDrag::try_new(
        400.0, 0.5, u
    ));
    effect!("position_spring", PositionSpring, |u| {
        PositionSpring::try_new(1000.0, 0.0, 0.5, u)
    });
    effect!("position_force_2", PositionForce<2>, |u| {
        PositionForce::try_new(-60e-6, 60e-6, [0.1; 2], u)
    });
    effect!("position_force_8", PositionForce<8>, |u| {
        PositionForce::try_new(-60e-6, 60e-6, [0.02; 8], u)
    });
    effect!("periodic_force", PeriodicForce, |u| PeriodicForce::try_new(
        0.03, 2.857e-4, 0.5, u
    ));
    effect!(f32, "external_vibration", ExternalVibration, |u| {
        ExternalVibration::try_new(0.02, 50.0, 0.5, SAMPLE_TIME, u)
    });
    effect!("coulomb_asymmetry", CoulombAsymmetry, |_u| {
        CoulombAsymmetry::try_new(0.1)
    });
    effect!("stribeck", Stribeck, |u| Stribeck::try_new(
        0.2, 1e-3, 2.0, u
    ));
    effect!("frictional_lag", FrictionalLag, |u| FrictionalLag::try_new(
        0.2,
        1e-3,
        2.0,
        0.01,
        SAMPLE_TIME,
        u
    ));
    effect!("position_friction_2", PositionFriction<2>, |u| {
        PositionFriction::try_new(-60e-6, 60e-6, [0.1; 2], u)
    });
    effect!("position_friction_8", PositionFriction<8>, |u| {
        PositionFriction::try_new(-60e-6, 60e-6, [0.02; 8], u)
    });
    effect!("local_friction_spot", LocalFrictionSpot, |u| {
        LocalFrictionSpot::try_new(0.4, 10e-6, 20e-6, u)
    });
    effect!("periodic_friction", PeriodicFriction, |u| {
        PeriodicFriction::try_new(0.1, 2.857e-4, 0.5, u)
    });
    effect!("load_dependent_friction", LoadDependentFriction, |u| {
        LoadDependentFriction::try_new(0.03, 30.0, 0.5, u)
    });
    effect!("thermal_drift", ThermalDrift, |_u| ThermalDrift::try_new(
        -0.02, 20.0, 0.5
    ));
    effect!(f32, "warm_up", WarmUp, |_u| WarmUp::try_new(
        0.2,
        1.0,
        SAMPLE_TIME
    ));
    effect!(f32, "run_in", RunIn, |u| RunIn::try_new(
        0.2,
        0.01,
        SAMPLE_TIME,
        u
    ));
    effect!(f32, "dwell_aging", DwellAging, |u| DwellAging::try_new(
        0.05,
        0.1,
        20e-6,
        1.0,
        SAMPLE_TIME,
        u
    ));
    effect!("encoder_error", EncoderError, |u| EncoderError::try_new(
        50e-9, 10e-6, 0.5, u
    ));
}
