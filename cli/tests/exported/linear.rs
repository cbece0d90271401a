// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model linear.toml, SHA-256 669a7ef1c2f724c8dd7b1f52441bd6daf5bf52e7d016fab97561bb8446f8eaff.
// Model: identified from a test.
// Force bound 9.00 N (ten times the breakaway force) cuts viscous above 750 mm/s, viscous_asymmetry above 9.00 m/s, quadratic_drag above 474 mm/s, position_spring beyond ±750 mm of its centre; --limit raises the bound, --recording REC takes it from your motion.
// Bound of temperature and load 0.500 of the friction level cuts thermal_drift beyond ±50.0 K of its temperature, load_dependent_friction beyond ±50.0 N of its load; --recording REC takes it from your motion.

#[allow(dead_code)] // for the settings of the feed-forward
/// `mass_kg` of the moving part.
pub const MASS_KG: f64 = 3.9;
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
/// Most by which temperature or load may change the friction level (-).
pub const LEVEL_LIMIT: f64 = 0.5;
/// `viscous_N_s_per_m` of `viscous`.
pub const VISCOUS_N_S_PER_M: f64 = 12.0;
/// `force_N` of `constant_force`.
pub const CONSTANT_FORCE_FORCE_N: f64 = 0.1;
/// `asymmetry` of `coulomb_asymmetry`.
pub const COULOMB_ASYMMETRY_ASYMMETRY: f64 = 0.05;
/// `half_difference_N_s_per_m` of `viscous_asymmetry`.
pub const VISCOUS_ASYMMETRY_HALF_DIFFERENCE_N_S_PER_M: f64 = 1.0;
/// `drag_N_s2_per_m2` of `quadratic_drag`.
pub const QUADRATIC_DRAG_DRAG_N_S2_PER_M2: f64 = 40.0;
/// `level` of `stribeck`.
pub const STRIBECK_LEVEL: f64 = 0.2;
/// `velocity_m_s` of `stribeck`.
pub const STRIBECK_VELOCITY_M_S: f64 = 0.004;
/// `exponent` of `stribeck`.
pub const STRIBECK_EXPONENT: f64 = 2.0;
/// `level` of `frictional_lag`.
pub const FRICTIONAL_LAG_LEVEL: f64 = 0.1;
/// `velocity_m_s` of `frictional_lag`.
pub const FRICTIONAL_LAG_VELOCITY_M_S: f64 = 0.004;
/// `exponent` of `frictional_lag`.
pub const FRICTIONAL_LAG_EXPONENT: f64 = 1.0;
/// `time_constant_s` of `frictional_lag`.
pub const FRICTIONAL_LAG_TIME_CONSTANT_S: f64 = 0.02;
/// `stiffness_N_per_m` of `position_spring`.
pub const POSITION_SPRING_STIFFNESS_N_PER_M: f64 = 12.0;
/// `centre_m` of `position_spring`.
pub const POSITION_SPRING_CENTRE_M: f64 = 0.001;
/// `from_m` of `position_force`.
pub const POSITION_FORCE_FROM_M: f64 = -0.004;
/// `to_m` of `position_force`.
pub const POSITION_FORCE_TO_M: f64 = 0.006;
/// The cosines of `position_force`.
pub const POSITION_FORCE_COSINES: [f64; 3] = [0.05, -0.02, 0.01];
/// `from_m` of `position_friction`.
pub const POSITION_FRICTION_FROM_M: f64 = -0.004;
/// `to_m` of `position_friction`.
pub const POSITION_FRICTION_TO_M: f64 = 0.006;
/// The cosines of `position_friction`.
pub const POSITION_FRICTION_COSINES: [f64; 2] = [0.1, 0.05];
/// `level` of `local_friction_spot`.
pub const LOCAL_FRICTION_SPOT_LEVEL: f64 = 0.4;
/// `position_m` of `local_friction_spot`.
pub const LOCAL_FRICTION_SPOT_POSITION_M: f64 = 0.002;
/// `width_m` of `local_friction_spot`.
pub const LOCAL_FRICTION_SPOT_WIDTH_M: f64 = 0.0005;
/// `force_N` of `periodic_force`.
pub const PERIODIC_FORCE_FORCE_N: f64 = 0.03;
/// `period_m` of `periodic_force`.
pub const PERIODIC_FORCE_PERIOD_M: f64 = 0.0002857;
/// `phase_rad` of `periodic_force`.
pub const PERIODIC_FORCE_PHASE_RAD: f64 = 0.4;
/// `force_N` of `periodic_force`.
pub const PERIODIC_FORCE_2_FORCE_N: f64 = 0.01;
/// `period_m` of `periodic_force`.
pub const PERIODIC_FORCE_2_PERIOD_M: f64 = 0.00014285;
/// `phase_rad` of `periodic_force`.
pub const PERIODIC_FORCE_2_PHASE_RAD: f64 = -1.0;
/// `level` of `periodic_friction`.
pub const PERIODIC_FRICTION_LEVEL: f64 = 0.1;
/// `period_m` of `periodic_friction`.
pub const PERIODIC_FRICTION_PERIOD_M: f64 = 0.002;
/// `phase_rad` of `periodic_friction`.
pub const PERIODIC_FRICTION_PHASE_RAD: f64 = 0.0;
/// `error_m` of `encoder_error`.
pub const ENCODER_ERROR_ERROR_M: f64 = 1e-7;
/// `period_m` of `encoder_error`.
pub const ENCODER_ERROR_PERIOD_M: f64 = 1e-5;
/// `phase_rad` of `encoder_error`.
pub const ENCODER_ERROR_PHASE_RAD: f64 = 0.5;
/// `level_per_K` of `thermal_drift`.
pub const THERMAL_DRIFT_LEVEL_PER_K: f64 = -0.01;
/// `temperature_C` of `thermal_drift`.
pub const THERMAL_DRIFT_TEMPERATURE_C: f64 = 21.0;
/// `level` of `thermal_drift`.
pub const THERMAL_DRIFT_2_LEVEL: f64 = 0.1;
/// `time_constant_s` of `thermal_drift`.
pub const THERMAL_DRIFT_2_TIME_CONSTANT_S: f64 = 3.0;
/// `level_per_decade` of `dwell_aging`.
pub const DWELL_AGING_LEVEL_PER_DECADE: f64 = 0.02;
/// `time_constant_s` of `dwell_aging`.
pub const DWELL_AGING_TIME_CONSTANT_S: f64 = 0.1;
/// `erasing_path_m` of `dwell_aging`.
pub const DWELL_AGING_ERASING_PATH_M: f64 = 2e-5;
/// `level_per_N` of `load_dependent_friction`.
pub const LOAD_DEPENDENT_FRICTION_LEVEL_PER_N: f64 = 0.01;
/// `load_N` of `load_dependent_friction`.
pub const LOAD_DEPENDENT_FRICTION_LOAD_N: f64 = 30.0;

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 58] = [
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
    CONSTANT_FORCE_FORCE_N,
    COULOMB_ASYMMETRY_ASYMMETRY,
    VISCOUS_ASYMMETRY_HALF_DIFFERENCE_N_S_PER_M,
    QUADRATIC_DRAG_DRAG_N_S2_PER_M2,
    STRIBECK_LEVEL,
    STRIBECK_VELOCITY_M_S,
    STRIBECK_EXPONENT,
    FRICTIONAL_LAG_LEVEL,
    FRICTIONAL_LAG_VELOCITY_M_S,
    FRICTIONAL_LAG_EXPONENT,
    FRICTIONAL_LAG_TIME_CONSTANT_S,
    POSITION_SPRING_STIFFNESS_N_PER_M,
    POSITION_SPRING_CENTRE_M,
    POSITION_FORCE_FROM_M,
    POSITION_FORCE_TO_M,
    POSITION_FORCE_COSINES[0],
    POSITION_FORCE_COSINES[1],
    POSITION_FORCE_COSINES[2],
    POSITION_FRICTION_FROM_M,
    POSITION_FRICTION_TO_M,
    POSITION_FRICTION_COSINES[0],
    POSITION_FRICTION_COSINES[1],
    LOCAL_FRICTION_SPOT_LEVEL,
    LOCAL_FRICTION_SPOT_POSITION_M,
    LOCAL_FRICTION_SPOT_WIDTH_M,
    PERIODIC_FORCE_FORCE_N,
    PERIODIC_FORCE_PERIOD_M,
    PERIODIC_FORCE_PHASE_RAD,
    PERIODIC_FORCE_2_FORCE_N,
    PERIODIC_FORCE_2_PERIOD_M,
    PERIODIC_FORCE_2_PHASE_RAD,
    PERIODIC_FRICTION_LEVEL,
    PERIODIC_FRICTION_PERIOD_M,
    PERIODIC_FRICTION_PHASE_RAD,
    ENCODER_ERROR_ERROR_M,
    ENCODER_ERROR_PERIOD_M,
    ENCODER_ERROR_PHASE_RAD,
    THERMAL_DRIFT_LEVEL_PER_K,
    THERMAL_DRIFT_TEMPERATURE_C,
    THERMAL_DRIFT_2_LEVEL,
    THERMAL_DRIFT_2_TIME_CONSTANT_S,
    DWELL_AGING_LEVEL_PER_DECADE,
    DWELL_AGING_TIME_CONSTANT_S,
    DWELL_AGING_ERASING_PATH_M,
    LOAD_DEPENDENT_FRICTION_LEVEL_PER_N,
    LOAD_DEPENDENT_FRICTION_LOAD_N,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0x166DDC91;

/// The effects beside the friction model.
pub type Effects<S = f32> = (
    (
        ::preslide::effects::Viscous<S>,
        ::preslide::effects::ConstantForce<S>,
        ::preslide::effects::CoulombAsymmetry<S>,
        ::preslide::effects::ViscousAsymmetry<S>,
        ::preslide::effects::QuadraticDrag<S>,
        ::preslide::effects::Stribeck<S>,
        ::preslide::effects::FrictionalLag<S>,
        ::preslide::effects::PositionSpring<S>,
    ),
    (
        ::preslide::effects::PositionForce<3, S>,
        ::preslide::effects::PositionFriction<2, S>,
        ::preslide::effects::LocalFrictionSpot<S>,
        ::preslide::effects::PeriodicForce<S>,
        ::preslide::effects::PeriodicForce<S>,
        ::preslide::effects::PeriodicFriction<S>,
        ::preslide::effects::EncoderError<S>,
        ::preslide::effects::ThermalDrift<S>,
    ),
    (
        ::preslide::effects::WarmUp<S>,
        ::preslide::effects::DwellAging<S>,
        ::preslide::effects::LoadDependentFriction<S>,
    ),
);

/// The friction model with its effects.
pub type Model<S = f32> = ::preslide::effects::With<::preslide::Gms<3, S>, Effects<S>>;

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
    parameters: &[f64; 58],
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
        constant_force_force_n,
        coulomb_asymmetry_asymmetry,
        viscous_asymmetry_half_difference_n_s_per_m,
        quadratic_drag_drag_n_s2_per_m2,
        stribeck_level,
        stribeck_velocity_m_s,
        stribeck_exponent,
        frictional_lag_level,
        frictional_lag_velocity_m_s,
        frictional_lag_exponent,
        frictional_lag_time_constant_s,
        position_spring_stiffness_n_per_m,
        position_spring_centre_m,
        position_force_from_m,
        position_force_to_m,
        position_force_cosines_0,
        position_force_cosines_1,
        position_force_cosines_2,
        position_friction_from_m,
        position_friction_to_m,
        position_friction_cosines_0,
        position_friction_cosines_1,
        local_friction_spot_level,
        local_friction_spot_position_m,
        local_friction_spot_width_m,
        periodic_force_force_n,
        periodic_force_period_m,
        periodic_force_phase_rad,
        periodic_force_2_force_n,
        periodic_force_2_period_m,
        periodic_force_2_phase_rad,
        periodic_friction_level,
        periodic_friction_period_m,
        periodic_friction_phase_rad,
        encoder_error_error_m,
        encoder_error_period_m,
        encoder_error_phase_rad,
        thermal_drift_level_per_k,
        thermal_drift_temperature_c,
        thermal_drift_2_level,
        thermal_drift_2_time_constant_s,
        dwell_aging_level_per_decade,
        dwell_aging_time_constant_s,
        dwell_aging_erasing_path_m,
        load_dependent_friction_level_per_n,
        load_dependent_friction_load_n,
    ] = *parameters;
    let friction = ::preslide::Gms::try_new(&[::preslide::Block { stiffness: stiffness_0, weight: weight_0 }, ::preslide::Block { stiffness: stiffness_1, weight: weight_1 }, ::preslide::Block { stiffness: stiffness_2, weight: weight_2 }], gms_breakaway_n, ::preslide::Sliding { coulomb: gms_coulomb_n, stribeck_velocity: gms_stribeck_velocity_m_s, stribeck_exponent: gms_stribeck_exponent, attraction: gms_attraction_n_per_s }, sample_time, units)?;
    let effects = (
        (
            ::preslide::effects::Viscous::try_new(viscous_n_s_per_m, FORCE_LIMIT, units)?,
            ::preslide::effects::ConstantForce::try_new(constant_force_force_n, units)?,
            ::preslide::effects::CoulombAsymmetry::try_new(coulomb_asymmetry_asymmetry)?,
            ::preslide::effects::ViscousAsymmetry::try_new(viscous_asymmetry_half_difference_n_s_per_m, FORCE_LIMIT, units)?,
            ::preslide::effects::QuadraticDrag::try_new(quadratic_drag_drag_n_s2_per_m2, FORCE_LIMIT, units)?,
            ::preslide::effects::Stribeck::try_new(stribeck_level, stribeck_velocity_m_s, stribeck_exponent, units)?,
            ::preslide::effects::FrictionalLag::try_new(frictional_lag_level, frictional_lag_velocity_m_s, frictional_lag_exponent, frictional_lag_time_constant_s, sample_time, units)?,
            ::preslide::effects::PositionSpring::try_new(position_spring_stiffness_n_per_m, position_spring_centre_m, FORCE_LIMIT, units)?,
        ),
        (
            ::preslide::effects::PositionForce::try_new(position_force_from_m, position_force_to_m, [position_force_cosines_0, position_force_cosines_1, position_force_cosines_2], units)?,
            ::preslide::effects::PositionFriction::try_new(position_friction_from_m, position_friction_to_m, [position_friction_cosines_0, position_friction_cosines_1], units)?,
            ::preslide::effects::LocalFrictionSpot::try_new(local_friction_spot_level, local_friction_spot_position_m, local_friction_spot_width_m, units)?,
            ::preslide::effects::PeriodicForce::try_new(periodic_force_force_n, periodic_force_period_m, periodic_force_phase_rad, units)?,
            ::preslide::effects::PeriodicForce::try_new(periodic_force_2_force_n, periodic_force_2_period_m, periodic_force_2_phase_rad, units)?,
            ::preslide::effects::PeriodicFriction::try_new(periodic_friction_level, periodic_friction_period_m, periodic_friction_phase_rad, units)?,
            ::preslide::effects::EncoderError::try_new(encoder_error_error_m, encoder_error_period_m, encoder_error_phase_rad, units)?,
            ::preslide::effects::ThermalDrift::try_new(thermal_drift_level_per_k, thermal_drift_temperature_c, LEVEL_LIMIT)?,
        ),
        (
            ::preslide::effects::WarmUp::try_new(thermal_drift_2_level, thermal_drift_2_time_constant_s, sample_time)?,
            ::preslide::effects::DwellAging::try_new(dwell_aging_level_per_decade, dwell_aging_time_constant_s, dwell_aging_erasing_path_m, 2.0, sample_time, units)?,
            ::preslide::effects::LoadDependentFriction::try_new(load_dependent_friction_level_per_n, load_dependent_friction_load_n, LEVEL_LIMIT, units)?,
        ),
    );
    ::preslide::effects::With::try_new(friction, effects)
}
