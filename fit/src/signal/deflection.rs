//! The stop operator: the deflection of one Maxwell-slip block, and how it changes with the yield displacement.

use crate::recording::Recording;
use preslide::Scalar;
use std::ops::Range;

/// Deflection `z(t; D)` (m) of a block with yield displacement `D` (m) that follows the position `x` (m), and its
/// derivative `∂z/∂D` (-), for every sample.
///
/// `z ← clamp(z + dx, −D, D)`: eq. (10) with the limit of the quasi-static form. A model with fixed yields is
/// linear in its stiffnesses, `F = Σ k_i·z(t; D_i)`, which is what makes the search for breakpoints tractable.
/// Every piece of contiguous samples starts with the state that the piece before left (the body does not move
/// between them as far as anyone knows); the first starts from rest.
pub struct Deflection {
    /// `z` (m or rad).
    pub z: Vec<f64>,
    /// `∂z/∂D` (-): 0 until the block first slips, then ±1 since its last slip.
    pub slope: Vec<f64>,
}

/// A stretch counts from where the axis has moved by this share of the travel: until then what friction did before is not known.
const FORGOTTEN: f64 = 0.03;

/// Samples at the start of a stretch in which friction still holds what nobody recorded.
pub fn not_yet_known(recording: &Recording, stretch: &Range<usize>) -> Range<usize> {
    let (low, high) = recording.ends();
    // Of a file that is a copy of another no samples are left.
    let Some(start) = recording.position.get(stretch.start) else {
        return stretch.clone();
    };
    let gone = |i: &usize| (recording.position[*i] - start).abs() > FORGOTTEN * (high - low);
    let end = stretch.clone().find(gone).unwrap_or(stretch.end);
    stretch.start..end
}

/// Starts of files in which friction still holds what nobody recorded. A file alone begins from rest, as the models do; of several none is the first,
/// in whatever order they are given.
pub fn unknown_starts(recording: &Recording) -> Vec<Range<usize>> {
    let several = recording.joined.len() > 1;
    let files = recording.joined.iter().filter(|_| several);
    files.map(|file| not_yet_known(recording, file)).collect()
}

impl Deflection {
    /// Runs the operator along `x` over the contiguous `pieces`.
    pub fn along(x: &[f64], pieces: &[Range<usize>], yield_displacement: f64) -> Self {
        let mut z = vec![0.0; x.len()];
        let mut slope = vec![0.0; x.len()];
        let (mut state, mut sensitivity) = (0.0_f64, 0.0);
        for piece in pieces {
            let mut last = x[piece.start];
            for i in piece.clone() {
                let free = state + (x[i] - last);
                last = x[i];
                state = free.limited(yield_displacement);
                if free >= yield_displacement {
                    sensitivity = 1.0;
                } else if free <= -yield_displacement {
                    sensitivity = -1.0;
                }
                z[i] = state;
                slope[i] = sensitivity;
            }
        }
        Self { z, slope }
    }
}
