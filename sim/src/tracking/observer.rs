//! What the observer is worth beside a friction model and without one, where friction and mass are not as given.

use super::{
    Benchmark, Experiment, FIXED_UNITS, IDENTIFICATION_SEED, Row, Run, Task, TrackingError,
    electrical, print as rows,
};
use crate::stage::{Stage, StageConfig};
use fixed::types::I16F16;
use preslide::control::learning::Adaptation;
use preslide::control::{
    Learning, LearningSettings, NoFriction, Observed, ObserverSettings, Settings,
};
use preslide::{Block, QuasiStaticGms, Units};
use preslide_fit::recording::MotionKind;
use preslide_host::tune::observer::{
    DEMANDS, Known, Proposal, UNCERTAINTY, UNMODELLED_KG, propose,
};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// The gains that `preslide tune` proposes for the axis, which gets the drive's true first mode: who has the stage hits it
/// and counts.
///
/// # Errors
/// [`TrackingError`] where the stage is not usable or no gains leave the margins.
pub fn proposal(
    settings: &Settings,
    stage: &StageConfig,
    blocks: &[Block],
    breakaway: f64,
) -> Result<Proposal, TrackingError> {
    let rotor_kg = Stage::try_new(stage.clone())?.reflected_rotor_kg();
    let (load_kg, drive) = (stage.mass_kg, &stage.drive);
    let per_kg = 1.0 / rotor_kg + 1.0 / load_kg;
    let mode = TAU * mode_hz(stage, rotor_kg);
    // The motor brakes the rotor's part of the mode.
    let rotor_part = load_kg / (rotor_kg * (rotor_kg + load_kg));
    let decay = drive.damping_n_s_per_m * per_kg + settings.motor.braking() * rotor_part;
    let known = Known {
        motion: MotionKind::Linear,
        noise: 0.0,
        breakaway,
        contact: blocks.iter().map(|block| block.stiffness).sum(),
        mode_hz: mode / TAU,
        mode_damping: decay / (2.0 * mode),
    };
    propose(settings, &known, &DEMANDS).map_err(TrackingError::Observer)
}

/// The drive's first mode (Hz), rotor and load both free.
pub(super) fn mode_hz(stage: &StageConfig, rotor_kg: f64) -> f64 {
    let per_kg = 1.0 / rotor_kg + 1.0 / stage.mass_kg;
    (stage.drive.stiffness_n_per_m * per_kg).sqrt() / TAU
}

/// The observer's rows for the tracking table: alone, with four blocks in both arithmetics, and with four whose level
/// adapts within.
pub(super) struct Observing {
    settings: Settings,
    observer: ObserverSettings,
    blocks: [Block; 4],
    breakaway: f64,
}

impl Observing {
    pub(super) fn tuned(
        e: &Experiment,
        settings: &Settings,
        stage: &StageConfig,
    ) -> Result<Self, TrackingError> {
        let (blocks, breakaway) = e.blocks::<4>()?;
        let proposal = proposal(settings, stage, &blocks, breakaway)?;
        Ok(Self {
            settings: Settings {
                gains: proposal.gains,
                ..*settings
            },
            observer: proposal.settings,
            blocks,
            breakaway,
        })
    }

    fn alone(&self, benchmark: Benchmark, name: &str) -> Result<Row, TrackingError> {
        let none = NoFriction::<f32>::new();
        let model =
            Observed::try_new(none, &self.observer, self.settings.sample_time(), Units::SI)?;
        self.on(benchmark).row(name, "f32", model, Units::SI)
    }

    fn with_blocks(&self, benchmark: Benchmark, name: &str) -> Result<Row, TrackingError> {
        let gms = QuasiStaticGms::<4, f32>::try_new(&self.blocks, self.breakaway, Units::SI)?;
        let model = Observed::try_new(gms, &self.observer, self.settings.sample_time(), Units::SI)?;
        self.on(benchmark).row(name, "f32", model, Units::SI)
    }

    fn adapted(&self, benchmark: Benchmark, name: &str) -> Result<Row, TrackingError> {
        let gms = QuasiStaticGms::<4, f32>::try_new(&self.blocks, self.breakaway, Units::SI)?;
        let learning = LearningSettings::PAPER_AXIS;
        let gms: Learning<_, Adaptation<f32>> = Learning::try_new(gms, &learning, Units::SI)?;
        let model = Observed::try_new(gms, &self.observer, self.settings.sample_time(), Units::SI)?;
        self.on(benchmark).row(name, "f32", model, Units::SI)
    }

    fn in_fixed_point(&self, benchmark: Benchmark, name: &str) -> Result<Row, TrackingError> {
        let gms = QuasiStaticGms::<4, I16F16>::try_new(&self.blocks, self.breakaway, FIXED_UNITS)?;
        let model = Observed::try_new(
            gms,
            &self.observer,
            self.settings.sample_time(),
            FIXED_UNITS,
        )?;
        self.on(benchmark).row(name, "fixed", model, FIXED_UNITS)
    }

    fn on<'a>(&'a self, benchmark: Benchmark<'a>) -> Benchmark<'a> {
        Benchmark {
            settings: &self.settings,
            ..benchmark
        }
    }

    pub(super) fn tasks<'a>(&'a self, benchmark: Benchmark<'a>) -> [Task<'a>; 4] {
        let both = "obs+GMS N=4";
        let tasks: [(&str, Run); 4] = [
            (
                "observer",
                Box::new(move |name| self.alone(benchmark, name)),
            ),
            (
                both,
                Box::new(move |name| self.with_blocks(benchmark, name)),
            ),
            (
                "obs+adaptive",
                Box::new(move |name| self.adapted(benchmark, name)),
            ),
            (
                both,
                Box::new(move |name| self.in_fixed_point(benchmark, name)),
            ),
        ];
        tasks.map(|(name, run)| (name.to_owned(), run))
    }
}

/// What the stage is where the controller knows nothing of it: a name, friction (-), and more mass (kg).
const UNMODELLED: [(&str, f64, f64); 4] = [
    ("as modelled", 1.0, 0.0),
    ("friction +15 %", 1.0 + UNCERTAINTY, 0.0),
    ("friction −15 %", 1.0 - UNCERTAINTY, 0.0),
    ("payload +1 kg", 1.0, UNMODELLED_KG),
];

/// One stage in one of these conditions.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Which.
    pub name: String,
    /// Feedback alone, with four blocks, with the observer, with both, and with the blocks adapted.
    pub rows: Vec<Row>,
}

/// PID, PID + GMS, observer, observer + GMS, and that with adaptation, on the ideal and on the electrical stage, in each condition. `progress` gets (rows
/// done, rows in all).
///
/// # Errors
/// [`TrackingError`] where the identification fails or no observer's gains leave their margins.
pub fn study(
    settings: &Settings,
    stage: &StageConfig,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<Condition>, TrackingError> {
    let mut told = *settings;
    let switching = electrical(&mut told, stage.clone());
    let mut conditions = Vec::new();
    for (on, settings, stage) in [
        ("ideal", settings, stage),
        ("electrical", &told, &switching),
    ] {
        let identified = StageConfig {
            seed: IDENTIFICATION_SEED,
            ..stage.clone()
        };
        let e = Experiment::run(settings, identified)?;
        let observing = Observing::tuned(&e, settings, stage)?;
        for (name, level, more_kg) in UNMODELLED {
            let stage = StageConfig {
                mass_kg: stage.mass_kg + more_kg,
                ..stage.clone()
            };
            let benchmark = Benchmark {
                settings,
                stage: &stage,
                level,
            };
            let feedback: Run = Box::new(move |name| {
                benchmark.row(name, "f32", NoFriction::<f32>::new(), Units::SI)
            });
            let mut tasks = vec![("none".to_owned(), feedback)];
            let [gms, ..] = super::gms::<4, 2>(&e, benchmark);
            let [alone, both, adapted, _] = observing.tasks(benchmark);
            tasks.extend([gms, alone, both, adapted]);
            let rows = (tasks.par_iter())
                .map(|(name, run)| run(name))
                .collect::<Result<Vec<_>, _>>()?;
            conditions.push(Condition {
                name: format!("{on} stage, {name}"),
                rows,
            });
            progress(conditions.len(), 2 * UNMODELLED.len());
        }
    }
    Ok(conditions)
}

/// The study for people.
pub fn print(conditions: &[Condition]) -> String {
    let mut text = String::new();
    for condition in conditions {
        let _ = writeln!(text, "{}\n{}", condition.name, rows(&condition.rows));
    }
    text
}
