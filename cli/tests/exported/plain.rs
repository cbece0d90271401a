// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model plain.toml, SHA-256 535d5c199821e67eb0aee4839521c0150cc475e3aee32a9f1dd344b4e62f2a53.

/// `breakaway_N` of `gms`.
pub const GMS_BREAKAWAY_N: f64 = 0.9;
/// Maxwell-slip blocks: `stiffness_N_per_m` and weight.
pub const BLOCKS: [::preslide::Block; 2] = [
    ::preslide::Block { stiffness: 113948.0, weight: 0.616 },
    ::preslide::Block { stiffness: 8870.0, weight: 0.384 },
];

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 5] = [
    GMS_BREAKAWAY_N,
    BLOCKS[0].stiffness,
    BLOCKS[0].weight,
    BLOCKS[1].stiffness,
    BLOCKS[1].weight,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0xF2CB7FB6;

/// The friction model.
pub type Model<S = f32> = ::preslide::QuasiStaticGms<2, S>;

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
    parameters: &[f64; 5],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        gms_breakaway_n,
        stiffness_0,
        weight_0,
        stiffness_1,
        weight_1,
    ] = *parameters;
    ::preslide::QuasiStaticGms::try_new(&[::preslide::Block { stiffness: stiffness_0, weight: weight_0 }, ::preslide::Block { stiffness: stiffness_1, weight: weight_1 }], gms_breakaway_n, units)
}
