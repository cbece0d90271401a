//! The whole chain, once around: a stage that hides an effect, what is recorded of it, and how well it is followed.
//!
//! `cargo xtask chain` runs it with the firmware in QEMU, `preslide demo` with the same control code on the host. Whoever
//! diagnoses gets the recording and the model that was identified from it; what is concealed stays in this module.

mod known;
mod motions;
mod on_emulator;
mod on_host;
mod table;

pub use known::known;
pub use motions::{judged, recorded};
pub use on_emulator::{serve, track};
pub use on_host::{Followed, follow, record, rehearse};
pub use table::{Errors, Row, Told, table};

use crate::stage::concealed::Concealed;
use crate::stage::{EncoderConfig, FrictionConfig, Stage, StageConfig, StageError};

/// One concealed effect, and the machine that hides it: recorded, switched off, and followed on the same day.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is concealed.
    pub effect: Concealed,
    /// The machine.
    pub config: StageConfig,
}

impl Trial {
    /// The trials of a seed: every kind of effect once before any comes again ([`Concealed::draw`]).
    pub fn draw(seed: u64, count: usize) -> Vec<Self> {
        let of = |(index, effect)| Self {
            effect,
            config: config(seed.wrapping_mul(1000).wrapping_add(index as u64)),
        };
        let effects = Concealed::draw(seed, count).into_iter();
        effects.enumerate().map(of).collect()
    }

    /// The stage, at rest.
    ///
    /// # Errors
    /// [`StageError`] where the effect is out of the stage's range.
    pub fn stage(&self) -> Result<Stage, StageError> {
        Stage::concealing(self.config.clone(), self.effect)
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
