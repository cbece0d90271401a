//! Every friction model on one recording: how well each fits, in and out of sample, and what each remembers.

pub mod cost;
pub mod memory;
mod present;
#[cfg(test)]
mod tests;

use crate::cost::Cost;
use memory::{LoopClosure, Scale, loop_closure};
use preslide_fit::identify::family::Family;
use preslide_fit::identify::family::bench::Bench;
use preslide_fit::identify::{Candidate, Identification, Method, Options, STEPS, identify};
use preslide_fit::progress::Progress;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Kinematics;

/// Numbers of Maxwell-slip blocks that are always shown, besides the knee and the best.
const SIZES: [usize; 3] = [1, 4, 6];

/// How much more than the lowest error a cheaper model may leave and still be near it.
const NEAR: f64 = 1.2;

/// Cycles that an update of a cheap one may take on average: 5 % of 170 MHz at 20 kHz, what `preslide tune` allows by default.
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

impl Compared {
    /// Its family, where it has one: neither Coulomb friction nor GMS.
    pub fn family(&self) -> Option<Family> {
        match self.candidate.method {
            Method::Descent(family) => Some(family),
            _ => None,
        }
    }
}

/// Everything that `compare` found.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Coulomb first, then Dahl, LuGre, Hsieh and GMS by size.
    pub models: Vec<Compared>,
    /// Index into `models` of the one that `identify` recommends.
    pub recommended: usize,
    /// Index of the one that is near the lowest error at the least cost.
    pub cheapest: Option<usize>,
    /// What `identify` found: split, effort, band.
    pub identification: Identification,
    /// The motion on which memory was judged.
    pub scale: Scale,
    /// What the user should know, besides the recording's own warnings.
    pub notes: Vec<String>,
}

/// Steps that [`compare`] reports to its progress, those of `identify` included.
pub fn steps() -> u64 {
    STEPS + 2 * Family::ALL.len() as u64
}

/// Fits and judges every model on what `identify` fits its own to: the same rows, the same delay, the same physics beside friction.
///
/// # Errors
/// What the recording lacks and what to record instead; exit code 3.
pub fn compare(
    recording: &Recording,
    options: &Options,
    progress: &Progress,
) -> Result<Comparison, String> {
    progress.set_message("compare: Coulomb and GMS");
    let identification = identify(recording, options, progress)?;
    if identification.optimal().next().is_none() {
        return Err(format!(
            "{}: the motion goes one way, and friction models differ at reversals only; record reversals, or use `preslide identify`",
            recording.name
        ));
    }
    let scale = Scale {
        amplitude: identification.yield_range.1,
        speed: identification.top_speed(),
    };
    let mut notes = identification.notes(recording);
    let mut gms = Vec::new();
    let mut models = Vec::new();
    for candidate in chosen(&identification) {
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
    let best = identification.best();
    let is_best = |m: &Compared| {
        let own = &m.candidate;
        own.method == best.method && own.size() == best.size()
    };
    Ok(Comparison {
        recommended: models.iter().position(is_best).unwrap_or(0),
        cheapest: cheapest(&models),
        models,
        identification,
        scale,
        notes,
    })
}

/// Coulomb, and GMS by optimal breakpoints of the sizes worth a row, the recommended one among them.
fn chosen(identification: &Identification) -> impl Iterator<Item = &Candidate> {
    let least = identification
        .optimal()
        .min_by(|a, b| a.nmse_test.total_cmp(&b.nmse_test));
    let told = [least, Some(identification.best())].map(|c| c.map(Candidate::size));
    identification
        .candidates
        .iter()
        .filter(move |c| match c.method {
            Method::LeastSquares => true,
            Method::Paper | Method::Descent(_) => false,
            Method::Optimal => SIZES.contains(&c.size()) || told.contains(&Some(c.size())),
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

/// Of the models of known cost that fit into a control tick ([`TICK`]), with every parameter within its bounds, the one with the fewest cycles whose
/// held-out error is within [`NEAR`] of the lowest among them.
fn cheapest(models: &[Compared]) -> Option<usize> {
    let of_known_cost = |(i, m): (usize, &Compared)| {
        let cycles = m.cost.as_ref()?.cycles_mean;
        let takes_part = cycles <= TICK && m.candidate.at_edge.is_empty();
        takes_part.then_some((i, m.candidate.nmse_test, cycles))
    };
    let part: Vec<_> = models
        .iter()
        .enumerate()
        .filter_map(of_known_cost)
        .collect();
    let lowest = part.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    part.into_iter()
        .filter(|p| p.1 <= NEAR * lowest)
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .map(|p| p.0)
}
