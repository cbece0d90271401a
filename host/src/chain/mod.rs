//! The whole chain, once around: a stage that hides an effect, what is recorded of it, and how well it is followed.
//!
//! `cargo xtask chain` runs it with the firmware in QEMU, `preslide demo` with the same control code on the host. Whoever
//! diagnoses gets the recording and the model that was identified from it; what is concealed stays in this module.

mod known;
mod motions;
mod on_host;

pub use known::known;
pub use motions::{judged, recorded};
pub use on_host::{follow, record};

use crate::stage::concealed::Concealed;
use crate::stage::{EncoderConfig, FrictionConfig, Stage, StageConfig, StageError};

/// The stage that hides `effect` and nothing else: the paper's axis with its hysteresis of 64 elements that wanders by ±15 %,
/// its viscous friction, ripple and quantisation, but without the Stribeck drop and the interpolation error that the default
/// has, which would be effects of their own. `seed` is that of friction's randomness.
///
/// # Errors
/// [`StageError`] where the effect is out of the stage's range.
pub fn stage(effect: Concealed, seed: u64) -> Result<Stage, StageError> {
    let config = StageConfig {
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
    };
    Stage::concealing(config, effect)
}
