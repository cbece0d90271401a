//! A model tick after tick: what [`Model::force_along`] gives of a whole path, for programs that know only the present.

use super::along::Encoder;
use super::running::Running;
use super::{Measured, Model};
use crate::effects::form;
use crate::friction::Tick;
use preslide::effects::Situation;

/// A model at work, from rest.
pub struct Stepper {
    model: Model,
    sample_time: f64,
    encoders: Vec<Encoder>,
    friction: Tick,
    running: Running,
    last: Option<f64>,
}

/// What is known of a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Now {
    /// Position (m or rad).
    pub position: f64,
    /// Velocity (m/s or rad/s); without it the way since the last tick over its time, 0 at first.
    pub velocity: Option<f64>,
    /// Acceleration (m/s² or rad/s²); without it the force of the inertia is left out.
    pub acceleration: Option<f64>,
    /// Temperature (°C).
    pub temperature_c: Option<f64>,
    /// Normal load (N).
    pub load_n: Option<f64>,
}

impl Stepper {
    /// A model at rest, for ticks of `sample_time` (s).
    ///
    /// # Errors
    /// A parameter that the library refuses; an effect that needs what comes later, or that belongs to a recording; a time that is not positive.
    pub fn of(model: &Model, sample_time: f64) -> Result<Self, String> {
        if !(sample_time.is_finite() && sample_time > 0.0) {
            return Err(format!(
                "{sample_time} s is not the length of a tick; give one above zero"
            ));
        }
        for (form, reason) in [
            (
                &form::DRIVE_COMPLIANCE,
                "its spring is solved with the samples that come after",
            ),
            (
                &form::CHANNEL_DELAY,
                "it is how a recording was made, not what the axis takes",
            ),
        ] {
            if model.of(form).next().is_some() {
                return Err(format!(
                    "effect {}: it cannot be computed tick by tick: {reason}; compute the whole path, or remove it from the model",
                    form.id
                ));
            }
        }
        Ok(Self {
            sample_time,
            encoders: Encoder::of(model)?,
            friction: model
                .friction
                .at_work(model.transmission(), sample_time)
                .map_err(|e| e.to_string())?,
            running: Running::of(model, sample_time)?,
            last: None,
            model: model.clone(),
        })
    }

    /// The force (N or N·m) that the tick takes.
    ///
    /// # Errors
    /// An effect that needs a temperature or a load that is not given.
    #[inline]
    pub fn step(&mut self, now: &Now) -> Result<f64, String> {
        self.model.has_columns(&Measured {
            temperature_c: now.temperature_c.as_ref().map(std::slice::from_ref),
            load_n: now.load_n.as_ref().map(std::slice::from_ref),
            ..Measured::default()
        })?;
        let way = now.position - self.last.replace(now.position).unwrap_or(now.position);
        let velocity = now.velocity.unwrap_or(way / self.sample_time);
        let mut at = [now.position, velocity, now.acceleration.unwrap_or(0.0)];
        for encoder in &self.encoders {
            encoder.correct(now.position, &mut at);
        }
        // What the encoder's error adds to an acceleration belongs to one that was given.
        let acceleration = now.acceleration.map_or(0.0, |_| at[2]);
        let at = Situation {
            position: at[0],
            located: true,
            velocity: at[1],
            friction: (self.friction)(at[0], at[1]),
            temperature: now.temperature_c,
            load: now.load_n,
        };
        let force = self
            .running
            .whole(&at, 0.0, self.model.inertia, acceleration);
        Ok(self.model.command(force, now.position))
    }
}
