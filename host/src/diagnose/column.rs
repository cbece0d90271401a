//! What a further column is. Only another axis's motion couples to this one: a current, a command or somebody's prediction is this axis's
//! effort once more, and explains anything.

use nalgebra::{DMatrix, DVector};

/// Correlation, at some lag, from which a column is the effort up to scale and noise.
const ALIKE: f64 = 0.9;
/// Share of a column that this axis's own motion explains from which it is that motion, or an effort that follows it.
const OWN: f64 = 0.8;
/// Longest lag between the effort and its copy (s), and places within.
const LAG_S: f64 = 0.05;
const LAGS: i32 = 25;
/// Most samples that are looked at.
const MOST: usize = 20_000;
/// Share of the highest speed over which a direction changes.
const SMALL: f64 = 0.02;

/// What a further column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something of its own, which may be another axis's motion.
    Other,
    /// This axis's own motion, or what follows from it.
    OwnMotion,
    /// This axis's effort.
    Effort,
}

/// What a column is compared with.
pub struct Own<'a> {
    /// Position, velocity and acceleration of the axis.
    pub motion: [&'a [f64]; 3],
    /// Its effort.
    pub effort: &'a [f64],
    /// Sample time (s).
    pub dt: f64,
}

impl Kind {
    /// In words, behind the column's name.
    pub fn words(self) -> &'static str {
        match self {
            Kind::Other => "is a column of its own",
            Kind::OwnMotion => "follows from this axis's own position, velocity and acceleration",
            Kind::Effort => "is the effort itself, up to scale, delay and noise",
        }
    }

    /// What a column is.
    pub fn of(values: &[f64], own: &Own) -> Self {
        let step = values.len().div_ceil(MOST).max(1);
        let lag_step = (LAG_S / own.dt / f64::from(LAGS)).ceil().max(1.0) as i32;
        let most = (LAG_S / own.dt) as i32;
        let alike = (-most..=most)
            .step_by(lag_step as usize)
            .any(|lag| correlation(values, own.effort, lag, step).abs() >= ALIKE);
        if alike {
            return Kind::Effort;
        }
        match own.explains(values, step) {
            Some(share) if share >= OWN => Kind::OwnMotion,
            _ => Kind::Other,
        }
    }
}

impl Own<'_> {
    /// Share of a column's variance that the axis's own motion explains: position and its square, velocity, acceleration, direction.
    fn explains(&self, values: &[f64], step: usize) -> Option<f64> {
        let [x, v, a] = self.motion;
        let top = v.iter().fold(f64::MIN_POSITIVE, |top, v| top.max(v.abs()));
        let rows: Vec<usize> = (0..values.len()).step_by(step).collect();
        let of = |i: usize| {
            let direction = (v[i] / (SMALL * top)).tanh();
            [
                x[i],
                x[i] * x[i],
                x[i].sin(),
                x[i].cos(),
                v[i],
                a[i],
                direction,
            ]
        };
        let count = 7;
        let mut matrix = DMatrix::from_fn(rows.len(), count, |k, j| of(rows[k])[j]);
        for mut column in matrix.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
            let norm = column.norm().max(1e-300);
            column.unscale_mut(norm);
        }
        let mut target = DVector::from_fn(rows.len(), |k, _| values[rows[k]]);
        let mean = target.mean();
        target.add_scalar_mut(-mean);
        let gram = matrix.tr_mul(&matrix) + DMatrix::from_diagonal_element(count, count, 1e-9);
        let right = matrix.tr_mul(&target);
        let solved = gram.cholesky()?.solve(&right);
        Some(right.dot(&solved) / target.norm_squared().max(1e-300))
    }
}

/// Correlation of one column with another that is `lag` samples later.
fn correlation(a: &[f64], b: &[f64], lag: i32, step: usize) -> f64 {
    let n = a.len().min(b.len());
    let off = lag.unsigned_abs() as usize;
    if off >= n {
        return 0.0;
    }
    let (from_a, from_b) = if lag >= 0 { (0, off) } else { (off, 0) };
    let pairs = || {
        (0..n - off)
            .step_by(step)
            .map(move |i| (a[from_a + i], b[from_b + i]))
    };
    let count = pairs().count().max(1) as f64;
    let (sum_a, sum_b) = pairs().fold((0.0, 0.0), |(p, q), (a, b)| (p + a, q + b));
    let (mean_a, mean_b) = (sum_a / count, sum_b / count);
    let (mut square_a, mut square_b, mut product) = (0.0, 0.0, 0.0);
    for (a, b) in pairs() {
        square_a += (a - mean_a).powi(2);
        square_b += (b - mean_b).powi(2);
        product += (a - mean_a) * (b - mean_b);
    }
    product / (square_a * square_b).sqrt().max(1e-300)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis with inertia and friction for 20 s at 1 kHz, and what columns may stand beside it.
    #[test]
    fn only_another_motion_is_a_column_of_its_own() {
        let t: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-3).collect();
        let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { t.iter().map(|t| f(*t)).collect() };
        let (x, v, a) = (
            of(&|t| (2.0 * t).sin()),
            of(&|t| 2.0 * (2.0 * t).cos()),
            of(&|t| -4.0 * (2.0 * t).sin()),
        );
        let force = |t: f64| -1.2 * (2.0 * t).sin() + (2.0 * t).cos().signum();
        let noise = |t: f64| 0.2 * (1e4 * t * t).sin();
        let own = Own {
            motion: [&x, &v, &a],
            effort: &of(&|t| force(t) + noise(t)),
            dt: 1e-3,
        };
        let kind = |f: &dyn Fn(f64) -> f64| Kind::of(&of(f), &own);
        assert_eq!(kind(&|t| 0.3 * force(t - 0.011)), Kind::Effort);
        assert_eq!(kind(&|t| -7.0 * force(t) + 0.5), Kind::Effort);
        assert_eq!(kind(&|t| (2.0 * (t + 0.02)).sin()), Kind::OwnMotion);
        assert_eq!(kind(&|t| (1.3 * t).sin()), Kind::Other);
        assert_eq!(
            kind(&|t| (0.7 * t).cos() + 0.4 * (2.0 * t).sin()),
            Kind::Other
        );
    }
}
