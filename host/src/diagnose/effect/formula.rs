//! What formulas of effects are made of: the parameters that a diagnosis states.

use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::Cos;
use crate::diagnose::expr::Input::{Direction, Position};
use preslide_fit::statistics::Estimate;
use std::f64::consts::{PI, TAU};

/// The parameters of an effect in the keys of a linear axis, and the level (N or N·m) of the recording's friction.
pub struct Stated<'a> {
    parameters: &'a [(String, Estimate)],
    /// The level.
    pub(super) level: f64,
}

impl<'a> Stated<'a> {
    pub(super) fn new(parameters: &'a [(String, Estimate)], level: f64) -> Self {
        Self { parameters, level }
    }

    /// The value of a key, where it has one.
    pub(super) fn get(&self, key: &str) -> Option<f64> {
        let own = self.parameters.iter().find(|(own, _)| own == key);
        own.map(|(_, estimate)| estimate.value)
    }

    /// The position less that of a key.
    pub(super) fn past(&self, key: &str) -> Option<Expr> {
        Some(Expr::from(Position) + Expr::Number(-self.get(key)?))
    }

    /// `cos(2πx/p + φ)`.
    pub(super) fn wave(&self) -> Option<Expr> {
        let turns = TAU / self.get("period_m")? * Expr::from(Position);
        Some((turns + Expr::Number(self.get("phase_rad")?)).of(Cos))
    }

    /// The sum of a map's cosines, whose keys end in `unit`.
    pub(super) fn cosines(&self, unit: &str) -> Option<Expr> {
        let (from, to) = (self.get("from_m")?, self.get("to_m")?);
        let sizes = (1..).map_while(|j| Some((j, self.get(&format!("cosine{j}{unit}"))?)));
        let mut sum: Option<Expr> = None;
        for (j, size) in sizes {
            let angle = f64::from(j) * PI / (to - from) * self.past("from_m")?;
            let part = size * angle.of(Cos);
            sum = Some(match sum {
                Some(sum) => sum + part,
                None => part,
            });
        }
        sum
    }

    /// A share of friction in its direction.
    pub(super) fn friction(&self, share: Expr) -> Expr {
        self.level * Expr::from(Direction) * share
    }
}
