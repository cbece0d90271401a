//! Cycles by the core's own counter, where there is one. QEMU has none: there the calls are recorded from outside.

use crate::machine::{self, MEASURES};
use crate::stub::{ControlTick, Controller, Step};
use crate::tick::Inputs;

/// What one call took, without the reading of the counters.
pub struct Taken {
    pub cycles: u32,
    /// `None` on a core that does not count them.
    pub instructions: Option<u32>,
}

/// What many calls took.
#[derive(Default)]
pub struct Spent {
    calls: u32,
    cycles: u64,
    pub worst: u32,
    instructions: u64,
    pub longest: Option<u32>,
}

impl Spent {
    /// One update, counted where the core counts.
    ///
    /// # Safety
    /// `step` takes these types.
    pub unsafe fn update<M, State, S: Copy>(
        &mut self,
        step: Step<M, State, S>,
        model: &M,
        state: &mut State,
        motion: [S; 2],
    ) -> S {
        let [displacement, velocity] = motion;
        if !MEASURES {
            // SAFETY: the caller's.
            return unsafe { step(model, state, displacement, velocity) };
        }
        // SAFETY: the caller's.
        let (force, taken) = unsafe { machine::update(step, model, state, motion) };
        self.add(&taken);
        force
    }

    /// One control tick, counted where the core counts.
    pub fn tick<M, State, S: Copy>(
        &mut self,
        control: ControlTick<M, State, S>,
        model: &M,
        state: &mut State,
        controller: &mut Controller,
        inputs: &Inputs<S>,
    ) -> S {
        if !MEASURES {
            return control(model, state, controller, inputs);
        }
        let (force, taken) = machine::tick(control, model, state, controller, inputs);
        self.add(&taken);
        force
    }

    fn add(&mut self, taken: &Taken) {
        self.calls += 1;
        self.cycles += u64::from(taken.cycles);
        self.worst = self.worst.max(taken.cycles);
        self.instructions += u64::from(taken.instructions.unwrap_or(0));
        self.longest = self.longest.max(taken.instructions);
    }

    pub fn mean(&self) -> f64 {
        self.cycles as f64 / f64::from(self.calls.max(1))
    }

    pub fn mean_instructions(&self) -> f64 {
        self.instructions as f64 / f64::from(self.calls.max(1))
    }
}
