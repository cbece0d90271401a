//! Parameters from the motion: those with which a simulation, left to itself, moves as the machine did.
//!
//! The fit of the force ([`super::identify`]) says what force a motion takes, and a small error of it drives a simulation far away. This
//! fit minimises the error of a simulation: position, open loop from the recorded effort or closed loop behind the user's
//! controller. It begins with the fit of the force, with several starts around it, simulates the longest windows for which all
//! starts agree, and takes in only physics that makes windows smaller that it was not fitted to.

mod beside;
mod body;
mod descent;
mod present;
mod search;
mod terms;
#[cfg(test)]
mod tests;
mod told;
mod window;

use super::Identification;
use crate::effects::form;
use crate::model::Model;
use crate::progress::Progress;
use crate::recording::Recording;
use crate::signal::{End, Kinematics};
use crate::simulate::closed::Controller;
use crate::statistics::{Estimate, quantile};
use beside::Beside;
use body::{Body, Place};
use search::{COMPARED, ROUNDS, Search, long_pieces};
use terms::{GROUPS, Sizes};
use window::{Drive, Driven};

/// What [`fit`] works on.
pub const STEPS: u64 = 2 + (ROUNDS * GROUPS.len()) as u64;

/// Error of a simulated motion (m or rad).
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    /// Root mean square.
    pub rms: f64,
    /// Mean magnitude.
    pub mean_abs: f64,
}

impl Apart {
    fn of(errors: &[f64]) -> Self {
        let n = errors.len() as f64;
        Self {
            rms: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            mean_abs: errors.iter().map(|e| e.abs()).sum::<f64>() / n,
        }
    }
}

/// Physics that was tried beside what the fit of the force has.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Id in the catalogue.
    pub id: &'static str,
    /// Share by which it changes the loss of windows that it was not fitted to; negative is better.
    pub change: f64,
    /// It was taken.
    pub taken: bool,
}

/// What a motion fit found.
#[derive(Clone, Debug)]
pub struct MotionFit {
    /// The model; Coulomb friction, as sticks and slides decide a motion.
    pub model: Model,
    /// Parameters by name.
    pub parameters: Vec<(&'static str, Estimate)>,
    /// Values that the fit of the force gave the same parameters.
    pub before: Vec<f64>,
    /// Simulations through whole pieces, with the fit of the force and with this one.
    pub errors: [Apart; 2],
    /// The same through each quarter of the pieces, from its own start, with the fit of the others; `None` where they cannot be fitted.
    pub held_out: Option<Apart>,
    /// Losses (m or rad) in which the starts ended, best first.
    pub starts: Vec<f64>,
    /// All starts ended at one place.
    pub agree: bool,
    /// Length (s) of the longest window.
    pub window_s: f64,
    /// What was tried, in the order of its trial.
    pub tried: Vec<Tried>,
    /// RMS (m or rad) by which 1 % more drive gain and 1 % more friction move the simulation.
    pub moves: [f64; 2],
    /// Pairs of parameters whose combination alone the motion determines, with their correlation.
    pub together: Vec<(&'static str, &'static str, f64)>,
    /// The simulation behind a controller.
    pub closed_loop: bool,
    /// Simulated position (m or rad) at every sample, as the fit of the force and this one have it.
    pub simulated: [Vec<f64>; 2],
    /// The fit of the force with blocks.
    beside: Beside,
}

/// Parameters with which the simulated motion meets the recorded one; `force` is the fit of the force of the same recording.
///
/// # Errors
/// A recording or a controller that cannot be simulated, with the reason and the remedy.
pub fn fit(
    recording: &Recording,
    force: &Identification,
    controller: Option<&Controller>,
    progress: &Progress,
) -> Result<MotionFit, String> {
    let name = &recording.name;
    if !recording.role.contains_inertia() {
        return Err(format!(
            "{name}: friction alone moves nothing; --criterion motion needs the driving force, with inertia in it"
        ));
    }
    if controller.is_some() && recording.reference.is_none() {
        let column = recording.kind.reference_column();
        return Err(format!(
            "{name}: --controller follows a reference, and there is none; bring it in with --map {column}=COLUMN, or leave out --controller for the open loop"
        ));
    }
    let end = force.channel.saturation.as_ref();
    if let Some(end) = end.filter(|end| end.of == End::Reading && controller.is_none()) {
        return Err(format!(
            "{name}: {}, and a simulation of the force needs all of it; simulate the loop (--controller), or map the command as the effort",
            end.words(recording.effort_unit())
        ));
    }
    let beside = Beside::of(force);
    if force.is_mostly_presliding() {
        return Err(beside.refusal(name));
    }
    let arrived = force.channel.taken_off(recording);
    let recording = arrived.as_ref().unwrap_or(recording);
    let coulomb = &force.candidates[0].model;
    if coulomb.inertia <= 0.0 {
        return Err(format!(
            "{name}: the fit of the force finds no inertia, so nothing can be simulated; record a motion that accelerates"
        ));
    }
    let kinematics = Kinematics::of(recording);
    let (low, high) = recording.ends();
    let place = Place {
        kind: recording.kind,
        travel: [low, high],
    };
    let drive = match controller {
        None => Drive::Open,
        Some(controller) => Drive::Loop {
            controller,
            pid: controller.pid()?,
        },
    };
    let body = Body::of(coulomb, &place);
    let mut magnitudes: Vec<f64> = recording.effort.iter().map(|f| f.abs()).collect();
    let typical = quantile(&mut magnitudes, 0.5).unwrap_or(0.0);
    let search = Search {
        driven: Driven {
            recording,
            velocity: &kinematics.velocity,
            drive,
            place,
        },
        sizes: Sizes {
            inertia: body.inertia,
            force: body.coulomb.max(typical),
            speed: kinematics
                .velocity
                .iter()
                .fold(0.0, |top, v| v.abs().max(top)),
            forgets_s: body.inertia / body.viscous.max(f64::MIN_POSITIVE),
            place,
        },
        pieces: long_pieces(recording),
        steps: 1,
        every: recording.len().div_ceil(COMPARED),
    };
    let mut found = search.run(body, beside, progress)?;
    let [limit, delay] =
        [&form::ACTUATOR_SATURATION, &form::CHANNEL_DELAY].map(|form| coulomb.of(form).next());
    found.model.effort_unit = coulomb.effort_unit;
    found
        .model
        .effects
        .extend(limit.into_iter().chain(delay).cloned());
    Ok(found)
}
