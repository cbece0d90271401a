//! Friction and the other forces that resist motion, as a function of the path: a hysteresis law and the
//! effects that change its level or add to it.

use std::f64::consts::TAU;

use super::draw::Draw;
use super::effect::{Acting, Effect, Id, Present};
use super::law::Hysteresis;

/// Temperature (°C) and preload (N) at which the friction level is the nominal one.
pub const TEMPERATURE_C: f64 = 20.0;
/// See [`TEMPERATURE_C`].
pub const LOAD_N: f64 = 30.0;

/// The state of the moving part at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Now {
    /// Time (s).
    pub t: f64,
    /// Position (m).
    pub x: f64,
    /// Velocity (m/s).
    pub v: f64,
    /// Temperature (°C).
    pub temperature: f64,
    /// Preload (N).
    pub load: f64,
}

/// Resistance to motion with everything that it remembers.
#[derive(Clone)]
pub struct Friction<'a> {
    law: Hysteresis,
    effects: &'a [Effect],
    bursts: &'a [f64],
    half_travel: f64,
    breakaway: f64,
    x: f64,
    path: f64,
    lag: Option<f64>,
    age_s: f64,
    hysteretic: f64,
    heading: f64,
    /// Time and place of the last reversal, and the farthest point since (s, m, m).
    turn: (f64, f64, f64),
    recent_speed: f64,
    trend: f64,
    stirred: f64,
}

impl<'a> Friction<'a> {
    /// At rest at position 0. `bursts` are the start times (s) of [`Id::RandomBursts`].
    pub fn new(
        law: Hysteresis,
        effects: &'a [Effect],
        bursts: &'a [f64],
        half_travel: f64,
        breakaway: f64,
    ) -> Self {
        Friction {
            law,
            effects,
            bursts,
            half_travel,
            breakaway,
            x: 0.0,
            path: 0.0,
            lag: None,
            age_s: 0.0,
            hysteretic: 0.0,
            heading: 1.0,
            turn: (0.0, 0.0, 0.0),
            recent_speed: 0.0,
            trend: 0.0,
            stirred: 0.0,
        }
    }

    /// Moves to `now`, `dt` (s) after the last call, and returns the resisting force (N). `variability`
    /// multiplies the friction level: 1, or what does not repeat.
    pub fn step(&mut self, dt: f64, now: &Now, variability: f64) -> f64 {
        let dx = now.x - self.x;
        self.remember(dx, now);
        let mut acting = Acting::NONE;
        let present = Present {
            t: now.t,
            x: now.x,
            v: now.v,
            warmer: now.temperature - TEMPERATURE_C,
            loaded: now.load - LOAD_N,
            half_travel: self.half_travel,
            bursts: self.bursts,
            here: 1.0,
            corner: None,
        };
        let mut crept = 0.0;
        for effect in self.effects {
            let [p0, p1, ..] = effect.values;
            if effect.id == Id::Creep {
                crept += dt * p0 * (self.hysteretic / (p1 * self.breakaway)).sinh();
            } else {
                effect.act(&present, &mut acting);
                self.add_of_past(effect, dt, dx, now, &mut acting);
            }
        }
        // An element that creeps as fast as it is moved stays where it is: limits the sinh of an overload.
        let crept = crept.clamp(-1e-7, 1e-7);
        let level = acting.level * variability;
        let (up, down) = (
            (level + acting.tilt).max(0.05),
            (level - acting.tilt).max(0.05),
        );
        self.hysteretic = self.law.step(dx - crept, now.v, up, down);
        self.hysteretic + acting.added
    }

    /// The effects that depend on how the body came here.
    fn add_of_past(&mut self, effect: &Effect, dt: f64, dx: f64, now: &Now, acting: &mut Acting) {
        let Acting { level, added, .. } = acting;
        let [p0, p1, p2, p3] = effect.values;
        let speed = now.v.abs();
        match effect.id {
            Id::FrictionalLag => {
                let steady = p0 * (-(speed / p1).powf(p2)).exp();
                let before = self.lag.unwrap_or(steady);
                let after = steady + (before - steady) * (-dt / p3).exp();
                self.lag = Some(after);
                *level += after;
            }
            Id::RunIn => *level += p0 * (-self.path / p1).exp(),
            Id::DwellAging => {
                // Age of the contact: grows with time, erased along a path (Dieterich 1979).
                self.age_s = (self.age_s + dt) / (1.0 + dx.abs() / p2);
                *level += p0 * (1.0 + self.age_s / p1).log10();
            }
            Id::RelaxingMemory => {
                // Fades in over micrometres, so that a dithering rest does not chatter.
                let moved = 1.0 - (-(now.x - self.turn.1).abs() / 3e-6).exp();
                *added += p0 * self.heading * moved * (-(now.t - self.turn.0) / p1).exp();
            }
            Id::AccelerationFriction => {
                // Delayed by 20 ms: friction that answers its own acceleration at once has no solution.
                self.trend += (now.v - self.trend) * (1.0 - (-dt / 0.02).exp());
                let power = (now.v - self.trend) / 0.02 * now.v;
                *level += p0 * (power / p1).tanh();
            }
            Id::SpeedHistory => {
                self.recent_speed = speed.max(self.recent_speed * (-dt / p2).exp());
                *level -= p0 * self.recent_speed / (p1 + self.recent_speed);
            }
            Id::ReversalChurn => {
                // The reversal counts at the instant at which it is remembered.
                let turned = self.turn.0 == now.t && dx != 0.0;
                if turned {
                    self.stirred = (self.stirred + 1.0).min(3.0);
                }
                self.stirred *= (-dx.abs() / p1).exp();
                *level += p0 * self.stirred;
            }
            Id::PathRipple => *level += p0 * (TAU * self.path / p1 + p2).cos(),
            _ => {}
        }
    }

    /// Path travelled and the last reversal, which counts once the stage has come back by a micrometre
    /// from its farthest point; dither at rest is none.
    fn remember(&mut self, dx: f64, now: &Now) {
        const TURN: f64 = 1e-6;
        self.x = now.x;
        self.path += dx.abs();
        let farthest = self.turn.2;
        if (now.x - farthest) * self.heading > 0.0 {
            self.turn.2 = now.x;
        } else if (now.x - farthest) * self.heading < -TURN {
            self.heading = -self.heading;
            self.turn = (now.t, now.x, now.x);
        }
    }
}

/// Start times (s) of random bursts up to `end` (s), a Poisson process with the effect's mean interval.
pub fn burst_times(effects: &[Effect], end: f64, draw: &mut Draw) -> Vec<f64> {
    let Some(effect) = effects.iter().find(|e| e.id == Id::RandomBursts) else {
        return Vec::new();
    };
    let mut times = Vec::new();
    let mut t = 0.0;
    while t < end {
        t -= effect.values[3] * draw.uniform(1e-12, 1.0).ln();
        times.push(t);
    }
    times
}
