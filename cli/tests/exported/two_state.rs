// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model two_state.toml, SHA-256 f07a68f1a1787d85cca5a170b2ed0a23dcbff1ce104bb9641c16494cff685d6e.

/// `presliding_m` of `two_state`.
pub const TWO_STATE_PRESLIDING_M: f64 = 3.5e-5;
/// `breakaway_N` of `two_state`.
pub const TWO_STATE_BREAKAWAY_N: f64 = 0.9;
/// `coulomb_N` of `two_state`.
pub const TWO_STATE_COULOMB_N: f64 = 0.8;
/// `stribeck_velocity_m_s` of `two_state`.
pub const TWO_STATE_STRIBECK_VELOCITY_M_S: f64 = 0.001;
/// `stribeck_exponent` of `two_state`.
pub const TWO_STATE_STRIBECK_EXPONENT: f64 = 2.0;
/// `attraction_N_per_s` of `two_state`.
pub const TWO_STATE_ATTRACTION_N_PER_S: f64 = 40.0;

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 6] = [
    TWO_STATE_PRESLIDING_M,
    TWO_STATE_BREAKAWAY_N,
    TWO_STATE_COULOMB_N,
    TWO_STATE_STRIBECK_VELOCITY_M_S,
    TWO_STATE_STRIBECK_EXPONENT,
    TWO_STATE_ATTRACTION_N_PER_S,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0x2231C366;

/// The friction model.
pub type Model<S = f32> = ::preslide::TwoState<S>;

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
    parameters: &[f64; 6],
    sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        two_state_presliding_m,
        two_state_breakaway_n,
        two_state_coulomb_n,
        two_state_stribeck_velocity_m_s,
        two_state_stribeck_exponent,
        two_state_attraction_n_per_s,
    ] = *parameters;
    ::preslide::TwoState::try_new(two_state_presliding_m, two_state_breakaway_n, ::preslide::Sliding { coulomb: two_state_coulomb_n, stribeck_velocity: two_state_stribeck_velocity_m_s, stribeck_exponent: two_state_stribeck_exponent, attraction: two_state_attraction_n_per_s }, sample_time, units)
}
