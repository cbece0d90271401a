//! Whether the user's own hysteresis is wrong: `presliding_shape`, which has no term of its own.

use super::blocks::{FINER, between_samples};
use super::effect::Effect;
use super::effect::backlash::Backlash;
use super::effect::drive_compliance::DriveCompliance;
use super::normal::{Bound, Normal};
use super::null_model::{Hypothesis, NullModel};
use super::signals::Signals;
use super::weak::Column;
use preslide_fit::evidence::{Evidence, evidence};
use preslide_fit::friction::{FrictionModel, Path};

/// NMSE (%) by which the user's friction, refitted by a common factor, may be worse than the core before its shape is said to be
/// wrong with confidence: half of what the paper's own three blocks leave of its recording (5.97 %, `preslide reproduce`).
const TOLERATED: f64 = 3.0;
/// The same before it is suspected: what three blocks leave of a smooth law when they are placed well.
const NOTICED: f64 = 0.84;
/// Times the core's held-out error that it must leave at least.
const WORSE: f64 = 2.0;
/// Steps of half an octave by which the user's displacements are shortened, to a quarter: fitted to a first loading, blocks stand for Dahl's
/// law with twice the displacements that it has after reversals. Longer ones are not tried, for a gap and a spring lengthen them.
const STEPS: u32 = 4;

/// What the user's displacements are to be multiplied by (-), where that mends the hysteresis.
pub const DISPLACEMENT_FACTOR: &str = "displacement_factor";
/// Id of the effect.
pub const ID: &str = "presliding_shape";
/// Its name for a person.
pub const NAME: &str = "shape of the hysteresis";
/// What it is.
pub const WORDS: &str = "a hysteresis that the model's friction law does not have";
/// The experiment that decides between it and its rivals.
pub const EXPERIMENT: &str = "reversals of 5, 20 and 100 µm at one slow speed";

/// A gap or a spring in the drive stretches the first path after a reversal, as a softer hysteresis does.
static RIVALS: [&dyn Effect; 2] = [&Backlash, &DriveCompliance];

/// Effects that a recording does not separate from a wrong hysteresis.
pub fn rivals(s: &Signals) -> Vec<&'static dyn Effect> {
    let can_be = |e: &&dyn Effect| e.lacks(s).is_none();
    RIVALS.into_iter().filter(can_be).collect()
}

/// The user's hysteresis against the core's.
pub struct Shape {
    /// Held-out NMSE (%) with the user's friction, and with the core.
    pub nmse: [f64; 2],
    /// What the user's displacements are to be multiplied by, and the held-out NMSE (%) then.
    pub shorter: (f64, f64),
    /// What the core explains beside the user's friction.
    pub evidence: Evidence,
    /// What the core changes, at the rows (N or N·m).
    pub force: Vec<f64>,
}

impl Shape {
    /// Whether the user's hysteresis is materially wrong as it is.
    pub fn misleads(&self) -> bool {
        self.is_worse_by(TOLERATED, self.nmse[0])
    }

    /// Whether it is with shorter displacements, too.
    pub fn is_wrong(&self) -> bool {
        self.is_worse_by(TOLERATED, self.shorter.1)
    }

    /// Whether it may be.
    pub fn is_suspect(&self) -> bool {
        self.is_worse_by(NOTICED, self.nmse[0])
    }

    /// What its displacements are to be multiplied by where that mends it: a parameter is wrong, not the shape.
    pub fn displacement_factor(&self) -> Option<f64> {
        let (factor, left) = self.shorter;
        (!self.is_wrong() && self.nmse[0] - left > NOTICED).then_some(factor)
    }

    fn is_worse_by(&self, tolerated: f64, own: f64) -> bool {
        let core = self.nmse[1];
        own - core > tolerated && own > WORSE * core
    }

    /// Judges the friction of the user's model beside the terms of a hypothesis, by least squares: a wrong shape misleads a fit that
    /// trusts its noise model. `None` where the library refuses a parameter.
    pub fn of(null: &NullModel, hypothesis: &Hypothesis, friction: &FrictionModel) -> Option<Self> {
        let rows = &null.rows;
        let core = &null.core.rows[..null.core.first_of_friction()];
        let terms: Vec<_> = hypothesis.terms.iter().map(|t| null.columns(t)).collect();
        let residual = |factor: f64| {
            let own = own_friction(null, friction, factor)?;
            let columns: Vec<&[f64]> = std::iter::once(&own)
                .chain(core)
                .chain(terms.iter().flat_map(|c| c.iter()))
                .map(Vec::as_slice)
                .collect();
            let bounds = vec![Bound::Free; columns.len()];
            let white = null.unweighted();
            let fit = Normal::new(&white, &rows.weak.folds, &columns, &bounds, &rows.target)?;
            Some(fit.held_out_residual(&columns, &rows.target))
        };
        let as_it_is = residual(1.0)?;
        let with_core = null
            .fit_unweighted(&hypothesis.terms)?
            .held_out_residual(rows);
        let force: Vec<f64> = as_it_is
            .iter()
            .zip(&with_core)
            .map(|(a, b)| a - b)
            .collect();
        let nmse = [rows.nmse(&as_it_is), rows.nmse(&with_core)];
        let mut shape = Self {
            nmse,
            shorter: (1.0, nmse[0]),
            evidence: evidence(&force, &as_it_is, &rows.blocks),
            force,
        };
        if shape.is_suspect() {
            for step in 1..=STEPS {
                let factor = 0.5_f64.powf(f64::from(step) / 2.0);
                let left = rows.nmse(&residual(factor)?);
                if left < shape.shorter.1 {
                    shape.shorter = (factor, left);
                }
            }
        }
        Some(shape)
    }
}

/// The user's friction along the recording, at the rows, its displacements times a factor.
fn own_friction(null: &NullModel, friction: &FrictionModel, factor: f64) -> Option<Vec<f64>> {
    let s = &null.rows.s;
    let (mut fine, pieces) = between_samples(s);
    fine.iter_mut().for_each(|x| *x /= factor);
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
    Some(null.rows.weak.rows(&Column::of(at_samples)))
}
