// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model plain.toml, SHA-256 535d5c199821e67eb0aee4839521c0150cc475e3aee32a9f1dd344b4e62f2a53.

/// `breakaway_N` of `gms`.
pub const GMS_BREAKAWAY_N: f64 = 0.9;
/// Maxwell-slip blocks: `stiffness_N_per_m` and weight.
pub const BLOCKS: [::preslide::Block; 2] = [
    ::preslide::Block { stiffness: 113948.0, weight: 0.616 },
    ::preslide::Block { stiffness: 8870.0, weight: 0.384 },
];

/// The friction model.
pub type Model<S = f32> = ::preslide::QuasiStaticGms<2, S>;

/// Builds the model, in which the sample time plays no part, computing in `units`.
///
/// # Errors
/// The parameter that does not fit the number type in `units`.
pub fn model<S: ::preslide::Scalar>(
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    ::preslide::QuasiStaticGms::try_new(&BLOCKS, GMS_BREAKAWAY_N, units)
}
