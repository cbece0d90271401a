// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model full.toml, SHA-256 12ced9cd524ee6379b088358b4608a4919a6c9a76938658f5c2a35c5c5049b2b.
// Force bound 9.00 N (ten times the breakaway force) cuts viscous above 750 mm/s; --limit raises the bound, --recording REC takes it from your motion.

/// `breakaway_N` of `gms`.
pub const GMS_BREAKAWAY_N: f64 = 0.9;
/// `coulomb_N` of `gms`.
pub const GMS_COULOMB_N: f64 = 0.8;
/// `stribeck_velocity_m_s` of `gms`.
pub const GMS_STRIBECK_VELOCITY_M_S: f64 = 0.002;
/// `stribeck_exponent` of `gms`.
pub const GMS_STRIBECK_EXPONENT: f64 = 2.0;
/// `attraction_N_per_s` of `gms`.
pub const GMS_ATTRACTION_N_PER_S: f64 = 20.0;
/// Maxwell-slip blocks: `stiffness_N_per_m` and weight.
pub const BLOCKS: [::preslide::Block; 3] = [
    ::preslide::Block { stiffness: 325379.0, weight: 0.352 },
    ::preslide::Block { stiffness: 40535.0, weight: 0.307 },
    ::preslide::Block { stiffness: 7886.0, weight: 0.341 },
];
/// Bound of each force that grows with speed or position (N or N·m).
pub const FORCE_LIMIT: f64 = 9.0;
/// `viscous_N_s_per_m` of `viscous`.
pub const VISCOUS_N_S_PER_M: f64 = 12.0;
/// `force_N` of `periodic_force`.
pub const PERIODIC_FORCE_FORCE_N: f64 = 0.03;
/// `period_m` of `periodic_force`.
pub const PERIODIC_FORCE_PERIOD_M: f64 = 0.0002857;
/// `phase_rad` of `periodic_force`.
pub const PERIODIC_FORCE_PHASE_RAD: f64 = 0.5;

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 15] = [
    GMS_BREAKAWAY_N,
    GMS_COULOMB_N,
    GMS_STRIBECK_VELOCITY_M_S,
    GMS_STRIBECK_EXPONENT,
    GMS_ATTRACTION_N_PER_S,
    BLOCKS[0].stiffness,
    BLOCKS[0].weight,
    BLOCKS[1].stiffness,
    BLOCKS[1].weight,
    BLOCKS[2].stiffness,
    BLOCKS[2].weight,
    VISCOUS_N_S_PER_M,
    PERIODIC_FORCE_FORCE_N,
    PERIODIC_FORCE_PERIOD_M,
    PERIODIC_FORCE_PHASE_RAD,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0xA30EF0E7;

/// The effects beside the friction model.
pub type Effects<S = ::preslide::fixed::types::I16F16> = (
    ::preslide::effects::Viscous<S>,
    ::preslide::effects::PeriodicForce<S>,
);

/// The friction model with its effects.
pub type Model<S = ::preslide::fixed::types::I16F16> = ::preslide::effects::With<::preslide::kernels::Scaled<::preslide::kernels::CountGms<3>, S>, Effects<S>>;

/// Builds the model, for ticks that are `sample_time` (s) apart, computing in `units`.
///
/// # Errors
/// The parameter that does not fit the number type in `units`.
pub fn model<S: ::preslide::Scalar>(
    sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    with(&PARAMETERS, sample_time, units)
}

/// The same with other parameters.
///
/// # Errors
/// As of `model`.
pub fn with<S: ::preslide::Scalar>(
    parameters: &[f64; 15],
    sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        gms_breakaway_n,
        gms_coulomb_n,
        gms_stribeck_velocity_m_s,
        gms_stribeck_exponent,
        gms_attraction_n_per_s,
        stiffness_0,
        weight_0,
        stiffness_1,
        weight_1,
        stiffness_2,
        weight_2,
        viscous_n_s_per_m,
        periodic_force_force_n,
        periodic_force_period_m,
        periodic_force_phase_rad,
    ] = *parameters;
    let friction = <::preslide::kernels::Scaled<::preslide::kernels::CountGms<3>, S>>::try_new(&[::preslide::Block { stiffness: stiffness_0, weight: weight_0 }, ::preslide::Block { stiffness: stiffness_1, weight: weight_1 }, ::preslide::Block { stiffness: stiffness_2, weight: weight_2 }], gms_breakaway_n, ::preslide::Sliding { coulomb: gms_coulomb_n, stribeck_velocity: gms_stribeck_velocity_m_s, stribeck_exponent: gms_stribeck_exponent, attraction: gms_attraction_n_per_s }, sample_time, units)?;
    let effects = (
        ::preslide::effects::Viscous::try_new(viscous_n_s_per_m, FORCE_LIMIT, units)?,
        ::preslide::effects::PeriodicForce::try_new(periodic_force_force_n, periodic_force_period_m, periodic_force_phase_rad, units)?,
    );
    ::preslide::effects::With::try_new(friction, effects)
}
