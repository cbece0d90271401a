//! Table 3 recovered from the ten-block curve by the paper's procedure (7)–(9).

use preslide_fit::identify::virgin::VirginCurve;
use preslide_host::paper::{BREAKAWAY, REFERENCE, TableColumn};

/// Half a unit of the last digit of the table's weights.
const HALF_DIGIT: f64 = 0.0005;

/// One block of a column, printed and recovered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecoveredBlock {
    /// Yield displacement `D_i` \[m\] of the table.
    pub yield_displacement: f64,
    /// `k_i` (N/m) of the table.
    pub stiffness_printed: f64,
    /// `k_i` (N/m) by (7)–(8).
    pub stiffness: f64,
    /// `α_i` (-) of the table.
    pub weight_printed: f64,
    /// `α_i` (-) by (9).
    pub weight: f64,
    /// Relative deviation of `k_i` (-) that the three digits of the weights may cause, both in this column and in
    /// the ten-block one. To first order, all digits at their worst.
    pub rounding: f64,
}

impl RecoveredBlock {
    /// Relative deviation of the recovered from the printed stiffness (-); that of the weight is the same, since
    /// (9) is linear in `k_i`.
    pub fn deviation(&self) -> f64 {
        self.stiffness / self.stiffness_printed - 1.0
    }
}

/// One column of Table 3, printed and recovered.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovery {
    /// Its blocks.
    pub blocks: Vec<RecoveredBlock>,
    /// Largest relative deviation of a stiffness (-) when the curve is the 2,001 samples with straight lines
    /// between them, which cut the corners at the breakpoints.
    pub sampled_deviation: f64,
    /// Where the column leaves the ten-block curve furthest at one of its own breakpoints: that breakpoint \[m\]
    /// and the column's force less the curve's \[N\].
    pub furthest: (f64, f64),
}

impl Recovery {
    /// Largest relative deviation of a stiffness (-).
    pub fn largest_deviation(&self) -> f64 {
        largest(self.blocks.iter().map(|b| b.deviation()))
    }

    /// The sum of the table's weights.
    pub fn printed_sum(&self) -> f64 {
        self.blocks.iter().map(|b| b.weight_printed).sum()
    }

    /// Whether the digits of the table explain every deviation.
    pub fn explained_by_rounding(&self) -> bool {
        self.blocks
            .iter()
            .all(|b| b.deviation().abs() <= b.rounding + 1e-9)
    }
}

/// The ten-block curve by its corners, exact everywhere up to the last yield and constant beyond.
pub fn exact_curve(weights: &[f64]) -> VirginCurve {
    let stiffness = REFERENCE.stiffness();
    let corners: Vec<f64> = yields(&stiffness, weights);
    let displacement: Vec<f64> = [0.0].into_iter().chain(corners.iter().copied()).collect();
    let force = displacement
        .iter()
        .map(|&x| force_at(&stiffness, &corners, x))
        .collect();
    VirginCurve {
        displacement,
        force,
    }
}

/// Applies (7)–(9) to the curve at the column's own breakpoints.
///
/// # Errors
/// Where the curve is not concave at these breakpoints, so that fewer blocks come back.
pub fn recover(column: &TableColumn, sampled: &VirginCurve) -> Result<Recovery, String> {
    let printed = column.stiffness();
    let (weights, reference_weights) = (column.weights(), REFERENCE.weights());
    let exact = exact_curve(&reference_weights);
    let d = column.yields();
    let found = stiffness_at(&exact, &d)?;
    let rounding = rounding(column, &found)?;
    let blocks = (0..column.size())
        .map(|i| RecoveredBlock {
            yield_displacement: d[i],
            stiffness_printed: printed[i],
            stiffness: found[i],
            weight_printed: weights[i],
            weight: found[i] * d[i] / BREAKAWAY,
            rounding: rounding[i] / printed[i],
        })
        .collect();
    let from_samples = stiffness_at(sampled, &d)?;
    let furthest = d
        .iter()
        .map(|&x| (x, force_at(&printed, &d, x) - exact.at(x)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or_default();
    Ok(Recovery {
        blocks,
        sampled_deviation: largest(from_samples.iter().zip(&printed).map(|(a, b)| a / b - 1.0)),
        furthest,
    })
}

/// By how much (N/m) each recovered stiffness may move when every weight moves by half its last digit.
fn rounding(column: &TableColumn, found: &[f64]) -> Result<Vec<f64>, String> {
    let printed = column.stiffness();
    let reference = REFERENCE.weights();
    let mut sum = vec![0.0; column.size()];
    let mut add_worst = |moved: [Vec<f64>; 2]| {
        for (i, sum) in sum.iter_mut().enumerate() {
            *sum += (moved[0][i] - found[i])
                .abs()
                .max((moved[1][i] - found[i]).abs());
        }
    };
    let moved = |weights: &[f64], j: usize, by: f64| {
        let mut weights = weights.to_vec();
        weights[j] += by;
        weights
    };
    let exact = exact_curve(&reference);
    for j in 0..column.size() {
        let at = |by| stiffness_at(&exact, &yields(&printed, &moved(&column.weights(), j, by)));
        add_worst([at(-HALF_DIGIT)?, at(HALF_DIGIT)?]);
    }
    for j in 0..reference.len() {
        let at = |by| stiffness_at(&exact_curve(&moved(&reference, j, by)), &column.yields());
        add_worst([at(-HALF_DIGIT)?, at(HALF_DIGIT)?]);
    }
    Ok(sum)
}

fn stiffness_at(curve: &VirginCurve, breakpoints: &[f64]) -> Result<Vec<f64>, String> {
    let blocks = curve.blocks(breakpoints);
    if blocks.len() == breakpoints.len() {
        Ok(blocks.into_iter().map(|b| b.1).collect())
    } else {
        Err(format!(
            "eqs. (7)–(9) give {} blocks at {} breakpoints: the curve is not concave there",
            blocks.len(),
            breakpoints.len()
        ))
    }
}

fn yields(stiffness: &[f64], weights: &[f64]) -> Vec<f64> {
    let pairs = stiffness.iter().zip(weights);
    pairs.map(|(k, weight)| weight * BREAKAWAY / k).collect()
}

/// Virgin force \[N\] of Maxwell-slip blocks at the displacement `x` \[m\].
fn force_at(stiffness: &[f64], yields: &[f64], x: f64) -> f64 {
    stiffness
        .iter()
        .zip(yields)
        .map(|(k, d)| k * x.min(*d))
        .sum()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}
