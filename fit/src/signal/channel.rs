//! What lies between the machine and the recorded effort, an end of command or reading and a delay, and what shakes it.

use super::delay::yields;
use super::rigid::Rigid;
use super::{Delay, Kinematics, Saturation, StickSlip, Vibration};
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
    /// What shakes the axis from outside.
    pub vibrations: Vec<Vibration>,
}

impl Channel {
    /// Of a recording.
    pub fn of(recording: &Recording, kinematics: &Kinematics) -> Self {
        let saturation = Saturation::of(recording, kinematics);
        let mut found = Self {
            saturation,
            ..Self::default()
        };
        let Some(yields) = yields(recording) else {
            return found;
        };
        let mut rigid = Rigid::of(recording, kinematics, &yields);
        let mut is_known = vec![true; recording.len()];
        for range in found.unknown(kinematics.filter.reach(recording)) {
            is_known[range].fill(false);
        }
        rigid.rows.retain(|i| is_known[*i]);
        let arrived = found.taken_off(recording);
        let arrived = arrived.as_ref().unwrap_or(recording);
        // What an axis that hunts does by itself shakes it, too.
        if !StickSlip::of(arrived).is_some_and(|found| found.hunts) {
            found.vibrations = Vibration::all(&arrived.effort, &rigid);
        }
        // What shakes the axis moves it, by a phase of its own.
        let arrived = found.taken_off(recording);
        let arrived = arrived.as_ref().unwrap_or(recording);
        found.delay = Delay::of(&arrived.effort, &rigid);
        found
    }

    /// The recording with the effort that arrived, as early as its position and without what shakes it; `None` where that is the recording.
    pub fn taken_off(&self, recording: &Recording) -> Option<Recording> {
        let end = self.saturation.as_ref();
        let mut arrived = end.and_then(|end| end.arrived(recording));
        for vibration in &self.vibrations {
            vibration.take_off(arrived.get_or_insert_with(|| recording.clone()));
        }
        let delay = self.delay.as_ref();
        let on_time = delay.map(|delay| delay.taken_off(arrived.as_ref().unwrap_or(recording)));
        on_time.or(arrived)
    }

    /// Samples whose effort is unknown, `reach` to each side among them.
    pub fn unknown(&self, reach: usize) -> Vec<Range<usize>> {
        let end = self.saturation.as_ref();
        end.map_or_else(Vec::new, |end| end.unknown(reach))
    }

    /// In words, a sentence each without its full stop.
    pub fn words(&self, unit: &str) -> impl Iterator<Item = String> {
        let end = self.saturation.as_ref().map(|end| end.words(unit));
        let shaken = self.vibrations.iter().map(|v| v.words(unit));
        let delay = self.delay.map(|delay| delay.words());
        end.into_iter().chain(delay).chain(shaken)
    }
}
