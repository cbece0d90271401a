//! What a delay between effort and position, which was taken off as a shift, is worth.

use super::effect::{constant_force::ConstantForce, viscous::Viscous};
use super::normal::{Bound, Normal};
use super::null_model::NullModel;
use super::term::{Subject, Term};
use super::weak::Column;
use preslide_fit::evidence::{Evidence, evidence};

/// What a delay is worth.
pub struct Shift {
    /// Beyond nothing.
    pub evidence: Evidence,
    /// Held-out NMSE (%) without and with it.
    pub nmse: [f64; 2],
    /// What it changes, at the rows (N or N·m).
    pub force: Vec<f64>,
}

impl Shift {
    /// Of the null models of a recording as it was made and on time, each with a hysteresis of its own. `None` where the motion does not determine
    /// inertia and friction.
    pub fn of(late: &NullModel, on_time: &NullModel) -> Option<Self> {
        let [without, with] = [late, on_time].map(left);
        let (without, with) = (without?, with?);
        let force: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
        Some(Self {
            evidence: evidence(&force, &without, &late.rows.blocks),
            nmse: [late.rows.nmse(&without), on_time.rows.nmse(&with)],
            force,
        })
    }
}

/// What plain physics leaves of the effort on folds held out (N or N·m).
fn left(null: &NullModel) -> Option<Vec<f64>> {
    let rows = &null.rows;
    let (columns, bounds) = columns(null);
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let fit = Normal::new(
        &null.unweighted(),
        &rows.weak.folds,
        &all,
        &bounds,
        &rows.force,
    )?;
    Some(fit.held_out_residual(&all, &rows.force))
}

/// Inertia and hysteresis, a constant, viscous friction, a spring and gravity, with how they are bound.
fn columns(null: &NullModel) -> (Vec<Vec<f64>>, Vec<Bound>) {
    let s = &null.rows.s;
    let mut columns = null.core.rows.to_vec();
    let mut bounds = null.core.bounds();
    let plain = [Subject::Effect(&ConstantForce), Subject::Effect(&Viscous)];
    let mut beside: Vec<Vec<f64>> = plain
        .iter()
        .flat_map(|subject| null.columns(&Term::new(*subject, &[])).to_vec())
        .collect();
    let of = |column: Vec<f64>| null.rows.weak.rows(&Column::of(column));
    beside.push(of(s.x.clone()));
    if s.rotary {
        beside.push(of(s.x.iter().map(|x| x.sin()).collect()));
        beside.push(of(s.x.iter().map(|x| x.cos()).collect()));
    }
    bounds.extend(beside.iter().map(|_| Bound::Free));
    columns.extend(beside);
    (columns, bounds)
}
