//! The over-resolved core: inertia, a fine set of Maxwell-slip blocks and one of Dahl's bristles, and the friction that effects act through.

use super::blocks::{as_blocks, bend, between_samples, deflection, lengths, yields};
use super::effect::{Baseline, Scene};
use super::normal::Bound;
use super::rows::Rows;
use super::term::Term;
use super::weak::Column;
use crate::statistics::quantile_between_ranks;
use rayon::prelude::*;
use std::sync::Arc;

/// Share of a block's yield beyond which it is said to slip.
const SLIPS: f64 = 0.999;

/// Inertia, blocks and bristles.
pub struct Core {
    /// Yield displacements of the blocks (m or rad).
    yields: Vec<f64>,
    /// Relaxation lengths of the bristles (m or rad).
    bristles: Vec<f64>,
    /// Inertia where the effort contains it, then the blocks, then the bristles, at the rows.
    pub rows: Arc<Vec<Vec<f64>>>,
    /// It stands for what a simulation's inertia and friction lack, which may be less than nothing.
    pub corrects: bool,
    /// Deflections of blocks and bristles at the samples.
    deflections: Vec<Vec<f64>>,
}

impl Core {
    /// Blocks and bristles whose lengths a recording can tell.
    pub fn new(rows: &Rows) -> Self {
        let yields = yields(&rows.s);
        let bristles = lengths(&yields);
        let (fine, pieces) = between_samples(&rows.s);
        let blocks = yields.par_iter().map(|&d| deflection(&fine, &pieces, d));
        let bent = bristles.par_iter().map(|&d| bend(&fine, &pieces, d));
        let deflections: Vec<Vec<f64>> = blocks.chain(bent).collect();
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
            bristles,
            rows: Arc::new(columns),
            corrects: false,
            deflections,
        }
    }

    /// The same for what a simulation lacks: blocks alone, since with either sign bristles would cancel them.
    pub fn correcting(mut self) -> Self {
        let kept = self.rows.len() - self.bristles.len();
        Arc::make_mut(&mut self.rows).truncate(kept);
        self.deflections.truncate(self.yields.len());
        self.bristles.clear();
        self.corrects = true;
        self
    }

    /// Its first column of friction, behind the inertia's where the effort contains it.
    pub fn first_of_friction(&self) -> usize {
        self.rows.len() - self.deflections.len()
    }

    /// What each column of friction reaches in sliding, for a stiffness of one (m or rad).
    pub fn reaches(&self) -> impl Iterator<Item = f64> {
        self.yields.iter().chain(&self.bristles).copied()
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

    /// Blocks that take part, from the coefficients of the core's columns: stiffness and yield displacement. Bristles stand for as many
    /// as follow them after long strokes.
    pub fn blocks(&self, coefficients: &[f64]) -> Vec<(f64, f64)> {
        let stiffness = &coefficients[self.first_of_friction()..self.rows.len()];
        let (blocks, bristles) = stiffness.split_at(self.yields.len());
        let active = |(k, d): (&f64, &f64)| (*k > 0.0).then_some((*k, *d));
        let blocks = blocks.iter().zip(&self.yields).filter_map(active);
        let bristles = bristles.iter().zip(&self.bristles).filter_map(active);
        blocks.chain(bristles.flat_map(as_blocks)).collect()
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
        let first = self.first_of_friction();
        let mass = if rows.inertial { coefficients[0] } else { 0.0 };
        let n = s.x.len();
        let (mut friction, mut slipping, mut stiffness) =
            (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for ((j, z), d) in self.deflections.iter().enumerate().zip(self.reaches()) {
            let k = coefficients[first + j];
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
            level: quantile_between_ranks(&size, 0.9).max(1e-300),
            friction,
            slipping,
            stiffness,
            fitted,
        }
    }
}
