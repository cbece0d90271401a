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

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 4] = [
    BOUC_WEN_STIFFNESS_N_PER_M,
    BOUC_WEN_COULOMB_N,
    BOUC_WEN_EXPONENT,
    BOUC_WEN_SHAPE,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0xB21626B1;

/// The friction model.
pub type Model<S = f32> = ::preslide::BoucWen<S>;

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
    parameters: &[f64; 4],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        bouc_wen_stiffness_n_per_m,
        bouc_wen_coulomb_n,
        bouc_wen_exponent,
        bouc_wen_shape,
    ] = *parameters;
    ::preslide::BoucWen::try_new(bouc_wen_stiffness_n_per_m, bouc_wen_coulomb_n, bouc_wen_exponent, bouc_wen_shape, units)
}
