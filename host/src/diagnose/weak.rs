//! The weak form: every column is averaged with one compact kernel and thinned out.
//!
//! With `φ(t) = (1 − (t/h)²)⁴` a derivative of a column passes to the kernel, `φ∗ẍ = φ̈∗x`: a quantised encoder is never
//! differentiated, and as all columns pass the same kernel nothing is biased by it. (A finite difference would: it smooths an
//! acceleration by a triangle of variance Δt²/6, which looks like an elastic drive of some 300 Hz.)

use super::signals::Signals;
use std::ops::Range;

/// Most rows kept: more would cost time and show nothing new.
const ROWS: usize = 20_000;

/// The kernel and where its rows are.
pub struct Weak {
    /// The kernel and its first two derivatives.
    kernels: [Vec<f64>; 3],
    /// Sample at the centre of each row, ascending within each fold.
    pub centres: Vec<usize>,
    /// Rows of each fold.
    pub folds: Vec<Range<usize>>,
    /// Half-width of the kernel (s).
    pub half_width_s: f64,
    /// Samples between two rows.
    pub spacing: usize,
}

impl Weak {
    /// Chooses the kernel: about 25 ms wide, wider where the encoder's noise asks for it (−6 dB at the band of the
    /// kinematics), never below four samples. `inertial` says whether an acceleration is needed at all, `usable` which samples
    /// a row may be centred at.
    pub fn new(s: &Signals, inertial: bool, usable: &[bool]) -> Self {
        let by_band = if inertial { 0.62 / s.band_hz } else { 0.0 };
        // What no row is centred at, as a rest, must not blur the others.
        let moving = usable.iter().filter(|u| **u).count();
        let by_rows = moving as f64 * s.dt / ROWS as f64;
        let half_s = by_band.max(12.5e-3).max(by_rows);
        let half = ((half_s / s.dt).round() as usize).max(4);
        let kernels = kernels(half, s.dt);
        // Neighbours overlap little: white noise stays white.
        let spacing = half;
        let mut by_fold: Vec<Vec<usize>> = vec![Vec::new(); s.folds];
        for piece in &s.pieces {
            let first = piece.start + half + 1;
            let last = piece.end.saturating_sub(half + 1);
            for centre in (first..last).step_by(spacing).filter(|c| usable[*c]) {
                by_fold[s.fold[centre]].push(centre);
            }
        }
        by_fold.retain(|rows| !rows.is_empty());
        let mut folds = Vec::new();
        let mut centres = Vec::new();
        for rows in by_fold {
            folds.push(centres.len()..centres.len() + rows.len());
            centres.extend(rows);
        }
        Self {
            kernels,
            centres,
            folds,
            half_width_s: half as f64 * s.dt,
            spacing,
        }
    }

    /// The column, or its first or second derivative, as rows.
    pub fn rows(&self, column: &Column) -> Vec<f64> {
        let parts = [&column.value, &column.sloped, &column.curved];
        let mut rows = vec![0.0; self.centres.len()];
        for (part, kernel) in parts.into_iter().zip(&self.kernels) {
            if part.is_empty() {
                continue;
            }
            let half = kernel.len() / 2;
            for (row, &c) in rows.iter_mut().zip(&self.centres) {
                *row += part[c - half..=c + half]
                    .iter()
                    .zip(kernel)
                    .map(|(v, k)| v * k)
                    .sum::<f64>();
            }
        }
        rows
    }

    /// The value at the centre of each row.
    pub fn at_centres(&self, column: &[f64]) -> Vec<f64> {
        self.centres.iter().map(|&c| column[c]).collect()
    }
}

/// A column at the sample rate: `value + d(sloped)/dt + d²(curved)/dt²`, the latter two empty where there is none.
#[derive(Clone, Default)]
pub struct Column {
    /// Added as it is.
    pub value: Vec<f64>,
    /// Added by its first derivative.
    pub sloped: Vec<f64>,
    /// Added by its second derivative.
    pub curved: Vec<f64>,
}

impl Column {
    /// A column without derivatives.
    pub fn of(value: Vec<f64>) -> Self {
        Self {
            value,
            ..Self::default()
        }
    }
}

/// `φ`, `−φ̇` and `φ̈` as weights of samples, exact on polynomials of the second degree.
fn kernels(half: usize, dt: f64) -> [Vec<f64>; 3] {
    let h = (half as f64 + 0.5) * dt;
    let times: Vec<f64> = (0..=2 * half)
        .map(|i| (i as f64 - half as f64) * dt)
        .collect();
    let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { times.iter().map(|t| f(t / h)).collect() };
    let moment = |k: &[f64], power: i32| -> f64 {
        k.iter().zip(&times).map(|(k, t)| k * t.powi(power)).sum()
    };
    let scaled = |mut k: Vec<f64>, power: i32, to: f64| {
        let factor = to / moment(&k, power);
        k.iter_mut().for_each(|k| *k *= factor);
        k
    };
    let value = scaled(of(&|u| (1.0 - u * u).powi(4)), 0, 1.0);
    let slope = scaled(of(&|u| u * (1.0 - u * u).powi(3)), 1, 1.0);
    let mut curve = of(&|u| (7.0 * u * u - 1.0) * (1.0 - u * u).powi(2));
    let mean = moment(&curve, 0);
    curve
        .iter_mut()
        .zip(&value)
        .for_each(|(c, v)| *c -= mean * v);
    [value, slope, scaled(curve, 2, 2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_derive_sines_as_the_first_smooths_them() {
        let (half, dt) = (6, 2e-3);
        let [value, slope, curve] = kernels(half, dt);
        for hertz in [1.0, 5.0, 15.0] {
            let w = std::f64::consts::TAU * hertz;
            let over = |k: &[f64], f: &dyn Fn(f64) -> f64| -> f64 {
                k.iter()
                    .enumerate()
                    .map(|(i, k)| k * f((i as f64 - half as f64) * dt))
                    .sum()
            };
            let passed = over(&value, &|t| (w * t).cos());
            let first = over(&slope, &|t| (w * t).sin()) / w;
            let second = -over(&curve, &|t| (w * t).cos()) / (w * w);
            assert!(
                (first / passed - 1.0).abs() < 1e-3,
                "{hertz} Hz: {first} {passed}"
            );
            assert!(
                (second / passed - 1.0).abs() < 1e-3,
                "{hertz} Hz: {second} {passed}"
            );
        }
    }
}
