//! The controller's own code as an outer task.

use super::learnt::Learnt;
use super::outer::{Sample, Task};
use super::{
    BLOCKS, FORCE_N, ITERATIONS, LENGTHS, Lift, MOVES, Mpc, SLEW_N, STATES, TICKS, TRAVEL,
};
use crate::tracking::TrackingError;
use crate::tracking::rivals::velocities;
use preslide::control::koopman::{Ahead, ErrorLiftState, KoopmanSettings, KoopmanState};
use preslide::control::{Move, Settings};
use std::sync::Arc;

/// What is tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weights {
    /// Of a squared force and of its squared change (m²/N²).
    pub(super) effort: f64,
    pub(super) change: f64,
    /// Of the error that was not foreseen (-).
    pub(super) gain: f64,
}

impl Weights {
    pub(super) fn cost(&self) -> KoopmanSettings<MOVES> {
        KoopmanSettings {
            lengths: LENGTHS,
            effort: self.effort,
            change: self.change,
            force: FORCE_N,
            slew: SLEW_N,
            travel: TRAVEL,
            iterations: ITERATIONS,
        }
    }
}

/// Lift and controller over a motion that is known beforehand, as a planner knows its queue.
#[derive(Clone, PartialEq)]
pub(super) struct Predictive {
    lift: Lift,
    mpc: Mpc,
    /// The reference (m) at the end of every tick, from where the motion begins.
    places: Arc<[f64]>,
    travel: (f64, f64),
}

impl Predictive {
    pub(super) fn try_new(
        learnt: &Learnt,
        yields: &[f64; BLOCKS],
        compensated: bool,
        weights: Weights,
        settings: &Settings,
        moves: &[Move],
    ) -> Result<Self, TrackingError> {
        let mut place = 0.0;
        let per_tick = velocities(settings, moves)?;
        let places = per_tick.iter().map(|v| {
            place += f64::from(*v) * settings.sample_time();
            place
        });
        Ok(Self {
            lift: Lift::try_new(yields, compensated, &learnt.model, weights.gain)?,
            mpc: Mpc::try_new(&learnt.model, &weights.cost())?,
            places: places.collect(),
            travel: settings
                .limits
                .travel
                .unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
        })
    }

    pub(super) fn contraction(&self) -> f64 {
        self.mpc.contraction()
    }

    fn ahead(&self, tick: usize) -> Ahead<MOVES> {
        let mut ahead = Ahead {
            displacement: [0.0; MOVES],
            below: [0.0; MOVES],
            above: [0.0; MOVES],
        };
        let last = self.places.len() - 1;
        let mut at = tick.min(last);
        for (j, length) in LENGTHS.into_iter().enumerate() {
            let end = (at + (length * TICKS) as usize).min(last);
            let (from, to) = (self.places[at], self.places[end]);
            ahead.displacement[j] = ((to - from) / f64::from(length)) as f32;
            ahead.below[j] = (to - self.travel.0) as f32;
            ahead.above[j] = (self.travel.1 - to) as f32;
            at = end;
        }
        ahead
    }
}

#[derive(Clone)]
pub(super) struct PredictiveState {
    lift: ErrorLiftState<STATES, BLOCKS>,
    mpc: KoopmanState<MOVES>,
}

impl Task for Predictive {
    type State = PredictiveState;

    fn start(&self) -> PredictiveState {
        PredictiveState {
            lift: self.lift.at_rest(),
            mpc: KoopmanState::new(),
        }
    }

    fn run(&self, state: &mut PredictiveState, sample: &Sample) -> Option<f64> {
        let told = [
            sample.error,
            sample.travelled,
            sample.reference,
            sample.force,
        ];
        let [error, travelled, reference, force] = told.map(|value| value as f32);
        let lifted = (self.lift).take(&mut state.lift, error, travelled, reference, force);
        let order = self
            .mpc
            .solve(&mut state.mpc, lifted, &self.ahead(sample.tick));
        Some(order.into())
    }
}
