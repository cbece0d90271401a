//! What the paper prints: Tables 2 and 3 and the errors it quotes.
//!
//! E. Kamenar and S. Zelenika, "Issues in validation of pre-sliding friction models for ultra-high precision
//! positioning", Part C: Journal of Mechanical Engineering Science, manuscript JMES-17-1227.R1.

mod table_3;

use preslide::{Block, HsiehParams, Sliding};
use preslide_fit::friction::FrictionModel;

/// Breakaway force `F_s` \[N\]: Table 2, LuGre column; the text says "up to ~0.9 N". Table 3 is normalised by it.
pub const BREAKAWAY: f64 = 0.9;

/// End of the pre-sliding range \[m\]: the text says "displacements of up to 30–40 µm". Every yield of Table 3 lies
/// below it.
pub const RANGE: f64 = 40e-6;

/// Load resolution of the micro-tensile machine \[N\] ("Experimental set-up").
pub const LOAD_RESOLUTION: f64 = 0.010;

/// NMSE (13) (%) that the text quotes, by number of blocks: "~ 14 %", "~ 3 %", "0,5 %", "0,1 %". Figure 8 shows
/// the other sizes, as a picture only.
pub const PRINTED_NMSE: [(usize, f64); 4] = [(3, 14.0), (4, 3.0), (6, 0.5), (7, 0.1)];

/// One column of Table 3 (printed as two rows, `k_i` (N/m) and `α_i` (-)), for one number of blocks.
#[derive(Clone, Copy, Debug)]
pub struct TableColumn {
    /// `(k_i, α_i)` in (N/m) and (-).
    pub blocks: &'static [(f64, f64)],
}

/// Table 3: 2 to 10 blocks.
pub const TABLE_3: [TableColumn; 9] = {
    let mut columns = [TableColumn { blocks: &[] }; 9];
    let mut i = 0;
    while i < columns.len() {
        columns[i].blocks = table_3::TABLE_3[i];
        i += 1;
    }
    columns
};

/// The column that stands for the measured curve.
pub const REFERENCE: TableColumn = TABLE_3[8];

impl TableColumn {
    /// Number of blocks `N`.
    pub fn size(&self) -> usize {
        self.blocks.len()
    }

    /// `k_i` (N/m).
    pub fn stiffness(&self) -> Vec<f64> {
        self.blocks.iter().map(|b| b.0).collect()
    }

    /// `α_i` (-).
    pub fn weights(&self) -> Vec<f64> {
        self.blocks.iter().map(|b| b.1).collect()
    }

    /// `D_i = α_i·F_s/k_i` \[m\], eq. (9) solved for `D_i`; ascending.
    pub fn yields(&self) -> Vec<f64> {
        self.blocks
            .iter()
            .map(|(k, weight)| weight * BREAKAWAY / k)
            .collect()
    }

    /// The quasi-static GMS model with these parameters.
    pub fn model(&self) -> FrictionModel {
        FrictionModel::Gms {
            breakaway: BREAKAWAY,
            blocks: self
                .blocks
                .iter()
                .map(|&(stiffness, weight)| Block { stiffness, weight })
                .collect(),
            sliding: None,
        }
    }
}

/// Table 2, Dahl: `σ0` 320 000 N/m, `F_C` 0.9 N, `n` 1.6.
pub fn dahl() -> FrictionModel {
    FrictionModel::Dahl {
        stiffness: 320_000.0,
        coulomb: 0.9,
        exponent: 1.6,
    }
}

/// Table 2, LuGre: `σ0` 195 000 N/m, `σ_p` 4416, `F_C = F_s` = 0.9 N.
///
/// The table prints N/m for `σ_p`; it multiplies `dz/dt` in (3), so its unit is N·s/m. With `F_C = F_s` the curve
/// `s(v)` is constant and needs no Stribeck velocity, of which none is printed.
pub fn lugre() -> FrictionModel {
    FrictionModel::LuGre {
        stiffness: 195_000.0,
        damping: 4416.0,
        breakaway: BREAKAWAY,
        sliding: Sliding::none(BREAKAWAY),
    }
}

/// Table 2, Hsieh: `k_1s`, `k_2s` (N/m), `C_v`, `β`, `ρ`, `ψ`, `a`.
///
/// The table prints no unit for the last five; (4)–(6) make them N·s/m, 1/m, 1/s, Nᵃ/m and 1. With the printed `ψ`
/// the plastic module moves `0.9ᵃ/ψ` = 23 µm at breakaway, most of the pre-sliding range.
pub fn hsieh() -> FrictionModel {
    FrictionModel::Hsieh(HsiehParams {
        k1: 51_540.0,
        k2: 2_026_400.0,
        viscous: 5000.0,
        beta: 3_216_500.0,
        creep: 500.0,
        hardening: 31_200.0,
        hardening_exponent: 3.22,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against a slip of the pen: sizes, ascending yields inside the range, and the sums of weights that
    /// the documentation states.
    #[test]
    fn the_table_is_well_formed() {
        for (i, column) in TABLE_3.iter().enumerate() {
            let n = i + 2;
            assert_eq!(column.size(), n);
            let yields = column.yields();
            assert!(yields.windows(2).all(|pair| pair[0] < pair[1]), "N = {n}");
            assert!(yields.iter().all(|&d| d < RANGE), "N = {n}");
            let sum: f64 = column.weights().iter().sum();
            let expected = if (4..=6).contains(&n) { 0.999 } else { 1.0 };
            assert!((sum - expected).abs() < 1e-9, "N = {n}: {sum}");
        }
    }
}
