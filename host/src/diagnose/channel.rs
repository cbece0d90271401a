//! What lies between the machine and the recorded effort: a delay, and an end of command or reading.

use super::confidence;
use super::effect::{ALWAYS_FREE, actuator_saturation::ActuatorSaturation};
use super::evidence::{NAMED, evidence};
use super::ground::Ground;
use super::place::Place;
use super::shift::{SURE, Shift};
use super::verdict::{Name, Named};
use super::weak::Column;
use crate::signal::Saturation;
use std::ops::Range;

/// What lies between the machine and the recorded effort, found before the search, which goes on without it.
pub struct Channel {
    /// A delay.
    pub shift: Option<Shift>,
    /// An end.
    pub saturation: Option<Saturation>,
}

impl Channel {
    /// What there is of it, as effects.
    pub fn named(self, ground: &Ground) -> impl Iterator<Item = Named> {
        let shifted = self.shift.map(|shift| shifted(ground, shift));
        let limited = self.saturation.map(|end| limited(ground, &end));
        shifted.into_iter().chain(limited)
    }
}

/// A delay that the whole recording was shifted by.
fn shifted(ground: &Ground, shift: Shift) -> Named {
    Named {
        name: Name::Entry(ALWAYS_FREE),
        term: None,
        confident: true,
        in_fit: false,
        confidence: confidence::of_evidence(&shift.evidence),
        evidence: shift.evidence,
        standing: None,
        nmse_test: shift.nmse,
        places: Place::all(&ground.rows, ALWAYS_FREE.axis(), &shift.force),
        force: shift.force,
        parameters: vec![("delay_s".to_owned(), shift.delay)],
        source: None,
        ambiguous: Vec::new(),
    }
}

/// An end of the effort: of a command that was cut to it, of a reading whose samples there were left out.
fn limited(ground: &Ground, end: &Saturation) -> Named {
    let [without, with] = &end.residuals;
    let change: Vec<f64> = without.iter().zip(with).map(|(a, b)| a - b).collect();
    let blocks = blocks_of(without.len());
    let evidence = evidence(&change, without, &blocks);
    let rows = &ground.rows;
    let of = |values: &[f64]| rows.nmse(&rows.weak.rows(&Column::of(values.to_vec())));
    let force = rows.weak.rows(&Column::of(change));
    Named {
        name: Name::Entry(&ActuatorSaturation),
        term: None,
        confident: evidence.share >= NAMED && evidence.z >= SURE,
        in_fit: false,
        confidence: confidence::of_evidence(&evidence),
        evidence,
        standing: None,
        nmse_test: [of(without), of(with)],
        places: Vec::new(),
        force,
        parameters: vec![("limit_N".to_owned(), end.limit)],
        source: None,
        ambiguous: Vec::new(),
    }
}

/// Samples in blocks of one length.
fn blocks_of(samples: usize) -> Vec<Range<usize>> {
    const BLOCKS: usize = 24;
    let cut = |k: usize| k * samples / BLOCKS;
    (0..BLOCKS).map(|k| cut(k)..cut(k + 1)).collect()
}
