//! Whether the user's own hysteresis is what is wrong: `presliding_shape`, which has no term of its own.

use super::blocks::{FINER, between_samples};
use super::effect::Effect;
use super::effect::backlash::Backlash;
use super::effect::drive_compliance::DriveCompliance;
use super::evidence::{Evidence, evidence};
use super::ground::{Ground, Hypothesis};
use super::normal::{Bound, Normal};
use super::signals::Signals;
use super::weak::Column;
use crate::friction::{FrictionModel, Path};

/// NMSE (%) by which the user's friction, refitted by a common factor, may be worse than the core before its shape is said to be
/// wrong with confidence: half of what the paper's own three blocks leave of its recording (5.97 %, `preslide reproduce`).
const TOLERATED: f64 = 3.0;
/// The same before it is suspected: what three blocks leave of a smooth law when they are placed well.
const NOTICED: f64 = 0.84;
/// Times the core's held-out error that it must leave at least.
const WORSE: f64 = 2.0;

/// Id of the effect.
pub const ID: &str = "presliding_shape";
/// Its name for a person.
pub const NAME: &str = "shape of the hysteresis";
/// What it is.
pub const WORDS: &str = "a hysteresis that the model's friction law does not have";
/// The experiment that tells it from its rivals.
pub const EXPERIMENT: &str = "reversals of 5, 20 and 100 µm at one slow speed";

/// A gap or a spring in the drive stretches the first path after a reversal, as a softer hysteresis does.
static RIVALS: [&dyn Effect; 2] = [&Backlash, &DriveCompliance];

/// Effects that a recording does not tell from a wrong hysteresis.
pub fn rivals(s: &Signals) -> Vec<&'static dyn Effect> {
    let can_be = |e: &&dyn Effect| e.lacks(s).is_none();
    RIVALS.into_iter().filter(can_be).collect()
}

/// The user's hysteresis against the core's.
pub struct Shape {
    /// Held-out NMSE (%) with the user's friction, and with the core.
    pub nmse: [f64; 2],
    /// What the core explains beside the user's friction.
    pub evidence: Evidence,
    /// What the core changes, at the rows (N or N·m).
    pub force: Vec<f64>,
}

impl Shape {
    /// Whether the user's hysteresis is materially wrong.
    pub fn is_wrong(&self) -> bool {
        self.is_worse_by(TOLERATED)
    }

    /// Whether it may be.
    pub fn is_suspect(&self) -> bool {
        self.is_worse_by(NOTICED)
    }

    fn is_worse_by(&self, tolerated: f64) -> bool {
        let [own, core] = self.nmse;
        own - core > tolerated && own > WORSE * core
    }

    /// Judges the friction of the user's model beside the terms of a hypothesis, by least squares: a wrong shape misleads a fit that
    /// trusts its noise model. `None` where the library refuses a parameter.
    pub fn of(ground: &Ground, hypothesis: &Hypothesis, friction: &FrictionModel) -> Option<Self> {
        let rows = &ground.rows;
        let own = own_friction(ground, friction)?;
        let terms = hypothesis
            .terms
            .iter()
            .map(|t| ground.columns(t))
            .collect::<Vec<_>>();
        let core = &ground.core.rows;
        let inertia = ground.core.first_of_friction();
        let mut columns: Vec<&[f64]> = vec![own.as_slice()];
        columns.extend(core[..inertia].iter().map(Vec::as_slice));
        columns.extend(terms.iter().flat_map(|c| c.iter()).map(Vec::as_slice));
        let bounds = vec![Bound::Free; columns.len()];
        let white = ground.unweighted();
        let fit = Normal::new(&white, &rows.weak.folds, &columns, &bounds, &rows.target)?;
        let residual = fit.held_out_residual(&columns, &rows.target);
        let with_core = ground
            .fit_unweighted(&hypothesis.terms)?
            .held_out_residual(rows);
        let force: Vec<f64> = residual
            .iter()
            .zip(&with_core)
            .map(|(a, b)| a - b)
            .collect();
        Some(Self {
            nmse: [rows.nmse(&residual), rows.nmse(&with_core)],
            evidence: evidence(&force, &residual, &rows.blocks),
            force,
        })
    }
}

/// The user's friction along the recording, at the rows.
fn own_friction(ground: &Ground, friction: &FrictionModel) -> Option<Vec<f64>> {
    let s = &ground.rows.s;
    let (fine, pieces) = between_samples(s);
    let velocity: Vec<f64> =
        s.v.iter()
            .flat_map(|v| std::iter::repeat_n(*v, FINER))
            .collect();
    let path = Path {
        position: &fine,
        velocity: &velocity,
        pieces: &pieces,
        sample_time: s.dt / FINER as f64,
    };
    let mut friction = friction.clone();
    if let FrictionModel::Gms { sliding, .. } = &mut friction {
        // Its Stribeck curve is among the given terms.
        *sliding = None;
    }
    let force = friction.force(path).ok()?;
    let at_samples = force.into_iter().step_by(FINER).collect();
    Some(ground.rows.weak.rows(&Column::of(at_samples)))
}
