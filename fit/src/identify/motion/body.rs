//! One moving body that sticks exactly: the velocity at the end of a step in closed form.
//!
//! ```text
//! M·a + L(x) + (b ± d + c·|v|)·v + s·(F(x, v) + μ·|T|) = u,    T = (M − M_motor)·a + L(x)
//! ```
//!
//! `s` is the direction of motion, or of what pushes at rest; where neither direction moves, the body stands. With `L` and `F` half a step ahead
//! and the viscous part by the trapezoidal rule the step is second order between reversals, and each direction has one solution: `T + s·q·|T| = c`
//! with `q < 1`. [`crate::simulate::motion_with_inertia`], which runs every model file, agrees with it.

use crate::recording::MotionKind;
use preslide::effects::LARGEST_LEVEL;
use std::f64::consts::PI;

/// What moves and what resists, SI, rotary or linear alike.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Body {
    pub(super) inertia: f64,
    /// The part of the inertia before the gear.
    pub(super) motor_inertia: f64,
    pub(super) viscous: f64,
    /// `d`: half of what viscous friction has more forwards than backwards.
    pub(super) slant: f64,
    /// `c` of `c·v·|v|`.
    pub(super) drag: f64,
    pub(super) coulomb: f64,
    pub(super) offset: f64,
    /// Of a spring about the middle of the travel.
    pub(super) spring: f64,
    /// Gravity, of a rotary axis.
    pub(super) sine: f64,
    pub(super) cosine: f64,
    /// Share of the Coulomb force that friction at rest has more, and the speed over which it goes.
    pub(super) stribeck: f64,
    pub(super) stribeck_speed: f64,
    /// Share of what is transmitted.
    pub(super) transmitted: f64,
    /// First cosines of the Coulomb force over the travel.
    pub(super) along: [f64; 2],
}

/// Where a body is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) kind: MotionKind,
    /// The travel (m or rad).
    pub(super) travel: [f64; 2],
}

/// A shape that a body takes along its travel: what does not change within a step.
#[derive(Clone, Copy)]
struct Here {
    /// Load (N or N·m) of place.
    load: f64,
    /// Friction (N or N·m) without what is transmitted.
    friction: f64,
}

impl Body {
    /// The force of place (N or N·m) at `x`, the constant one included.
    fn load(&self, x: f64, place: &Place) -> f64 {
        let mut load = self.offset + self.spring * (x - place.middle());
        if self.sine != 0.0 || self.cosine != 0.0 {
            load += self.sine * x.sin() + self.cosine * x.cos();
        }
        load
    }

    fn here(&self, x: f64, v: f64, place: &Place) -> Here {
        let mut level = 1.0;
        if self.stribeck != 0.0 {
            level += self.stribeck * (-(v / self.stribeck_speed).abs()).exp();
        }
        if self.along != [0.0; 2] {
            let cosine = (PI * place.share(x)).cos();
            level += self.along[0] * cosine + self.along[1] * (2.0 * cosine * cosine - 1.0);
        }
        Here {
            load: self.load(x, place),
            friction: self.coulomb * level.max(0.0),
        }
    }

    /// Velocity after `dt` (s) under `force` where the body moves in `direction` (±1).
    fn moved(&self, v: f64, force: f64, here: Here, dt: f64, direction: f64) -> f64 {
        let damping = self.viscous + direction * self.slant + self.drag * v.abs();
        let implicit = 1.0 / (1.0 + 0.5 * damping * dt / self.inertia);
        let push = force - here.load - damping * v - direction * here.friction;
        let behind = implicit * (1.0 - self.motor_inertia / self.inertia);
        let unlossy = behind * push + here.load;
        let lost = self.transmitted * behind;
        let transmitted = unlossy / (1.0 + direction * unlossy.signum() * lost);
        let accelerating = push - direction * self.transmitted * transmitted.abs();
        v + dt / self.inertia * implicit * accelerating
    }

    /// Goes on by `dt` (s) under `force` (N or N·m) from position and velocity.
    pub(super) fn advance(&self, [x, v]: [f64; 2], force: f64, dt: f64, place: &Place) -> [f64; 2] {
        let here = self.here(x + 0.5 * dt * v, v, place);
        let likely = if v == 0.0 { force - here.load } else { v }.signum();
        let moves = |direction: f64| {
            let v = self.moved(v, force, here, dt, direction);
            (v * direction > 0.0).then_some(v)
        };
        let after = moves(likely).or_else(|| moves(-likely)).unwrap_or(0.0);
        [x + 0.5 * dt * (v + after), after]
    }

    /// Whether these are parameters that a machine can have.
    pub(super) fn is_possible(&self) -> bool {
        let travelling = self.viscous - self.slant.abs() >= 0.0 && self.coulomb >= 0.0;
        let gear = (0.0..1.0).contains(&self.transmitted)
            && (0.0..1.0).contains(&(self.motor_inertia / self.inertia));
        let stribeck = (0.0..=LARGEST_LEVEL).contains(&self.stribeck)
            && (self.stribeck == 0.0 || self.stribeck_speed > 0.0);
        let along = self.along.iter().map(|c| c.abs()).sum::<f64>() < 1.0;
        self.inertia > 0.0 && travelling && gear && stribeck && along
    }
}

impl Place {
    /// The middle of the travel (m or rad).
    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.travel[0] + self.travel[1])
    }

    /// Share of the travel, 0 to 1.
    fn share(&self, x: f64) -> f64 {
        ((x - self.travel[0]) / (self.travel[1] - self.travel[0])).clamp(0.0, 1.0)
    }
}
