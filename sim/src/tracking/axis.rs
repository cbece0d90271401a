//! The production controller on the simulated stage, tick by tick.

use crate::stage::{
    ElectricalConfig, Sampling, SenseConfig, Stage, StageConfig, StageError, interpolated_m,
};
use preslide::control::{
    Coefficients, Command, Condition, Controller, Fault, Hardware, Measurement, Move, Settings,
};
use preslide::{Friction, ParamError, Units};

/// Ticks at rest in which the controller learns the current sense's offset: eight times the time constant of its mean.
const CALIBRATION_TICKS: u32 = 2048;

/// Why a run could not be made.
#[derive(Debug, thiserror::Error)]
pub enum TrackingError {
    /// The stage's configuration is not usable.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The controller's settings or a friction model's parameters are not usable.
    #[error("controller: {0}")]
    Parameter(ParamError),
    /// The identification experiment did not lead to a model.
    #[error("identification: {0}")]
    Identification(String),
    /// No gains of an observer leave their margins.
    #[error("observer: {0}")]
    Observer(String),
    /// The controller gave up where it should not have.
    #[error("the axis stopped with {0:?}; the gains do not fit the stage")]
    Stopped(Fault),
}

impl From<ParamError> for TrackingError {
    fn from(error: ParamError) -> Self {
        Self::Parameter(error)
    }
}

/// A motion in SI, to be planned for any arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// A move by `distance_m` at up to `speed_m_s`, reached in `ramp_s`.
    Move {
        /// Signed distance (m).
        distance_m: f64,
        /// Speed (m/s).
        speed_m_s: f64,
        /// Time to reach it (s).
        ramp_s: f64,
    },
    /// Rest for this time (s).
    Dwell(f64),
}

impl Step {
    /// The planned move.
    ///
    /// # Errors
    /// [`ParamError`] where the move cannot be planned.
    pub fn plan(&self, settings: &Settings) -> Result<Move, ParamError> {
        match *self {
            Step::Move {
                distance_m,
                speed_m_s,
                ramp_s,
            } => Move::plan(distance_m, speed_m_s, speed_m_s / ramp_s, settings.grid()),
            Step::Dwell(time_s) => Move::dwell(time_s, settings.sample_time()),
        }
    }

    /// Several, one after the other.
    ///
    /// # Errors
    /// As of [`Step::plan`].
    pub fn plan_all(steps: &[Self], settings: &Settings) -> Result<Vec<Move>, ParamError> {
        steps.iter().map(|step| step.plan(settings)).collect()
    }
}

/// What one tick looked like from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Which step of the motion was running.
    pub step: usize,
    /// The controller's decision.
    pub command: Command,
    /// The encoder's position before quantisation (m), for scoring.
    pub encoder_m: f64,
    /// True position of the mass (m), for scoring.
    pub true_m: f64,
    /// Winding current (A) as a drive measures it, less its reading at rest.
    pub current_a: f64,
}

/// The controller with the friction model `F` closed around a stage.
pub struct Axis<F: Friction> {
    controller: Controller<F, u32>,
    stage: Stage,
    steps: f64,
    hardware: Hardware,
    /// Encoder position at the controller's zero (m), which its quantisation and interpolation leave.
    origin_m: f64,
}

/// The stage with the default electrical model, its current sampled where the firmware does; `settings` get its dead time.
pub fn electrical(settings: &mut Settings, stage: StageConfig) -> StageConfig {
    let electrical = ElectricalConfig {
        sense: SenseConfig {
            sampling: Sampling::Synchronous(settings.sampling_phase()),
            ..SenseConfig::default()
        },
        ..ElectricalConfig::default()
    };
    settings.hardware = settings
        .hardware
        .with_dead_time(electrical.dead_time_s, electrical.diode_v);
    StageConfig {
        electrical: Some(electrical),
        ..stage
    }
}

impl<F: Friction> Axis<F> {
    /// Both at rest, and homed.
    ///
    /// # Errors
    /// [`TrackingError`] where the settings or the stage's configuration are not usable.
    pub fn try_new(
        settings: &Settings,
        friction: F,
        units: Units,
        stage: StageConfig,
    ) -> Result<Self, TrackingError> {
        Self::on(settings, friction, units, Stage::try_new(stage)?)
    }

    /// On a stage that stands where it is.
    ///
    /// # Errors
    /// [`TrackingError`] where the settings are not usable.
    pub fn on(
        settings: &Settings,
        friction: F,
        units: Units,
        stage: Stage,
    ) -> Result<Self, TrackingError> {
        let coefficients = Coefficients::try_new(settings, friction, units)?;
        let first = stage.reading().count;
        let mut controller = Controller::new(coefficients, first.cast_unsigned());
        // Homed: it knows where the stage stands, to the nearest count.
        let here = (stage.truth().position_m / settings.encoder.count).round() as i32;
        controller.set_position(0, here.into());
        let origin = first.wrapping_sub(stage.config().encoder.origin_count);
        let mut axis = Self {
            controller,
            stage,
            steps: settings.hardware.steps.into(),
            hardware: settings.hardware,
            origin_m: f64::from(origin - here) * settings.encoder.count,
        };
        // A current sense with an offset is read at rest first, as on a board.
        if axis.stage.config().electrical.is_some() {
            for _ in 0..CALIBRATION_TICKS {
                axis.tick();
            }
        }
        axis.controller.enable().map_err(TrackingError::Stopped)?;
        Ok(axis)
    }

    /// One tick: reads, decides, acts.
    pub fn tick(&mut self) -> (Command, f64, f64, f64) {
        let reading = self.stage.reading();
        let true_m = self.stage.truth().position_m;
        let encoder_m = interpolated_m(&self.stage.config().encoder, true_m) - self.origin_m;
        // Who simulates it is not silent.
        self.controller.heard();
        let command = self.controller.tick(Measurement {
            count: reading.count.cast_unsigned(),
            // Saturating: what an ADC does.
            supply: (reading.supply_v / self.hardware.supply_code).round() as u16,
            current: (reading.current_a / self.hardware.current_code).round() as i16,
            late: false,
        });
        self.stage.tick(f64::from(command.code) / self.steps);
        let offset_a = f64::from(self.controller.current_at_rest()) * self.hardware.current_code;
        (command, encoder_m, true_m, reading.current_a - offset_a)
    }

    /// Follows the moves one after the other and shows every tick to `observe`; ends early at a fault.
    pub fn follow(&mut self, moves: &[Move], mut observe: impl FnMut(Instant)) {
        for (step, &next) in moves.iter().enumerate() {
            self.start(next);
            while !self.controller.is_idle() {
                let (command, encoder_m, true_m, current_a) = self.tick();
                observe(Instant {
                    step,
                    command,
                    encoder_m,
                    true_m,
                    current_a,
                });
                if command.fault.is_some() {
                    return;
                }
            }
        }
    }

    /// The stage, for scoring.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// The stage, to change it.
    pub fn stage_mut(&mut self) -> &mut Stage {
        &mut self.stage
    }

    /// What a friction model that learns has to say.
    pub fn condition(&self) -> Condition<F::Scalar> {
        self.controller.condition()
    }

    /// The winding's resistance over the configured one, as the controller follows it.
    pub fn resistance_share(&self) -> f64 {
        f64::from(self.controller.resistance_share()) / 65536.0
    }

    /// The friction model's memory.
    pub fn friction_state(&mut self) -> &mut F::State {
        self.controller.friction_state()
    }

    /// Starts a move; the next ticks follow it.
    pub fn start(&mut self, next: Move) {
        // What is refused is not made, and shows in the score: studies plan moves within the axis's limits.
        let _ = self.controller.start(next);
    }

    /// The move is done.
    pub fn is_idle(&self) -> bool {
        self.controller.is_idle()
    }
}
