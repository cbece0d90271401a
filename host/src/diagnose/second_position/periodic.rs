//! `periodic_lead_error`: the part of a difference that is periodic over the travel, as a screw, its balls or the mesh of a gear make it.
//!
//! The period is looked for in what all else leaves, and anew for each group of samples that is held out: groups of passes, and
//! stretches of the travel. A stretch is fitted by all else again and keeps only the sine of the others, since a curve over the travel
//! says nothing of a stretch that it has not seen. What repeats in passes and is no sine fails on stretches; what is there in one
//! part of the time fails on passes.

use super::FEWEST;
use super::held_out::{Sums, Taken};
use super::samples::{BESIDE, COLUMNS, Samples};
use nalgebra::DVector;
use preslide_fit::signal::spectra;
use preslide_fit::statistics::{Estimate, jackknife};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Stretches of the travel that are held out in turn.
const STRETCHES: usize = 8;
/// Degrees of the curve that a stretch is fitted with again: over an eighth of the travel a cubic follows what the eighth does over all.
const BEND: usize = 3;
/// Fewest periods over the travel: two a stretch; the smooth curve and its cubics bend less often.
const FEWEST_PERIODS: f64 = 16.0;
/// Most periods over the travel: of the 2¹⁸ bins that a spectrum may have, three times the travel takes nearly all at a quarter of such a period.
const MOST_PERIODS: f64 = 20_000.0;
/// Parts of the travel of which each counts once where a period is looked for: a quarter of the shortest period. An axis that stands at
/// the ends for half of the time would else be one sample of great weight, in which every frequency is.
const PARTS: f64 = 4.0 * MOST_PERIODS;
/// Counts in the shortest period: counting takes a sixtieth of the amplitude of a sine of ten, and makes sines itself of one.
const COUNTS: f64 = 10.0;
/// Share of a comb's frequency from which a sine looks like a longer one on places that a scan in steps stopped at.
const ALIAS: f64 = 0.5;
/// Steps to the frequency of least squares from that of the spectrum, which is a tenth of its resolution away; the error of each is
/// the square of the one before.
const STEPS: usize = 2;
/// Sines that are reported: a turn, a part of it, and a passage of balls or teeth.
const SINES: usize = 3;
/// Places within a period at which its mean is taken.
const PLACES: usize = 24;

/// A difference that is periodic over the travel.
pub struct Periodic {
    /// Its period (m or rad).
    pub period: Estimate,
    /// How far it goes to either side (m or rad).
    pub amplitude: Estimate,
    /// Where it is highest, next to the middle of the travel (m or rad).
    pub highest_at: f64,
    /// What it takes of what all else leaves, on passes held out …
    pub passes: Taken,
    /// … and on stretches of the travel held out.
    pub stretches: Taken,
    /// Position from the last multiple of the period (m or rad), and the mean of what all else leaves there (m or rad).
    pub folded: Vec<[f64; 2]>,
}

impl Periodic {
    /// The sine at a position (m or rad).
    pub fn at(&self, position: f64) -> f64 {
        self.amplitude.value * (TAU * (position - self.highest_at) / self.period.value).cos()
    }
}

/// What of the difference is periodic, which is then taken out of it. `finest` is a count of the coarser position (m or rad).
pub fn take_out(samples: &mut Samples, groups: usize, finest: f64) -> Vec<Periodic> {
    let band = band(samples, finest);
    let mut found = Vec::new();
    while found.len() < SINES
        && let Some((sine, periodic)) = next(samples, band, groups)
    {
        let places = samples.difference.iter_mut().zip(&samples.place);
        places.for_each(|(d, place)| *d -= sine.at(*place));
        found.push(periodic);
    }
    found
}

/// The fewest and the most periods over the travel that are looked for.
fn band(samples: &Samples, finest: f64) -> [f64; 2] {
    let most = MOST_PERIODS.min(samples.travel / (COUNTS * finest));
    let every = (0..samples.place.len()).map(|i| (samples.place[i], 0.0));
    let comb = spectra::comb(&once_a_part(every).0, FEWEST_PERIODS, most);
    [FEWEST_PERIODS, comb.map_or(most, |teeth| ALIAS * teeth)]
}

/// The strongest sine, where passes and stretches that are held out say that it is one.
fn next(samples: &Samples, band: [f64; 2], groups: usize) -> Option<(Sine, Periodic)> {
    let passes = samples.pass.iter().map(|pass| pass % groups);
    let passes = Tried::of(samples, band, &passes.collect::<Vec<_>>(), COLUMNS)?;
    if !passes.taken.is_stated() {
        return None;
    }
    let stretch = |place: &f64| ((place * STRETCHES as f64) as usize).min(STRETCHES - 1);
    let stretches: Vec<usize> = samples.place.iter().map(stretch).collect();
    let stretches = Tried::of(samples, band, &stretches, BESIDE + BEND)?;
    if !stretches.taken.is_stated() {
        return None;
    }
    let sine = Sine::of(samples, band, &|_| true)?;
    let estimate = |of: &dyn Fn(&Sine) -> f64| {
        let of_split = |split: &Tried| {
            let others: Vec<f64> = split.sines.iter().map(of).collect();
            Estimate::new(of(&sine), Some(jackknife(&others)), others.len())
        };
        wider(of_split(&passes), of_split(&stretches))
    };
    let period = estimate(&|s| samples.travel / s.frequency);
    let periodic = Periodic {
        period,
        amplitude: estimate(&|s| samples.travel * s.amplitude()),
        highest_at: samples.low + samples.travel * sine.highest_at(),
        passes: passes.taken,
        stretches: stretches.taken,
        folded: sine.folded(samples, period.value),
    };
    Some((sine, periodic))
}

/// The one with the wider interval: what differs between passes and what differs along the travel are both of an estimate's error.
fn wider(a: Estimate, b: Estimate) -> Estimate {
    let reach = |e: &Estimate| e.reach().unwrap_or(f64::INFINITY);
    if reach(&a) < reach(&b) { b } else { a }
}

/// The sines of all samples but each group of them, and what they take on it.
struct Tried {
    sines: Vec<Sine>,
    taken: Taken,
}

impl Tried {
    /// `refitted`: how many of the columns the group itself is fitted with.
    fn of(samples: &Samples, band: [f64; 2], group: &[usize], refitted: usize) -> Option<Self> {
        let mut groups = group.to_vec();
        groups.sort_unstable();
        groups.dedup();
        if groups.len() < FEWEST {
            return None;
        }
        let refitted: Vec<usize> = (0..refitted).collect();
        let without = |&held_out: &usize| {
            let sine = Sine::of(samples, band, &|i| group[i] != held_out)?;
            let own = sums(samples, sine.frequency, &|i| group[i] == held_out);
            let less = own.less(&sine.alone());
            let left = |s: &Sums| Some(s.left(&Sums::solve(&[s], &refitted)?) / s.count);
            Some((sine, [left(&own)?, left(&less)?]))
        };
        let all: Option<Vec<_>> = groups.par_iter().map(without).collect();
        let (sines, left): (_, Vec<[f64; 2]>) = all?.into_iter().unzip();
        let [before, after] = [0, 1].map(|k| left.iter().map(|l| l[k]).collect::<Vec<_>>());
        Some(Self {
            sines,
            taken: Taken::of(&before, &after),
        })
    }
}

/// A sine over the place, 0 to 1, and what is fitted beside it; by the travel.
struct Sine {
    /// Periods over the travel.
    frequency: f64,
    /// Coefficients of the columns of [`sums`]; those that move the frequency are zero.
    coefficients: DVector<f64>,
}

impl Sine {
    /// The strongest between two frequencies on the samples that are `taken`.
    fn of(samples: &Samples, band: [f64; 2], taken: &dyn Fn(usize) -> bool) -> Option<Self> {
        let mut frequency = strongest(samples, band, taken)?;
        let every: Vec<usize> = (0..COLUMNS + WAVE).collect();
        for _ in 0..STEPS {
            let c = Sums::solve(&[&sums(samples, frequency, taken)], &every)?;
            let [cosine, sine, by_cosine, by_sine] = [0, 1, 2, 3].map(|k| c[COLUMNS + k]);
            let step = (by_cosine * sine - by_sine * cosine) / (TAU * cosine.hypot(sine).powi(2));
            // No further than to the next line of the spectrum.
            frequency += if step.is_finite() {
                step.clamp(-0.5, 0.5)
            } else {
                0.0
            };
        }
        let still: Vec<usize> = (0..COLUMNS + 2).collect();
        Some(Self {
            frequency,
            coefficients: Sums::solve(&[&sums(samples, frequency, taken)], &still)?,
        })
    }

    fn cosine_and_sine(&self) -> [f64; 2] {
        [0, 1].map(|k| self.coefficients[COLUMNS + k])
    }

    fn amplitude(&self) -> f64 {
        let [cosine, sine] = self.cosine_and_sine();
        cosine.hypot(sine)
    }

    /// The place next to the middle at which it is highest.
    fn highest_at(&self) -> f64 {
        let [cosine, sine] = self.cosine_and_sine();
        0.5 + sine.atan2(cosine) / (TAU * self.frequency)
    }

    fn at(&self, place: f64) -> f64 {
        self.amplitude() * (TAU * self.frequency * (place - self.highest_at())).cos()
    }

    /// Its own coefficients without those of what is beside it.
    fn alone(&self) -> DVector<f64> {
        let mut alone = self.coefficients.clone();
        alone.rows_mut(0, COLUMNS).fill(0.0);
        alone
    }

    /// See [`Periodic::folded`].
    fn folded(&self, samples: &Samples, period: f64) -> Vec<[f64; 2]> {
        let mut sums = [[0.0; 2]; PLACES];
        for (i, place) in samples.place.iter().enumerate() {
            let turned = (samples.low + samples.travel * place) / period;
            let within = (turned.rem_euclid(1.0) * PLACES as f64) as usize;
            let sum = &mut sums[within.min(PLACES - 1)];
            let left = left_beside(samples, i, &self.coefficients);
            *sum = [sum[0] + samples.travel * left, sum[1] + 1.0];
        }
        let at = |k: usize| period * (k as f64 + 0.5) / PLACES as f64;
        let means = sums.iter().enumerate().filter(|(_, s)| s[1] > 0.0);
        means.map(|(k, s)| [at(k), s[0] / s[1]]).collect()
    }
}

/// Columns of a sine: cosine and sine about the middle of the travel, and what moves their frequency: both times the place.
const WAVE: usize = 4;

fn wave(frequency: f64, place: f64) -> [f64; WAVE] {
    let from_middle = place - 0.5;
    let (sine, cosine) = (TAU * frequency * from_middle).sin_cos();
    [cosine, sine, from_middle * cosine, from_middle * sine]
}

/// Sums of the samples that are `taken` over all columns and a sine's.
fn sums(samples: &Samples, frequency: f64, taken: &dyn Fn(usize) -> bool) -> Sums {
    let mut sums = Sums::new(COLUMNS + WAVE);
    let mut columns = [0.0; COLUMNS + WAVE];
    for i in (0..samples.place.len()).filter(|i| taken(*i)) {
        columns[..COLUMNS].copy_from_slice(&samples.columns[i]);
        columns[COLUMNS..].copy_from_slice(&wave(frequency, samples.place[i]));
        sums.add(&columns, samples.difference[i]);
    }
    sums
}

/// The frequency at which most is of what all else leaves.
fn strongest(samples: &Samples, band: [f64; 2], taken: &dyn Fn(usize) -> bool) -> Option<f64> {
    let kept: Vec<usize> = (0..samples.place.len()).filter(|i| taken(*i)).collect();
    let mut sums = Sums::new(COLUMNS);
    kept.iter()
        .for_each(|&i| sums.add(&samples.columns[i], samples.difference[i]));
    let c = Sums::solve(&[&sums], &(0..COLUMNS).collect::<Vec<_>>())?;
    let left = |&i: &usize| (samples.place[i], left_beside(samples, i, &c));
    let (place, left) = once_a_part(kept.iter().map(left));
    spectra::strongest(&place, &left, band[0], band[1])
}

/// The mean place and value of each of [`PARTS`] of the travel that has any.
fn once_a_part(of: impl Iterator<Item = (f64, f64)>) -> (Vec<f64>, Vec<f64>) {
    let mut sums = vec![[0.0; 3]; PARTS as usize + 1];
    for (place, value) in of {
        let sum = &mut sums[(place * PARTS) as usize];
        *sum = [sum[0] + place, sum[1] + value, sum[2] + 1.0];
    }
    let any = sums.into_iter().filter(|s| s[2] > 0.0);
    any.map(|[place, value, n]| (place / n, value / n)).unzip()
}

/// What the columns beside a sine leave of a sample's difference.
fn left_beside(samples: &Samples, i: usize, c: &DVector<f64>) -> f64 {
    let columns = samples.columns[i].iter().zip(c.iter());
    samples.difference[i] - columns.map(|(column, c)| column * c).sum::<f64>()
}
