//! The force of a model with its effects along a recording.
//!
//! `F = delay(actuator(m·F_friction(x_load) + Σ forces + b·v + F0 + M·a))`, with the effects that only a host can use:
//!
//! - `backlash`: the load follows the motor with a play of the whole width `gap`. After a reversal it springs back with
//!   the motor until its friction is used up, rests while the gap is crossed, and is pushed from the other side.
//!   Quasi-static: the load's inertia and the impact at the gap's end are not in it.
//! - `creep`: while the blocks are loaded they give way, `dx ← dx − rate·T_s·sinh(F/(share·F_limit))`; needs a bounded friction model.
//! - `drive_compliance`: the load hangs on a spring behind the motor, which has the encoder: `x_load = x − F_t/k`, and
//!   `−F_t''/ω²` is added, with `F_t` the force transmitted to a rigid load and `k = ω²·M/2`: half of the inertia is taken to
//!   be the load's, which one recording does not show. `F_t''` is the second difference over a quarter of the
//!   resonance's period, so what changes faster than the resonance is left out.
//! - `torque_ripple`, `actuator_saturation`, `actuator_dead_zone`: from the force back to the command, as far as it can be known.
//! - `channel_delay`: the force `τ` earlier, interpolated; each piece begins and ends with its own first and last value.

use super::Model;
use super::running::Running;
use crate::effects::Effect;
use crate::effects::form::{self, Column, Form};
use crate::effects::term;
use crate::friction::{Path, Transmission};
use preslide::effects::{Effect as _, EncoderError, Situation};
use std::f64::consts::TAU;
use std::ops::Range;

/// What was measured along a [`Path`] beside the motion; each as long as the path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured<'a> {
    /// Time stamps (s), to bridge gaps; without them samples are taken to follow each other.
    pub t_s: Option<&'a [f64]>,
    /// Acceleration (m/s² or rad/s²); without it the force of the inertia is left out.
    pub acceleration: Option<&'a [f64]>,
    /// Temperature (°C), which `thermal_drift` with `level_per_K` needs.
    pub temperature_c: Option<&'a [f64]>,
    /// Normal load (N), which `load_dependent_friction` needs.
    pub load_n: Option<&'a [f64]>,
}

/// Most ticks by which a gap between two pieces is bridged; longer ones are taken as that.
const LONGEST_GAP: f64 = 1e7;

impl Model {
    /// Friction, viscous and constant force and all effects (N or N·m) at every sample, without inertia.
    ///
    /// # Errors
    /// [`Model::force_along`], and an effect that needs what is measured beside the motion.
    pub fn resistance(&self, path: Path) -> Result<Vec<f64>, String> {
        self.force_along(path, &Measured::default())
    }

    /// The force (N or N·m) that the motion takes at every sample: inertia where the acceleration is given, friction,
    /// viscous and constant force, and every effect.
    ///
    /// # Errors
    /// A parameter that the library refuses; an effect that needs a column that is not there, named with the remedy.
    /// Nothing is left out silently.
    pub fn force_along(&self, path: Path, measured: &Measured) -> Result<Vec<f64>, String> {
        self.has_columns(measured)?;
        let motion = self.true_motion(path, measured)?;
        let (friction, springs) = self.transmitted(path, &motion)?;
        let mut force = self.beside_friction(path, measured, &motion, friction, &springs)?;
        self.behind_the_actuator(path, &mut force);
        Ok(force)
    }

    /// The effects of a form.
    pub fn of<'a>(&'a self, form: &'static Form) -> impl Iterator<Item = &'a Effect> {
        self.effects.iter().filter(move |effect| effect.is(form))
    }

    /// Whether what the effects need was measured.
    pub(super) fn has_columns(&self, measured: &Measured) -> Result<(), String> {
        let has = |column| match column {
            Column::Temperature => measured.temperature_c.is_some(),
            Column::Load => measured.load_n.is_some(),
        };
        for effect in &self.effects {
            if let Some((column, way)) = effect.form.needs
                && !has(column)
            {
                let (id, column) = (effect.id(), column.name());
                return Err(format!(
                    "effect {id}: the recording has no column {column}; record it, bring it in with --map {column}=COLUMN, or use {way} in the model"
                ));
            }
        }
        Ok(())
    }

    /// Where the axis is: the recording without the encoder's errors.
    fn true_motion(&self, path: Path, measured: &Measured) -> Result<Motion, String> {
        let mut motion = Motion {
            position: path.position.to_vec(),
            velocity: path.velocity.to_vec(),
            acceleration: measured.acceleration.map(<[f64]>::to_vec),
        };
        for encoder in Encoder::of(self)? {
            for (i, &read) in path.position.iter().enumerate() {
                let mut at = [
                    motion.position[i],
                    motion.velocity[i],
                    motion.acceleration.as_ref().map_or(0.0, |all| all[i]),
                ];
                encoder.correct(read, &mut at);
                [motion.position[i], motion.velocity[i]] = [at[0], at[1]];
                if let Some(acceleration) = &mut motion.acceleration {
                    acceleration[i] = at[2];
                }
            }
        }
        Ok(motion)
    }

    /// What lies between the encoder and the friction.
    pub(super) fn transmission(&self) -> Transmission {
        let creep = self.of(&form::CREEP).next();
        let gaps = self.of(&form::BACKLASH).map(|effect| effect.get("gap_m"));
        Transmission {
            creep: creep.map(|effect| (effect.get("rate_m_s"), effect.get("share_of_breakaway"))),
            gap: gaps.sum(),
        }
    }

    /// Friction of the load, behind play and springs, and what the springs add.
    fn transmitted(&self, path: Path, motion: &Motion) -> Result<(Vec<f64>, Vec<f64>), String> {
        let transmission = self.transmission();
        let of_load = |position: &[f64]| {
            let path = Path {
                position,
                velocity: &motion.velocity,
                ..path
            };
            self.friction
                .force_through(path, transmission)
                .map_err(|e| e.to_string())
        };
        let mut friction = of_load(&motion.position)?;
        let mut springs = vec![0.0; friction.len()];
        for effect in self.of(&form::DRIVE_COMPLIANCE) {
            if self.inertia <= 0.0 {
                return Err("effect drive_compliance: needs the inertia, which gives the spring its stiffness; identify it, or remove the effect".to_owned());
            }
            let frequency = effect.get("frequency_Hz");
            let load = 0.5 * self.inertia;
            // Two equal masses, free: ω² = 4k/M.
            let stiffness = 0.5 * load * (TAU * frequency).powi(2);
            let mut transmitted = friction;
            if let Some(acceleration) = &motion.acceleration {
                for (f, a) in transmitted.iter_mut().zip(acceleration) {
                    *f += load * a;
                }
            }
            let behind: Vec<f64> = motion
                .position
                .iter()
                .zip(&transmitted)
                .map(|(x, f)| x - f / stiffness)
                .collect();
            friction = of_load(&behind)?;
            let inertia = load / stiffness;
            spring(&mut springs, &transmitted, inertia, path);
        }
        Ok((friction, springs))
    }

    /// Friction at the level of each tick, and every force beside it, inertia among them.
    fn beside_friction(
        &self,
        path: Path,
        measured: &Measured,
        motion: &Motion,
        friction: Vec<f64>,
        springs: &[f64],
    ) -> Result<Vec<f64>, String> {
        let mut running = Running::of(self, path.sample_time)?;
        let mut force = friction;
        for (number, piece) in path.pieces.iter().enumerate() {
            for i in piece.clone() {
                let at = Situation {
                    position: motion.position[i],
                    located: true,
                    velocity: motion.velocity[i],
                    friction: force[i],
                    temperature: measured.temperature_c.map(|column| column[i]),
                    load: measured.load_n.map(|column| column[i]),
                };
                if i == piece.start && number > 0 {
                    let still = Situation {
                        velocity: 0.0,
                        ..at
                    };
                    for _ in 0..missing_ticks(measured.t_s, i, path.sample_time) {
                        running.tick(&still);
                    }
                }
                let a = motion.acceleration.as_ref().map_or(0.0, |all| all[i]);
                force[i] = running.whole(&at, springs[i], self.inertia, a);
            }
        }
        Ok(force)
    }

    /// What the drive gives of its command at a position (m or rad).
    pub(crate) fn given_of_command(&self, position: f64) -> f64 {
        let ripples = self.of(&form::TORQUE_RIPPLE).map(|effect| {
            let phase = TAU * position / effect.get("period_m") + effect.get("phase_rad");
            1.0 + effect.get("share") * phase.cos()
        });
        ripples.product()
    }

    /// From the force (N or N·m) at a position of the encoder (m or rad) back to the command.
    pub(super) fn command(&self, force: f64, position: f64) -> f64 {
        let mut command = force / self.given_of_command(position);
        for effect in self.of(&form::ACTUATOR_SATURATION) {
            let limit = effect.get("limit_N");
            command = command.clamp(-limit, limit);
        }
        for effect in self.of(&form::ACTUATOR_DEAD_ZONE) {
            if command != 0.0 {
                command += (0.5 * effect.get("width_N")).copysign(command);
            }
        }
        command
    }

    /// From the force back to the command, and to when it was sampled.
    fn behind_the_actuator(&self, path: Path, force: &mut [f64]) {
        if self
            .effects
            .iter()
            .any(|effect| OF_ACTUATOR.contains(&effect.form))
        {
            for (f, x) in force.iter_mut().zip(path.position) {
                *f = self.command(*f, *x);
            }
        }
        for effect in self.of(&form::CHANNEL_DELAY) {
            delay(force, effect.get("delay_s") / path.sample_time, path.pieces);
        }
    }
}

/// Effects that lie between command and force.
static OF_ACTUATOR: [&Form; 3] = [
    &form::TORQUE_RIPPLE,
    &form::ACTUATOR_SATURATION,
    &form::ACTUATOR_DEAD_ZONE,
];

/// A motion as one part of the machine makes it.
#[derive(Clone)]
struct Motion {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Option<Vec<f64>>,
}

/// An encoder's error at work.
pub(super) struct Encoder {
    own: EncoderError<f64>,
    /// `2π/p`, error and phase.
    wave: [f64; 3],
}

impl Encoder {
    /// Those of a model.
    pub(super) fn of(model: &Model) -> Result<Vec<Self>, String> {
        let encoder = |effect: &Effect| {
            let own = term::encoder(effect).map_err(|e| format!("effect {}: {e}", effect.id()))?;
            let wave = [
                TAU / effect.get("period_m"),
                effect.get("error_m"),
                effect.get("phase_rad"),
            ];
            Ok(Self { own, wave })
        };
        model.of(&form::ENCODER_ERROR).map(encoder).collect()
    }

    /// From what the encoder reads to where the axis is: `x ← x + s(x)`, `v ← v·(1 + s')`, `a ← a·(1 + s') + s''·v²`.
    pub(super) fn correct(&self, read: f64, [x, v, a]: &mut [f64; 3]) {
        let [k, error, phase] = self.wave;
        *x += self.own.shift(read);
        let (sin, cos) = (k * read + phase).sin_cos();
        let slope = 1.0 + error * k * sin;
        *a = *a * slope + error * k * k * cos * *v * *v;
        *v *= slope;
    }
}

/// Ticks that lie between sample `i` and the one before it beyond the usual one.
fn missing_ticks(t_s: Option<&[f64]>, i: usize, sample_time: f64) -> u64 {
    let Some(t_s) = t_s else { return 0 };
    let gap = (t_s[i] - t_s[i - 1]) / sample_time;
    // A clock that starts again shows nothing.
    if gap > 1.0 {
        (gap.min(LONGEST_GAP).round() as u64).saturating_sub(1)
    } else {
        0
    }
}

/// Adds `−F_t''·M_load/k` to `added`; `ratio` is `M_load/k` (s²).
fn spring(added: &mut [f64], transmitted: &[f64], ratio: f64, path: Path) {
    let span = ((0.25 * TAU * ratio.sqrt() / path.sample_time).round() as usize).max(1);
    let scale = ratio / (span as f64 * path.sample_time).powi(2);
    for piece in path.pieces.iter().filter(|piece| !piece.is_empty()) {
        for i in piece.clone() {
            let before = transmitted[i.saturating_sub(span).max(piece.start)];
            let after = transmitted[(i + span).min(piece.end - 1)];
            added[i] -= scale * (before - 2.0 * transmitted[i] + after);
        }
    }
}

/// The values `ticks` earlier, interpolated.
fn delay(force: &mut [f64], ticks: f64, pieces: &[Range<usize>]) {
    let prompt = force.to_vec();
    for piece in pieces.iter().filter(|piece| !piece.is_empty()) {
        let last = piece.len() - 1;
        for (n, f) in force[piece.clone()].iter_mut().enumerate() {
            let at = (n as f64 - ticks).clamp(0.0, last as f64);
            let low = at.floor() as usize;
            let part = at - low as f64;
            let of = |n: usize| prompt[piece.start + n.min(last)];
            *f = of(low) + part * (of(low + 1) - of(low));
        }
    }
}
