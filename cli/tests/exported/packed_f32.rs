// Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.
// Model packed.toml, SHA-256 ac8ac96305b109f320a76c651417a8c59c5b0ad6e3ec8a13c0122485e357c430.
// Model: the paper's Table 3, four blocks.

/// `breakaway_N` of `gms`.
pub const GMS_BREAKAWAY_N: f64 = 0.9;
/// Maxwell-slip blocks: `stiffness_N_per_m` and weight.
pub const BLOCKS: [::preslide::Block; 4] = [
    ::preslide::Block { stiffness: 313728.0, weight: 0.339 },
    ::preslide::Block { stiffness: 43670.0, weight: 0.236 },
    ::preslide::Block { stiffness: 10545.0, weight: 0.171 },
    ::preslide::Block { stiffness: 5858.0, weight: 0.253 },
];

/// The friction model.
pub type Model<S = f32> = ::preslide::kernels::Scaled<::preslide::kernels::PackedSlipReserve<2>, S>;

/// Builds the model, in which the sample time plays no part, computing in `units`.
///
/// # Errors
/// The parameter that does not fit the number type in `units`.
pub fn model<S: ::preslide::Scalar>(
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    <::preslide::kernels::Scaled<::preslide::kernels::PackedSlipReserve<2>, S>>::try_new(&BLOCKS, GMS_BREAKAWAY_N, units)
}
