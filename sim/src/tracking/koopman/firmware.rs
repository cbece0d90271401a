//! The input of a board's outer task: learnt on the stage, written as source.

use super::learnt::learn;
use super::predictive::Weights;
use super::{BLOCKS, DELAYS, MOVES, STATES, TICKS};
use crate::stage::StageConfig;
use crate::tracking::TrackingError;
use preslide::control::koopman::{Outer, OuterSettings};
use preslide::control::{NoFriction, PidGains, Settings};
use preslide_host::paper;

/// What the outer task of [`super::Contender::Koopman`] is built of.
pub type FirmwareSettings = OuterSettings<STATES, BLOCKS, MOVES>;

/// That task.
pub type FirmwareTask = Outer<STATES, BLOCKS, DELAYS, MOVES>;

/// Not those of the verdict's search, which takes minutes.
pub(super) const WEIGHTS: Weights = Weights {
    effort: 1e-16,
    change: 1e-13,
    gain: 0.05,
};

/// The axis with the integral's place free, for the outer task.
pub(super) fn guided(settings: &Settings) -> Settings {
    Settings {
        gains: PidGains {
            integral: 0.0,
            ..settings.gains
        },
        ..*settings
    }
}

/// Yield displacements (m) of the paper's Table 3, four blocks.
pub(super) fn yields() -> [f64; BLOCKS] {
    paper::TABLE_3[BLOCKS - 2]
        .blocks
        .first_chunk::<BLOCKS>()
        .map_or([0.0; BLOCKS], |blocks| {
            blocks.map(|(k, alpha)| alpha * paper::BREAKAWAY / k)
        })
}

/// Learns, for an axis on a stage, its loop of proportional and derivative feedback.
///
/// # Errors
/// [`TrackingError`] where no map can be fitted.
pub fn firmware(
    settings: &Settings,
    stage: StageConfig,
) -> Result<FirmwareSettings, TrackingError> {
    let yields = yields();
    let none = NoFriction::<f32>::new();
    let learnt = learn(&guided(settings), none, stage, &yields, false)?;
    Ok(OuterSettings {
        ticks: TICKS,
        yields,
        compensated: false,
        gain: WEIGHTS.gain,
        model: learnt.model,
        cost: WEIGHTS.cost(),
    })
}

/// As source, for PRESLIDE_KOOPMAN.
pub fn source(settings: &FirmwareSettings) -> String {
    format!(
        "\
// Written by `track -- koopman-firmware`: the outer task over proportional and derivative feedback. Set gains.integral to 0 beside it.
#[allow(clippy::unreadable_literal)]
/// What the outer task is built of.
pub const SETTINGS: preslide::control::koopman::OuterSettings<{STATES}, {BLOCKS}, {MOVES}> = {{
    use preslide::control::koopman::{{KoopmanModel, KoopmanSettings, OuterSettings}};
    {settings:?}
}};

/// The outer task.
pub type Outer = preslide::control::koopman::Outer<{STATES}, {BLOCKS}, {DELAYS}, {MOVES}>;
"
    )
}
