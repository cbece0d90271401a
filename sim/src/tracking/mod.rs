//! How well each friction model compensates: the production controller against the simulated stage.
//!
//! Same gains throughout. Every compensator's parameters come from one [`Experiment`] on the stage; the motions are
//! then followed on stages with other seeds, whose friction differs by up to ±15 % from the one identified.

pub mod adaptation;
mod axis;
mod circle;
pub mod dead_time;
mod identification;
pub mod koopman;
pub mod motions;
pub mod notch;
pub mod observer;
mod perfect;
mod rivals;
mod score;
mod simplex;
pub mod watch;
pub mod winding;

pub use axis::{Axis, Instant, Step, TrackingError, electrical};
pub use circle::Circle;
pub use identification::Experiment;
pub use perfect::Perfect;
pub use rivals::{LookAhead, LookAheadSettings, SmoothedCoulomb};
pub use score::{Rest, Row, Steps, Tracking, print};

use crate::stage::StageConfig;
use fixed::types::I16F16;
use preslide::control::{Move, NoFriction, Settings};
use preslide::kernels::{PackedSlipReserve, Scaled};
use preslide::{Coulomb, Friction, QuasiStaticGms, Units};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The fixed-point form's units: a displacement of 1 is a count, a force of 1 a millinewton.
pub const FIXED_UNITS: Units = Units {
    length: 25e-9,
    force: 1e-3,
    velocity: 1e-3,
};

/// Seed of the stage that the parameters are identified on.
pub const IDENTIFICATION_SEED: u64 = 1;

/// Seeds of the stages that are then followed on.
pub const TRACKING_SEEDS: [u64; 3] = [101, 102, 103];

/// Makes a row of that name.
type Run<'a> = Box<dyn Fn(&str) -> Result<Row, TrackingError> + Send + Sync + 'a>;
type Task<'a> = (String, Run<'a>);

/// Runs every compensator, or those whose names contain one of `only`, over every motion. `progress` gets (rows done, rows in all).
///
/// # Errors
/// [`TrackingError`] where a controller cannot be built or the identification fails. A run that ends in a fault is
/// no error: its row says so.
pub fn table(
    settings: &Settings,
    stage: &StageConfig,
    only: &[String],
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<Row>, TrackingError> {
    let identified = StageConfig {
        seed: IDENTIFICATION_SEED,
        ..stage.clone()
    };
    let experiment = Experiment::run(settings, identified.clone())?;
    let benchmark = Benchmark {
        settings,
        stage,
        level: 1.0,
    };
    let observing = observer::Observing::tuned(&experiment, settings, stage)?;
    let mut tasks = rivals_tasks(&experiment, &identified, benchmark);
    tasks.extend(gms::<2, 1>(&experiment, benchmark));
    tasks.extend(gms::<3, 2>(&experiment, benchmark));
    tasks.extend(gms::<4, 2>(&experiment, benchmark));
    tasks.extend(gms::<6, 3>(&experiment, benchmark));
    tasks.extend(gms::<10, 5>(&experiment, benchmark));
    tasks.extend(observing.tasks(benchmark));
    tasks.retain(|(name, _)| only.is_empty() || only.iter().any(|part| name.contains(part)));

    let (done, all) = (AtomicUsize::new(0), tasks.len());
    progress(0, all);
    tasks
        .par_iter()
        .map(|(name, run)| {
            let row = run(name);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
            row
        })
        .collect()
}

/// Everything but the GMS: no compensation, the static ones, and the models of one state.
fn rivals_tasks<'a>(
    e: &'a Experiment,
    identified: &'a StageConfig,
    benchmark: Benchmark<'a>,
) -> Vec<Task<'a>> {
    let settings = benchmark.settings;
    let tasks: [(&str, Run); 7] = [
        (
            "none",
            Box::new(move |name| benchmark.row(name, "f32", NoFriction::<f32>::new(), Units::SI)),
        ),
        (
            "sgn(v)·F_c",
            Box::new(move |name| {
                let sign = Coulomb::<f32>::try_new(e.coulomb(), 0.0, Units::SI)?;
                benchmark.row(name, "f32", sign, Units::SI)
            }),
        ),
        (
            "tanh(v/v_s)",
            Box::new(move |name| {
                let smoothed = SmoothedCoulomb::tuned(e, settings, identified)?;
                benchmark.row(name, "f32", smoothed, Units::SI)
            }),
        ),
        (
            "F(v) ahead",
            Box::new(move |name| {
                let table = LookAheadSettings::tuned(e, settings, identified)?;
                benchmark.row_with(name, "f32", Units::SI, |moves| table.on(settings, moves))
            }),
        ),
        (
            "Dahl",
            Box::new(move |name| benchmark.row(name, "f32", e.dahl::<f32>()?, Units::SI)),
        ),
        (
            "LuGre",
            Box::new(move |name| benchmark.row(name, "f32", e.lugre::<f32>(true)?, Units::SI)),
        ),
        (
            "LuGre σp=0",
            Box::new(move |name| benchmark.row(name, "f32", e.lugre::<f32>(false)?, Units::SI)),
        ),
    ];
    tasks
        .into_iter()
        .map(|(name, run)| (name.to_owned(), run))
        .collect()
}

/// The GMS of N blocks, in floating and in fixed point, and packed.
fn gms<'a, const N: usize, const PAIRS: usize>(
    e: &'a Experiment,
    benchmark: Benchmark<'a>,
) -> [Task<'a>; 3] {
    let float: Run = Box::new(move |name| {
        let (blocks, breakaway) = e.blocks::<N>()?;
        let model = QuasiStaticGms::<N, f32>::try_new(&blocks, breakaway, Units::SI)?;
        benchmark.row(name, "f32", model, Units::SI)
    });
    let fixed: Run = Box::new(move |name| {
        let (blocks, breakaway) = e.blocks::<N>()?;
        let model = QuasiStaticGms::<N, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
        benchmark.row(name, "fixed", model, FIXED_UNITS)
    });
    let packed: Run = Box::new(move |name| {
        let (blocks, breakaway) = e.blocks::<N>()?;
        let model =
            Scaled::<PackedSlipReserve<PAIRS>, f32>::try_new(&blocks, breakaway, Units::SI)?;
        benchmark.row(name, "packed", model, Units::SI)
    });
    [float, fixed, packed].map(|run| (format!("GMS N={N}"), run))
}

/// What every compensator is judged on.
#[derive(Clone, Copy)]
struct Benchmark<'a> {
    settings: &'a Settings,
    stage: &'a StageConfig,
    /// Friction, of what it is (-).
    level: f64,
}

impl Benchmark<'_> {
    /// One compensator over all motions.
    fn row<F: Friction + Clone>(
        &self,
        compensator: &str,
        arithmetic: &'static str,
        friction: F,
        units: Units,
    ) -> Result<Row, TrackingError> {
        self.row_with(compensator, arithmetic, units, |_| Ok(friction.clone()))
    }

    /// One that knows each motion beforehand.
    fn row_with<F: Friction>(
        &self,
        compensator: &str,
        arithmetic: &'static str,
        units: Units,
        friction: impl Fn(&[Move]) -> Result<F, TrackingError>,
    ) -> Result<Row, TrackingError> {
        let settings = self.settings;
        let mut row = Row::new(compensator, arithmetic);
        let follow = |moves: &[Move], seed: u64, observe: &mut dyn FnMut(Instant)| {
            let stage = StageConfig {
                seed,
                ..self.stage.clone()
            };
            let mut axis = Axis::try_new(settings, friction(moves)?, units, stage)?;
            axis.stage_mut().set_friction_level(self.level)?;
            axis.follow(moves, observe);
            Ok::<_, TrackingError>(())
        };
        let plan = |steps: Vec<Step>| Step::plan_all(&steps, settings);
        let (count, sample_time) = (settings.encoder.count, settings.sample_time());
        for seed in TRACKING_SEEDS {
            follow(&plan(motions::nested_triangles())?, seed, &mut |now| {
                row.nested.add(&now, count)
            })?;
            follow(&plan(motions::slide())?, seed, &mut |now| {
                row.slide.add(&now, count)
            })?;
            follow(&plan(motions::steps())?, seed, &mut |now| {
                row.steps.add(&now, sample_time)
            })?;
            row.steps.finish();
        }
        follow(&plan(motions::rest())?, TRACKING_SEEDS[0], &mut |now| {
            row.rest.add(&now, sample_time)
        })?;
        let [mut x, mut y] = [circle::Path::default(), circle::Path::default()];
        let [first, second, _] = TRACKING_SEEDS;
        for (path, cosine, seed) in [(&mut x, true, first), (&mut y, false, second)] {
            let moves = circle::moves(settings, cosine)?;
            follow(&moves, seed, &mut |now| path.add(&now, count))?;
        }
        row.circle = Circle::judge(&x, &y);
        Ok(row)
    }
}
