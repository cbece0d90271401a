//! What the watch on the friction model is worth: false alarms on normal stages, and delays on stages that change.

use super::{Axis, Step, TrackingError};
use crate::stage::{Stage, StageConfig};
use preslide::control::learning::{BlockMeans, Learn, MismatchSettings, MismatchWatch};
use preslide::control::{Condition, Learning, LearningSettings, NormalRange, Settings};
use preslide::{Block, ParamError, QuasiStaticGms, Units};
use preslide_fit::report::Table;
use preslide_fit::statistics::mean_and_half_width;
use preslide_host::paper;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

type Model = QuasiStaticGms<4, f32>;

/// Strokes (m), their speed (m/s), and the time to reach it (s).
const STROKE_M: f64 = 1e-3;
const SPEED_M_S: f64 = 4e-3;
const RAMP_S: f64 = 0.02;

/// Windows after commissioning over which false alarms are counted.
const NORMAL: u32 = 300;
/// Windows after commissioning in which nothing changes yet, and in which the change must be found.
const BEFORE: u32 = 20;
const AFTER: u32 = 100;

/// Rates that are asked for (per window).
const RATES: [f64; 3] = [1e-2, 3e-3, 1e-3];

/// What happens to a stage: its friction level, from the position (m) and the path since the beginning of the change (m).
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// What it is called.
    pub name: &'static str,
    /// The friction level [–].
    pub level: fn(f64, f64) -> f64,
}

/// A bell of the height `level` and the width `width_m` in the middle of the strokes.
fn spot(position_m: f64, level: f64, width_m: f64) -> f64 {
    1.0 + level * (-((position_m - 0.5 * STROKE_M) / width_m).powi(2)).exp()
}

/// All of them.
pub const CHANGES: [Change; 7] = [
    Change {
        name: "wear, 0.1 % per mm",
        level: |_, path_m| 1.0 + path_m,
    },
    Change {
        name: "wear, 1 % per mm",
        level: |_, path_m| 1.0 + 10.0 * path_m,
    },
    Change {
        name: "step of +5 %",
        level: |_, _| 1.05,
    },
    Change {
        name: "step of +10 %",
        level: |_, _| 1.1,
    },
    Change {
        name: "step of -10 %",
        level: |_, _| 0.9,
    },
    Change {
        name: "spot, +50 %, 50 µm",
        level: |position_m, _| spot(position_m, 0.5, 50e-6),
    },
    Change {
        name: "spot, +50 %, 20 µm",
        level: |position_m, _| spot(position_m, 0.5, 20e-6),
    },
];

/// A rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// False alarms per window asked for.
    pub asked: f64,
    /// Alarms.
    pub alarms: usize,
    /// Alarms per window, and half its 95 % interval's width, from what differs between stages.
    pub measured: [f64; 2],
}

/// How soon a change was noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Delay {
    /// The change.
    pub name: &'static str,
    /// Stages on which it was.
    pub stages: usize,
    /// Of these, on which it was noticed within the 100 windows that were run.
    pub noticed: usize,
    /// Windows that ended from the change to the flag: median and largest, where noticed.
    pub windows: [usize; 2],
    /// Flags before the change.
    pub early: usize,
}

/// Both.
#[derive(Clone, Debug)]
pub struct Study {
    /// Stages of the rates, windows on each.
    pub stages: usize,
    /// False alarms.
    pub rates: Vec<Rate>,
    /// Correlation of neighbouring windows on the normal stages [–].
    pub correlation: f64,
    /// Delays, at the rate of the settings.
    pub delays: Vec<Delay>,
    /// The settings.
    pub watch: MismatchSettings,
}

/// Keeps every block, so that one run serves several settings of the watch.
#[derive(Clone, Debug, PartialEq)]
struct Recorder;

impl Learn<f32> for Recorder {
    type State = Vec<BlockMeans<f32>>;
    const LEVEL: bool = false;

    fn try_new(_: &LearningSettings, _: f64, _: Units) -> Result<Self, ParamError> {
        Ok(Self)
    }

    fn start(&self) -> Self::State {
        Vec::new()
    }

    fn block(&self, state: &mut Self::State, block: &BlockMeans<f32>) {
        state.push(*block);
    }

    fn tell(&self, _: &Self::State, _: &mut Condition<f32>) {}
}

/// Runs normal stages, and stages that change, under the production controller: strokes of 1 mm at 4 mm/s, GMS with the paper's
/// Table 3, four blocks, in `f32`. `progress` gets (runs done, runs in all).
///
/// # Errors
/// [`TrackingError`] where a controller cannot be built.
pub fn study(
    settings: &Settings,
    learning: &LearningSettings,
    normal_stages: u64,
    changed_stages: u64,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Study, TrackingError> {
    let watch = learning.watch;
    let (done, all) = (
        AtomicUsize::new(0),
        (normal_stages + changed_stages * CHANGES.len() as u64) as usize,
    );
    let tell = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
    progress(0, all);
    let normal = (0..normal_stages)
        .into_par_iter()
        .map(|seed| {
            let windows = 2 * watch.commissioning + NORMAL;
            let blocks = run(settings, learning, 1000 + seed, windows, &mut |_, _| {});
            tell();
            blocks
        })
        .collect::<Result<Vec<_>, TrackingError>>()?;
    let rates = RATES.iter().map(|asked| rate(learning, *asked, &normal));
    let rates = rates.collect::<Result<Vec<_>, ParamError>>()?;
    let delays = CHANGES.iter().map(|change| {
        let found = (0..changed_stages)
            .into_par_iter()
            .map(|seed| {
                let found = noticed(settings, learning, 2000 + seed, change.level);
                tell();
                found
            })
            .collect::<Result<Vec<_>, TrackingError>>()?;
        Ok(delay(change.name, &found))
    });
    let delays = delays.collect::<Result<Vec<_>, TrackingError>>()?;
    let correlations = normal
        .iter()
        .map(|blocks| Ok(correlation(&judge(learning, watch, blocks)?.values)))
        .collect::<Result<Vec<f64>, TrackingError>>()?;
    Ok(Study {
        stages: normal.len(),
        rates,
        correlation: mean_and_half_width(&correlations)[0],
        delays,
        watch,
    })
}

/// False alarms on normal stages, for a watch set to a rate.
fn rate(
    learning: &LearningSettings,
    asked: f64,
    normal: &[Vec<BlockMeans<f32>>],
) -> Result<Rate, ParamError> {
    let with = MismatchSettings {
        false_alarms: asked,
        ..learning.watch
    };
    let judged = normal
        .iter()
        .map(|blocks| judge(learning, with, blocks))
        .collect::<Result<Vec<_>, ParamError>>()?;
    let per_window = judged.iter().map(|stage| {
        let windows = stage.values.len() - 2 * with.commissioning as usize;
        stage.alarms.len() as f64 / windows as f64
    });
    Ok(Rate {
        asked,
        alarms: judged.iter().map(|stage| stage.alarms.len()).sum(),
        measured: mean_and_half_width(&per_window.collect::<Vec<_>>()),
    })
}

/// How late a change was noticed, from the answers of [`noticed`] on every stage.
fn delay(name: &'static str, found: &[Option<Option<usize>>]) -> Delay {
    let mut late: Vec<usize> = found.iter().flatten().copied().flatten().collect();
    late.sort_unstable();
    Delay {
        name,
        stages: found.len(),
        noticed: late.len(),
        windows: [
            late.get(late.len() / 2).copied().unwrap_or(0),
            late.last().copied().unwrap_or(0),
        ],
        early: found.iter().filter(|stage| **stage == Some(None)).count(),
    }
}

/// Windows that ended from the change to the flag, on one stage; none if the flag came earlier.
fn noticed(
    settings: &Settings,
    learning: &LearningSettings,
    seed: u64,
    level: fn(f64, f64) -> f64,
) -> Result<Option<Option<usize>>, TrackingError> {
    let before = 2 * learning.watch.commissioning + BEFORE;
    let begin_m = f64::from(before) * learning.watch.window;
    let mut changed_m = None;
    let blocks = run(
        settings,
        learning,
        seed,
        before + AFTER,
        &mut |path_m, stage| {
            if path_m < begin_m {
                return;
            }
            let since_m = path_m - *changed_m.get_or_insert(path_m);
            // Above zero in all of them.
            let _ = stage.set_friction_level(level(stage.truth().position_m, since_m));
        },
    )?;
    let judged = judge(learning, learning.watch, &blocks)?;
    let changed_m = changed_m.unwrap_or(f64::INFINITY);
    let before = judged
        .ends_m
        .iter()
        .filter(|end| **end <= changed_m)
        .count();
    let first = judged.alarms.first();
    Ok(first.map(|window| window.checked_sub(before).filter(|late| *late > 0)))
}

/// The blocks of a run over the path of `windows` windows. `change` gets the path (m), as the watch counts it, and may
/// change the stage before every tick.
fn run(
    settings: &Settings,
    learning: &LearningSettings,
    seed: u64,
    windows: u32,
    change: &mut dyn FnMut(f64, &mut Stage),
) -> Result<Vec<BlockMeans<f32>>, TrackingError> {
    let [_, _, four_blocks, ..] = paper::TABLE_3;
    let mut blocks = [Block {
        stiffness: 0.0,
        weight: 0.0,
    }; 4];
    for (block, &(stiffness, weight)) in blocks.iter_mut().zip(four_blocks.blocks) {
        *block = Block { stiffness, weight };
    }
    let model = Model::try_new(&blocks, paper::BREAKAWAY, Units::SI)?;
    let model = Learning::<_, Recorder>::try_new(model, learning, Units::SI)?;
    let stage = StageConfig {
        seed,
        // Coarser than the stage's stated error bound needs: four times as many windows in the same time.
        substeps: 2,
        ..StageConfig::default()
    };
    let mut axis = Axis::try_new(settings, model, Units::SI, stage)?;
    let moves = [1.0, -1.0]
        .map(|sign| Step::Move {
            distance_m: sign * STROKE_M,
            speed_m_s: SPEED_M_S,
            ramp_s: RAMP_S,
        })
        .map(|step| step.plan(settings));
    let wanted_m = f64::from(windows) * learning.watch.window;
    let (mut path_m, mut counted) = (0.0, 0);
    let mut moves = moves.iter().cycle();
    while path_m < wanted_m
        && let Some(next) = moves.next()
    {
        axis.start((*next)?);
        while !axis.is_idle() {
            change(path_m, axis.stage_mut());
            let (command, ..) = axis.tick();
            if let Some(fault) = command.fault {
                return Err(TrackingError::Stopped(fault));
            }
            let blocks = axis.friction_state().learned();
            for block in blocks.iter().skip(counted) {
                path_m += f64::from(block.path);
            }
            counted = blocks.len();
        }
    }
    Ok(std::mem::take(axis.friction_state().learned()))
}

/// What a watch makes of a run.
struct Judged {
    /// Windows at whose end there was an alarm, each acknowledged at once.
    alarms: Vec<usize>,
    /// Mean mismatch of each window (N), and the path at its end (m).
    values: Vec<f64>,
    ends_m: Vec<f64>,
}

fn judge(
    learning: &LearningSettings,
    watch: MismatchSettings,
    blocks: &[BlockMeans<f32>],
) -> Result<Judged, ParamError> {
    let settings = LearningSettings { watch, ..*learning };
    // As `Learning` builds it: with the model's own limit.
    let mismatch: MismatchWatch<f32> = Learn::try_new(&settings, paper::BREAKAWAY, Units::SI)?;
    let mut state = mismatch.start();
    let mut judged = Judged {
        alarms: Vec::new(),
        values: Vec::new(),
        ends_m: Vec::new(),
    };
    let (mut path_m, mut work, mut begin_m) = (0.0, 0.0, 0.0);
    for block in blocks {
        path_m += f64::from(block.path);
        work += f64::from(block.path) * f64::from(block.spent - block.model);
        let before = state.windows();
        mismatch.block(&mut state, block);
        if state.windows() > before {
            judged.values.push(work / (path_m - begin_m));
            judged.ends_m.push(path_m);
            (work, begin_m) = (0.0, path_m);
        }
        if matches!(state.range(), NormalRange::Above | NormalRange::Below) {
            judged.alarms.push(judged.values.len());
            state.acknowledge();
        }
    }
    Ok(judged)
}

/// Correlation of neighbours.
fn correlation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let neighbours = values.iter().zip(values.iter().skip(1));
    neighbours
        .map(|(a, b)| (a - mean) * (b - mean))
        .sum::<f64>()
        / square
}

/// The study for people.
pub fn print(study: &Study) -> String {
    let watch = &study.watch;
    let rates = Table::of(
        format!(
            "windows of {:.0} µm, {} for commissioning, slack {} spreads; {} normal stages, {NORMAL} windows each, their friction varying \
             by ±15 %; neighbouring windows correlate by {:.2}",
            watch.window * 1e6,
            2 * watch.commissioning,
            watch.slack,
            study.stages,
            study.correlation,
        ),
        &study.rates,
    )
    .column("asked for (per window)", |rate| rate.asked.to_string())
    .column("alarms", |rate| rate.alarms.to_string())
    .column("measured (95 %)", |rate| {
        let [measured, half] = rate.measured;
        format!("{measured:.5} (±{half:.5})")
    });
    let delays = Table::of(
        format!("at {} per window", watch.false_alarms),
        &study.delays,
    )
    .column("change", |delay| delay.name.to_owned())
    .column("noticed", |delay| {
        format!("{} of {}", delay.noticed, delay.stages)
    })
    .column("windows, median", |delay| {
        let median = delay.windows[0];
        format!("{median} ({:.1} mm)", median as f64 * watch.window * 1e3)
    })
    .column("largest", |delay| delay.windows[1].to_string())
    .column("early", |delay| delay.early.to_string());
    format!("{}\n{}", rates.table().to_text(), delays.table().to_text())
}
