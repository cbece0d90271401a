//! The over-resolved core: inertia, a fine set of Maxwell-slip blocks and one of Dahl's bristles, friction without hysteresis, and the friction that effects act through.

use super::blocks::{as_blocks, bend, between_samples, deflection, lengths, yields};
use super::effect::{Baseline, Scene};
use super::normal::Bound;
use super::rows::Rows;
use super::signals::Signals;
use super::term::Term;
use super::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::signal::SMOOTH;
use preslide_fit::statistics::quantile_between_ranks;
use rayon::prelude::*;
use std::sync::Arc;

/// Share of a block's yield beyond which it is said to slip.
pub(super) const SLIPS: f64 = 0.999;

/// Inertia, blocks, bristles, and friction that follows velocity alone.
pub struct Core {
    /// Yield displacements of the blocks (m or rad).
    yields: Vec<f64>,
    /// Relaxation lengths of the bristles (m or rad).
    bristles: Vec<f64>,
    /// Inertia where the effort contains it, then the blocks, then the bristles, at the rows.
    pub rows: Arc<Vec<Vec<f64>>>,
    /// It stands for what a simulation's inertia and friction lack, which may be less than nothing.
    pub corrects: bool,
    /// Speeds (m/s or rad/s) over which friction that follows velocity alone reverses.
    smooth: Vec<f64>,
    /// Deflections of blocks and bristles (m or rad), and `tanh(v/v₀)` (-), at the samples.
    deflections: Vec<Vec<f64>>,
}

impl Core {
    /// Blocks and bristles whose lengths a recording can resolve, blocks of the yields `fitted` (m or rad) among them.
    pub fn new(rows: &Rows, fitted: Option<&[f64]>) -> Self {
        let yields = yields(&rows.s, fitted);
        let bristles = lengths(&yields);
        let top = rows.s.moving_speed(0.95).max(1e-300);
        Self::along(
            rows,
            yields,
            bristles,
            SMOOTH.map(|share| share * top).to_vec(),
        )
    }

    /// The same along another motion.
    pub fn moved(&self, rows: &Rows) -> Self {
        let (yields, bristles) = (self.yields.clone(), self.bristles.clone());
        Self::along(rows, yields, bristles, self.smooth.clone())
    }

    fn along(rows: &Rows, yields: Vec<f64>, bristles: Vec<f64>, smooth: Vec<f64>) -> Self {
        let (fine, pieces) = between_samples(&rows.s);
        let blocks = yields.par_iter().map(|&d| deflection(&fine, &pieces, d));
        let bent = bristles.par_iter().map(|&d| bend(&fine, &pieces, d));
        let sloped = smooth.par_iter().map(|&slow| follows(&rows.s, slow));
        let deflections: Vec<Vec<f64>> = blocks.chain(bent).chain(sloped).collect();
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
            smooth,
            deflections,
        }
    }

    /// The same without friction that follows velocity alone.
    pub fn hysteretic(&self) -> Self {
        let kept = self.deflections.len() - self.smooth.len();
        Self {
            yields: self.yields.clone(),
            bristles: self.bristles.clone(),
            rows: Arc::new(self.rows[..self.rows.len() - self.smooth.len()].to_vec()),
            corrects: self.corrects,
            smooth: Vec::new(),
            deflections: self.deflections[..kept].to_vec(),
        }
    }

    /// The same for what a simulation lacks: blocks alone, since with either sign bristles would cancel them; and the simulation's own friction
    /// where that follows velocity alone, reversing over the speed `smooth` (m/s or rad/s): that it has too much of.
    pub fn correcting(mut self, rows: &Rows, smooth: Option<f64>) -> Self {
        let kept = self.rows.len() - self.bristles.len() - self.smooth.len();
        let own = Arc::make_mut(&mut self.rows);
        own.truncate(kept);
        self.deflections.truncate(self.yields.len());
        self.bristles.clear();
        self.smooth = smooth.into_iter().collect();
        for slow in &self.smooth {
            let follows = follows(&rows.s, *slow);
            own.push(rows.weak.rows(&Column::of(follows.clone())));
            self.deflections.push(follows);
        }
        self.corrects = true;
        self
    }

    /// Speed (m/s or rad/s) over which a column of friction reverses, counted from the first of them; `None` for blocks and bristles.
    pub fn smooth_of(&self, column: usize) -> Option<f64> {
        let first = self.deflections.len() - self.smooth.len();
        column.checked_sub(first).map(|own| self.smooth[own])
    }

    /// The speed (m/s or rad/s) over which the friction of a simulation reverses, where that follows velocity alone.
    pub fn simulated_law(&self) -> Option<f64> {
        self.smooth.first().copied().filter(|_| self.corrects)
    }

    /// Whether part of the recording's friction follows velocity alone.
    pub fn follows_velocity(&self) -> bool {
        !self.smooth.is_empty() && !self.corrects
    }

    /// Its first column of friction, behind the inertia's where the effort contains it.
    pub fn first_of_friction(&self) -> usize {
        self.rows.len() - self.deflections.len()
    }

    /// What each column of friction reaches in sliding, for a coefficient of one (m or rad; – for what follows velocity alone).
    pub fn reaches(&self) -> impl Iterator<Item = f64> {
        let smooth = std::iter::repeat_n(1.0, self.smooth.len());
        self.yields
            .iter()
            .chain(&self.bristles)
            .copied()
            .chain(smooth)
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
    /// as follow them after long strokes; for what follows velocity alone, one that yields at once.
    pub fn blocks(&self, coefficients: &[f64]) -> Vec<(f64, f64)> {
        let friction = &coefficients[self.first_of_friction()..self.rows.len()];
        let (blocks, others) = friction.split_at(self.yields.len());
        let (bristles, smooth) = others.split_at(self.bristles.len());
        let active = |(k, d): (&f64, &f64)| (*k > 0.0).then_some((*k, *d));
        let blocks = blocks.iter().zip(&self.yields).filter_map(active);
        let bristles = bristles.iter().zip(&self.bristles).filter_map(active);
        let level: f64 = smooth.iter().sum();
        let at_once = self.yields.first().map(|d| (level / d, *d));
        blocks
            .chain(bristles.flat_map(as_blocks))
            .chain(at_once.filter(|b| b.0 > 0.0))
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
            let follows_velocity = j >= self.deflections.len() - self.smooth.len();
            for (i, z) in z.iter().enumerate() {
                friction[i] += k * z;
                if follows_velocity || z.abs() >= SLIPS * d {
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
        let (mut next, mut viscous) = (self.rows.len(), 0.0);
        for term in terms {
            if term.effect().is_some_and(|e| e.id() == form::VISCOUS.id) {
                viscous += coefficients[next];
            }
            for column in term.columns(&scene) {
                let c = coefficients[next];
                next += 1;
                if term.acts_on_effort() {
                    continue;
                }
                let slope = |values: &[f64]| match values {
                    [] => Vec::new(),
                    values => s.smooth_slope(values),
                };
                let parts = [
                    column.value,
                    slope(&column.sloped),
                    slope(&slope(&column.curved)),
                ];
                for part in &parts {
                    let own = fitted.iter_mut().zip(part);
                    own.for_each(|(f, v)| *f += c * v);
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
            viscous,
            simulated_swing: None,
        }
    }
}

/// `tanh(v/v₀)` (-) at the samples.
fn follows(s: &Signals, slow: f64) -> Vec<f64> {
    s.v.iter().map(|v| (v / slow).tanh()).collect()
}
