// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model bouc_wen.toml, SHA-256 c6a9be468728f164146a871bbbb4644f8e15fb2ff5f81a925f65939c92468601.

/// `stiffness_N_per_m` of `bouc_wen`.
pub const BOUC_WEN_STIFFNESS_N_PER_M: f64 = 320000.0;
/// `coulomb_N` of `bouc_wen`.
pub const BOUC_WEN_COULOMB_N: f64 = 0.9;
/// `exponent` of `bouc_wen`.
pub const BOUC_WEN_EXPONENT: f64 = 1.6;
/// `shape` of `bouc_wen`.
pub const BOUC_WEN_SHAPE: f64 = 0.75;

/// The friction model.
pub type Model<S = f32> = ::preslide::BoucWen<S>;

/// Builds the model, in which the sample time plays no part, computing in `units`.
///
/// # Errors
/// The parameter that does not fit the number type in `units`.
pub fn model<S: ::preslide::Scalar>(
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    ::preslide::BoucWen::try_new(BOUC_WEN_STIFFNESS_N_PER_M, BOUC_WEN_COULOMB_N, BOUC_WEN_EXPONENT, BOUC_WEN_SHAPE, units)
}
