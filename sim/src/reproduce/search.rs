//! The best blocks for a curve: a grid of yields first, the best of its subsets refined.

use super::SIZES;
use preslide_fit::identify::refine;
use preslide_fit::identify::regression::{Exact, MaxwellSlipFit, Regression};
use preslide_fit::identify::search::{Choice, best_choices};
use preslide_fit::identify::weights::Weights;
use preslide_host::paper;
use std::ops::Range;

/// Yields in the grid of the global search, logarithmic …
const GRID: usize = 120;
/// … from here \[m\], a fifth of the first yield of Table 3, to [`paper::RANGE`].
const SHORTEST: f64 = 0.2e-6;

/// The search for the best blocks of a curve.
pub struct Search<'a> {
    regression: Regression<'a>,
    rows: Vec<usize>,
    grid: Vec<f64>,
    choices: Vec<Vec<Choice>>,
}

impl<'a> Search<'a> {
    /// On positions \[m\], contiguous in `pieces`, and the force \[N\] there. No yield is sought beyond the range: a block that
    /// never slips there would put its share of ΣW beyond the breakaway force.
    ///
    /// # Errors
    /// Where there are no samples.
    pub fn new(
        position: &'a [f64],
        pieces: &'a [Range<usize>],
        force: &[f64],
    ) -> Result<Self, String> {
        let rows: Vec<usize> = pieces.iter().cloned().flatten().collect();
        let regression = Regression {
            position,
            pieces,
            force: force.to_vec(),
            columns: Vec::new(),
            filter: Box::new(<[f64]>::to_vec),
            folds: vec![rows.clone()],
            weights: Weights::default(),
        };
        let grid: Vec<f64> = (0..GRID)
            .map(|j| SHORTEST * (paper::RANGE / SHORTEST).powf(j as f64 / (GRID - 1) as f64))
            .collect();
        let grams = regression.grams(&grid);
        let gram = grams.first().ok_or("the curve has no samples")?;
        let choices = best_choices(gram, 0, SIZES.end - 1);
        Ok(Self {
            regression,
            rows,
            grid,
            choices,
        })
    }

    /// The best `n` blocks, where there are any of positive stiffness: the best `refined` subsets of the grid compete.
    pub fn best(&self, n: usize, refined: usize) -> Option<MaxwellSlipFit> {
        self.choices
            .get(n.checked_sub(1)?)?
            .iter()
            .take(refined)
            .filter_map(|choice| {
                let start = choice.yields.iter().map(|&j| self.grid[j]).collect();
                let range = (SHORTEST, paper::RANGE);
                refine::refine(
                    &Exact {
                        regression: &self.regression,
                        rows: &self.rows,
                    },
                    start,
                    range,
                )
            })
            .min_by(|a, b| a.squared_error.total_cmp(&b.squared_error))
    }
}
