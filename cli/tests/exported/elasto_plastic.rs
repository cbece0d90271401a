// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model elasto_plastic.toml, SHA-256 c65182fcf1ed53c3f8a0438e01f8964aaeeb3d355e5412cedf1515d1d0ae0709.

/// `stiffness_N_per_m` of `elasto_plastic`.
pub const ELASTO_PLASTIC_STIFFNESS_N_PER_M: f64 = 195000.0;
/// `damping_N_s_per_m` of `elasto_plastic`.
pub const ELASTO_PLASTIC_DAMPING_N_S_PER_M: f64 = 1.0;
/// `elastic_m` of `elasto_plastic`.
pub const ELASTO_PLASTIC_ELASTIC_M: f64 = 1.5e-6;
/// `breakaway_N` of `elasto_plastic`.
pub const ELASTO_PLASTIC_BREAKAWAY_N: f64 = 0.9;
/// `coulomb_N` of `elasto_plastic`.
pub const ELASTO_PLASTIC_COULOMB_N: f64 = 0.8;
/// `stribeck_velocity_m_s` of `elasto_plastic`.
pub const ELASTO_PLASTIC_STRIBECK_VELOCITY_M_S: f64 = 0.001;
/// `stribeck_exponent` of `elasto_plastic`.
pub const ELASTO_PLASTIC_STRIBECK_EXPONENT: f64 = 2.0;
/// `attraction_N_per_s` of `elasto_plastic`.
pub const ELASTO_PLASTIC_ATTRACTION_N_PER_S: f64 = 40.0;

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 8] = [
    ELASTO_PLASTIC_STIFFNESS_N_PER_M,
    ELASTO_PLASTIC_DAMPING_N_S_PER_M,
    ELASTO_PLASTIC_ELASTIC_M,
    ELASTO_PLASTIC_BREAKAWAY_N,
    ELASTO_PLASTIC_COULOMB_N,
    ELASTO_PLASTIC_STRIBECK_VELOCITY_M_S,
    ELASTO_PLASTIC_STRIBECK_EXPONENT,
    ELASTO_PLASTIC_ATTRACTION_N_PER_S,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0x85A95BFF;

/// The friction model.
pub type Model<S = f32> = ::preslide::ElastoPlastic<S>;

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
    parameters: &[f64; 8],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        elasto_plastic_stiffness_n_per_m,
        elasto_plastic_damping_n_s_per_m,
        elasto_plastic_elastic_m,
        elasto_plastic_breakaway_n,
        elasto_plastic_coulomb_n,
        elasto_plastic_stribeck_velocity_m_s,
        elasto_plastic_stribeck_exponent,
        elasto_plastic_attraction_n_per_s,
    ] = *parameters;
    ::preslide::ElastoPlastic::try_new(elasto_plastic_stiffness_n_per_m, elasto_plastic_damping_n_s_per_m, elasto_plastic_elastic_m, elasto_plastic_breakaway_n, ::preslide::Sliding { coulomb: elasto_plastic_coulomb_n, stribeck_velocity: elasto_plastic_stribeck_velocity_m_s, stribeck_exponent: elasto_plastic_stribeck_exponent, attraction: elasto_plastic_attraction_n_per_s }, units)
}
