//! What lies between the machine and the recorded effort, a delay and an end of command or reading, and what shakes it above the band of the
//! motion, as effects: they were found before the search, which goes on without them.

use super::effect::actuator_saturation::{ActuatorSaturation, READING};
use super::effect::{ALWAYS_FREE, Effect, VIBRATION};
use super::measured::OF_THE_FRICTION;
use super::null_model::NullModel;
use super::shift::Shift;
use super::weak::Column;
use preslide_fit::evidence::{Evidence, NAMED, evidence};
use preslide_fit::recording::Recording;
use preslide_fit::signal::{Channel, End, Saturation, Vibration};
use preslide_fit::statistics::Estimate;
use std::ops::Range;

/// Standard errors that an end must be beyond nothing.
const SURE: f64 = 3.0;

/// Key of a vibration's frequency.
pub const FREQUENCY: &str = "frequency_Hz";

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

/// What there is of a channel, of which the delay is worth so much; `recorded` still has it.
pub fn found(
    channel: &Channel,
    shift: Option<Shift>,
    null: &NullModel,
    recorded: &Recording,
) -> Vec<Found> {
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
    let lines = channel.vibrations.iter();
    let shaken = lines.map(|line| shaken(null, line, recorded));
    // It was held against blocks that it was not fitted to, and may be too small for anyone.
    let material = |found: &Found| {
        let taken = null.rows.rms_of(found.nmse[0] - found.nmse[1]);
        taken >= OF_THE_FRICTION * null.usual_friction()
    };
    let shaken = shaken.filter(material);
    shifted.into_iter().chain(limited).chain(shaken).collect()
}

/// A line of the effort above the band of the motion, of which the rows, which pass a narrower kernel, show next to nothing: it is weighed against all
/// that the effort has there.
fn shaken(null: &NullModel, line: &Vibration, recorded: &Recording) -> Found {
    let rows = &null.rows;
    let smooth = rows.s.smoothed(&recorded.effort);
    let whole: Vec<f64> = (recorded.effort.iter().zip(smooth))
        .map(|(effort, smooth)| effort - smooth)
        .collect();
    let force = line.at(&recorded.t_s);
    let left: Vec<f64> = whole.iter().zip(&force).map(|(w, f)| w - f).collect();
    let variance = rows.variation() / rows.force.len().max(1) as f64;
    let nmse = |values: &[f64]| {
        let square = values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64;
        100.0 * square / variance.max(1e-300)
    };
    let first = recorded.t_s.first().copied().unwrap_or_default();
    let known = |value| Estimate { value, ci95: None };
    Found {
        effect: VIBRATION,
        confident: true,
        evidence: evidence(&force, &whole, &blocks_of(whole.len())),
        nmse: [&whole, &left].map(|values| nmse(values)),
        // As it is there: averaged over a row it would be next to nothing.
        force: rows.weak.at_centres(&force),
        parameters: vec![
            ("force_N".to_owned(), line.force),
            ("phase_rad".to_owned(), known(line.phase(first))),
            (FREQUENCY.to_owned(), known(line.frequency_hz)),
        ],
    }
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
