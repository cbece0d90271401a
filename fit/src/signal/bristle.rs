//! The deflection of a bristle along a path: friction that nears its level along a tail and forgets inner loops.

use std::ops::Range;

/// Longest yield displacement over the longest relaxation length: a bristle slips after some three of its lengths.
pub const RELAXED: f64 = 3.0;

/// Deflection `z` (m or rad) of a bristle of relaxation length `d` (m or rad) at every point of a path `x` in contiguous `pieces`:
/// `dz/dx = (1 − sgn(v)·z/d)ⁿ` (Dahl 1968) with n = 1, or 2 where it is `squared`; exact between two points.
pub fn bristle(x: &[f64], pieces: &[Range<usize>], d: f64, squared: bool) -> Vec<f64> {
    let mut bent = vec![0.0; x.len()];
    let mut z = 0.0;
    for piece in pieces {
        let mut last = x[piece.start];
        for i in piece.clone() {
            let end = d.copysign(x[i] - last);
            let (gap, way) = (z - end, (x[i] - last).abs() / d);
            let kept = match squared {
                false => (-way).exp(),
                true => 1.0 / (1.0 + way * gap.abs() / d),
            };
            z = end + gap * kept;
            last = x[i];
            bent[i] = z;
        }
    }
    bent
}
