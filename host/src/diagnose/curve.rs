//! Free curves over a coordinate: what organises a mismatch, without asking what physics it is.

use super::axis::Axis;
use super::effect::Scene;
use super::normal::dot;
use super::signals::{Signals, mean};
use super::weak::Column;
use preslide_fit::statistics::quantile_between_ranks;

/// Knots of the smooth curve over a coordinate.
const KNOTS: usize = 8;
/// Knots closer than this share of the range are one.
const CLOSE: f64 = 0.02;

/// A curve over one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Curve {
    /// The coordinate.
    pub axis: Axis,
    /// Flips with direction: a change of the friction level, not a force.
    pub odd: bool,
}

impl Curve {
    /// The curves that this recording can have.
    pub fn all(s: &Signals) -> Vec<Curve> {
        let axes = Axis::of(s).into_iter();
        // A level that follows velocity is one that follows speed and direction.
        let both = axes.flat_map(|axis| [false, true].map(|odd| Curve { axis, odd }));
        both.filter(|c| c.axis != Axis::Velocity || !c.odd)
            .collect()
    }

    /// Hat functions at the samples: a force, or a change of the friction level.
    pub fn columns(self, scene: &Scene) -> Vec<Column> {
        let Some(values) = self.axis.values(scene.s) else {
            return Vec::new();
        };
        let mut hats = hats(&values);
        let friction = &scene.core.friction;
        if self.odd {
            for hat in &mut hats {
                hat.iter_mut().zip(friction).for_each(|(h, f)| *h *= f);
            }
        }
        // What others have: friction's level is the core's, and would be lost to what acts through it; a constant is a force of its own;
        // the inertia is better known from the core than from a noisier acceleration.
        let one = vec![1.0; values.len()];
        let others: Vec<&[f64]> = match self.axis {
            _ if self.odd => vec![friction],
            Axis::Velocity => vec![&one, friction],
            Axis::Acceleration => vec![&one, &values],
            _ => vec![&one],
        };
        let others = orthonormal(&others);
        hats.iter_mut().for_each(|hat| rid(hat, &others));
        hats.into_iter().map(Column::of).collect()
    }
}

/// An orthonormal basis of what some columns span (Gram and Schmidt); nothing of a column that is no more than the others.
fn orthonormal(columns: &[&[f64]]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let mut own = column.to_vec();
        rid(&mut own, &basis);
        let size = dot(&own, &own).sqrt();
        if size > 1e-6 * dot(column, column).sqrt() {
            own.iter_mut().for_each(|v| *v /= size);
            basis.push(own);
        }
    }
    basis
}

/// Takes what an orthonormal basis spans out of a column.
fn rid(column: &mut [f64], basis: &[Vec<f64>]) {
    for direction in basis {
        let part = dot(column, direction);
        for (c, d) in column.iter_mut().zip(direction) {
            *c -= part * d;
        }
    }
}

/// Hat functions over quantiles of a coordinate, without the last one (all together are a constant); none where it has too
/// few values.
pub fn hats(values: &[f64]) -> Vec<Vec<f64>> {
    let knots: Vec<f64> = (0..KNOTS)
        .map(|k| quantile_between_ranks(values, k as f64 / (KNOTS - 1) as f64))
        .collect();
    let (low, high) = (knots[0], knots[KNOTS - 1]);
    let span = high - low;
    // Where it dwells several fall together: the ends stay, whichever way the axis is called positive.
    let one = |close: &[f64]| match (close[0] == low, close[close.len() - 1] == high) {
        (true, _) => low,
        (_, true) => high,
        _ => mean(close),
    };
    let knots: Vec<f64> = knots
        .chunk_by(|a, b| b - a < CLOSE * span)
        .map(one)
        .collect();
    if span <= 0.0 || knots.len() < 4 {
        return Vec::new();
    }
    let last = knots.len() - 1;
    let hat = |k: usize, v: f64| {
        let v = v.clamp(knots[0], knots[last]);
        if v <= knots[k] {
            if k == 0 {
                return 1.0;
            }
            ((v - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0)
        } else {
            ((knots[k + 1] - v) / (knots[k + 1] - knots[k])).max(0.0)
        }
    };
    (0..last)
        .map(|k| values.iter().map(|v| hat(k, *v)).collect())
        .collect()
}
