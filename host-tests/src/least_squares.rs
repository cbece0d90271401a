//! Least squares for judges, apart from the tool's own.

use nalgebra::{DMatrix, DVector};

/// Coefficients of the columns over some rows, with a ridge of 1e-9 of the diagonal against columns that move alike; none without rows.
pub fn least_squares(rows: &[Vec<f64>], effort: &[f64], which: &[usize]) -> Option<Vec<f64>> {
    let n = rows.first()?.len();
    let (mut normal, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for &i in which {
        let row = DVector::from_column_slice(&rows[i]);
        normal.ger(1.0, &row, &row, 1.0);
        right.axpy(effort[i], &row, 1.0);
    }
    for j in 0..n {
        normal[(j, j)] = normal[(j, j)] * (1.0 + 1e-9) + f64::MIN_POSITIVE;
    }
    let solved = normal.cholesky()?.solve(&right);
    Some(solved.iter().copied().collect())
}
