//! What displacements a recording resolves where blocks yield: near its reversals.

use crate::statistics::quantile;
use std::ops::Range;

/// Samples on either side of a reversal whose steps count.
const NEAR: usize = 8;

/// The median displacement (m or rad) from sample to sample near the first samples of strokes, `turns`, that are steps at all; `None` without
/// any. A fast stroke is sampled coarsely, but not where it begins.
pub fn step_at_reversals(
    position: &[f64],
    pieces: &[Range<usize>],
    turns: impl Iterator<Item = usize>,
) -> Option<f64> {
    let near = turns.flat_map(|turn| {
        let piece = pieces.iter().find(|piece| piece.contains(&turn));
        let piece = piece.cloned().unwrap_or(turn..turn + 1);
        turn.saturating_sub(NEAR).max(piece.start)..(turn + NEAR).min(piece.end - 1)
    });
    let steps = near.map(|i| (position[i + 1] - position[i]).abs());
    quantile(
        &mut steps.filter(|step| *step > 0.0).collect::<Vec<_>>(),
        0.5,
    )
}
