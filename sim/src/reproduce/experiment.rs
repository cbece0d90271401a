//! The paper's experiment, simulated: force ramps in steps with holds, repeated, averaged, identified; which number of
//! blocks the repeats can support.

use super::SIZES;
use super::search::Search;
use crate::normal::normal;
use preslide_fit::friction::{FrictionModel, Path};
use preslide_fit::identify::regression::MaxwellSlipFit;
use preslide_fit::progress::Progress;
use preslide_fit::simulate::inverse::inverse;
use preslide_fit::statistics::nmse;
use preslide_host::paper;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

/// Seed of the repeats; the bootstrap's is one more.
pub const SEED: u64 = 20_170_101;
/// "more than 50 experiments are hence performed".
pub const REPEATS: usize = 60;
/// "a dispersion of up to ±15 %": every block's force and yield displacement vary by so much, uniformly and each for
/// itself, from repeat to repeat.
pub const VARIABILITY: f64 = 0.15;
/// Loads \[N\] between which the force is stepped by [`paper::LOAD_RESOLUTION`]: up, an inner loop, and on.
const TURNS: [f64; 3] = [0.5, 0.2, 0.88];
/// Standard deviation of a displacement reading \[m\]: an interferometer on a table that is damped, not perfect.
const READING: f64 = 5e-9;
/// Best subsets of the grid that are refined: scatter hides what more would gain.
const REFINED: usize = 2;
/// Resamples of a bootstrap.
const RESAMPLES: usize = 1000;

/// A mean and its 95 % interval.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Mean.
    pub mean: f64,
    /// Lower and upper end.
    pub ci95: [f64; 2],
}

/// Displacement \[m\] and force \[N\] at the end of every hold.
#[derive(Clone, Debug, Default)]
pub struct Ramp {
    /// Displacement \[m\], as read.
    pub position: Vec<f64>,
    /// Load \[N\], as read: whole steps.
    pub force: Vec<f64>,
}

/// What one number of blocks does with the repeats.
#[derive(Clone, Debug)]
pub struct Size {
    /// `N`.
    pub n: usize,
    /// Repeats from which `N` blocks of positive stiffness could be identified.
    pub identified: usize,
    /// Spread over the repeats, standard deviation over mean (-), of each block's stiffness.
    pub stiffness_spread: Vec<f64>,
    /// The same of the yield displacements.
    pub yield_spread: Vec<f64>,
    /// Stiffnesses (N/m) and yields \[m\] from the average curve.
    pub of_average: MaxwellSlipFit,
    /// NMSE (%) on the average curve.
    pub nmse_average: f64,
    /// NMSE (%) of each repeat's own parameters on itself.
    pub nmse_own: Interval,
    /// NMSE (%) on repeats of parameters from the average of other repeats.
    pub nmse_others: Interval,
    /// How much worse that is than with the best number of blocks, repeat by repeat (%).
    pub loss: Interval,
}

/// The experiment and what follows from it.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Seed.
    pub seed: u64,
    /// The repeats.
    pub repeats: Vec<Ramp>,
    /// Mean displacement at each load that every repeat held.
    pub average: Ramp,
    /// Largest deviation of a repeat's displacement from the average at the same load (-), on the virgin curve from
    /// a fifth of breakaway on.
    pub dispersion: f64,
    /// By number of blocks.
    pub sizes: Vec<Size>,
}

/// NMSE (%) of each repeat under parameters from the average of the other half of the repeats, by number of blocks; NaN where
/// that average has no fit.
fn predicted_by_others(repeats: &[Ramp]) -> Result<Vec<Vec<f64>>, String> {
    let half = |odd: usize| -> Result<Vec<Option<MaxwellSlipFit>>, String> {
        let ramps: Vec<&Ramp> = repeats.iter().skip(odd).step_by(2).collect();
        averaged(&ramps).fits()
    };
    // Each half predicts the other.
    let halves = [half(1)?, half(0)?];
    let errors = (0..SIZES.len()).map(|j| {
        let errors = repeats.iter().enumerate().map(|(i, repeat)| {
            let fit = halves[i % 2].get(j).and_then(Option::as_ref);
            fit.map_or(Ok(f64::NAN), |fit| repeat.error(fit))
        });
        errors.collect()
    });
    errors.collect()
}

/// The errors of the number of blocks whose mean is the least.
fn least(others: &[Vec<f64>]) -> Option<&Vec<f64>> {
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    others
        .iter()
        .filter(|errors| mean(errors).is_finite())
        .min_by(|a, b| mean(a).total_cmp(&mean(b)))
}

impl Experiment {
    /// Simulates and identifies.
    ///
    /// # Errors
    /// A parameter that the library refuses, or a size that fits no average.
    pub fn run(seed: u64, repeats: usize, progress: &Progress) -> Result<Self, String> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let repeats = (0..repeats)
            .map(|_| ramp(&mut random))
            .collect::<Result<Vec<_>, String>>()?;
        let all: Vec<&Ramp> = repeats.iter().collect();
        let average = averaged(&all);
        let own: Vec<Vec<Option<MaxwellSlipFit>>> = repeats
            .par_iter()
            .map(|repeat| {
                let fits = repeat.fits();
                progress.inc(1);
                fits
            })
            .collect::<Result<_, String>>()?;
        let of_average = average.fits()?;
        let others = predicted_by_others(&repeats)?;
        progress.inc(1);
        let best = least(&others).ok_or("no number of blocks fits the average of the repeats")?;
        let mut sizes = Vec::new();
        for ((j, n), of_average) in SIZES.enumerate().zip(of_average) {
            let Some(of_average) = of_average else {
                continue;
            };
            let fits: Vec<(usize, &MaxwellSlipFit)> = own
                .iter()
                .enumerate()
                .filter_map(|(i, fits)| Some((i, fits.get(j)?.as_ref()?)))
                .collect();
            let errors = fits
                .iter()
                .map(|(i, fit)| repeats[*i].error(fit))
                .collect::<Result<Vec<f64>, String>>()?;
            let loss: Vec<f64> = others[j].iter().zip(best).map(|(a, b)| a - b).collect();
            sizes.push(Size {
                n,
                identified: fits.len(),
                stiffness_spread: spreads(n, &fits, |fit| &fit.stiffness),
                yield_spread: spreads(n, &fits, |fit| &fit.yields),
                nmse_average: average.error(&of_average)?,
                of_average,
                nmse_own: interval(&errors, seed + 1),
                nmse_others: interval(&others[j], seed + 1),
                loss: interval(&loss, seed + 1),
            });
        }
        Ok(Self {
            seed,
            dispersion: dispersion(&repeats, &average),
            repeats,
            average,
            sizes,
        })
    }

    /// NMSE (%) by which a repeat differs from what the average predicts with the best number of blocks: the spread
    /// that no number of blocks can remove.
    pub fn spread(&self) -> Option<Interval> {
        self.sizes
            .iter()
            .map(|size| size.nmse_others)
            .min_by(|a, b| a.mean.total_cmp(&b.mean))
    }

    /// The fewest blocks whose error on the average lies below the repeats' spread (its lower end).
    pub fn within_spread(&self) -> Option<usize> {
        let spread = self.spread()?;
        self.first(|size| size.nmse_average < spread.ci95[0])
    }

    /// The fewest blocks whose error on the average lies below the average's own uncertainty, the spread over the
    /// number of repeats.
    pub fn within_average(&self) -> Option<usize> {
        let spread = self.spread()?;
        self.first(|size| size.nmse_average < spread.ci95[0] / self.repeats.len() as f64)
    }

    /// The fewest blocks that predict other repeats no worse than any number, within the interval.
    pub fn no_gain_beyond(&self) -> Option<usize> {
        self.first(|size| size.loss.ci95[0] <= 0.0)
    }

    fn first(&self, holds: impl Fn(&Size) -> bool) -> Option<usize> {
        self.sizes.iter().find(|size| holds(size)).map(|s| s.n)
    }
}

impl Ramp {
    fn fits(&self) -> Result<Vec<Option<MaxwellSlipFit>>, String> {
        let piece = 0..self.position.len();
        let pieces = std::slice::from_ref(&piece);
        let search = Search::new(&self.position, pieces, &self.force)?;
        Ok(SIZES.map(|n| search.best(n, REFINED)).collect())
    }

    /// NMSE (%) of blocks on this ramp.
    fn error(&self, fit: &MaxwellSlipFit) -> Result<f64, String> {
        let piece: Range<usize> = 0..self.position.len();
        let force = FrictionModel::maxwell_slip(&fit.stiffness, &fit.yields)
            .force(Path {
                position: &self.position,
                velocity: &vec![0.0; self.position.len()],
                pieces: std::slice::from_ref(&piece),
                sample_time: 1.0,
            })
            .map_err(|e| e.to_string())?;
        let rows: Vec<usize> = piece.collect();
        Ok(nmse(&self.force, &force, &rows))
    }
}

/// The loads at the end of each hold.
fn loads() -> Vec<f64> {
    let mut loads = vec![0.0];
    let mut at = 0_i64;
    for turn in TURNS {
        let to = (turn / paper::LOAD_RESOLUTION).round() as i64;
        while at != to {
            at += (to - at).signum();
            loads.push(at as f64 * paper::LOAD_RESOLUTION);
        }
    }
    loads
}

/// One repeat: the ten blocks as they are today, loaded step by step up to where they break away. The model does not
/// creep, so a hold ends where the step does.
fn ramp(random: &mut ChaCha8Rng) -> Result<Ramp, String> {
    let mut vary = || 1.0 + random.random_range(-VARIABILITY..VARIABILITY);
    let (stiffness, yields): (Vec<f64>, Vec<f64>) = paper::REFERENCE
        .stiffness()
        .into_iter()
        .zip(paper::REFERENCE.yields())
        .map(|(k, d)| {
            let (force, displacement) = (vary(), vary());
            (k * force / displacement, d * displacement)
        })
        .unzip();
    let today = FrictionModel::maxwell_slip(&stiffness, &yields);
    let mut axis = inverse(&today, 1.0).map_err(|e| e.to_string())?;
    let mut at = 0.0;
    let mut ramp = Ramp::default();
    for load in loads() {
        // The load cell resolves a step: the true force lies within half of it.
        let half = 0.5 * paper::LOAD_RESOLUTION;
        let force = if load == 0.0 {
            0.0
        } else {
            load + random.random_range(-half..half)
        };
        let Ok(moved) = axis.advance(force) else {
            break;
        };
        at += moved;
        ramp.position.push(at + READING * normal(random));
        ramp.force.push(load);
    }
    Ok(ramp)
}

/// Mean displacement at each hold that all have.
fn averaged(ramps: &[&Ramp]) -> Ramp {
    let holds = ramps.iter().map(|r| r.position.len()).min().unwrap_or(0);
    let mean = |k: usize| ramps.iter().map(|r| r.position[k]).sum::<f64>() / ramps.len() as f64;
    Ramp {
        position: (0..holds).map(mean).collect(),
        force: ramps
            .first()
            .map(|r| r.force[..holds].to_vec())
            .unwrap_or_default(),
    }
}

fn dispersion(repeats: &[Ramp], average: &Ramp) -> f64 {
    let virgin = average
        .force
        .windows(2)
        .take_while(|pair| pair[1] > pair[0]);
    let virgin = 1 + virgin.count();
    let holds = (0..virgin).filter(|&k| average.force[k] >= 0.2 * paper::BREAKAWAY);
    holds
        .flat_map(|k| {
            let mean = average.position[k];
            repeats
                .iter()
                .filter_map(move |r| Some((r.position.get(k)? / mean - 1.0).abs()))
        })
        .fold(0.0, f64::max)
}

/// Standard deviation over mean of each block's parameter.
fn spreads(
    n: usize,
    fits: &[(usize, &MaxwellSlipFit)],
    of: impl Fn(&MaxwellSlipFit) -> &Vec<f64>,
) -> Vec<f64> {
    (0..n)
        .map(|block| {
            let values: Vec<f64> = fits.iter().map(|(_, fit)| of(fit)[block]).collect();
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            (squares / (count - 1.0)).sqrt() / mean
        })
        .collect()
}

/// Mean and percentile bootstrap over the repeats.
fn interval(values: &[f64], seed: u64) -> Interval {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn = (0..count).map(|_| values[random.random_range(0..count)]);
            drawn.sum::<f64>() / count as f64
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let at = |share: f64| means[(share * (RESAMPLES - 1) as f64).round() as usize];
    Interval {
        mean,
        ci95: if count == 0 {
            [f64::NAN; 2]
        } else {
            [at(0.025), at(0.975)]
        },
    }
}
