// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model rotary.toml, SHA-256 ae71481be791d12f0b6185c433eaf16b49d0b529a63b22f43df468ae3ea9aa78.

/// `stiffness_Nm_per_rad` of `lugre`.
pub const LUGRE_STIFFNESS_NM_PER_RAD: f64 = 100.0;
/// `damping_Nm_s_per_rad` of `lugre`.
pub const LUGRE_DAMPING_NM_S_PER_RAD: f64 = 0.0;
/// `breakaway_Nm` of `lugre`.
pub const LUGRE_BREAKAWAY_NM: f64 = 0.02;
/// `coulomb_Nm` of `lugre`.
pub const LUGRE_COULOMB_NM: f64 = 0.02;
/// `stribeck_velocity_rad_s` of `lugre`.
pub const LUGRE_STRIBECK_VELOCITY_RAD_S: f64 = 1.0;
/// `stribeck_exponent` of `lugre`.
pub const LUGRE_STRIBECK_EXPONENT: f64 = 2.0;
/// `attraction_Nm_per_s` of `lugre`.
pub const LUGRE_ATTRACTION_NM_PER_S: f64 = f64::INFINITY;
/// `force_Nm` of `periodic_force`.
pub const PERIODIC_FORCE_FORCE_NM: f64 = 0.005;
/// `period_rad` of `periodic_force`.
pub const PERIODIC_FORCE_PERIOD_RAD: f64 = 0.8975979010256552;
/// `phase_rad` of `periodic_force`.
pub const PERIODIC_FORCE_PHASE_RAD: f64 = 0.4;
/// `force_Nm` of `gravity`.
pub const GRAVITY_FORCE_NM: f64 = 0.03;
/// `angle_rad` of `gravity`.
pub const GRAVITY_ANGLE_RAD: f64 = 0.2;

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 12] = [
    LUGRE_STIFFNESS_NM_PER_RAD,
    LUGRE_DAMPING_NM_S_PER_RAD,
    LUGRE_BREAKAWAY_NM,
    LUGRE_COULOMB_NM,
    LUGRE_STRIBECK_VELOCITY_RAD_S,
    LUGRE_STRIBECK_EXPONENT,
    LUGRE_ATTRACTION_NM_PER_S,
    PERIODIC_FORCE_FORCE_NM,
    PERIODIC_FORCE_PERIOD_RAD,
    PERIODIC_FORCE_PHASE_RAD,
    GRAVITY_FORCE_NM,
    GRAVITY_ANGLE_RAD,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0xD17E1865;

/// The effects beside the friction model.
pub type Effects<S = f32> = (
    ::preslide::effects::PeriodicForce<S>,
    ::preslide::effects::Gravity<S>,
);

/// The friction model with its effects.
pub type Model<S = f32> = ::preslide::effects::With<::preslide::LuGre<S>, Effects<S>>;

/// Builds the model, in which the sample time plays no part, computing in `units`.
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
    parameters: &[f64; 12],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        lugre_stiffness_nm_per_rad,
        lugre_damping_nm_s_per_rad,
        lugre_breakaway_nm,
        lugre_coulomb_nm,
        lugre_stribeck_velocity_rad_s,
        lugre_stribeck_exponent,
        lugre_attraction_nm_per_s,
        periodic_force_force_nm,
        periodic_force_period_rad,
        periodic_force_phase_rad,
        gravity_force_nm,
        gravity_angle_rad,
    ] = *parameters;
    let friction = ::preslide::LuGre::try_new(lugre_stiffness_nm_per_rad, lugre_damping_nm_s_per_rad, lugre_breakaway_nm, ::preslide::Sliding { coulomb: lugre_coulomb_nm, stribeck_velocity: lugre_stribeck_velocity_rad_s, stribeck_exponent: lugre_stribeck_exponent, attraction: lugre_attraction_nm_per_s }, units)?;
    let effects = (
        ::preslide::effects::PeriodicForce::try_new(periodic_force_force_nm, periodic_force_period_rad, periodic_force_phase_rad, units)?,
        ::preslide::effects::Gravity::try_new(gravity_force_nm, gravity_angle_rad, units)?,
    );
    ::preslide::effects::With::try_new(friction, effects)
}
