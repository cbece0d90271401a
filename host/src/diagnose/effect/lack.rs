//! What a recording lacks, in words that effects share.

use crate::diagnose::signals::Signals;

/// Without it friction and a force are one.
pub(super) fn both_directions(s: &Signals) -> Option<&'static str> {
    (s.reversals == 0).then_some("motion in both directions")
}

/// Without them no law of speed shows.
pub(super) fn several_speeds(s: &Signals) -> Option<&'static str> {
    let (low, high) = s.speeds();
    (high < 3.0 * low).then_some("several speeds")
}

/// Without them a place is a displacement since reversal.
pub(super) fn different_ends(s: &Signals) -> Option<&'static str> {
    s.same_ends().then_some(
        "strokes between different ends: position and displacement since reversal are one coordinate",
    )
}
