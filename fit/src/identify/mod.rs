//! From a recording to parameters: the rigid body, and friction models of every size.

mod band;
mod between;
mod ends;
mod evidence;
pub mod family;
mod fit;
mod fitting;
mod judge;
mod laws;
pub mod maxwell_slip;
pub mod motion;
mod notes;
pub mod plain;
mod present;
pub mod refine;
pub mod regression;
pub mod rigid_body;
pub mod search;
mod speed;
pub mod speed_table;
pub mod virgin;
mod wave;
pub mod weights;
mod white;

use crate::effects::{Effect, form};
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::progress::Progress;
use crate::recording::Recording;
use crate::report::figures::quantity;
use crate::signal::{
    Channel, End, Kinematics, Split, StickSlip, TAKES, Vibration, Window, ZeroPhase, check_windows,
    step_at_reversals, unknown_starts,
};
use crate::statistics::Estimate;
use between::between;
pub use between::{Change, Changed};
use ends::{cut_from_a_motion, stands_out};
use family::Family;
use fitting::Fitting;
use laws::Mixture;
use nalgebra::{DMatrix, DVector};
use plain::Plain;
use std::ops::Range;
use virgin::VirginCurve;

/// What to fit and what to hold out.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Fit only this window (s).
    pub train: Option<Window>,
    /// Judge on this window (s), which is never fitted.
    pub test: Option<Window>,
}

/// How a friction model's parameters were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Linear least squares.
    LeastSquares,
    /// Eqs. (7)–(9) on the averaged branch, breakpoints at equal steps of force.
    Paper,
    /// Globally searched breakpoints.
    Optimal,
    /// Descent from several starts, linear parameters projected out.
    Descent(Family),
}

impl Method {
    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Method::LeastSquares => "least squares",
            Method::Paper => "paper",
            Method::Optimal => "optimal",
            Method::Descent(_) => "variable projection",
        }
    }
}

/// One friction model on the recording.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The model, viscous part and offset included.
    pub model: Model,
    /// How it was found.
    pub method: Method,
    /// NMSE (13) on the samples that were fitted (%).
    pub nmse_train: f64,
    /// NMSE (13) on the test window, or on folds held out in turn (%).
    pub nmse_test: f64,
    /// `mass` (where one is fitted), `viscous` and what else of [`Plain`] physics there is, `offset` and `coulomb`, which for GMS is the
    /// breakaway force ΣW; empty for the paper's procedure, which has none.
    pub rigid_body: Vec<(&'static str, Estimate)>,
    /// Friction's own parameters by their keys in model files of linear axes; empty for Coulomb friction and GMS.
    pub parameters: Vec<(&'static str, Estimate)>,
    /// Parameters that the search would have moved beyond its bounds.
    pub at_edge: Vec<&'static str>,
    /// Stiffness (N/m) and yield displacement (m) of each block with confidence.
    pub blocks: Vec<(Estimate, Estimate)>,
    /// Covariance of the blocks' stiffnesses and then of the logarithms of their yields, and the folds it comes from.
    covariance: Option<(DMatrix<f64>, usize)>,
    /// Squared errors on each held-out group, of GMS by optimal breakpoints.
    held_out: Vec<f64>,
    /// Modelled effort at every sample, filtered like the measured one.
    pub fitted: Vec<f64>,
}

impl Candidate {
    fn new(model: Model) -> Self {
        Self {
            model,
            method: Method::LeastSquares,
            nmse_train: f64::NAN,
            nmse_test: f64::NAN,
            rigid_body: Vec::new(),
            parameters: Vec::new(),
            at_edge: Vec::new(),
            blocks: Vec::new(),
            covariance: None,
            held_out: Vec::new(),
            fitted: Vec::new(),
        }
    }

    /// Number of friction parameters that were fitted, without inertia, viscous part (but for Hsieh's own) and offset.
    pub fn fitted_parameters(&self) -> usize {
        match (self.method, self.size()) {
            (Method::Descent(family), _) => family.parameter_count(),
            (_, 0) => 1,
            (_, blocks) => 2 * blocks,
        }
    }

    /// Number of Maxwell-slip blocks, 0 for other models.
    pub fn size(&self) -> usize {
        match &self.model.friction {
            FrictionModel::Gms { blocks, .. } => blocks.len(),
            _ => 0,
        }
    }

    /// Force (N or N·m) of the virgin curve at the displacement `x` (m or rad), `Σ k·min(x, D)`, with the confidence that
    /// all blocks together have there: neighbouring blocks are much better known as a sum than one by one.
    pub fn virgin_force(&self, x: f64) -> Estimate {
        let blocks = || self.blocks.iter().map(|(k, d)| (k.value, d.value));
        let force = blocks().map(|(k, d)| k * x.min(d)).sum();
        let Some((covariance, folds)) = &self.covariance else {
            return Estimate::new(force, None, 0);
        };
        let by_stiffness = blocks().map(|(_, d)| x.min(d));
        let by_yield = blocks().map(|(k, d)| if x > d { k * d } else { 0.0 });
        let slope: Vec<f64> = by_stiffness.chain(by_yield).collect();
        let slope = DVector::from_vec(slope);
        let variance = (covariance * &slope).dot(&slope);
        Estimate::new(force, Some(variance.max(0.0).sqrt()), *folds)
    }
}

/// Everything that `identify` found.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Cut-off of the zero-phase filter (Hz).
    pub band_hz: f64,
    /// Whether the effort went through that filter (it does where it contains inertia).
    pub filtered: bool,
    /// Coulomb and viscous first, then the paper's procedure and optimal breakpoints by size.
    pub candidates: Vec<Candidate>,
    /// Index into `candidates`.
    pub recommended: usize,
    /// One sentence: what to use and why.
    pub recommendation: String,
    /// What the user should know of the search, whichever model is taken.
    search_notes: Vec<String>,
    /// The effort that the models explain, filtered where `filtered`.
    pub effort: Vec<f64>,
    /// Velocity (m/s or rad/s).
    pub velocity: Vec<f64>,
    /// The split that was used.
    pub split: Split,
    /// The virgin curve of the training strokes.
    pub virgin: VirginCurve,
    /// Shortest and longest yield displacement that were tried (m or rad).
    pub yield_range: (f64, f64),
    /// Half of the longest stroke (m or rad), beyond which a block never slips; what it tells from a force of the position may end before.
    half_a_stroke: f64,
    /// What acts beside hysteresis.
    pub plain: Plain,
    /// Breakaway and kinetic levels, where the axis sticks and slips.
    pub stick_slip: Option<StickSlip>,
    /// What lies between the machine and the recorded effort, and was taken off.
    pub channel: Channel,
    /// What later files have otherwise than the first.
    pub between: Vec<Change>,
    /// What other laws of friction make of the plain physics, until the intervals reach to it.
    mixture: Option<Mixture>,
    /// What that made of it beside friction that falls with the speed, where it found any.
    beside_falling: Option<laws::Parameters>,
    /// What the recommended model leaves is noise.
    leaves_noise: bool,
}

/// Warnings of the loader that leave nothing to identify or diagnose, with what would.
const FATAL: [(&str, &str); 3] = [
    ("no-motion", "record a motion"),
    ("too-short", "record for longer"),
    (
        "constant-effort",
        "record or map the column that holds the effort",
    ),
];

/// Shortest yield displacement that is tried, relative to half of the longest stroke.
const FINEST: f64 = 1e-6;

/// Samples from which on a recording is thinned that models are compared on.
pub const MANY: usize = 60_000;

/// Sample rate that is kept, in cut-offs of the filter that the effort goes through anyway.
const KEPT_RATE: f64 = 10.0;

/// The same in frequencies of a line above that band, which is to be found again.
const KEPT_OF_A_LINE: f64 = 4.0;

/// Most samples that are kept, whatever the band: more add nothing to these models.
const MOST_KEPT: usize = 100_000;

/// The recording with as many samples as its band needs, where it has many more; `None` where it is best left as it is.
///
/// The band is that of the zero-phase filter through which effort and motion are compared ([`ZeroPhase`]). A recorded
/// friction goes through no filter: only what is more than anything could use is taken off it. What shakes the axis above that band stays in it. A
/// recording of fewer samples than `from` is left as it is.
pub fn thinned(recording: &Recording, from: usize) -> Option<Recording> {
    if recording.len() < from {
        return None;
    }
    // Slips are shorter than the band of the motion resolves.
    let by_band = if recording.role.contains_inertia() && StickSlip::of(recording).is_none() {
        let cutoff = ZeroPhase::highest_cutoff(recording);
        let filter = ZeroPhase::new(recording, cutoff);
        let shaken = Vibration::above(recording, &recording.effort, &filter).into_iter();
        let rate = shaken.fold(KEPT_RATE * cutoff, |rate, line| {
            rate.max(KEPT_OF_A_LINE * line.frequency_hz)
        });
        (1.0 / (rate * recording.sample_time_s())).floor() as usize
    } else {
        1
    };
    let factor = by_band.max(recording.len() / MOST_KEPT);
    (factor > 1).then(|| recording.decimated(factor))
}

/// Share of the error held out that may be left in a narrower band, where that is what the fit lacked: a load behind a spring or a gap leaves half.
const LEAVES: f64 = 0.2;

/// Times that the band of a fit is narrowed at most: the residual of a fit with false accelerations shows the rest.
const NARROWER: usize = 3;

/// Steps of the progress of [`identify`]: the search, its repetitions on held-out data, each number of blocks.
pub const STEPS: u64 = maxwell_slip::STEPS;

/// Identifies rigid body and friction. A delay is taken off only where the fit then leaves that much less on stretches held out: what yields late
/// looks like one, too.
///
/// # Errors
/// What the recording lacks and what to record instead; exit code 3.
pub fn identify(
    recording: &Recording,
    options: &Options,
    progress: &Progress,
) -> Result<Identification, String> {
    let mut kinematics = Kinematics::of(recording);
    let mut found = within(recording, options, &kinematics, progress)?;
    for _ in 0..NARROWER {
        let followed = found
            .filtered
            .then(|| found.followed_up_to(recording, &kinematics));
        let Some(cutoff_hz) = followed.flatten() else {
            break;
        };
        kinematics = Kinematics::below(recording, cutoff_hz);
        let progress = Progress::new("in a narrower band", STEPS);
        let narrower = within(recording, options, &kinematics, &progress).ok();
        let better = narrower.filter(|narrower| {
            let [own, before] = [narrower, &found].map(|fit| fit.best());
            let ends = |fit: &Candidate| {
                let mass = fit.rigid_body.iter().find(|p| p.0 == "mass");
                mass.and_then(|p| p.1.ci95)
            };
            // Where friction is nearly all, the inertia tells: what does not follow the acceleration makes it less, and surely so.
            let is_more = ends(own)
                .zip(ends(before))
                .is_some_and(|(o, b)| o[0] > b[1]);
            let left = own.nmse_test / found.left_within(&kinematics).max(1e-300);
            // Its filter carries an end of the reading into every sample: there it is no longer seen, but spoils the fit.
            let loses_end = reads_to_an_end(&found.channel) && !reads_to_an_end(&narrower.channel);
            !loses_end && ((left < LEAVES && ends(own).is_some()) || (left < 1.0 && is_more))
        });
        let Some(better) = better else {
            break;
        };
        found = better;
        found.search_notes.push(format!(
            "above {:.1} Hz the effort shows less inertia than below, or none: a load swings, or the encoder's error is periodic. The fit and its errors are of what is below, `preslide simulate` shows the whole; `preslide diagnose` finds the cause",
            found.band_hz
        ));
    }
    found.reach_to_other_laws(recording);
    found.leave_out_intervals(recording);
    Ok(found)
}

/// The fit within the band of a motion.
fn within(
    recording: &Recording,
    options: &Options,
    kinematics: &Kinematics,
    progress: &Progress,
) -> Result<Identification, String> {
    let split = split(recording, options)?;
    let channel = Channel::of(recording, kinematics);
    let has_delay = channel.delay.is_some();
    let without_delay = Channel {
        delay: None,
        ..channel.clone()
    };
    let fit = |channel, progress| {
        let split = split.clone();
        fitted(recording, options, split, kinematics, channel, progress)
    };
    let on_time = fit(channel, progress)?;
    if !has_delay {
        return Ok(on_time);
    }
    let as_recorded = fit(without_delay, &Progress::new("as recorded", STEPS))?;
    let [with, without] = [&on_time, &as_recorded].map(|found| found.best().nmse_test);
    match with < (1.0 - TAKES) * without {
        true => Ok(on_time),
        false => Ok(as_recorded),
    }
}

/// The fit of what is left when a channel is taken off.
fn fitted(
    recording: &Recording,
    options: &Options,
    mut split: Split,
    kinematics: &Kinematics,
    channel: Channel,
    progress: &Progress,
) -> Result<Identification, String> {
    let inertial = recording.role.contains_inertia();
    let arrived = channel.taken_off(recording);
    let recording = arrived.as_ref().unwrap_or(recording);
    let stick_slip = StickSlip::of(recording);
    if let Some(hunting) = stick_slip.filter(|found| found.hunts) {
        return Err(hunting.refusal(recording));
    }
    let reach = kinematics.filter.reach(recording);
    if inertial {
        keep_from_gaps(&mut split, recording, reach);
    }
    let mut unknown = channel.unknown(reach);
    unknown.extend(unknown_starts(recording));
    leave_out(&mut split, recording, unknown);
    let effort = if inertial {
        kinematics.filter.smooth(&recording.effort)
    } else {
        recording.effort.clone()
    };
    let mut notes: Vec<String> = recording.per_unit().into_iter().collect();
    notes.extend(overlap(options));
    notes.extend(channel.words(recording.effort_unit()));
    let own_notes = notes.len();
    let mut train = split.train();
    let mut of_train = |split: &Split, train: &[usize], progress: &Progress| {
        notes.truncate(own_notes);
        let fitting = Fitting {
            recording,
            kinematics,
            effort: &effort,
            split,
            train,
            inertial,
        };
        let found = fitting.fit(progress, &mut notes)?;
        let hysteresis = &found.candidates[found.recommended].model.friction;
        let between = between(&fitting, found.plain, hysteresis);
        Ok::<_, String>((found, between))
    };
    let mut told = of_train(&split, &train, progress)?;
    if inertial {
        let cut = cut_from_a_motion(recording, reach);
        let fitted = &told.0.candidates[told.0.recommended].fitted;
        if stands_out(&cut, &train, &effort, fitted) {
            leave_out(&mut split, recording, cut);
            train = split.train();
            let progress = Progress::new("without its ends", STEPS);
            told = of_train(&split, &train, &progress)?;
        }
    }
    let (found, between) = told;
    notes.extend(between.iter().map(|change| change.words(recording)));
    let mut identification = Identification {
        band_hz: kinematics.filter.cutoff_hz(),
        filtered: inertial,
        candidates: found.candidates,
        recommended: found.recommended,
        recommendation: String::new(),
        search_notes: notes,
        effort,
        velocity: kinematics.velocity.clone(),
        split,
        virgin: found.virgin,
        yield_range: found.range,
        half_a_stroke: found.half_a_stroke,
        plain: found.plain,
        stick_slip,
        channel,
        between,
        mixture: found.mixture,
        beside_falling: None,
        leaves_noise: false,
    };
    for candidate in &mut identification.candidates {
        candidate
            .model
            .effects
            .extend(effects_of(&identification.channel));
    }
    identification.leaves_noise = identification.leaves_white(recording);
    identification.recommendation = identification.recommended_in_words();
    Ok(identification)
}

fn reads_to_an_end(channel: &Channel) -> bool {
    let end = channel.saturation.as_ref();
    end.is_some_and(|end| end.of == End::Reading)
}

/// What a model has of a channel: the drive's end and the delay, where there are any; a reading's end is the sensor's, and no machine's.
fn effects_of(channel: &Channel) -> impl Iterator<Item = Effect> {
    let end = channel.saturation.as_ref();
    let end = end.filter(|end| end.of == End::Command);
    let end = end.map(|end| Effect::of(&form::ACTUATOR_SATURATION, &[end.limit.value]));
    let delay = channel.delay;
    let delay = delay.map(|found| Effect::of(&form::CHANNEL_DELAY, &[found.delay_s.value]));
    end.into_iter().chain(delay)
}

/// Fewest samples on the way across the travel that show a motion: of a stroke of five, as a servo at 10 Hz has, velocity and acceleration are
/// anybody's guess.
const RESOLVED: f64 = 12.0;

/// Samples on the way across the travel, by the step of a typical part of the path.
fn samples_across(recording: &Recording) -> f64 {
    let (low, high) = recording.ends();
    let steps = recording.pieces.iter().flat_map(|piece| {
        let own = recording.position[piece.clone()].windows(2);
        own.map(|pair| (pair[1] - pair[0]).abs())
    });
    let (path, squares) = steps.fold((0.0, 0.0), |(p, s), step| (p + step, s + step * step));
    (high - low) * path / squares.max(1e-300)
}

/// Why nobody saw how the axis moved, if so.
fn unseen(recording: &Recording) -> Option<String> {
    let across = samples_across(recording);
    (across < RESOLVED).then(|| {
        format!(
            "{}: the axis crosses its travel within {across:.0} samples, too few to see the motion; sample {:.0} times as fast, or move slower",
            recording.name,
            (RESOLVED / across).ceil()
        )
    })
}

/// Why nothing can be identified or diagnosed, if so; each of many files gives what it can.
pub fn tells_nothing(recording: &Recording) -> Option<String> {
    let last = recording.joined.len().saturating_sub(1);
    let fatal = FATAL.iter().find_map(|(code, remedy)| {
        let mut of_files = recording.warnings.iter().filter(|w| w.code == *code);
        let warning = of_files.nth(last)?;
        Some(format!("{}: {warning}; {remedy}", recording.name))
    });
    fatal.or_else(|| unseen(recording))
}

/// The samples to fit and to hold out, of a recording that can be fitted.
fn split(recording: &Recording, options: &Options) -> Result<Split, String> {
    if let Some(reason) = tells_nothing(recording) {
        return Err(reason);
    }
    check_windows(recording, options.train, options.test)?;
    Ok(Split::new(recording, options.train, options.test))
}

/// Leaves samples out of the fit.
fn leave_out(split: &mut Split, recording: &Recording, ranges: Vec<Range<usize>>) {
    let mut is_known = vec![true; recording.len()];
    for range in ranges {
        is_known[range].fill(false);
    }
    for fold in &mut split.folds {
        fold.retain(|i| is_known[*i]);
    }
}

/// Leaves out of the fit what stands beside a gap within a recording; a fold of which that is most stays whole.
fn keep_from_gaps(split: &mut Split, recording: &Recording, near: usize) {
    let starts = |at: usize| recording.joined.iter().any(|file| file.start == at);
    let cuts = recording.pieces.iter().map(|piece| piece.start);
    let cuts: Vec<usize> = cuts.filter(|at| !starts(*at)).collect();
    let is_clear = |i: usize| {
        let next = cuts.partition_point(|cut| *cut <= i);
        let before = next.checked_sub(1).map(|k| cuts[k]);
        before.is_none_or(|cut| i >= cut + near) && cuts.get(next).is_none_or(|cut| i + near < *cut)
    };
    for fold in &mut split.folds {
        let clear: Vec<usize> = fold.iter().copied().filter(|i| is_clear(*i)).collect();
        if 2 * clear.len() > fold.len() {
            *fold = clear;
        }
    }
}

/// Where the windows overlap, in words.
fn overlap(options: &Options) -> Option<String> {
    let (train, test) = options.train.zip(options.test)?;
    let (from, to) = (train.0.max(test.0), train.1.min(test.1));
    (from < to).then(|| {
        format!(
            "--train and --test overlap from {from} to {to} s: these samples are judged, not fitted"
        )
    })
}

/// First samples of the strokes that follow a reversal.
fn reversals<'a>(recording: &'a Recording, train: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
    let turns = train.windows(2).filter(|pair| {
        pair[1] == pair[0] + 1 && recording.segment[pair[1]] != recording.segment[pair[0]]
    });
    turns.map(|pair| pair[1])
}

/// Displacements (m or rad) between pairs of samples, ascending, without zeros.
fn steps(recording: &Recording, pairs: impl Iterator<Item = (usize, usize)>) -> Vec<f64> {
    let position = &recording.position;
    let steps = pairs.map(|(i, j)| (position[j] - position[i]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps
}

/// The displacement of a typical slow sample.
fn typical(steps: &[f64]) -> Option<f64> {
    steps.get(steps.len() / 10).copied()
}

/// Yields that a recording can tell apart: from the displacement of a typical sample near a reversal, where blocks yield, to half of the
/// longest stroke, beyond which a block never slips.
fn yield_range(recording: &Recording, train: &[usize]) -> Result<(f64, f64), String> {
    let steps = steps(recording, train.windows(2).map(|pair| (pair[0], pair[1])));
    let turns = reversals(recording, train);
    let local = step_at_reversals(&recording.position, &recording.pieces, turns);
    let mut extent = std::collections::BTreeMap::new();
    for &i in train {
        let x = recording.position[i];
        let (low, high) = extent.entry(recording.segment[i]).or_insert((x, x));
        *low = x.min(*low);
        *high = x.max(*high);
    }
    let longest = extent
        .values()
        .map(|(low, high)| high - low)
        .fold(0.0, f64::max)
        / 2.0;
    let typical = typical(&steps).unwrap_or(longest);
    let shortest = local.unwrap_or(typical).min(typical) / 2.0;
    // A filtered position creeps by rounding errors while it rests.
    let shortest = shortest.max(longest * FINEST);
    if shortest.max(steps.first().copied().unwrap_or(0.0)) >= longest / 2.0 {
        return Err(format!(
            "{}: strokes of {} are sampled every {}: too coarse for a friction model; sample faster or move slower",
            recording.name,
            quantity(2.0 * longest, recording.position_unit()),
            quantity(2.0 * shortest, recording.position_unit()),
        ));
    }
    Ok((shortest.max(steps[0]).min(longest / 10.0), longest))
}
