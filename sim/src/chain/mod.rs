//! The whole chain: a stage that hides an effect, what is recorded of it, and how well it is followed.
//!
//! `cargo xtask chain` runs it with the firmware in QEMU, `preslide demo` with the same control code on the host. The
//! diagnosis gets the recording and the model identified from it; what is concealed stays in this module.

mod any;
mod known;
mod motions;
mod on_emulator;
mod on_host;
mod table;

pub use known::known;
pub use motions::{judged, recorded};
pub use on_emulator::{serve, track};
pub use on_host::{Followed, follow, follow_by, record, rehearse};
pub use table::{Diagnosed, Errors, Row, Tracked, table};

use crate::stage::concealed::Concealed;
use crate::stage::{EncoderConfig, FrictionConfig, Stage, StageConfig, StageError};
use crate::tracking::{Step, electrical};
use preslide::control::Settings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Times that a machine is switched on: to be recorded, and to be judged.
const RECORDED: u64 = 0;
const JUDGED: u64 = 1;

/// Keeps where it is switched on apart from what else a seed makes.
const SWITCHED_ON: u64 = 0x0a;

/// One concealed effect, and the machine that hides it: recorded, switched off, and followed on the same day.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is concealed.
    pub effect: Concealed,
    /// The machine.
    pub config: StageConfig,
    /// What its controller knows.
    pub axis: Settings,
}

impl Trial {
    /// The trials of a seed: every kind of effect once before any comes again ([`Concealed::draw`]).
    pub fn draw(seed: u64, count: usize) -> Vec<Self> {
        let of = |(index, effect)| Self {
            effect,
            config: config(seed.wrapping_mul(1000).wrapping_add(index as u64)),
            axis: Settings::PAPER_AXIS,
        };
        let effects = Concealed::draw(seed, count).into_iter();
        effects.enumerate().map(of).collect()
    }

    /// The same on another axis than the paper's.
    #[must_use]
    pub fn on(self, axis: &Settings) -> Self {
        Self {
            config: self.config.on(axis),
            axis: *axis,
            ..self
        }
    }

    /// The same on the electrical stage, its dead time known to the controller.
    #[must_use]
    pub fn electrical(mut self) -> Self {
        self.config = electrical(&mut self.axis, self.config);
        self
    }

    /// The machine as it is switched on for the `run`-th time: somewhere within the middle millimetre, with any count. Only homing
    /// tells it where it is, so what is recorded in one run and compensated in another is bound to places, not to counts.
    #[must_use]
    pub fn switched_on(&self, run: u64) -> StageConfig {
        let mut draw = ChaCha8Rng::seed_from_u64(self.config.seed);
        draw.set_stream(SWITCHED_ON + run);
        let count_m = self.config.encoder.count_m;
        StageConfig {
            // Whole counts: a host tells the place as a number of them.
            start_m: (draw.random_range(-0.5e-3..0.5e-3) / count_m).round() * count_m,
            encoder: EncoderConfig {
                origin_count: draw.random(),
                ..self.config.encoder.clone()
            },
            ..self.config.clone()
        }
    }

    /// The stage as it is switched on for the `run`-th time, at rest.
    ///
    /// # Errors
    /// [`StageError`] where the effect is out of the stage's range.
    pub fn stage(&self, run: u64) -> Result<Stage, StageError> {
        Stage::concealing(self.switched_on(run), self.effect)
    }

    /// A motion from where the machine is switched on for the `run`-th time: to the origin first.
    #[must_use]
    pub fn from_start(&self, run: u64, steps: Vec<Step>) -> Vec<Step> {
        let home = Step::Move {
            distance_m: -self.switched_on(run).start_m,
            speed_m_s: 2e-3,
            ramp_s: 0.02,
        };
        std::iter::once(home).chain(steps).collect()
    }
}

/// A stage that hides nothing but what it will conceal: the paper's axis with its hysteresis of 64 elements that wanders by
/// ±15 %, its viscous friction, ripple and quantisation, but without the Stribeck drop and the interpolation error of the default,
/// which would be effects of their own.
fn config(seed: u64) -> StageConfig {
    StageConfig {
        encoder: EncoderConfig {
            error_order1_m: 0.0,
            error_order2_m: 0.0,
            ..EncoderConfig::default()
        },
        friction: FrictionConfig {
            stribeck_drop: 0.0,
            ..FrictionConfig::default()
        },
        seed,
        ..StageConfig::default()
    }
}
