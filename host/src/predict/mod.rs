//! What models say of the next second from measured samples: a linear predictor on lifted states (Koopman) beside the identified
//! friction models.
//!
//! The recording is cut in time. On its first part everything is fitted, on the second the predictors' delays and ridge are chosen by the
//! errors of predictions over many samples, and what is reported is of the third, which nothing has seen.

pub mod edmd;
pub mod lift;
mod present;
#[cfg(test)]
mod tests;

use lift::{Dictionary, Lift, Series};
use nalgebra::DMatrix;
use preslide_fit::friction::FrictionModel;
use preslide_fit::identify::family::Family;
use preslide_fit::identify::{Candidate, Method, Options, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Kinematics;
use preslide_fit::simulate::motion_from_each;
use rayon::prelude::*;
use std::ops::Range;

/// Samples ahead of which errors are reported.
pub const AHEAD: [usize; 4] = [1, 10, 100, 1000];

/// What of the recording is fitted, and what is fitted or chosen from (-).
const FITTED: f64 = 0.6;
const CHOSEN: f64 = 0.8;

/// Places from which predictions start, evenly over a part.
const STARTS: usize = 100;

/// Numbers of samples in a lift, rising: a drive's mode, a filter and a delay take two each.
const DELAYS: [usize; 5] = [1, 2, 4, 8, 16];
const RIDGES: [f64; 6] = [1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2];
/// Centres of thin plates: as many more states do not fit a tick.
const PLATES: usize = 20;
/// Blocks in a lift, where the recommended model has none.
const BLOCKS: usize = 4;

/// A predictor and its errors.
#[derive(Clone, Debug)]
pub struct Predictor {
    /// In words.
    pub name: String,
    /// What lifts, and the ridge; `None` for a friction model.
    pub lift: Option<(Dictionary, f64)>,
    /// Lifted states; 0 for a friction model.
    pub states: usize,
    /// RMS error [`AHEAD`] on the part that was chosen from (m or rad, of friction N or N·m).
    pub chosen: [f64; 4],
    /// And on the part that nothing has seen.
    pub told: [f64; 4],
}

impl Predictor {
    /// Mean logarithm of the errors on the part that is chosen from: every distance counts alike.
    fn score(&self) -> f64 {
        let mean = self.chosen.iter().map(|error| error.ln()).sum::<f64>() / AHEAD.len() as f64;
        if mean.is_nan() { f64::INFINITY } else { mean }
    }
}

/// All of them on one recording.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The lifts, then GMS and LuGre where they can be fitted.
    pub predictors: Vec<Predictor>,
    /// Which of the lifts errs least where it was chosen.
    pub best: usize,
    /// A force drives, and positions are predicted; otherwise friction along the motion.
    pub forced: bool,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Steps of the progress of [`predict`].
pub const STEPS: u64 = preslide_fit::identify::STEPS + 2;

/// Fits, chooses and judges.
///
/// # Errors
/// What the recording lacks; exit code 3.
pub fn predict(recording: &Recording, progress: &Progress) -> Result<Prediction, String> {
    let parts = Parts::of(recording)?;
    let mut notes = Vec::new();
    if recording.pieces.len() > 1 {
        notes.push("Only the longest stretch without a gap is used".to_owned());
    }
    let times = &recording.t_s[parts.piece.clone()];
    let until = |at: usize| times[at.min(times.len() - 1)];
    let whole = recording
        .slice_time(times[0], until(times.len() - 1))
        .map_err(|e| e.to_string())?;
    let first = recording
        .slice_time(times[0], until(parts.fitted.end))
        .map_err(|e| e.to_string())?;
    let mut found = identify(&first, &Options::default(), progress)?;
    let gms = gms(&found.candidates, found.recommended).cloned();
    let series = series(&whole, gms.as_ref());
    let mut predictors = lifts(&series, &parts);
    let best = (0..predictors.len())
        .min_by(|a, b| predictors[*a].score().total_cmp(&predictors[*b].score()))
        .ok_or("no linear predictor can be fitted: the motion does not separate its states")?;
    let mut models: Vec<Candidate> = gms.into_iter().collect();
    match found.choose_family(&first, Family::LuGre, progress) {
        Ok(()) => models.push(found.best().clone()),
        Err(reason) => notes.push(reason),
    }
    for candidate in models {
        match judged(&candidate.model, &whole, &series, &parts) {
            Ok([chosen, told]) => predictors.push(Predictor {
                name: candidate.model.friction.name(),
                lift: None,
                states: 0,
                chosen,
                told,
            }),
            Err(reason) => notes.push(format!("{}: {reason}", candidate.model.friction.kind())),
        }
    }
    Ok(Prediction {
        predictors,
        best,
        forced: series.forced,
        notes,
    })
}

/// Where the recording is cut, in samples of its longest piece.
struct Parts {
    piece: Range<usize>,
    fitted: Range<usize>,
    chosen: Range<usize>,
    told: Range<usize>,
}

impl Parts {
    fn of(recording: &Recording) -> Result<Self, String> {
        let longest = recording.pieces.iter().max_by_key(|piece| piece.len());
        // The last sample is left to the window's end.
        let piece = longest.cloned().unwrap_or_default();
        let n = piece.len().saturating_sub(1);
        let [first, second] = [FITTED, CHOSEN].map(|share| (share * n as f64) as usize);
        let least = AHEAD[AHEAD.len() - 1] + STARTS + DELAYS[DELAYS.len() - 1];
        if n - second < least {
            return Err(format!(
                "{}: predictions of {} samples are judged on the last fifth of the longest stretch without a gap, which has {} samples; record at least {}",
                recording.name,
                AHEAD[AHEAD.len() - 1],
                n - second,
                5 * least + 5
            ));
        }
        Ok(Self {
            piece,
            fitted: 0..first,
            chosen: first..second,
            told: second..n,
        })
    }

    /// Where predictions start in a part, none of which leaves it.
    fn starts(part: &Range<usize>) -> Vec<usize> {
        let from = part.start + DELAYS[DELAYS.len() - 1];
        let to = part.end - 1 - AHEAD[AHEAD.len() - 1];
        (0..STARTS)
            .map(|i| from + i * (to - from) / STARTS)
            .collect()
    }
}

/// The recommended model if it is of blocks, or the one with the best four, or as many as there are.
fn gms(candidates: &[Candidate], recommended: usize) -> Option<&Candidate> {
    let of_blocks = |c: &&Candidate| c.method == Method::Optimal && c.size() > 0;
    let recommended = Some(&candidates[recommended]).filter(of_blocks);
    let few = candidates
        .iter()
        .filter(of_blocks)
        .filter(|c| c.size() <= BLOCKS);
    recommended.or_else(|| few.max_by_key(|c| c.size()))
}

fn series(recording: &Recording, gms: Option<&Candidate>) -> Series {
    let n = recording.len();
    let mean = recording.position.iter().sum::<f64>() / n as f64;
    let position: Vec<f64> = recording.position.iter().map(|x| x - mean).collect();
    let steps = || (1..n).map(|k| position[k] - position[k - 1]);
    let forced = recording.role.contains_inertia();
    let effort = &recording.effort;
    let (output, input) = if forced {
        let means = effort.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        (
            std::iter::once(0.0).chain(steps()).collect(),
            means.chain([effort[n - 1]]).collect(),
        )
    } else {
        (effort.clone(), steps().chain([0.0]).collect())
    };
    let yields = gms.map_or(Vec::new(), |c| match &c.model.friction {
        FrictionModel::Gms {
            breakaway, blocks, ..
        } => (blocks.iter().map(|b| b.yield_displacement(*breakaway))).collect(),
        _ => Vec::new(),
    });
    let deflections = yields.into_iter().map(|most: f64| {
        let along = steps().scan(0.0, |z: &mut f64, step| {
            *z = (*z + step).clamp(-most, most);
            Some(*z)
        });
        std::iter::once(0.0).chain(along).collect()
    });
    Series {
        deflections: deflections.collect(),
        position,
        output,
        input,
        forced,
    }
}

/// Every dictionary with the delays and the ridge that predict best on the part that is chosen from.
fn lifts(series: &Series, parts: &Parts) -> Vec<Predictor> {
    let known = !series.deflections.is_empty();
    let kinds = [(false, 0), (true, 0), (false, PLATES), (true, PLATES)];
    let kinds = kinds.into_iter().filter(|(blocks, _)| known || !blocks);
    let kinds: Vec<_> = kinds.collect();
    let best = kinds.into_par_iter().filter_map(|(blocks, plates)| {
        let tried = DELAYS.into_iter().flat_map(|delays| {
            let dictionary = Dictionary {
                delays,
                blocks,
                plates,
            };
            of_dictionary(series, parts, dictionary)
        });
        tried.min_by(|a, b| a.score().total_cmp(&b.score()))
    });
    best.collect()
}

fn of_dictionary(series: &Series, parts: &Parts, dictionary: Dictionary) -> Vec<Predictor> {
    let lift = Lift::new(series, dictionary, parts.fitted.clone());
    let moments = lift.moments(parts.fitted.clone());
    let furthest = AHEAD[AHEAD.len() - 1];
    let tried = RIDGES.into_iter().filter_map(|ridge| {
        let map = lift.whole(&moments.map(ridge)?);
        let [chosen, told] = [&parts.chosen, &parts.told].map(|part| {
            let starts = Parts::starts(part);
            errors(series, &starts, &lift.roll(&map, &starts, furthest))
        });
        Some(Predictor {
            name: dictionary.name().to_owned(),
            lift: Some((dictionary, ridge)),
            states: lift.states(),
            chosen,
            told,
        })
    });
    tried.collect()
}

/// RMS errors [`AHEAD`] of what was `said` (starts × steps).
fn errors(series: &Series, starts: &[usize], said: &DMatrix<f64>) -> [f64; 4] {
    let truth = match series.forced {
        true => &series.position,
        false => &series.output,
    };
    AHEAD.map(|ahead| {
        let square = |(i, s): (usize, &usize)| (said[(i, ahead - 1)] - truth[s + ahead]).powi(2);
        let squares: f64 = starts.iter().enumerate().map(square).sum();
        (squares / starts.len() as f64).sqrt()
    })
}

/// The same of a friction model.
fn judged(
    model: &Model,
    recording: &Recording,
    series: &Series,
    parts: &Parts,
) -> Result<[[f64; 4]; 2], String> {
    let furthest = AHEAD[AHEAD.len() - 1];
    let along = match series.forced {
        true => Vec::new(),
        false => model.resistance(Kinematics::of(recording).path(recording))?,
    };
    let mean = recording.position[0] - series.position[0];
    let of = |part: &Range<usize>| {
        let starts = Parts::starts(part);
        let said = if series.forced {
            let all = motion_from_each(model, recording, &starts, furthest)?;
            DMatrix::from_fn(starts.len(), furthest, |i, k| all[i][k] - mean)
        } else {
            DMatrix::from_fn(starts.len(), furthest, |i, k| along[starts[i] + k + 1])
        };
        Ok::<_, String>(errors(series, &starts, &said))
    };
    Ok([of(&parts.chosen)?, of(&parts.told)?])
}
