//! What an error of the measured position does to the effort.

use super::Scene;
use crate::diagnose::weak::Column;

/// How the effort changes when the measured position is the load's position plus `error` (m or rad): `−m·ë − Σ k_i·w_i`, where
/// `w_i` follows the error while block `i` sticks and is cleared when it slips.
pub(super) fn displaced(error: &[f64], mass: f64, scene: &Scene) -> Column {
    let s = scene.s;
    let mut column = vec![0.0; error.len()];
    for &(k, d) in &scene.core.blocks {
        let (mut z, mut w) = (0.0f64, 0.0);
        for piece in &s.pieces {
            for i in piece.start + 1..piece.end {
                let free = z + s.x[i] - s.x[i - 1];
                z = free.clamp(-d, d);
                w = if free.abs() >= d {
                    0.0
                } else {
                    w + error[i] - error[i - 1]
                };
                column[i] -= k * w;
            }
        }
    }
    Column {
        value: column,
        sloped: Vec::new(),
        curved: error.iter().map(|e| -mass * e).collect(),
    }
}
