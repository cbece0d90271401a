//! The outer task beside the tick, as a board runs it: started when a sample begins, its order counting from the next one.

use preslide::control::Condition;
use preslide::control::koopman::{Guided, GuidedState};
use preslide::{Friction, Motion, ParamError, Units};

/// What an outer task gets of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Ticks since the motion began.
    pub(super) tick: usize,
    /// The following error (m), and what axis and reference travelled since the last sample.
    pub(super) error: f64,
    pub(super) travelled: f64,
    pub(super) reference: f64,
    /// The force that counts from here on (N).
    pub(super) force: f64,
}

/// An outer task.
pub(super) trait Task: Clone + PartialEq {
    /// Its memory.
    type State: Clone;

    fn start(&self) -> Self::State;

    /// The order for the next sample (N); `None` where the deadline is missed.
    fn run(&self, state: &mut Self::State, sample: &Sample) -> Option<f64>;
}

/// A friction model with an outer task.
#[derive(Clone, PartialEq)]
pub(super) struct Outer<F: Friction<Scalar = f32>, T: Task> {
    guided: Guided<F>,
    task: T,
}

#[derive(Clone)]
pub(super) struct OuterState<M, T> {
    pub(super) guided: GuidedState<M, f32>,
    pub(super) task: T,
    tick: usize,
    error: f64,
}

impl<F: Friction<Scalar = f32>, T: Task> Outer<F, T> {
    pub(super) fn try_new(friction: F, limit_n: f64, task: T) -> Result<Self, ParamError> {
        Ok(Self {
            guided: Guided::try_new(friction, super::TICKS, limit_n, Units::SI)?,
            task,
        })
    }
}

impl<F: Friction<Scalar = f32>, T: Task> Friction for Outer<F, T> {
    type Scalar = f32;
    type State = OuterState<F::State, T::State>;
    const OBSERVES: bool = F::OBSERVES;

    fn at_rest(&self) -> Self::State {
        OuterState {
            guided: self.guided.at_rest(),
            task: self.task.start(),
            tick: 0,
            error: 0.0,
        }
    }

    fn set_position(&self, state: &mut Self::State, position: f32) {
        self.guided.set_position(&mut state.guided, position);
    }

    fn velocity(
        &self,
        state: &mut Self::State,
        displacement: f32,
        window: impl FnOnce() -> f32,
    ) -> f32 {
        (self.guided).velocity(&mut state.guided, displacement, window)
    }

    fn acted(&self, state: &mut Self::State, velocity_error: f32, force: impl FnOnce() -> f32) {
        self.guided.acted(&mut state.guided, velocity_error, force);
    }

    fn spent(&self, state: &mut Self::State, force: impl FnOnce() -> Option<f32>) {
        self.guided.spent(&mut state.guided, force);
    }

    fn condition(&self, state: &Self::State) -> Condition<f32> {
        self.guided.condition(&state.guided)
    }

    fn step(&self, state: &mut Self::State, motion: Motion<f32>) -> f32 {
        let force = self.guided.step(&mut state.guided, motion);
        if state.guided.is_due() {
            let [travelled, reference] = state.guided.travelled().map(f64::from);
            state.error += reference - travelled;
            let sample = Sample {
                tick: state.tick,
                error: state.error,
                travelled,
                reference,
                force: state.guided.force().into(),
            };
            if let Some(order) = self.task.run(&mut state.task, &sample) {
                state.guided.order(order as f32);
            }
        }
        state.tick += 1;
        force
    }

    fn limit(&self) -> Option<f32> {
        self.guided.limit()
    }
}
