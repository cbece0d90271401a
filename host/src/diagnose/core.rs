//! The over-resolved core: inertia and a fine set of Maxwell-slip blocks, and the friction that effects act through.

use super::blocks::{between_samples, deflection, yields};
use super::effect::{Baseline, Scene};
use super::normal::Bound;
use super::rows::Rows;
use super::signals::quantile;
use super::term::Term;
use super::weak::Column;
use rayon::prelude::*;
use std::sync::Arc;

/// Share of a block's yield beyond which it is said to slip.
const SLIPS: f64 = 0.999;

/// Inertia and blocks.
pub struct Core {
    /// Yield displacements (m or rad).
    pub yields: Vec<f64>,
    /// Inertia where the effort contains it, then the blocks, at the rows.
    pub rows: Arc<Vec<Vec<f64>>>,
    /// It stands for what a simulation's inertia and friction lack, which may be less than nothing.
    pub corrects: bool,
    /// Deflections of the blocks at the samples.
    deflections: Vec<Vec<f64>>,
}

impl Core {
    /// The blocks whose yields lie between two displacements.
    pub fn new(rows: &Rows) -> Self {
        let yields = yields(&rows.s);
        let (fine, pieces) = between_samples(&rows.s);
        let deflections: Vec<Vec<f64>> = yields
            .par_iter()
            .map(|&d| deflection(&fine, &pieces, d))
            .collect();
        let mut columns: Vec<Vec<f64>> = deflections
            .par_iter()
            .map(|z| rows.weak.rows(&Column::of(z.clone())))
            .collect();
        if rows.inertial {
            let curved = rows.s.x.clone();
            columns.insert(
                0,
                rows.weak.rows(&Column {
                    curved,
                    ..Column::default()
                }),
            );
        }
        Self {
            yields,
            rows: Arc::new(columns),
            corrects: false,
            deflections,
        }
    }

    /// Inertia and stiffness are not negative; their errors may be.
    pub fn bounds(&self) -> Vec<Bound> {
        let bound = if self.corrects {
            Bound::Free
        } else {
            Bound::NonNegative
        };
        vec![bound; self.rows.len()]
    }

    /// Blocks that take part, from the coefficients of the core's columns: stiffness and yield displacement.
    pub fn blocks(&self, coefficients: &[f64]) -> Vec<(f64, f64)> {
        let first = self.rows.len() - self.yields.len();
        let stiffness = coefficients[first..self.rows.len()].iter();
        stiffness
            .zip(&self.yields)
            .map(|(k, d)| (*k, *d))
            .filter(|b| b.0 > 0.0)
            .collect()
    }

    /// The model that effects act through, from the coefficients of the core's columns and of `terms` behind them.
    pub fn baseline(
        &self,
        rows: &Rows,
        coefficients: &[f64],
        terms: &[Term],
        before: &Baseline,
    ) -> Baseline {
        let s = &rows.s;
        let first = self.rows.len() - self.yields.len();
        let mass = if rows.inertial { coefficients[0] } else { 0.0 };
        let n = s.x.len();
        let (mut friction, mut slipping, mut stiffness) =
            (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for (j, z) in self.deflections.iter().enumerate() {
            let (k, d) = (coefficients[first + j], self.yields[j]);
            if k <= 0.0 {
                continue;
            }
            for (i, z) in z.iter().enumerate() {
                friction[i] += k * z;
                if z.abs() >= SLIPS * d {
                    slipping[i] += k * z;
                } else {
                    stiffness[i] += k;
                }
            }
        }
        let mut fitted: Vec<f64> = friction
            .iter()
            .zip(&s.a)
            .map(|(f, a)| f + mass * a)
            .collect();
        let scene = Scene {
            s,
            core: before,
            effort: &rows.effort,
        };
        let mut next = self.rows.len();
        for term in terms {
            for column in term.columns(&scene) {
                let c = coefficients[next];
                next += 1;
                if !term.acts_on_effort() && !column.value.is_empty() {
                    fitted
                        .iter_mut()
                        .zip(&column.value)
                        .for_each(|(f, v)| *f += c * v);
                }
            }
        }
        let size: Vec<f64> = friction.iter().map(|f| f.abs()).collect();
        Baseline {
            mass,
            blocks: self.blocks(coefficients),
            level: quantile(&size, 0.9).max(1e-300),
            friction,
            slipping,
            stiffness,
            fitted,
        }
    }
}
