//! Tracking with and without adaptation of the friction level, on the same stages.

use super::{Axis, Experiment, IDENTIFICATION_SEED, Step, Tracking, TrackingError, motions};
use crate::stage::{EncoderConfig, FrictionConfig, StageConfig, VariabilityConfig};
use preslide::control::learning::Adaptation;
use preslide::control::{Fault, Learning, LearningSettings, Settings};
use preslide::{Friction, QuasiStaticGms, Units};
use preslide_fit::report::Table;
use preslide_fit::statistics::mean_and_half_width;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

type Model = QuasiStaticGms<4, f32>;

/// What the stage's friction does.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// What it is called.
    pub name: &'static str,
    /// The part that does not repeat.
    pub variability: fn() -> VariabilityConfig,
    /// Friction level over the second half of the motion [–].
    pub level: f64,
}

/// Nothing but the level varies, by up to ±15 %, over `correlation_m` of path.
fn level_wanders(correlation_m: f64) -> VariabilityConfig {
    VariabilityConfig {
        repeat_share: 0.0,
        gain_share: 1.0,
        correlation_m,
        ..VariabilityConfig::default()
    }
}

fn constant() -> VariabilityConfig {
    VariabilityConfig {
        bound: 0.0,
        ..VariabilityConfig::default()
    }
}

/// All of them.
pub const SCENARIOS: [Scenario; 6] = [
    Scenario {
        name: "as identified",
        variability: constant,
        level: 1.0,
    },
    Scenario {
        name: "+15 % half way",
        variability: constant,
        level: 1.15,
    },
    Scenario {
        name: "-15 % half way",
        variability: constant,
        level: 0.85,
    },
    Scenario {
        name: "±15 %, mixed",
        variability: VariabilityConfig::default,
        level: 1.0,
    },
    Scenario {
        name: "level ±15 %, 0.1 mm",
        variability: || level_wanders(0.1e-3),
        level: 1.0,
    },
    Scenario {
        name: "level ±15 %, 1 mm",
        variability: || level_wanders(1e-3),
        level: 1.0,
    },
];

/// Means over pairs of runs on the same stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairs {
    /// Mean RMS error without and with adaptation (m).
    pub rms_m: [f64; 2],
    /// Mean change of the RMS error by the adaptation [–], and half the width of its 95 % interval.
    pub change: [f64; 2],
    /// Runs in all pairs that ended in a fault.
    pub faults: usize,
}

/// One scenario.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: &'static str,
    /// Stages.
    pub stages: u64,
    /// Twice the nested triangles of the tracking table.
    pub nested: Pairs,
    /// Sixteen slides of 0.5 mm at 1 mm/s.
    pub slide: Pairs,
}

/// Runs every scenario on `stages` stages. The model, GMS with four blocks in `f32`, comes from an experiment on a stage whose friction
/// does not vary. `progress` gets (pairs done, pairs in all).
///
/// # Errors
/// [`TrackingError`] where a controller cannot be built or the identification fails.
pub fn table(
    settings: &Settings,
    learning: &LearningSettings,
    stages: u64,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<Row>, TrackingError> {
    let experiment = Experiment::run(settings, stage(IDENTIFICATION_SEED, constant()))?;
    let (blocks, breakaway) = experiment.blocks::<4>()?;
    let model = Model::try_new(&blocks, breakaway, Units::SI)?;
    let adaptive = Learning::<_, Adaptation<f32>>::try_new(model.clone(), learning, Units::SI)?;
    let twice = |steps: Vec<Step>| [steps.clone(), steps].concat();
    let nested = twice(motions::nested_triangles());
    let slide = twice(twice(motions::slide()));
    let all = 2 * SCENARIOS.len() * stages as usize;
    let done = AtomicUsize::new(0);
    progress(0, all);
    SCENARIOS
        .par_iter()
        .map(|scenario| {
            let pairs = |steps: &[Step]| {
                let pairs = (101..101 + stages).into_par_iter().map(|seed| {
                    let stage = stage(seed, (scenario.variability)());
                    let without = follow(settings, model.clone(), &stage, steps, scenario.level)?;
                    let with = follow(settings, adaptive.clone(), &stage, steps, scenario.level)?;
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
                    Ok([without, with])
                });
                Ok::<_, TrackingError>(summarise(
                    &pairs.collect::<Result<Vec<_>, TrackingError>>()?,
                ))
            };
            Ok(Row {
                name: scenario.name,
                stages,
                nested: pairs(&nested)?,
                slide: pairs(&slide)?,
            })
        })
        .collect()
}

fn stage(seed: u64, variability: VariabilityConfig) -> StageConfig {
    StageConfig {
        seed,
        friction: FrictionConfig {
            variability,
            ..FrictionConfig::default()
        },
        // Every stage has its own interpolation error, also where its friction does not vary.
        encoder: EncoderConfig {
            error_phase_rad: [0.7, 1.9].map(|rad| rad * seed as f64 % std::f64::consts::TAU),
            ..EncoderConfig::default()
        },
        ..StageConfig::default()
    }
}

/// RMS error of a run; over the second half the friction level is `level`.
fn follow<F: Friction>(
    settings: &Settings,
    friction: F,
    stage: &StageConfig,
    steps: &[Step],
    level: f64,
) -> Result<Result<f64, Fault>, TrackingError> {
    let mut axis = Axis::try_new(settings, friction, Units::SI, stage.clone())?;
    let mut tracking = Tracking::default();
    let mut fault = None;
    for (index, step) in steps.iter().enumerate() {
        if 2 * index == steps.len() {
            axis.stage_mut().set_friction_level(level)?;
        }
        axis.follow(&[step.plan(settings)?], |now| {
            tracking.add(&now, settings.encoder.count);
            fault = fault.or(now.command.fault);
        });
    }
    Ok(match (tracking.rms_m(), fault) {
        (Some(rms), None) => Ok(rms),
        (_, fault) => Err(fault.unwrap_or(Fault::NotANumber)),
    })
}

fn summarise(pairs: &[[Result<f64, Fault>; 2]]) -> Pairs {
    let whole: Vec<[f64; 2]> = pairs
        .iter()
        .filter_map(|[a, b]| Some([a.ok()?, b.ok()?]))
        .collect();
    let changes: Vec<f64> = whole.iter().map(|[a, b]| b / a - 1.0).collect();
    Pairs {
        rms_m: [0, 1].map(|i| {
            let of_one: Vec<f64> = whole.iter().map(|pair| pair[i]).collect();
            mean_and_half_width(&of_one)[0]
        }),
        change: mean_and_half_width(&changes),
        faults: pairs.iter().flatten().filter(|run| run.is_err()).count(),
    }
}

/// The rows as a table for people.
pub fn print(rows: &[Row]) -> String {
    let cell = |p: &Pairs| {
        let [without, with] = p.rms_m.map(|rms| rms * 1e9);
        let [change, half] = p.change.map(|change| change * 100.0);
        format!("{without:.1} → {with:.1}, {change:+.1} % (±{half:.1})")
    };
    Table::of(
        "RMS error without → with adaptation, and its change (95 % interval over stages)",
        rows,
    )
    .column("the stage's friction", |row| row.name.to_owned())
    .column("stages", |row| row.stages.to_string())
    .column("nested triangles (nm)", |row| cell(&row.nested))
    .column("slide 1 mm/s (nm)", |row| cell(&row.slide))
    .column("faults", |row| {
        (row.nested.faults + row.slide.faults).to_string()
    })
    .table()
    .to_text()
}
