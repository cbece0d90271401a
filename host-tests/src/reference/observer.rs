//! A mass under a disturbance that walks at random, estimated by least squares over everything that was read: no filter, no Riccati
//! equation.

use nalgebra::{DMatrix, DVector};

/// What is known of the mass, the disturbance and the readings (SI).
#[derive(Clone, Copy, Debug)]
pub struct WalkingDisturbance {
    /// Time from one reading to the next (s).
    pub sample_time: f64,
    /// Mass (kg).
    pub mass: f64,
    /// What brakes it (N·s/m).
    pub braking: f64,
    /// Variance of a reading (m²).
    pub reading: f64,
    /// Variance of the disturbance's change from one reading to the next (N²).
    pub change: f64,
}

impl WalkingDisturbance {
    /// Velocity and disturbance at the last of `readings` (m), of which the first is at the start of `forces[0]` (N, held for a sample
    /// time): the trajectory that makes `Σ (reading error)²/R + Σ (change)²/Q` least. The disturbance opposes positive motion.
    pub fn estimate(&self, readings: &[f64], forces: &[f64]) -> (f64, f64) {
        let n = readings.len();
        // Unknown: position, velocity and disturbance at the start, then every change. Each is one column; what the known forces do
        // by themselves is taken off the readings.
        let columns = [
            self.answer(n, 1.0, 0.0, |_| 0.0),
            self.answer(n, 0.0, 1.0, |_| 0.0),
            self.answer(n, 0.0, 0.0, |_| -1.0),
        ];
        // A change before reading k acts on readings from k + 1 on; all of them are one answer, shifted.
        let step = columns[2].clone();
        let free = self.answer(n, 0.0, 0.0, |k| forces[k]);
        let size = 2 + n;
        let design = DMatrix::from_fn(n, size, |row, column| match column {
            0..3 => columns[column].0[row],
            _ => {
                let since = column - 2;
                if row >= since {
                    step.0[row - since]
                } else {
                    0.0
                }
            }
        });
        let seen = DVector::from_fn(n, |row, _| readings[row] - free.0[row]);
        // Columns of very different size: each is scaled to its own.
        let scale: Vec<f64> = (0..size)
            .map(|column| match column {
                0..3 => design.column(column).norm(),
                _ => (self.reading / self.change).sqrt(),
            })
            .collect();
        let scaled = DMatrix::from_fn(n, size, |row, column| design[(row, column)] / scale[column]);
        let mut normal = scaled.transpose() * &scaled;
        for column in 3..size {
            normal[(column, column)] += 1.0;
        }
        let solved = normal
            .cholesky()
            .expect("three readings and more determine it")
            .solve(&(scaled.transpose() * seen));
        let found = |column: usize| solved[column] / scale[column];
        let velocity = free.1
            + (0..size)
                .map(|column| match column {
                    0..3 => found(column) * columns[column].1,
                    _ => found(column) * self.speed_after(n - 1 - (column - 2)),
                })
                .sum::<f64>();
        let disturbance = found(2) + (3..size).map(found).sum::<f64>();
        (velocity, disturbance)
    }

    /// Positions at each reading, and the last velocity, from a position and a velocity under forces.
    fn answer(&self, n: usize, x: f64, v: f64, force: impl Fn(usize) -> f64) -> (Vec<f64>, f64) {
        let (mut x, mut v) = (x, v);
        let mut positions = vec![x];
        for k in 0..n - 1 {
            (x, v) = self.held(x, v, force(k));
            positions.push(x);
        }
        (positions, v)
    }

    /// Velocity so many sample times after a disturbance of 1 N began.
    fn speed_after(&self, ticks: usize) -> f64 {
        -(1.0 - (-self.rate() * ticks as f64 * self.sample_time).exp()) / self.braking
    }

    fn rate(&self) -> f64 {
        self.braking / self.mass
    }

    /// `m·v′ = F − b·v`, exactly.
    fn held(&self, x: f64, v: f64, force: f64) -> (f64, f64) {
        let (t, rate, settled) = (self.sample_time, self.rate(), force / self.braking);
        let left = (-rate * t).exp();
        let travelled = settled * t + (v - settled) * (1.0 - left) / rate;
        (x + travelled, settled + (v - settled) * left)
    }
}
