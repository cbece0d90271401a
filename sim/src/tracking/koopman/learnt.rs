//! The closed loop's map between lifted states, from a motion with forces in it that nothing in the loop asked for.

use super::outer::{Outer, Sample, Task};
use super::{BLOCKS, DELAYS, Lift, Model, STATES};
use crate::stage::StageConfig;
use crate::tracking::{Axis, Step, TrackingError, motions};
use nalgebra::{DMatrix, DVector};
use preslide::control::Settings;
use preslide::{Friction, Units};
use preslide_host::predict::edmd::{Map, Moments};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest force that is added (N): a third of the breakaway force, so that contacts stick and slip as they do without.
const ADDED_N: f64 = 0.3;
/// Samples for which one is held at most.
const HELD: u32 = 16;
/// Its seed.
const SEED: u64 = 48;
/// Repeats of the motion that are fitted; one more is left to choose by.
const FITTED: usize = 2;
/// Samples ahead that predictions are judged at.
const AHEAD: [usize; 3] = [1, 4, 16];
/// Samples between two starts of predictions.
const EVERY: usize = 50;
const RIDGES: [f64; 6] = [1e-10, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2];

/// States that the map is learnt of; the rest is known.
const LEARNT: usize = 1 + BLOCKS;
/// All but the unforeseen error.
const KNOWN: usize = STATES - 1;

/// A map, and how it was chosen.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// For the controller.
    pub(super) model: Model,
    /// Its ridge (-).
    pub ridge: f64,
    /// RMS errors (m) of the predicted following error 1, 4 and 16 samples ahead on the repeat that was not fitted.
    pub errors_m: [f64; 3],
    /// RMS of what was predicted there (m).
    pub size_m: f64,
}

/// Adds held random forces and keeps every sample.
#[derive(Clone, PartialEq)]
struct Shake;

#[derive(Clone)]
struct Shaken {
    rng: ChaCha8Rng,
    force: f64,
    left: u32,
    samples: Vec<Sample>,
}

impl Task for Shake {
    type State = Shaken;

    fn start(&self) -> Shaken {
        Shaken {
            rng: ChaCha8Rng::seed_from_u64(SEED),
            force: 0.0,
            left: 0,
            samples: Vec::new(),
        }
    }

    fn run(&self, state: &mut Shaken, sample: &Sample) -> Option<f64> {
        state.samples.push(*sample);
        if state.left == 0 {
            state.left = state.rng.random_range(1..=HELD);
            state.force = state.rng.random_range(-ADDED_N..ADDED_N);
        }
        state.left -= 1;
        Some(state.force)
    }
}

/// Learns the loop of `settings` with `friction` in it on a stage. The lift's blocks have `yields` (m); `compensated` as for
/// [`preslide::control::koopman::ErrorLift`].
///
/// # Errors
/// [`TrackingError`] where the controller cannot be built or gave up, or no map can be fitted.
pub fn learn<F: Friction<Scalar = f32>>(
    settings: &Settings,
    friction: F,
    stage: StageConfig,
    yields: &[f64; BLOCKS],
    compensated: bool,
) -> Result<Learnt, TrackingError> {
    let samples = shaken(settings, friction, stage)?;
    let lifted = lifted(&samples, yields, compensated)?;
    let fitted = lifted.len() * FITTED / (FITTED + 1);
    let moments = moments(&lifted[..fitted], &samples[..fitted]);
    let tried = RIDGES.into_iter().filter_map(|ridge| {
        let model = model(&moments.map(ridge)?);
        let (errors_m, size_m) = judged(&model, &lifted[fitted..], &samples[fitted..]);
        Some(Learnt {
            model,
            ridge,
            errors_m,
            size_m,
        })
    });
    let score = |l: &Learnt| l.errors_m.iter().map(|e| e.ln()).sum::<f64>();
    tried
        .filter(|l| score(l).is_finite())
        .min_by(|a, b| score(a).total_cmp(&score(b)))
        .ok_or_else(|| {
            TrackingError::Identification("no linear map of the loop can be fitted".into())
        })
}

/// The samples of the motion, repeated.
fn shaken<F: Friction<Scalar = f32>>(
    settings: &Settings,
    friction: F,
    stage: StageConfig,
) -> Result<Vec<Sample>, TrackingError> {
    let outer = Outer::try_new(friction, 2.0 * ADDED_N, Shake)?;
    let mut axis = Axis::try_new(settings, outer, Units::SI, stage)?;
    let moves = Step::plan_all(&motions::identification(), settings)?;
    let mut fault = None;
    for _ in 0..=FITTED {
        axis.follow(&moves, |now| fault = fault.or(now.command.fault));
    }
    match fault {
        Some(fault) => Err(TrackingError::Stopped(fault)),
        None => Ok(std::mem::take(&mut axis.friction_state().task.samples)),
    }
}

/// The lifted states by the controller's own lift, without the error that no map foresaw.
fn lifted(
    samples: &[Sample],
    yields: &[f64; BLOCKS],
    compensated: bool,
) -> Result<Vec<DVector<f64>>, TrackingError> {
    let nothing = Model {
        map: [[0.0; STATES]; STATES],
        force: [0.0; STATES],
        reference: [0.0; STATES],
    };
    let lift = Lift::try_new(yields, compensated, &nothing, 0.0)?;
    let mut state = lift.at_rest();
    let take = |s: &Sample| {
        let told = [s.error, s.travelled, s.reference, s.force].map(|value| value as f32);
        let lifted = lift.take(&mut state, told[0], told[1], told[2], told[3]);
        DVector::from_fn(KNOWN, |i, _| lifted[i].into())
    };
    Ok(samples.iter().map(take).collect())
}

/// The rows that are learnt: the error and the deflections.
fn rows() -> impl Iterator<Item = usize> {
    std::iter::once(0).chain(2 * DELAYS..KNOWN)
}

fn moments(lifted: &[DVector<f64>], samples: &[Sample]) -> Moments {
    let last = lifted.len() - 1;
    let state = DMatrix::from_columns(&lifted[..last]);
    let input = DMatrix::from_fn(1, last, |_, k| samples[k + 1].reference);
    let rows: Vec<usize> = rows().collect();
    let next = DMatrix::from_fn(LEARNT, last, |i, k| lifted[k + 1][rows[i]]);
    Moments::of(&state, &input, &next)
}

/// What was learnt, the delays' shifts, the order that waits for the next sample, and the unforeseen error, which stays.
fn model(learnt: &Map) -> Model {
    let mut model = Model {
        map: [[0.0; STATES]; STATES],
        force: [0.0; STATES],
        reference: [0.0; STATES],
    };
    for (i, row) in rows().enumerate() {
        for k in 0..KNOWN {
            model.map[row][k] = learnt.a[(i, k)];
        }
        model.reference[row] = learnt.b[(i, 0)];
    }
    for i in 1..DELAYS {
        model.map[i][i - 1] = 1.0;
        model.map[DELAYS + i][DELAYS + i - 1] = 1.0;
    }
    model.force[DELAYS] = 1.0;
    model.map[0][STATES - 1] = 1.0;
    model.map[STATES - 1][STATES - 1] = 1.0;
    model
}

/// RMS errors of the predicted error at each distance, and its own RMS.
fn judged(model: &Model, lifted: &[DVector<f64>], samples: &[Sample]) -> ([f64; 3], f64) {
    let map = DMatrix::from_fn(KNOWN, KNOWN, |i, k| model.map[i][k]);
    let furthest = AHEAD[AHEAD.len() - 1];
    let (mut squares, mut size, mut starts) = ([0.0; 3], 0.0, 0.0);
    for start in (0..lifted.len() - furthest).step_by(EVERY) {
        let mut state = lifted[start].clone();
        for ahead in 1..=furthest {
            state = &map * state;
            for row in rows() {
                state[row] += model.reference[row] * samples[start + ahead].reference;
            }
            state[DELAYS] = samples[start + ahead].force;
            if let Some(at) = AHEAD.iter().position(|a| *a == ahead) {
                squares[at] += (state[0] - lifted[start + ahead][0]).powi(2);
            }
        }
        size += lifted[start][0].powi(2);
        starts += 1.0;
    }
    (squares.map(|s| (s / starts).sqrt()), (size / starts).sqrt())
}
