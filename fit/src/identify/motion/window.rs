//! Stretches of a recording that a simulation runs through: begun with the measured position and velocity, and left to itself.

use super::body::{Body, Place};
use crate::recording::Recording;
use crate::simulate::closed::{Controller, at_ticks, limited, sampled};
use preslide::control::{Pid, PidState, Saturation};
use std::ops::Range;

/// What drives the body.
pub(super) enum Drive<'a> {
    /// The recorded effort (N or N·m).
    Open,
    /// A controller that follows the recorded reference.
    Loop {
        controller: &'a Controller,
        pid: Pid<f64>,
    },
}

/// A recording as a motion fit sees it.
pub(super) struct Driven<'a> {
    pub(super) recording: &'a Recording,
    /// Measured velocity (m/s or rad/s), filtered.
    pub(super) velocity: &'a [f64],
    pub(super) drive: Drive<'a>,
    pub(super) place: Place,
}

/// A stretch of samples, with the reference and its velocity at the controller's ticks where there is one.
#[derive(Clone)]
pub(super) struct Window {
    pub(super) rows: Range<usize>,
    wanted: Vec<[f64; 2]>,
}

/// What is changed of a machine to see what that does: factors of drive gain.
pub(super) const AS_IT_IS: f64 = 1.0;

impl Driven<'_> {
    pub(super) fn window(&self, rows: Range<usize>) -> Window {
        let wanted = match &self.drive {
            Drive::Open => Vec::new(),
            Drive::Loop { controller, .. } => {
                let measured = &self.recording.position;
                let reference = self.recording.reference.as_ref().unwrap_or(measured);
                let t_s = &self.recording.t_s[rows.clone()];
                at_ticks(t_s, &reference[rows.clone()], 1.0 / controller.rate_hz)
            }
        };
        Window { rows, wanted }
    }

    /// Pieces cut into windows of `1/parts` of their length that overlap by half.
    pub(super) fn windows(&self, pieces: &[Range<usize>], parts: usize) -> Vec<Window> {
        let mut windows = Vec::new();
        for piece in pieces {
            let length = piece.len() / parts;
            for half in 0..2 * parts - 1 {
                let start = piece.start + half * piece.len() / (2 * parts);
                windows.push(self.window(start..start + length));
            }
        }
        windows
    }

    /// Position (m or rad) at every sample of a window, with `steps` to a sample (in a loop: to a tick) and the drive's gain changed by a factor.
    pub(super) fn simulate(&self, body: &Body, window: &Window, steps: u32, gain: f64) -> Vec<f64> {
        let first = window.rows.start;
        let start = [self.recording.position[first], self.velocity[first]];
        match &self.drive {
            Drive::Open => self.open(body, window, steps, gain, start),
            Drive::Loop { controller, pid } => {
                let dt = 1.0 / controller.rate_hz / f64::from(steps);
                let (mut memory, mut cut) = (PidState::new(), Saturation::None);
                let mut now = start;
                let mut ticks = Vec::with_capacity(window.wanted.len());
                for [r, speed] in &window.wanted {
                    ticks.push(now[0]);
                    let asked = pid.step(&mut memory, r - now[0], speed - now[1], cut);
                    let force;
                    (force, cut) = limited(asked, controller.limit);
                    for _ in 0..steps {
                        now = body.advance(now, gain * force, dt, &self.place);
                    }
                }
                let t_s = &self.recording.t_s[window.rows.clone()];
                sampled(t_s, &ticks, 1.0 / controller.rate_hz)
            }
        }
    }

    fn open(
        &self,
        body: &Body,
        window: &Window,
        steps: u32,
        gain: f64,
        start: [f64; 2],
    ) -> Vec<f64> {
        let (t_s, effort) = (&self.recording.t_s, &self.recording.effort);
        let mut now = start;
        let mut positions = Vec::with_capacity(window.rows.len());
        positions.push(now[0]);
        for i in window.rows.start..window.rows.end - 1 {
            let dt = (t_s[i + 1] - t_s[i]) / f64::from(steps);
            for step in 0..steps {
                let part = (f64::from(step) + 0.5) / f64::from(steps);
                let force = effort[i] + part * (effort[i + 1] - effort[i]);
                now = body.advance(now, gain * force, dt, &self.place);
            }
            positions.push(now[0]);
        }
        positions
    }

    /// Simulated less measured position (m or rad), every so many samples.
    pub(super) fn errors(
        &self,
        body: &Body,
        windows: &[Window],
        steps: u32,
        every: usize,
    ) -> Vec<f64> {
        let mut errors = Vec::new();
        for window in windows {
            let found = self.simulate(body, window, steps, AS_IT_IS);
            let measured = &self.recording.position[window.rows.clone()];
            let apart = found.iter().zip(measured).map(|(f, m)| f - m);
            errors.extend(apart.step_by(every));
        }
        errors
    }
}
