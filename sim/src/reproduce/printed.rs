//! Why the paper's absolute errors differ: what its printed figures can and cannot mean.

use super::Curve;
use preslide_fit::statistics::nmse;
use preslide_host::paper;

/// A printed NMSE beside the largest one that Table 3 admits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Number of blocks.
    pub n: usize,
    /// NMSE (%) that the paper prints.
    pub printed: f64,
    /// Highest NMSE (%) against any measured curve that the best printed size fits as well as printed.
    pub highest: f64,
}

/// Bounds every printed NMSE by the triangle inequality.
///
/// NMSE (13) is a squared distance. A measured curve `m` that the 7-block column fits to the printed 0.1 % lies
/// within `√0.1 %` of it, so that column `N` can be no further from `m` than `√0.1 % + ‖F_N − F_7‖`, whatever the
/// unpublished samples were, as long as they are spread evenly over the same displacements.
///
/// # Errors
/// A parameter that the library refuses.
pub fn bounds(curve: &Curve) -> Result<Vec<Bound>, String> {
    let Some(&(best_n, best)) = paper::PRINTED_NMSE
        .iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
    else {
        return Ok(Vec::new());
    };
    // The text prints one digit: 0.1 stands for anything below 0.15.
    let best = best + 0.05;
    let force_of = |n: usize| -> Result<Vec<f64>, String> {
        let column = paper::TABLE_3.iter().find(|column| column.size() == n);
        curve.force_of(&column.ok_or("no such column")?.model())
    };
    let fitted = force_of(best_n)?;
    // With b the best NMSE: ‖m − F_best‖ ≤ √b·σ_m, so σ_m ≥ σ_best/(1 + √b), and ‖m − F_N‖/σ_m follows.
    let near = (best / 100.0).sqrt();
    paper::PRINTED_NMSE
        .iter()
        .filter(|(n, _)| *n != best_n)
        .map(|&(n, printed)| {
            let between = nmse(&fitted, &force_of(n)?, &curve.rows());
            let farthest = near + (1.0 + near) * (between / 100.0).sqrt();
            Ok(Bound {
                n,
                printed,
                highest: 100.0 * farthest * farthest,
            })
        })
        .collect()
}
