//! Every friction model on one recording: how well each fits, in and out of sample, and what each remembers.

pub mod cost;
pub mod memory;
mod present;
#[cfg(test)]
mod tests;

use crate::cost::Cost;
use memory::{LoopClosure, Scale, loop_closure};
use preslide_fit::friction::FrictionModel;
use preslide_fit::identify::family::Family;
use preslide_fit::identify::family::bench::Bench;
use preslide_fit::identify::{Candidate, Identification, Method, Options, STEPS, identify};
use preslide_fit::progress::Progress;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Kinematics;

/// Numbers of Maxwell-slip blocks that are always shown, besides the knee and the best.
const SIZES: [usize; 3] = [1, 4, 6];

/// How much more than the best error a cheaper model may leave and still be recommended.
const NEAR: f64 = 1.2;

/// Cycles that an update may take on average to be recommended: 5 % of 170 MHz at 20 kHz, what `preslide tune` allows by
/// default.
const TICK: f64 = 0.05 * 170e6 / 20e3;

/// One model on the recording.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The model as `identify` found it.
    pub candidate: Candidate,
    /// Nested loops over the recording's stroke at its speed.
    pub memory: LoopClosure,
    /// Cost of an update in `f32` in a control tick on a Cortex-M4F, where it was measured.
    pub cost: Option<Cost>,
}

/// Everything that `compare` found.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Coulomb first, then Dahl, LuGre, Hsieh and GMS by size.
    pub models: Vec<Compared>,
    /// Index into `models`.
    pub recommended: usize,
    /// What `identify` finds on all of the recording, as in its JSON.
    pub fit: serde_json::Value,
    /// What `identify` found on the rows that are compared: split, effort, band.
    pub identification: Identification,
    /// These rows.
    pub recording: Recording,
    /// The motion on which memory was judged.
    pub scale: Scale,
    /// What the user should know, besides the recording's own warnings.
    pub notes: Vec<String>,
}

/// Samples that the models are compared on: each of ten families runs along all of them several hundred times.
const MOST: usize = 12_000;
/// Stretches that these are in, over the whole of the recording.
const STRETCHES: usize = 6;

/// Stretches of a long recording, enough to tell the models apart; `None` where it is best left as it is, as where windows are asked for.
pub fn shortened(recording: &Recording, options: &Options) -> Option<Recording> {
    let windows = options.train.is_some() || options.test.is_some();
    (recording.len() > MOST && !windows).then(|| recording.stretches(STRETCHES, MOST))
}

/// Steps that [`compare`] reports to its progress, those of `identify` included.
pub fn steps() -> u64 {
    STEPS + 2 * Family::ALL.len() as u64
}

/// Fits and judges every model.
///
/// # Errors
/// What the recording lacks and what to record instead; exit code 3.
pub fn compare(
    recording: &Recording,
    options: &Options,
    progress: &Progress,
) -> Result<Comparison, String> {
    progress.set_message("compare: Coulomb and GMS");
    let mut identification = identify(recording, options, progress)?;
    if identification.optimal().next().is_none() {
        return Err(format!(
            "{}: the motion goes one way, and friction models differ at reversals only; record reversals, or use `preslide identify`",
            recording.name
        ));
    }
    let fit = identification.fit_json(recording);
    let wanted = identification.candidates[identification.recommended].size();
    let short = shortened(recording, options);
    if let Some(short) = &short {
        identification = identify(short, options, &Progress::new("stretches", STEPS))?;
    }
    let recording = short.as_ref().unwrap_or(recording);
    let scale = Scale {
        amplitude: identification.yield_range.1,
        speed: identification.top_speed(),
    };
    let mut notes = identification.notes(recording);
    let mut gms = Vec::new();
    let mut models = Vec::new();
    for candidate in chosen(&identification, wanted) {
        let judged = judged(candidate.clone(), scale)?;
        match candidate.method {
            Method::LeastSquares => models.push(judged),
            _ => gms.push(judged),
        }
    }
    let kinematics = Kinematics::below(recording, identification.band_hz);
    let bench = Bench::new(recording, &kinematics, &identification);
    for family in Family::ALL {
        progress.set_message(format!("compare: {}", family.name()));
        match bench.candidate(family, progress)? {
            Some(candidate) => {
                notes.extend(candidate.caveats());
                models.push(judged(candidate, scale)?);
            }
            None => notes.push(format!(
                "{} was left out: no starting values make its force resist the motion",
                family.name()
            )),
        }
    }
    models.extend(gms);
    Ok(Comparison {
        recommended: recommended(&models, wanted),
        models,
        fit,
        identification,
        recording: recording.clone(),
        scale,
        notes,
    })
}

/// Coulomb, and GMS by optimal breakpoints of the sizes worth a row, `wanted` among them.
fn chosen(identification: &Identification, wanted: usize) -> impl Iterator<Item = &Candidate> {
    let optimal = |c: &&Candidate| c.method == Method::Optimal;
    let best = identification
        .candidates
        .iter()
        .filter(optimal)
        .min_by(|a, b| a.nmse_test.total_cmp(&b.nmse_test))
        .map(Candidate::size);
    identification
        .candidates
        .iter()
        .filter(move |c| match c.method {
            Method::LeastSquares => true,
            Method::Paper | Method::Descent(_) => false,
            Method::Optimal => {
                let size = Some(c.size());
                SIZES.contains(&c.size()) || size == best || c.size() == wanted
            }
        })
}

fn judged(candidate: Candidate, scale: Scale) -> Result<Compared, String> {
    let friction = &candidate.model.friction;
    Ok(Compared {
        memory: loop_closure(friction, scale).map_err(|e| e.to_string())?,
        cost: cost::cost(friction),
        candidate,
    })
}

/// Of the models that fit into a control tick ([`TICK`]) the one with the fewest cycles whose held-out error is within
/// [`NEAR`] of the lowest among them. Of Coulomb friction and the sizes of GMS only the one that `identify` recommends for the whole
/// recording (`wanted` blocks) takes part, so that both commands give one answer.
fn recommended(models: &[Compared], wanted: usize) -> usize {
    let takes_part = |m: &Compared| match &m.candidate.model.friction {
        FrictionModel::Coulomb { .. } => wanted == 0,
        FrictionModel::Gms { blocks, .. } => blocks.len() == wanted,
        _ => true,
    };
    let fit = || {
        let cost = |m: &Compared| m.cost.as_ref().map(|c| c.cycles_mean);
        let part = models.iter().enumerate().filter(|(_, m)| takes_part(m));
        part.filter_map(move |(i, m)| Some((i, m.candidate.nmse_test, cost(m)?)))
            .filter(|(.., cycles)| *cycles <= TICK)
    };
    let lowest = fit()
        .map(|(_, error, _)| error)
        .fold(f64::INFINITY, f64::min);
    fit()
        .filter(|(_, error, _)| *error <= NEAR * lowest)
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .map_or(0, |(i, ..)| i)
}
