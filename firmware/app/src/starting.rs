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

/// The parameters in the order in which a running controller can be sent others.
pub const PARAMETERS: [f64; 9] = [
    GMS_BREAKAWAY_N,
    BLOCKS[0].stiffness,
    BLOCKS[0].weight,
    BLOCKS[1].stiffness,
    BLOCKS[1].weight,
    BLOCKS[2].stiffness,
    BLOCKS[2].weight,
    BLOCKS[3].stiffness,
    BLOCKS[3].weight,
];
/// Which they are: the same for models of the same parts.
#[allow(dead_code)] // for firmware that takes models over the link
pub const LAYOUT: u32 = 0x85C348E8;

/// The friction model.
pub type Model<S = f32> = ::preslide::QuasiStaticGms<4, S>;

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
    parameters: &[f64; 9],
    _sample_time: f64,
    units: ::preslide::Units,
) -> ::core::result::Result<Model<S>, ::preslide::ParamError> {
    let [
        gms_breakaway_n,
        stiffness_0,
        weight_0,
        stiffness_1,
        weight_1,
        stiffness_2,
        weight_2,
        stiffness_3,
        weight_3,
    ] = *parameters;
    ::preslide::QuasiStaticGms::try_new(&[::preslide::Block { stiffness: stiffness_0, weight: weight_0 }, ::preslide::Block { stiffness: stiffness_1, weight: weight_1 }, ::preslide::Block { stiffness: stiffness_2, weight: weight_2 }, ::preslide::Block { stiffness: stiffness_3, weight: weight_3 }], gms_breakaway_n, units)
}
