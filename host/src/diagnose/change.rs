//! Changes of the hysteresis core that a machine may have and Maxwell-slip blocks do not: they compete with names, because
//! what the core gets wrong looks like physics.

use super::axis::Axis;
use super::effect::Scene;
use super::normal::Bound;
use super::signals::Signals;
use super::weak::Column;
use preslide_fit::signal::{Deflection, LATE};

/// Late blocks.
const LATE_BLOCKS: usize = 8;

/// A change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Blocks that yield after a larger share of the travel.
    LateYields,
    /// Each direction has its own hysteresis.
    PerDirection,
    /// Hysteresis that grows or shrinks with the logarithm of speed.
    Rate,
    /// What sticks is damped: a force in proportion to the slope of friction.
    Damped,
}

impl Change {
    /// All of them.
    pub const ALL: [Change; 4] = [
        Change::LateYields,
        Change::PerDirection,
        Change::Rate,
        Change::Damped,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Change::LateYields => "hysteresis over a large part of the travel",
            Change::PerDirection => "hysteresis that differs by direction",
            Change::Rate => "hysteresis that depends on the rate",
            Change::Damped => "damping of what sticks",
        }
    }

    /// The coordinate that it follows.
    pub fn axis(self) -> Axis {
        match self {
            Change::Rate => Axis::Speed,
            Change::LateYields | Change::PerDirection | Change::Damped => Axis::SinceReversal,
        }
    }

    /// Whether every machine may have it, so that it is the core's own and nothing that is missing.
    pub fn is_plain(self) -> bool {
        matches!(self, Change::LateYields | Change::Damped)
    }

    /// How its coefficients are bound.
    pub fn bound(self) -> Bound {
        match self {
            Change::LateYields | Change::Damped => Bound::NonNegative,
            _ => Bound::Free,
        }
    }

    /// Columns at the samples.
    pub fn columns(self, scene: &Scene) -> Vec<Column> {
        let (s, core) = (scene.s, scene.core);
        let along = |d: f64| Deflection::along(&s.x, &s.pieces, d).z;
        match self {
            Change::LateYields => late_yields(s)
                .into_iter()
                .map(|d| Column::of(along(d)))
                .collect(),
            Change::PerDirection => core
                .blocks
                .iter()
                .map(|&(k, d)| Column::of(along(d).iter().map(|z| k * z.abs()).collect()))
                .collect(),
            Change::Damped => vec![Column {
                sloped: core.friction.clone(),
                ..Column::default()
            }],
            Change::Rate => {
                let top = s.moving_speed(0.95).max(1e-300);
                let slow = s.moving_speed(0.05).max(1e-3 * top);
                let rate = |v: f64| (v.abs().max(slow) / top).ln();
                vec![
                    Column::of(
                        s.v.iter()
                            .zip(&core.friction)
                            .map(|(v, f)| rate(*v) * f)
                            .collect(),
                    ),
                    Column::of(
                        s.v.iter()
                            .zip(core.friction.iter().zip(&core.slipping))
                            .map(|(v, (f, slip))| rate(*v) * (f - slip))
                            .collect(),
                    ),
                ]
            }
        }
    }
}

/// Yield displacements of the late blocks, to half of the travel (m or rad).
pub fn late_yields(s: &Signals) -> Vec<f64> {
    let ratio = f64::powf(0.5 / LATE, 1.0 / LATE_BLOCKS as f64);
    (1..=LATE_BLOCKS as i32)
        .map(|i| LATE * s.travel() * ratio.powi(i))
        .collect()
}
