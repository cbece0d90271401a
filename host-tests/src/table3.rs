//! Table 3 of the paper: GMS parameters for 2 to 10 blocks; Hsieh's of Table 2, and a Stribeck curve, which it has none of.

// Plain data, which `preslide-host` holds; this crate does not depend on that one.
#[path = "../../host/src/paper/table_3.rs"]
mod printed;

use preslide::{Block, HsiehParams, Sliding};

/// Breakaway force of the paper's stage (N).
pub const BREAKAWAY: f64 = 0.9;

/// `(k_i (N/m), α_i)` of the model with `blocks` blocks. The column for one block is not the paper's: one spring
/// that yields at 20 µm. Panics for other numbers than 1 to 10.
pub fn column(blocks: usize) -> &'static [(f64, f64)] {
    match blocks {
        1 => &[(45_000.0, 1.0)],
        2..=10 => printed::TABLE_3[blocks - 2],
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
