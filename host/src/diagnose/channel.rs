//! What lies between the machine and the recorded effort, a delay and an end of command or reading, as effects: both were found before the
//! search, which goes on without them.

use super::effect::actuator_saturation::{ActuatorSaturation, READING};
use super::effect::{ALWAYS_FREE, Effect};
use super::null_model::NullModel;
use super::shift::Shift;
use super::weak::Column;
use preslide_fit::evidence::{Evidence, NAMED, evidence};
use preslide_fit::signal::{Channel, End, Saturation};
use preslide_fit::statistics::Estimate;
use std::ops::Range;

/// Standard errors that an end must be beyond nothing.
const SURE: f64 = 3.0;

/// An effect that was found there.
pub struct Found {
    /// Which.
    pub effect: &'static dyn Effect,
    /// It is sure enough, and enough of the mismatch.
    pub confident: bool,
    /// What it is worth.
    pub evidence: Evidence,
    /// Held-out NMSE (%) without and with it.
    pub nmse: [f64; 2],
    /// What it changes, at the rows (N or N·m).
    pub force: Vec<f64>,
    /// By key.
    pub parameters: Vec<(String, Estimate)>,
}

/// What there is of a channel, of which the delay is worth so much.
pub fn found(channel: &Channel, shift: Option<Shift>, null: &NullModel) -> Vec<Found> {
    let delay = channel.delay.as_ref().zip(shift);
    let shifted = delay.map(|(delay, shift)| Found {
        effect: ALWAYS_FREE,
        confident: true,
        evidence: shift.evidence,
        nmse: shift.nmse,
        force: shift.force,
        parameters: vec![("delay_s".to_owned(), delay.delay_s)],
    });
    let end = channel.saturation.as_ref();
    let limited = end.map(|end| limited(null, end));
    shifted.into_iter().chain(limited).collect()
}

/// An end of the effort: of a command that was cut to it, of a reading whose samples there were left out.
fn limited(null: &NullModel, end: &Saturation) -> Found {
    let [without, with] = &end.residuals;
    let change: Vec<f64> = without.iter().zip(with).map(|(a, b)| a - b).collect();
    let evidence = evidence(&change, without, &blocks_of(without.len()));
    let key = match end.of {
        End::Command => "limit_N",
        End::Reading => READING,
    };
    let rows = &null.rows;
    let of = |values: &[f64]| rows.weak.rows(&Column::of(values.to_vec()));
    Found {
        effect: &ActuatorSaturation,
        confident: evidence.share >= NAMED && evidence.z >= SURE,
        evidence,
        nmse: [without, with].map(|left| rows.nmse(&of(left))),
        force: of(&change),
        parameters: vec![(key.to_owned(), end.limit)],
    }
}

/// Samples in blocks of one length.
fn blocks_of(samples: usize) -> Vec<Range<usize>> {
    const BLOCKS: usize = 24;
    let cut = |k: usize| k * samples / BLOCKS;
    (0..BLOCKS).map(|k| cut(k)..cut(k + 1)).collect()
}
