//! What lies between the machine and the recorded effort: an end of command or reading, and a delay.

use super::{Delay, Kinematics, Saturation};
use crate::recording::Recording;
use serde::Serialize;
use std::ops::Range;

/// What every fit takes off a recording before it begins.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Channel {
    /// Where the effort ends, if it does.
    pub saturation: Option<Saturation>,
    /// How late the effort is, if it is.
    pub delay: Option<Delay>,
}

impl Channel {
    /// Of a recording.
    pub fn of(recording: &Recording, kinematics: &Kinematics) -> Self {
        let saturation = Saturation::of(recording, kinematics);
        let ended = Self {
            saturation,
            delay: None,
        };
        let arrived = ended.taken_off(recording);
        let mut is_known = vec![true; recording.len()];
        for range in ended.unknown(kinematics.filter.reach(recording)) {
            is_known[range].fill(false);
        }
        let arrived = arrived.as_ref().unwrap_or(recording);
        let delay = Delay::of(arrived, kinematics, &is_known);
        Self { delay, ..ended }
    }

    /// The recording with the effort that arrived, as early as its position; `None` where that is the recording.
    pub fn taken_off(&self, recording: &Recording) -> Option<Recording> {
        let end = self.saturation.as_ref();
        let arrived = end.and_then(|end| end.arrived(recording));
        let on_time = self
            .delay
            .as_ref()
            .map(|delay| delay.taken_off(arrived.as_ref().unwrap_or(recording)));
        on_time.or(arrived)
    }

    /// Samples of which the effort is not known, `reach` to each side among them.
    pub fn unknown(&self, reach: usize) -> Vec<Range<usize>> {
        let end = self.saturation.as_ref();
        end.map_or_else(Vec::new, |end| end.unknown(reach))
    }

    /// In words, a sentence each without its full stop.
    pub fn words(&self, unit: &str) -> impl Iterator<Item = String> {
        let end = self.saturation.as_ref().map(|end| end.words(unit));
        end.into_iter().chain(self.delay.map(|delay| delay.words()))
    }
}
