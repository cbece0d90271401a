//! A force from outside at a frequency of its own, as of a pump or a neighbouring axis. Where it moves the axis, inertia, viscous friction and a
//! delay that are fitted without it answer for it.

use super::rigid::{BLOCKS, Rigid, blocks, every};
use super::spectra::{self, HARMONICS, MOTION};
use super::{Kinematics, ZeroPhase};
use crate::evidence::evidence;
use crate::recording::Recording;
use crate::report::figures::three;
use crate::statistics::{Estimate, LeastSquares, bounds, jackknife};
use serde::Serialize;
use std::f64::consts::TAU;
use std::ops::Range;

/// Lines that are looked for, one after the other.
const MOST: usize = 3;
/// Share that a line must take of what rigid body and hysteresis leave, and standard errors of that: a smaller one moves no parameter by much.
const TAKES: f64 = 0.2;
const SURE: f64 = 4.0;
/// Parts of the recording in each of which the line must be as large as in the whole, within these: a harmonic of what the motion does for a while is
/// there for a while.
const PARTS: usize = 8;
const STEADY: [f64; 2] = [0.6, 1.4];
/// Share of the position's squares from which a line is the motion's own: what shakes an axis moves it by little of its travel.
const OF_THE_MOTION: f64 = 0.01;
/// Share of the rate of the fitted samples below which a line is looked for: a faster one would have an alias.
const RESOLVED: f64 = 0.4;
/// Steps of the search between two bins of the spectrum.
const STEPS: usize = 10;

/// A line of the effort that is not the motion's.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Vibration {
    /// Its frequency (Hz).
    pub frequency_hz: f64,
    /// Its amplitude (N or N·m).
    pub force: Estimate,
    /// Whether the band of the motion ends below it, so that neither inertia nor friction answers to it.
    pub is_above: bool,
    /// Of its cosine and sine of the time of the samples (N or N·m).
    of_waves: [f64; 2],
}

impl Vibration {
    /// Those of an effort, strongest first, beside rigid body and hysteresis.
    pub(super) fn all(effort: &[f64], rigid: &Rigid) -> Vec<Self> {
        let most_hz = RESOLVED / rigid.step_s();
        let slower = (rigid.kinematics.filter.cutoff_hz() > most_hz)
            .then(|| Kinematics::below(rigid.recording, most_hz));
        let slower = slower.as_ref().map(|slower| rigid.within(slower));
        let rigid = slower.as_ref().unwrap_or(rigid);
        let filter = &rigid.kinematics.filter;
        let target = rigid.fitted(&filter.smooth(effort));
        let t = rigid.fitted(&rigid.recording.t_s);
        let position = rigid.fitted(&rigid.recording.position);
        let mut beside = rigid.at(&rigid.rows);
        // A spring is not a vibration.
        beside.push(position.clone());
        let band = spectra::band(&t, filter.cutoff_hz());
        let mut found = Self::strongest(&t, [&target, &position], beside, band);
        found.extend(Self::above(rigid.recording, effort, filter));
        found
    }

    /// Those above the band of the motion, in what the filter takes off an effort: there, no acceleration is known.
    pub(crate) fn above(recording: &Recording, effort: &[f64], filter: &ZeroPhase) -> Vec<Self> {
        let every = every(recording);
        let most_hz = RESOLVED / (every as f64 * recording.sample_time_s());
        let smooth = filter.smooth(effort);
        let rows = (0..recording.len()).step_by(every);
        let fitted = |of: &dyn Fn(usize) -> f64| rows.clone().map(of).collect::<Vec<f64>>();
        let t = fitted(&|i| recording.t_s[i]);
        let position = fitted(&|i| recording.position[i]);
        let left = fitted(&|i| effort[i] - smooth[i]);
        let from = spectra::band(&t, most_hz).0.max(filter.cutoff_hz());
        let beside = vec![vec![1.0; t.len()]];
        let mut found = Self::strongest(&t, [&left, &position], beside, (from, most_hz));
        for line in &mut found {
            let passes = 1.0 - filter.keeps(line.frequency_hz);
            line.is_above = true;
            line.force = line.force.times(1.0 / passes);
            line.of_waves = line.of_waves.map(|c| c / passes);
        }
        found
    }

    /// Those of a target within a band (Hz), strongest first, beside some columns.
    fn strongest(
        t: &[f64],
        [target, position]: [&[f64]; 2],
        mut beside: Vec<Vec<f64>>,
        band: (f64, f64),
    ) -> Vec<Self> {
        let mut found = Vec::new();
        while found.len() < MOST {
            let next = Line::strongest(t, target, &beside, band);
            let Some(next) = next.filter(|n| !is_of_the_motion(position, t, n.frequency_hz)) else {
                break;
            };
            beside.extend(waves(t, next.frequency_hz));
            found.push(next);
        }
        found
    }

    /// Its force at some times (s).
    pub fn at(&self, t: &[f64]) -> Vec<f64> {
        sum(&waves(t, self.frequency_hz), self.of_waves)
    }

    /// Its phase (rad), of a cosine that begins at the time `from` (s).
    pub fn phase(&self, from: f64) -> f64 {
        let [cos, sin] = self.of_waves;
        let phase = TAU * self.frequency_hz * from - sin.atan2(cos);
        phase.sin().atan2(phase.cos())
    }

    /// Takes it off an effort.
    pub(super) fn take_off(&self, recording: &mut Recording) {
        let own = self.at(&recording.t_s);
        let effort = recording.effort.iter_mut();
        effort.zip(own).for_each(|(effort, own)| *effort -= own);
    }

    /// In words, a sentence without its full stop.
    pub fn words(&self, unit: &str) -> String {
        format!(
            "something shakes the axis at {} Hz with {} {unit}: it is taken off the effort, and the fit is of the axis without it",
            three(self.frequency_hz),
            three(self.force.value)
        )
    }
}

/// Cosine and sine of a frequency.
fn waves(t: &[f64], hz: f64) -> [Vec<f64>; 2] {
    let (cos, sin) = t
        .iter()
        .map(|t| (TAU * hz * t).sin_cos())
        .map(|(s, c)| (c, s))
        .unzip();
    [cos, sin]
}

/// Both waves, so many times each.
fn sum([cos, sin]: &[Vec<f64>; 2], [a, b]: [f64; 2]) -> Vec<f64> {
    cos.iter().zip(sin).map(|(c, s)| a * c + b * s).collect()
}

/// Whether the position has a line there, or one of which it is a harmonic: friction that turns round with it has them all.
fn is_of_the_motion(position: &[f64], t: &[f64], hz: f64) -> bool {
    let share = |order: u32| share_of(position, t, hz / f64::from(order));
    share(1) > OF_THE_MOTION || (2..=HARMONICS).any(|order| share(order) > MOTION)
}

/// Share of the squares of `values`, about their mean, that lie in one line.
fn share_of(values: &[f64], t: &[f64], hz: f64) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let about: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let waves = waves(t, hz);
    let columns: Vec<&[f64]> = waves.iter().map(Vec::as_slice).collect();
    let square: f64 = about.iter().map(|v| v * v).sum();
    LeastSquares::of(&columns).map_or(0.0, |line| {
        1.0 - line.squares_left(&about) / square.max(1e-300)
    })
}

/// Two waves without what the motion has of them, and what the motion leaves of the effort.
struct Line<'a> {
    waves: [Vec<f64>; 2],
    left: &'a [f64],
}

impl<'a> Line<'a> {
    fn of(t: &[f64], motion: &LeastSquares, left: &'a [f64], hz: f64) -> Self {
        Self {
            waves: waves(t, hz).map(|wave| motion.left(&wave)),
            left,
        }
    }

    /// Coefficients of both waves on the samples that count.
    fn coefficients(&self, counts: impl Fn(usize) -> bool) -> Option<[f64; 2]> {
        let [c, s] = &self.waves;
        let (mut cc, mut cs, mut ss, mut cr, mut sr) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in (0..c.len()).filter(|i| counts(*i)) {
            cc += c[i] * c[i];
            cs += c[i] * s[i];
            ss += s[i] * s[i];
            cr += c[i] * self.left[i];
            sr += s[i] * self.left[i];
        }
        let determinant = cc * ss - cs * cs;
        (determinant > 0.0).then(|| {
            [
                (cr * ss - sr * cs) / determinant,
                (sr * cc - cr * cs) / determinant,
            ]
        })
    }

    /// Squares that it takes off.
    fn taken(&self) -> f64 {
        let own = self.coefficients(|_| true).map(|own| sum(&self.waves, own));
        own.map_or(0.0, |own| {
            own.iter().zip(self.left).map(|(f, r)| f * r).sum()
        })
    }

    /// The strongest line within a band (Hz) beside the columns of a motion, where it is one.
    fn strongest(
        t: &[f64],
        target: &[f64],
        beside: &[Vec<f64>],
        (from, to): (f64, f64),
    ) -> Option<Vibration> {
        let columns: Vec<&[f64]> = beside.iter().map(Vec::as_slice).collect();
        let motion = LeastSquares::of(&columns)?;
        let left = motion.left(target);
        let squares: f64 = left.iter().map(|r| r * r).sum();
        let (begin, end) = bounds(t);
        let bin = 1.0 / (end - begin);
        let at = |hz: f64| Line::of(t, &motion, &left, hz);
        let (mut hz, mut taken) = spectra::lines(t, &left, from, to)
            .into_iter()
            .map(|hz| (hz, at(hz).taken()))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        if taken < 0.5 * TAKES * squares {
            return None;
        }
        let mut step = 0.25 * bin;
        for _ in 0..STEPS {
            let beside = [hz - step, hz + step].map(|hz| (hz, at(hz).taken()));
            match beside.into_iter().find(|b| b.1 > taken) {
                Some(better) => (hz, taken) = better,
                None => step *= 0.5,
            }
        }
        let line = at(hz);
        let own = line.coefficients(|_| true)?;
        (line.is_sure() && line.is_steady(own)).then_some(())?;
        (!spectra::keeps_step(t, &sum(&waves(t, hz), own), target, hz)).then_some(())?;
        let amplitude = |[a, b]: [f64; 2]| a.hypot(b);
        let without =
            |block: Range<usize>| line.coefficients(|i| !block.contains(&i)).map(amplitude);
        let error = jackknife(&blocks(t.len()).filter_map(without).collect::<Vec<f64>>());
        Some(Vibration {
            frequency_hz: hz,
            force: Estimate::new(amplitude(own), Some(error), BLOCKS),
            is_above: false,
            of_waves: own,
        })
    }

    /// Whether its coefficients from elsewhere take enough off each block.
    fn is_sure(&self) -> bool {
        let own: Vec<Range<usize>> = blocks(self.left.len()).collect();
        let mut force = vec![0.0; self.left.len()];
        for block in &own {
            let Some(elsewhere) = self.coefficients(|i| !block.contains(&i)) else {
                return false;
            };
            force[block.clone()].copy_from_slice(&sum(&self.waves, elsewhere)[block.clone()]);
        }
        let found = evidence(&force, self.left, &own);
        found.share >= TAKES && found.z >= SURE
    }

    /// Whether all parts of the recording but one have as much of it as the whole.
    fn is_steady(&self, own: [f64; 2]) -> bool {
        let force = sum(&self.waves, own);
        let n = force.len();
        let is_as_large = |k: &usize| {
            let part = k * n / PARTS..(k + 1) * n / PARTS;
            let of = |other: &[f64]| -> f64 { part.clone().map(|i| force[i] * other[i]).sum() };
            let slope = of(self.left) / of(&force);
            (STEADY[0]..STEADY[1]).contains(&slope)
        };
        (0..PARTS).filter(is_as_large).count() + 1 >= PARTS
    }
}
