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

/// The friction model.
pub type Model<S = f32> = ::preslide::Leuven<2, S>;

/// Builds the model, in which the sample time plays no part, computing in `units`.
///
/// # Errors
/// The parameter that does not fit the number type in `units`.
pub fn model<S: ::preslide::Scalar>(
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    ::preslide::Leuven::try_new(::preslide::LeuvenForm::Original, &BLOCKS, LEUVEN_ORIGINAL_BREAKAWAY_N, LEUVEN_ORIGINAL_EXPONENT, LEUVEN_ORIGINAL_DAMPING_N_S_PER_M, ::preslide::Sliding { coulomb: LEUVEN_ORIGINAL_COULOMB_N, stribeck_velocity: LEUVEN_ORIGINAL_STRIBECK_VELOCITY_M_S, stribeck_exponent: LEUVEN_ORIGINAL_STRIBECK_EXPONENT, attraction: LEUVEN_ORIGINAL_ATTRACTION_N_PER_S }, units)
}
