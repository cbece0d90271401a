//! What a model left out of a recording: located, named, modelled and shown on folds that no fit saw.

pub mod blocks;
pub mod bursts;
pub mod catalogue;
pub mod columns;
pub mod conclude;
pub mod experiment;
mod extend;
pub mod noise;
mod parameters;
mod present;
pub mod score;
pub mod search;
mod shape;
pub mod signals;
pub mod signature;
pub mod spectra;
pub mod study;
pub mod weak;

use crate::friction::FrictionModel;
use crate::model::Model;
use crate::progress::Progress;
use crate::recording::Recording;
pub use conclude::Diagnosis;
use study::{Study, Term};
use thiserror::Error;

/// Ratio of sample times from which recordings are too unlike for one kernel.
const UNLIKE: f64 = 3.0;

/// Warnings of the loader that leave nothing to diagnose, with what would.
const FATAL: [(&str, &str); 3] = [
    ("no-motion", "record a motion"),
    ("too-short", "record for longer"),
    (
        "constant-effort",
        "record or map the column that holds the effort",
    ),
];

/// Why there is no diagnosis.
#[derive(Debug, Error)]
pub enum Refusal {
    /// The input is wrong.
    #[error("{0}")]
    Input(String),
    /// The data cannot tell.
    #[error("{0}")]
    Data(String),
}

/// Diagnoses a recording against a model, or against rigid body and GMS alone.
///
/// # Errors
/// [`Refusal`], with what to do.
pub fn diagnose(
    recording: &Recording,
    model: Option<&Model>,
    progress: &Progress,
) -> Result<(Study, Diagnosis), Refusal> {
    for (code, remedy) in FATAL {
        if let Some(warning) = recording.warnings.iter().find(|w| w.code == code) {
            return Err(Refusal::Data(format!(
                "{}: {warning}; {remedy}",
                recording.name
            )));
        }
    }
    if !matches!(recording.effort_unit(), "N" | "Nm") {
        return Err(Refusal::Input(format!(
            "{}: the effort is a {} in {}, which is no force; map it with the drive's constant, such as --map force_N=35.15*voltage_V or --map torque_Nm=0.0066*current_A",
            recording.name,
            recording.role.name(),
            recording.effort_unit()
        )));
    }
    one_sample_time(recording)?;
    if let Some(model) = model
        && model.motion != recording.kind
    {
        return Err(Refusal::Input(format!(
            "motion: the model is {}, {} is {}; give the model of this machine",
            model.motion.name(),
            recording.name,
            recording.kind.name()
        )));
    }
    let mut study = Study::new(recording).map_err(Refusal::Data)?;
    progress.inc(1);
    let given = model.map(given).unwrap_or_default();
    let mechanics = model.map(|m| m.mechanics.clone()).unwrap_or_default();
    let periods: Vec<f64> = mechanics
        .iter()
        .filter(|(key, _)| key != "encoder_count_m")
        .map(|m| m.1)
        .collect();
    let unable = || {
        Refusal::Data(format!(
            "{}: the motion does not determine inertia and friction; record both directions at several speeds",
            recording.name
        ))
    };
    let found = search::search(&mut study, &given, &periods, progress).ok_or_else(unable)?;
    let shape_error = model.and_then(|m| study.shape_error(&m.friction, &found.state));
    let diagnosis = conclude::conclude(&study, found, given.len(), &mechanics, shape_error)
        .ok_or_else(unable)?;
    Ok((study, diagnosis))
}

/// What the user's model already has.
fn given(model: &Model) -> Vec<Term> {
    let mut terms = Vec::new();
    let mut give = |id, shape: &[f64]| {
        terms.push(Term {
            given: true,
            ..Term::new(id, shape)
        });
    };
    if model.viscous != 0.0 {
        give("viscous", &[]);
    }
    if model.constant_force != 0.0 {
        give("constant_force", &[]);
    }
    if let FrictionModel::Gms {
        sliding: Some(sliding),
        ..
    }
    | FrictionModel::LuGre { sliding, .. } = &model.friction
        && sliding.coulomb > 0.0
    {
        let shape = [sliding.stribeck_velocity, sliding.stribeck_exponent, 0.0];
        give("stribeck", &shape);
    }
    for effect in &model.effects {
        let shape: Vec<f64> = match effect.id {
            // Its centre is free where no constant force stands for it.
            "position_spring" if model.constant_force == 0.0 => vec![1.0],
            "position_force" | "position_friction" => vec![effect.cosines().len() as f64],
            // The model file's drive has as much inertia on both sides.
            "drive_compliance" => vec![columns::MOTOR_SHARE],
            "thermal_drift" if effect.has("level_per_K") => Vec::new(),
            id => columns::parameters(id)
                .iter()
                .map(|(key, _)| effect.get(key))
                .collect(),
        };
        give(effect.id, &shape);
    }
    terms
}

/// Refuses recordings of different sample times: one kernel serves all rows.
fn one_sample_time(recording: &Recording) -> Result<(), Refusal> {
    let usual = recording.sample_time_s();
    let own = |piece: &std::ops::Range<usize>| {
        let t = &recording.t_s[piece.clone()];
        let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
        signals::quantile(&steps, 0.5)
    };
    let unlike: Vec<_> = recording
        .pieces
        .iter()
        .filter(|p| p.len() > 3 && !(1.0 / UNLIKE..UNLIKE).contains(&(own(p) / usual)))
        .collect();
    let samples: usize = unlike.iter().map(|p| p.len()).sum();
    if let Some(piece) = unlike.first()
        && 3 * samples > recording.len()
    {
        return Err(Refusal::Input(format!(
            "{}: {samples} of {} samples, the first of them number {}, are {:.2e} s apart and not {usual:.2e} s; diagnose recordings of one sample time together, the others by themselves",
            recording.name,
            recording.len(),
            piece.start + 1,
            own(piece)
        )));
    }
    Ok(())
}
