//! Lifted states of a recording, each with a reason, and the map between them of which only what is not known is learnt.

use super::edmd::{Map, Moments};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Seed of the thin plates' centres.
pub const SEED: u64 = 48;

/// What is predicted, what drives it, and what the contacts remember; evenly sampled.
pub struct Series {
    /// Position (m or rad) from its mean.
    pub position: Vec<f64>,
    /// What is learnt: the displacement of the last sample (m or rad) where a force drives, the friction (N or N·m) where a motion does.
    pub output: Vec<f64>,
    /// What acts until the next sample: the mean force, or the displacement.
    pub input: Vec<f64>,
    /// A force drives.
    pub forced: bool,
    /// Deflections (m or rad) of the identified blocks along the measured motion, block by block.
    pub deflections: Vec<Vec<f64>>,
}

/// Which functions lift a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dictionary {
    /// Samples of the output, the present one included, and of the input: what a drive's mode and a filter remember. At least 1.
    pub delays: usize,
    /// The identified blocks' deflections.
    pub blocks: bool,
    /// Thin plates `r²·ln r` about so many centres, as in the reference.
    pub plates: usize,
}

impl Dictionary {
    /// In words.
    pub fn name(&self) -> &'static str {
        match (self.blocks, self.plates) {
            (false, 0) => "ARX",
            (true, 0) => "Koopman, blocks",
            (false, _) => "Koopman, thin plates",
            (true, _) => "Koopman, blocks and thin plates",
        }
    }
}

/// A dictionary over a series: `[x, output and delays, delayed inputs, 1, deflections, plates]`.
pub struct Lift<'a> {
    series: &'a Series,
    dictionary: Dictionary,
    /// Centres of the plates, and what scales position, output and deflections to them.
    centres: Vec<[f64; 2]>,
    spread: [f64; 2],
}

impl<'a> Lift<'a> {
    /// Scaled to the samples that are fitted.
    pub fn new(series: &'a Series, dictionary: Dictionary, fitted: Range<usize>) -> Self {
        let root_mean_square = |values: &[f64]| {
            let squares: f64 = values.iter().map(|v| v * v).sum();
            (squares / values.len() as f64)
                .sqrt()
                .max(f64::MIN_POSITIVE)
        };
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        // Over what a sample takes twice its root mean square to leave.
        let mut centre = || [(); 2].map(|()| rng.random_range(-2.0..2.0));
        Self {
            centres: (0..dictionary.plates).map(|_| centre()).collect(),
            spread: [
                root_mean_square(&series.position[fitted.clone()]),
                root_mean_square(&series.output[fitted]),
            ],
            series,
            dictionary,
        }
    }

    fn blocks(&self) -> &[Vec<f64>] {
        match self.dictionary.blocks {
            true => &self.series.deflections,
            false => &[],
        }
    }

    /// States before the deflections.
    fn linear(&self) -> usize {
        2 * self.dictionary.delays + 1
    }

    /// Number of lifted states.
    pub fn states(&self) -> usize {
        self.linear() + self.blocks().len() + self.dictionary.plates
    }

    /// The row that is judged: the position where a force drives, the friction where a motion does.
    pub fn judged(&self) -> usize {
        usize::from(!self.series.forced)
    }

    /// The lifted state at a sample, which has `delays` before it.
    pub fn at(&self, k: usize) -> DVector<f64> {
        let (s, d) = (self.series, self.dictionary.delays);
        let (position, output) = (s.position[k], s.output[k]);
        let place = [position / self.spread[0], output / self.spread[1]];
        let plate = |c: &[f64; 2]| {
            let square = (place[0] - c[0]).powi(2) + (place[1] - c[1]).powi(2);
            0.5 * square * square.max(f64::MIN_POSITIVE).ln()
        };
        let states = std::iter::once(position)
            .chain((0..d).map(|i| s.output[k - i]))
            .chain((1..d).map(|i| s.input[k - i]))
            .chain([1.0])
            .chain(self.blocks().iter().map(|block| block[k]))
            .chain(self.centres.iter().map(plate));
        DVector::from_iterator(self.states(), states)
    }

    /// The moments of a stretch.
    pub fn moments(&self, fitted: Range<usize>) -> Moments {
        let from = fitted.start + self.dictionary.delays;
        let columns: Vec<DVector<f64>> = (from..fitted.end).map(|k| self.at(k)).collect();
        let state = DMatrix::from_columns(&columns[..columns.len() - 1]);
        let learnt = self.learnt();
        let next = DMatrix::from_fn(learnt.len(), state.ncols(), |i, k| {
            columns[k + 1][learnt[i]]
        });
        let input = &self.series.input[from..fitted.end - 1];
        Moments::of(
            &state,
            &DMatrix::from_row_slice(1, input.len(), input),
            &next,
        )
    }

    /// Rows that are not known: the output, deflections and plates.
    fn learnt(&self) -> Vec<usize> {
        std::iter::once(1)
            .chain(self.linear()..self.states())
            .collect()
    }

    /// The whole map from what was learnt: a position is the sum of displacements, a delay shifts, 1 stays.
    pub fn whole(&self, learnt: &Map) -> Map {
        let (n, d) = (self.states(), self.dictionary.delays);
        let mut map = Map {
            a: DMatrix::zeros(n, n),
            b: DMatrix::zeros(n, 1),
        };
        for (i, row) in self.learnt().into_iter().enumerate() {
            map.a.row_mut(row).copy_from(&learnt.a.row(i));
            map.b.row_mut(row).copy_from(&learnt.b.row(i));
        }
        if self.series.forced {
            map.a.row_mut(0).copy_from(&learnt.a.row(0));
        }
        map.b[(0, 0)] = if self.series.forced {
            learnt.b[(0, 0)]
        } else {
            1.0
        };
        map.a[(0, 0)] += 1.0;
        for i in 2..=d {
            map.a[(i, i - 1)] = 1.0;
        }
        for i in d + 2..2 * d {
            map.a[(i, i - 1)] = 1.0;
        }
        if d > 1 {
            map.b[(d + 1, 0)] = 1.0;
        }
        map.a[(2 * d, 2 * d)] = 1.0;
        map
    }

    /// What the map says of the judged row after 1, 2, … `steps` samples from each start; a row for each start.
    pub fn roll(&self, map: &Map, starts: &[usize], steps: usize) -> DMatrix<f64> {
        let columns: Vec<_> = starts.iter().map(|s| self.at(*s)).collect();
        let mut state = DMatrix::from_columns(&columns);
        let mut said = DMatrix::zeros(starts.len(), steps);
        for step in 0..steps {
            let input = starts.iter().map(|s| self.series.input[s + step]);
            let input = DMatrix::from_row_iterator(1, starts.len(), input);
            state = &map.a * state + &map.b * input;
            let judged = state.row(self.judged()).transpose();
            said.column_mut(step).copy_from(&judged);
        }
        said
    }
}
