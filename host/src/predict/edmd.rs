//! Extended dynamic mode decomposition with control: a linear map between lifted states, by least squares with a ridge.

use nalgebra::DMatrix;

/// Sums over pairs of a sample and the next one, from which a map follows for any ridge. Columns are samples.
pub struct Moments {
    /// Of states and inputs, scaled to a mean square of 1.
    gram: DMatrix<f64>,
    cross: DMatrix<f64>,
    scale: Vec<f64>,
    states: usize,
}

/// `ψ⁺ = A·ψ + B·u`, or some rows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// `A`, rows × states.
    pub a: DMatrix<f64>,
    /// `B`, rows × inputs.
    pub b: DMatrix<f64>,
}

impl Moments {
    /// Of `state` (states × samples), `input` (inputs × samples) and what of the next state is to be learnt, `next` (rows × samples).
    pub fn of(state: &DMatrix<f64>, input: &DMatrix<f64>, next: &DMatrix<f64>) -> Self {
        let (states, inputs, samples) = (state.nrows(), input.nrows(), state.ncols());
        let mut rows = DMatrix::zeros(states + inputs, samples);
        rows.rows_mut(0, states).copy_from(state);
        rows.rows_mut(states, inputs).copy_from(input);
        let mut scale = Vec::new();
        for mut row in rows.row_iter_mut() {
            let mean_square = row.norm_squared() / samples as f64;
            scale.push(mean_square.sqrt().max(f64::MIN_POSITIVE).recip());
            row *= scale[scale.len() - 1];
        }
        Self {
            gram: &rows * rows.transpose() / samples as f64,
            cross: next * rows.transpose() / samples as f64,
            scale,
            states,
        }
    }

    /// The map that leaves the least squares plus `ridge` (-) times those of the scaled coefficients: Tikhonov's `(G + λI)⁻¹`, as in
    /// Korda and Mezić, arXiv 1611.03537, eq. 21 with a ridge. `None` where the normal equations cannot be solved.
    pub fn map(&self, ridge: f64) -> Option<Map> {
        let n = self.gram.nrows();
        let factor = (&self.gram + DMatrix::from_diagonal_element(n, n, ridge)).cholesky()?;
        let mut all = factor.solve(&self.cross.transpose()).transpose();
        for (mut column, scale) in all.column_iter_mut().zip(&self.scale) {
            column *= *scale;
        }
        Some(Map {
            a: all.columns(0, self.states).into_owned(),
            b: all.columns(self.states, n - self.states).into_owned(),
        })
    }
}
