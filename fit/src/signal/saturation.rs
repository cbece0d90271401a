//! An effort with an end: the command exceeds what the drive gives, or the reading stops where the force goes on.
//!
//! Both are judged by the plain error of rigid body and hysteresis in newtons, which is fitted to the effort as it was recorded and to the
//! effort with its end. Beyond its end a *command* did not arrive: there the effort was the limit. Samples at the end of a *reading*
//! pile up; there the effort is not known, and the motion asks for more than was read.

use super::Kinematics;
use super::rigid::{BLOCKS, Rigid};
use crate::recording::Recording;
use crate::statistics::{Estimate, LeastSquares, quantile_between_ranks};
use serde::Serialize;
use std::ops::Range;

/// Share of the samples beyond the limit of a command at most: more would be explained by the limit alone.
const MOST_BEYOND: f64 = 0.6;
/// The same where the limit need not explain nearly all, and of what the recorded effort leaves it then leaves this at most.
const RARE: f64 = 0.2;
const NEARLY_ALL: f64 = 0.05;
/// Limits that are tried before the search between two of them, and its steps.
const PLACES: usize = 48;
const STEPS: usize = 12;
/// Of the squares that the fit of the recorded effort leaves, the fit with an end must not leave more; an interior least, so that it is no
/// limit that explains itself, must leave no more of what the lowest one tried does.
const LEAVES: f64 = 0.5;
const INTERIOR: f64 = 0.9;
/// The same where the end is one and the same number in as many samples as make a pile. Set with one such reading in sight, of a blind judge's
/// conveyor, at 0.82.
const LEAVES_OF_ONE: f64 = 0.9;
/// What is left where the command is cut may be this many times what is left elsewhere: at an outlier of the reading it is far more.
const LIKE_ELSEWHERE: f64 = 3.0;
/// A reading piles up where its highest values, within this share of the end, are so many and so many times those in a band as wide below.
const BAND: f64 = 0.03;
const PILED: usize = 20;
const TIMES: f64 = 2.0;
/// Share of the samples of a pile at most, as a level of friction is one, too. A pile of more must stand at one and the same number in this share of its
/// samples, and the fit of the rest must leave no more than this of what the fit of all leaves there: a command that acts at its limit for most
/// of the time fits with the rest.
const MOST_PILED: f64 = 0.5;
const STANDS: f64 = 0.9;
const LEAVES_OF_MOST: f64 = 0.1;
/// Samples off the end, for each column that is fitted to them, at least.
const KNOWN: usize = 20;
/// Share of the piled samples in which the motion must ask for more than was read.
const ASKS_FOR_MORE: f64 = 0.75;
/// Yields of the blocks beside the rigid body, as shares of the travel: there is no fit yet.
const YIELDS: [f64; 7] = [3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.25];

/// Whose end it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// The drive gives no more than this of the command.
    Command,
    /// The reading shows no more than this of the force.
    Reading,
}

/// An effort with an end.
#[derive(Clone, Debug, Serialize)]
pub struct Saturation {
    /// Whose.
    pub of: End,
    /// Magnitude (N or N·m).
    #[serde(rename = "limit_N")]
    pub limit: Estimate,
    /// Share of the samples beyond it.
    pub share: f64,
    /// RMS (N or N·m) that rigid body and hysteresis leave of the samples within, without the end and with it.
    #[serde(rename = "leaves_rms_N")]
    pub leaves: [f64; 2],
    /// Samples at or beyond the end.
    #[serde(skip)]
    pub beyond: Vec<bool>,
    /// What a fit leaves at every sample, without the end and with it, where that is known.
    #[serde(skip)]
    pub residuals: [Vec<f64>; 2],
}

impl Saturation {
    /// The end of a recording's effort, where one is seen.
    pub fn of(recording: &Recording, kinematics: &Kinematics) -> Option<Self> {
        if !recording.role.contains_inertia() {
            return None;
        }
        let (low, high) = recording.ends();
        let yields = YIELDS.map(|share| share * (high - low));
        let plain = Rigid::of(recording, kinematics, &yields);
        let command = plain.command();
        command.or_else(|| plain.reading())
    }

    /// The recording with the effort that arrived, where the command is what ends.
    pub fn arrived(&self, recording: &Recording) -> Option<Recording> {
        (self.of == End::Command).then(|| {
            let mut arrived = recording.clone();
            let limit = self.limit.value;
            arrived
                .effort
                .iter_mut()
                .for_each(|f| *f = f.clamp(-limit, limit));
            arrived
        })
    }

    /// Samples whose effort is unknown, with `reach` to each side, if it is the reading that saturates.
    pub fn unknown(&self, reach: usize) -> Vec<Range<usize>> {
        match self.of {
            End::Command => Vec::new(),
            End::Reading => spread(&self.beyond, reach),
        }
    }

    /// In words, a sentence without its full stop.
    pub fn words(&self, unit: &str) -> String {
        let (limit, percent) = (self.limit.value, 100.0 * self.share);
        match self.of {
            End::Command => format!(
                "the command exceeds what the drive gives: no more than ±{limit:.4} {unit} arrives ({percent:.1} % of the samples ask for more); the fit limits the effort alike"
            ),
            End::Reading => format!(
                "the reading ends at ±{limit:.4} {unit} while the motion takes more ({percent:.1} % of the samples stand there): these samples are left out of the fit"
            ),
        }
    }
}

/// Samples that stand at the highest or the lowest number.
fn standing(effort: &[f64]) -> usize {
    let wider = |(low, high): (f64, f64), f: &f64| (low.min(*f), high.max(*f));
    let (low, high) = effort
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), wider);
    effort.iter().filter(|f| **f <= low || **f >= high).count()
}

/// What to ask of an effort that stands at its ends for most of the time, of which the motion does not say whether it is the drive's or the reading's; a
/// sentence without its full stop.
pub fn stands_mostly(recording: &Recording) -> Option<String> {
    let share = standing(&recording.effort) as f64 / recording.len() as f64;
    (share > MOST_PILED && recording.role.contains_inertia()).then(|| {
        format!(
            "the effort stands at its highest or lowest number in {:.0} % of the samples: the fit is right if the drive gives just that, and inertia and friction are too small if the reading ends there; compare it with the range of the reading",
            100.0 * share
        )
    })
}

/// Samples that are `beyond`, and `reach` to each side of them.
fn spread(beyond: &[bool], reach: usize) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for (i, _) in beyond.iter().enumerate().filter(|(_, beyond)| **beyond) {
        let own = i.saturating_sub(reach)..(i + reach + 1).min(beyond.len());
        match ranges.last_mut() {
            Some(last) if own.start <= last.end => last.end = own.end,
            _ => ranges.push(own),
        }
    }
    ranges
}

impl Rigid<'_> {
    fn cut(&self, limit: f64) -> Vec<f64> {
        let effort = self.recording.effort.iter();
        let cut: Vec<f64> = effort.map(|f| f.clamp(-limit, limit)).collect();
        self.kinematics.filter.smooth(&cut)
    }

    /// The limit of a drive whose command exceeds it.
    fn command(&self) -> Option<Saturation> {
        let size: Vec<f64> = self.recording.effort.iter().map(|f| f.abs()).collect();
        let lowest = quantile_between_ranks(&size, 1.0 - MOST_BEYOND);
        let highest = size.iter().fold(0.0, |most: f64, f| most.max(*f));
        if lowest <= 0.0 || highest <= lowest {
            return None;
        }
        let without = self.left(&self.cut(highest), |_| true)?;
        let columns = self.at(&self.rows);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fit = LeastSquares::of(&columns)?;
        // What is left, of what there is: a lower limit leaves less of anything.
        let loss = |limit: f64| {
            let cut = self.cut(limit);
            let target: Vec<f64> = self.rows.iter().map(|&i| cut[i]).collect();
            fit.squares_left(&target) / target.iter().map(|f| f * f).sum::<f64>()
        };
        let ratio = (highest / lowest).powf(1.0 / PLACES as f64);
        let places = (0..PLACES).map(|k| lowest * ratio.powi(k as i32));
        let (mut best, mut least) = places
            .map(|limit| (limit, loss(limit)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let beyond = |limit: f64| size.iter().filter(|f| **f > limit).count() as f64;
        let leaves = match beyond(best) > RARE * size.len() as f64 {
            true => NEARLY_ALL,
            false => LEAVES,
        };
        if least > leaves * loss(highest) || least > INTERIOR * loss(lowest) {
            return None;
        }
        let mut step = ratio;
        for _ in 0..STEPS {
            step = step.sqrt();
            let beside = [best / step, best * step].map(|limit| (limit, loss(limit)));
            if let Some(better) = beside.into_iter().find(|b| b.1 < least) {
                (best, least) = better;
            }
        }
        let beyond: Vec<bool> = size.iter().map(|f| *f > best).collect();
        let with = self.left(&self.cut(best), |_| true)?;
        let (at, elsewhere) = (
            self.squares(&with, |i| beyond[i]),
            self.squares(&with, |i| !beyond[i]),
        );
        if at > LIKE_ELSEWHERE.powi(2) * elsewhere {
            return None;
        }
        // Where the loss has grown by what two standard deviations of its blocks' own would.
        let grown = |limit: f64| loss(limit) > least * (1.0 + 4.0 / BLOCKS as f64);
        let edge = |towards: f64| {
            let mut at = best;
            while at > lowest && at < highest && !grown(at) {
                at *= towards;
            }
            at
        };
        let limit = Estimate {
            value: best,
            ci95: Some([edge(0.99), edge(1.01)]),
        };
        Some(self.told(End::Command, limit, beyond, [without, with]))
    }

    /// The end of a reading at which its samples pile up.
    fn reading(&self) -> Option<Saturation> {
        let size: Vec<f64> = self.recording.effort.iter().map(|f| f.abs()).collect();
        let end = quantile_between_ranks(&size, 0.999);
        let count = |from: f64, to: f64| size.iter().filter(|f| (from..to).contains(*f)).count();
        let band = BAND * end;
        let (piled, below) = (
            count(end - band, f64::INFINITY),
            count(end - 2.0 * band, end - band),
        );
        let share = piled as f64 / size.len() as f64;
        if piled < PILED || (piled as f64) < TIMES * below as f64 {
            return None;
        }
        let top: Vec<f64> = size.iter().copied().filter(|f| *f >= end - band).collect();
        let beyond: Vec<bool> = size.iter().map(|f| *f >= end - band).collect();
        let near = self.near(&beyond);
        let is_most = share > MOST_PILED;
        if is_most && !(self.stands(piled) && self.known(&near) >= KNOWN * self.columns.len()) {
            return None;
        }
        let effort = self.kinematics.filter.smooth(&self.recording.effort);
        let without = self.left(&effort, |_| true)?;
        let with = self.left(&effort, |i| !near[i])?;
        let [before, after] = [&without, &with].map(|left| self.squares(left, |i| !near[i]));
        // A converter at its end gives one number; noise that is added behind an end, or a force that happens to be the highest, gives many.
        let most = size.iter().copied().fold(0.0, f64::max);
        let is_one_number = size.iter().filter(|f| **f >= most).count() >= PILED;
        let leaves = match (is_most, is_one_number) {
            (true, _) => LEAVES_OF_MOST,
            (false, true) => LEAVES_OF_ONE,
            (false, false) => LEAVES,
        };
        if after > leaves * before || self.asks_for_more(&beyond, &with) < ASKS_FOR_MORE {
            return None;
        }
        let middle = quantile_between_ranks(&top, 0.5);
        let reach = quantile_between_ranks(&top, 0.84) - middle;
        let limit = Estimate {
            value: middle,
            ci95: Some([middle - reach, middle + reach]),
        };
        // What is not known is left out.
        let mut with = with;
        let known = near.iter().zip(&mut with);
        known
            .filter(|(near, _)| **near)
            .for_each(|(_, left)| *left = 0.0);
        Some(self.told(End::Reading, limit, beyond, [without, with]))
    }

    /// Whether so many samples stand at the highest or the lowest number, but for a few.
    fn stands(&self, piled: usize) -> bool {
        standing(&self.recording.effort) as f64 >= STANDS * piled as f64
    }

    /// Samples to fit of which the effort is known.
    fn known(&self, near: &[bool]) -> usize {
        self.rows.iter().filter(|i| !near[**i]).count()
    }

    /// Share of the samples beyond at which the motion asks for more: what is left of the reading there is less than nothing.
    fn asks_for_more(&self, beyond: &[bool], left: &[f64]) -> f64 {
        let asks = self.rows.iter().filter(|i| beyond[**i]);
        let (more, all) = asks.fold((0.0, 0.0), |(more, all), &i| {
            let lacks = -left[i] * self.recording.effort[i].signum();
            (more + f64::from(u8::from(lacks > 0.0)), all + 1.0)
        });
        more / f64::max(all, 1.0)
    }

    /// Samples into which the filter carries those beyond.
    fn near(&self, beyond: &[bool]) -> Vec<bool> {
        let reach = self.kinematics.filter.reach(self.recording);
        let mut near = vec![false; beyond.len()];
        for range in spread(beyond, reach) {
            near[range].fill(true);
        }
        near
    }

    fn told(
        &self,
        of: End,
        limit: Estimate,
        beyond: Vec<bool>,
        residuals: [Vec<f64>; 2],
    ) -> Saturation {
        let leaves = [0, 1].map(|k: usize| self.squares(&residuals[k], |i| !beyond[i]).sqrt());
        Saturation {
            of,
            limit,
            share: beyond.iter().filter(|b| **b).count() as f64 / beyond.len() as f64,
            leaves,
            beyond,
            residuals,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, load_csv};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;
    use std::fmt::Write as _;

    const SEED: u64 = 3;

    /// A body of 2 kg with one block that is moved as asked, its force with noise of 5 mN, as `recorded` has it of time, acceleration and force.
    fn moved(recorded: impl Fn(f64, f64, f64) -> f64) -> Recording {
        println!("seed {SEED}");
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let (mut text, mut stop, mut last) = ("t_s,x_m,force_N\n".to_owned(), 0.0_f64, 0.0);
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            let parts = [(0.02, 0.31, 0.0), (0.004, 1.7, 1.0), (2e-4, 9.0, 2.0)];
            let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
            for (size, hertz, phase) in parts {
                let w = TAU * hertz;
                x += size * (w * t + phase).sin();
                v += size * w * (w * t + phase).cos();
                a -= size * w * w * (w * t + phase).sin();
            }
            stop = (stop + x - last).clamp(-2e-5, 2e-5);
            last = x;
            let force = 2.0 * a + 5.0 * v + 5e4 * stop + 0.01 * random.random_range(-1.0..1.0);
            let _ = writeln!(text, "{t:.3},{x:.7e},{:.6}", recorded(t, a, force));
        }
        load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("valid")
    }

    fn found(recording: &Recording) -> Option<Saturation> {
        Saturation::of(recording, &Kinematics::of(recording))
    }

    #[test]
    fn reports_where_a_reading_saturates() {
        let found = found(&moved(|_, _, f| f.clamp(-2.2, 2.2))).expect("an end");
        assert_eq!(found.of, End::Reading);
        assert!(
            (found.limit.value / 2.2 - 1.0).abs() < 5e-3,
            "{:?}",
            found.limit
        );
        assert!(
            found.leaves[1] < 0.5 * found.leaves[0],
            "{:?}",
            found.leaves
        );
        let unknown = found.unknown(0);
        let left_out: usize = unknown.iter().map(ExactSizeIterator::len).sum();
        assert_eq!(left_out, found.beyond.iter().filter(|b| **b).count());
    }

    /// Three quarters of the samples say nothing but that the force is more.
    #[test]
    fn reports_a_reading_that_stands_at_its_end_most_of_the_time() {
        let found = found(&moved(|_, _, f| f.clamp(-0.8, 0.8))).expect("an end");
        println!("{:?} {} {:?}", found.limit, found.share, found.leaves);
        assert_eq!(found.of, End::Reading);
        assert!(found.share > 0.6, "{}", found.share);
        assert!((found.limit.value - 0.8).abs() < 1e-6, "{:?}", found.limit);
    }

    /// A loop whose reference jumps twice a second asks for twice what the drive gives.
    #[test]
    fn a_command_that_does_not_arrive_is_cut_to_what_does() {
        let (dt, most) = (1e-4, 3.0);
        let (mut x, mut v, mut stop) = (0.0, 0.0, 0.0_f64);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..200_000 {
            let t = f64::from(i) * dt;
            let jumps = if (2.0 * t).fract() < 0.5 { 5e-4 } else { -5e-4 };
            let reference = 0.02 * (TAU * 0.31 * t).sin() + jumps;
            let asked = 6000.0 * (reference - x) - 80.0 * v;
            if i % 10 == 0 {
                let _ = writeln!(text, "{t:.3},{x:.8e},{asked:.6}");
            }
            stop = (stop + dt * v).clamp(-2e-5, 2e-5);
            v += dt / 2.0 * (f64::clamp(asked, -most, most) - 5.0 * v - 5e4 * stop);
            x += dt * v;
        }
        let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
        let recording = recording.expect("valid");
        let found = found(&recording).expect("an end");
        println!("{:?} {} {:?}", found.limit, found.share, found.leaves);
        assert_eq!(found.of, End::Command);
        assert!((found.limit.value / most - 1.0).abs() < 0.03);
        let arrived = found.arrived(&recording).expect("a command");
        assert!(arrived.effort.iter().all(|f| f.abs() <= found.limit.value));
    }

    #[test]
    fn neither_friction_nor_outliers_are_an_end() {
        assert!(found(&moved(|_, _, f| f)).is_none(), "nothing is cut");
        let spike = |t: f64| ((t * 1e3).round() as u64).is_multiple_of(997);
        let spiked = moved(|t, _, f| if spike(t) { 9.0 } else { f });
        assert!(found(&spiked).is_none(), "outliers");
        let slow = moved(|_, a, f| f - 2.0 * a);
        assert!(found(&slow).is_none(), "a level of friction");
    }

    /// The drive is at its limit two thirds of the time, and the force acts.
    #[test]
    fn a_command_that_acts_at_its_limit_is_no_end_of_the_reading() {
        let (dt, most) = (1e-4, 3.0);
        let (mut x, mut v, mut stop, mut force, mut at) = (0.0, 0.0, 0.0_f64, 0.0, 0);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..200_000 {
            let t = f64::from(i) * dt;
            if i % 10 == 0 {
                let reference =
                    0.02 * (TAU * 0.9 * t).sin().signum() + 0.01 * (TAU * 2.3 * t).sin().signum();
                force = f64::clamp(6000.0 * (reference - x) - 120.0 * v, -most, most);
                at += i32::from(force.abs() >= most);
                let _ = writeln!(text, "{t:.3},{x:.8e},{force:.6}");
            }
            stop = (stop + dt * v).clamp(-2e-5, 2e-5);
            v += dt / 2.0 * (force - 5.0 * v - 5e4 * stop);
            x += dt * v;
        }
        println!("{at} of 20000 at the limit");
        assert!(at > 12_000, "{at}");
        let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
        let recording = recording.expect("valid");
        assert!(found(&recording).is_none());
        // Whether it acts is for the user to say, where the motion cannot.
        let asked = stands_mostly(&recording).expect("more than half");
        assert!(asked.contains("range of the reading"), "{asked}");
    }
}
