// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model leuven.toml, SHA-256 fb1917d7f87a229c7b8463ef953b673bf2d3b3abf0e6b3162d200499dea53e3d.

/// `breakaway_N` of `leuven_original`.
pub const LEUVEN_ORIGINAL_BREAKAWAY_N: f64 = 0.9;
/// `exponent` of `leuven_original`.
pub const LEUVEN_ORIGINAL_EXPONENT: f64 = 2.0;
/// `damping_N_s_per_m` of `leuven_original`.
pub const LEUVEN_ORIGINAL_DAMPING_N_S_PER_M: f64 = 1.0;
/// `coulomb_N` of `leuven_original`.
pub const LEUVEN_ORIGINAL_COULOMB_N: f64 = 0.8;
/// `stribeck_velocity_m_s` of `leuven_original`.
pub const LEUVEN_ORIGINAL_STRIBECK_VELOCITY_M_S: f64 = 0.001;
/// `stribeck_exponent` of `leuven_original`.
pub const LEUVEN_ORIGINAL_STRIBECK_EXPONENT: f64 = 2.0;
/// `attraction_N_per_s` of `leuven_original`.
pub const LEUVEN_ORIGINAL_ATTRACTION_N_PER_S: f64 = 40.0;
/// Maxwell-slip blocks: `stiffness_N_per_m` and weight.
pub const BLOCKS: [::preslide::Block; 2] = [
    ::preslide::Block { stiffness: 113948.0, weight: 0.616 },
    ::preslide::Block { stiffness: 8870.0, weight: 0.384 },
];

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 11] = [
    LEUVEN_ORIGINAL_BREAKAWAY_N,
    LEUVEN_ORIGINAL_EXPONENT,
    LEUVEN_ORIGINAL_DAMPING_N_S_PER_M,
    LEUVEN_ORIGINAL_COULOMB_N,
    LEUVEN_ORIGINAL_STRIBECK_VELOCITY_M_S,
    LEUVEN_ORIGINAL_STRIBECK_EXPONENT,
    LEUVEN_ORIGINAL_ATTRACTION_N_PER_S,
    BLOCKS[0].stiffness,
    BLOCKS[0].weight,
    BLOCKS[1].stiffness,
    BLOCKS[1].weight,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0xD28DB6F6;

/// The friction model.
pub type Model<S = f32> = ::preslide::Leuven<2, S>;

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
    parameters: &[f64; 11],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        leuven_original_breakaway_n,
        leuven_original_exponent,
        leuven_original_damping_n_s_per_m,
        leuven_original_coulomb_n,
        leuven_original_stribeck_velocity_m_s,
        leuven_original_stribeck_exponent,
        leuven_original_attraction_n_per_s,
        stiffness_0,
        weight_0,
        stiffness_1,
        weight_1,
    ] = *parameters;
    ::preslide::Leuven::try_new(::preslide::LeuvenForm::Original, &[::preslide::Block { stiffness: stiffness_0, weight: weight_0 }, ::preslide::Block { stiffness: stiffness_1, weight: weight_1 }], leuven_original_breakaway_n, leuven_original_exponent, leuven_original_damping_n_s_per_m, ::preslide::Sliding { coulomb: leuven_original_coulomb_n, stribeck_velocity: leuven_original_stribeck_velocity_m_s, stribeck_exponent: leuven_original_stribeck_exponent, attraction: leuven_original_attraction_n_per_s }, units)
}
