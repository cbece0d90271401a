//! The controller that stands beside the kernel in the measured control tick: a float PID.

use preslide::Motion;

/// What a tick of the loop gets from the sensors.
pub struct Inputs<S> {
    pub motion: Motion<S>,
    /// Where the axis is, in the model's units.
    pub position: S,
    /// Control error \[counts\].
    pub error: f32,
}

/// PID in parallel form with a limited integral and output; sample time in the gains.
#[repr(C)]
pub struct Pid {
    proportional: f32,
    integral: f32,
    derivative: f32,
    limit: f32,
}

/// What it remembers, and its output.
#[derive(Default)]
#[repr(C)]
pub struct PidState {
    sum: f32,
    last_error: f32,
    pub output: f32,
}

impl Pid {
    /// Gains of no particular loop: they change no instruction.
    pub const EXAMPLE: Self = Self {
        proportional: 0.4,
        integral: 0.02,
        derivative: 1.5,
        limit: 100.0,
    };

    /// `u = limited(K_p·e + S + K_d·(e − e'))`, `S ← limited(S + K_i·e)`.
    #[inline(always)]
    pub fn step(&self, state: &mut PidState, error: f32) {
        let limited = |value: f32| preslide::Scalar::limited(value, self.limit);
        state.sum = limited(state.sum + self.integral * error);
        let rate = error - state.last_error;
        state.last_error = error;
        state.output = limited(self.proportional * error + state.sum + self.derivative * rate);
    }
}
