//! Table 3 of the paper: GMS parameters for 2 to 10 blocks; Hsieh's of Table 2, and a Stribeck curve, which it has none of.

use preslide::{Block, HsiehParams, Sliding};

/// Breakaway force of the paper's stage (N).
pub const BREAKAWAY: f64 = 0.9;

/// `(k_i (N/m), α_i)` of the model with `blocks` blocks. The column for one block is not the paper's: one spring
/// that yields at 20 µm. Panics for other numbers than 1 to 10.
pub fn column(blocks: usize) -> &'static [(f64, f64)] {
    match blocks {
        1 => &[(45_000.0, 1.0)],
        2 => &[(113_948.0, 0.616), (8_870.0, 0.384)],
        3 => &[(325_379.0, 0.352), (40_535.0, 0.307), (7_886.0, 0.341)],
        4 => &[
            (313_728.0, 0.339),
            (43_670.0, 0.236),
            (10_545.0, 0.171),
            (5_858.0, 0.253),
        ],
        5 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (29_198.0, 0.158),
            (10_545.0, 0.171),
            (5_858.0, 0.253),
        ],
        6 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (29_198.0, 0.158),
            (9_503.0, 0.154),
            (2_604.0, 0.084),
            (4_295.0, 0.186),
        ],
        7 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (24_903.0, 0.135),
            (10_349.0, 0.112),
            (4_295.0, 0.093),
            (1_759.0, 0.057),
            (4_295.0, 0.186),
        ],
        8 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (24_903.0, 0.135),
            (8_590.0, 0.093),
            (3_517.0, 0.057),
            (1_927.0, 0.042),
            (1_985.0, 0.054),
            (4_678.0, 0.202),
        ],
        9 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (24_903.0, 0.135),
            (8_590.0, 0.093),
            (3_517.0, 0.057),
            (1_927.0, 0.042),
            (1_219.0, 0.033),
            (1_149.0, 0.037),
            (4_295.0, 0.186),
        ],
        10 => &[
            (270_313.0, 0.292),
            (57_886.0, 0.125),
            (24_903.0, 0.135),
            (8_590.0, 0.093),
            (3_517.0, 0.057),
            (1_927.0, 0.042),
            (1_219.0, 0.033),
            (841.0, 0.027),
            (616.0, 0.023),
            (3_987.0, 0.173),
        ],
        _ => panic!("Table 3 has no column for {blocks} blocks"),
    }
}

/// The same as the library's parameters.
pub fn blocks<const N: usize>() -> [Block; N] {
    let column = column(N);
    std::array::from_fn(|i| Block {
        stiffness: column[i].0,
        weight: column[i].1,
    })
}

/// Table 2; `C_v` (N·s/m) has no unit there, and without `ρ` (1/s) nothing creeps.
pub const fn hsieh(viscous: f64, creep: f64) -> HsiehParams {
    HsiehParams {
        k1: 51_540.0,
        k2: 2_026_400.0,
        beta: 3_216_500.0,
        viscous,
        creep,
        hardening: 31_200.0,
        hardening_exponent: 3.22,
    }
}

/// A fall to the Coulomb force (N) over 1 mm/s, followed with an attraction (N/s).
pub const fn falling(coulomb: f64, attraction: f64) -> Sliding {
    Sliding {
        coulomb,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 2.0,
        attraction,
    }
}
