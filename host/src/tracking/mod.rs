//! How well each friction model compensates: the production controller against the simulated stage.
//!
//! Same gains throughout. Every compensator's parameters come from one [`Experiment`] on the stage; the motions are
//! then followed on stages with other seeds, whose friction differs by up to ±15 % from the one identified.

pub mod adaptation;
mod axis;
mod identification;
pub mod motions;
mod score;
mod simplex;
pub mod watch;

pub use axis::{Axis, Instant, Step, TrackingError};
pub use identification::Experiment;
pub use score::{Rest, Row, Steps, Tracking, print};

use crate::stage::StageConfig;
use fixed::types::I16F16;
use preslide::control::{NoFriction, Settings};
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

type Task<'a> = Box<dyn Fn() -> Result<Row, TrackingError> + Send + Sync + 'a>;

/// Runs every compensator over every motion. `progress` is told (rows done, rows in all).
///
/// # Errors
/// [`TrackingError`] where a controller cannot be built or the identification fails. A run that ends in a fault is
/// no error: its row says so.
pub fn table(
    settings: &Settings,
    stage: &StageConfig,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<Row>, TrackingError> {
    let experiment = Experiment::run(
        settings,
        StageConfig {
            seed: IDENTIFICATION_SEED,
            ..stage.clone()
        },
    )?;
    let e = &experiment;
    let mut tasks: Vec<Task> = vec![
        Box::new(move || {
            row(
                "none",
                "f32",
                settings,
                stage,
                NoFriction::<f32>::new(),
                Units::SI,
            )
        }),
        Box::new(move || {
            let sign = Coulomb::<f32>::try_new(e.coulomb(), 0.0, Units::SI)?;
            row("sgn(v)·F_c", "f32", settings, stage, sign, Units::SI)
        }),
        Box::new(move || row("Dahl", "f32", settings, stage, e.dahl::<f32>()?, Units::SI)),
        Box::new(move || {
            row(
                "LuGre",
                "f32",
                settings,
                stage,
                e.lugre::<f32>(true)?,
                Units::SI,
            )
        }),
        Box::new(move || {
            row(
                "LuGre σp=0",
                "f32",
                settings,
                stage,
                e.lugre::<f32>(false)?,
                Units::SI,
            )
        }),
    ];
    fn gms<'a, const N: usize>(
        tasks: &mut Vec<Task<'a>>,
        e: &'a Experiment,
        settings: &'a Settings,
        stage: &'a StageConfig,
    ) {
        let name = format!("GMS N={N}");
        let fixed_name = name.clone();
        tasks.push(Box::new(move || {
            let (blocks, breakaway) = e.blocks::<N>()?;
            let model = QuasiStaticGms::<N, f32>::try_new(&blocks, breakaway, Units::SI)?;
            row(&name, "f32", settings, stage, model, Units::SI)
        }));
        tasks.push(Box::new(move || {
            let (blocks, breakaway) = e.blocks::<N>()?;
            let model = QuasiStaticGms::<N, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
            row(&fixed_name, "fixed", settings, stage, model, FIXED_UNITS)
        }));
    }
    gms::<2>(&mut tasks, e, settings, stage);
    gms::<3>(&mut tasks, e, settings, stage);
    gms::<4>(&mut tasks, e, settings, stage);
    gms::<6>(&mut tasks, e, settings, stage);
    gms::<10>(&mut tasks, e, settings, stage);

    let (done, all) = (AtomicUsize::new(0), tasks.len());
    progress(0, all);
    tasks
        .par_iter()
        .map(|task| {
            let row = task();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
            row
        })
        .collect()
}

/// One compensator over all motions.
fn row<F: Friction + Clone>(
    compensator: &str,
    arithmetic: &'static str,
    settings: &Settings,
    stage: &StageConfig,
    friction: F,
    units: Units,
) -> Result<Row, TrackingError> {
    let mut row = Row::new(compensator, arithmetic);
    let follow = |steps: &[Step], seed: u64, observe: &mut dyn FnMut(Instant)| {
        let stage = StageConfig {
            seed,
            ..stage.clone()
        };
        let mut axis = Axis::try_new(settings, friction.clone(), units, stage)?;
        let moves = steps
            .iter()
            .map(|step| step.plan(settings))
            .collect::<Result<Vec<_>, _>>()?;
        axis.follow(&moves, observe);
        Ok::<_, TrackingError>(())
    };
    let (count, sample_time) = (settings.encoder.count, settings.sample_time());
    for seed in TRACKING_SEEDS {
        follow(&motions::nested_triangles(), seed, &mut |now| {
            row.nested.add(&now, count)
        })?;
        follow(&motions::slide(), seed, &mut |now| {
            row.slide.add(&now, count)
        })?;
        follow(&motions::steps(), seed, &mut |now| {
            row.steps.add(&now, sample_time)
        })?;
        row.steps.finish();
    }
    follow(&motions::rest(), TRACKING_SEEDS[0], &mut |now| {
        row.rest.add(&now, sample_time)
    })?;
    Ok(row)
}
