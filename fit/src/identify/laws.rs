//! Other laws of friction beside the blocks, and what plain physics would be beside them.
//!
//! A number of blocks is a model's form and no law of nature. Where friction nears its level along a tail, forgets inner loops (Dahl), or follows
//! the speed alone (`tanh`), or falls with the speed (Stribeck), blocks leave an error that every stroke repeats, and so does a force that is periodic in
//! the position: no scatter of the folds shows it, and inertia, viscous friction and the level are bent by it to beyond their intervals. A mixture of
//! all these laws, none with a negative share, is free where blocks are not.
//! Nor does a log say at which moment between two samples its effort acts: the mixture has that free, too.

use super::evidence::{Evidence, FALLING, LAW, MATERIAL, Shown, WAVE, is_better};
use super::fit::{shown as name_shown, unit};
use super::regression::{Gram, Regressor, Surface};
use super::rigid_body::clustered;
use super::{Candidate, Identification};
use crate::recording::Recording;
use crate::report::figures::{left, quantity};
use crate::signal::{Kinematics, LATE, RELAXED, SMOOTH, bristle};
use crate::statistics::{Estimate, quantile_between_ranks, spread};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Relaxation lengths of bristles, from two of the shortest yields on: over four decades neighbours differ by a factor of four, between which two mix.
const LENGTHS: usize = 8;
/// Share of the error of the recommended blocks below which the mixture's is worth a word.
const WORTH_TELLING: f64 = 0.5;
/// Error (%) of the blocks below which it is not: what is left is nothing that anybody looks for.
const HARDLY_ANY: f64 = 0.05;

/// Shares of the usual top speed within which friction falls: as far down as it may be seen, and no further up than viscous friction hides it.
const FALLS: [f64; 5] = [0.01, 0.025, 0.06, 0.15, 0.35];
/// Steps between the relaxation lengths over which falling friction turns round: it is small beside what it falls to.
const TURNS: usize = 4;

/// Share of the way from a law's parameter to what a better law makes of it by which the truth may be further away: the better one is not exact, either.
const INEXACT: f64 = 0.1;

/// Name of the column that is the effort's change within a sample.
const SHIFT: &str = "shift";

/// A law that is linear in its level, which is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// `dz/dx = (1 − sgn(v)·z)ⁿ/d` (Dahl 1968) with n = 1 or 2 and the length `d` (m or rad).
    Bristles { squared: bool, length: f64 },
    /// `tanh(v/v₀)` with the speed `v₀` (m/s or rad/s).
    Smooth(f64),
    /// Dahl's bristles of a length (m or rad), times `exp(−(|v|/v_s)ⁿ)` with n = 1 or 2 and the speed `v_s` (m/s or rad/s).
    Falling {
        squared: bool,
        length: f64,
        within: f64,
    },
}

impl Law {
    /// Those that the rows `train` of a recording can show, beside blocks that yield from `shortest` (m or rad) on.
    pub(super) fn all(
        recording: &Recording,
        kinematics: &Kinematics,
        train: &[usize],
        shortest: f64,
    ) -> Vec<Self> {
        let (low, high) = recording.ends();
        let lengths = spread(2.0 * shortest, LATE * (high - low) / RELAXED, LENGTHS);
        let bristles = lengths
            .iter()
            .flat_map(|&length| [false, true].map(|squared| Self::Bristles { squared, length }));
        let speeds: Vec<f64> = train
            .iter()
            .map(|i| kinematics.velocity[*i].abs())
            .collect();
        let top = quantile_between_ranks(&speeds, 0.95);
        let falling = lengths.iter().step_by(TURNS).flat_map(|&length| {
            let of = move |squared| {
                FALLS.map(|share| Self::Falling {
                    squared,
                    length,
                    within: share * top,
                })
            };
            [false, true].into_iter().flat_map(of)
        });
        bristles
            .chain(SMOOTH.map(|share| Self::Smooth(share * top)))
            .chain(falling)
            .collect()
    }

    /// Name of its column.
    fn name(self) -> &'static str {
        match self {
            Self::Falling { .. } => FALLING,
            _ => LAW,
        }
    }

    /// What it reaches at speed, of a coefficient of one.
    fn level(self) -> f64 {
        match self {
            Self::Falling { .. } => 0.0,
            _ => 1.0,
        }
    }

    /// Its force at every sample.
    fn force(self, recording: &Recording, kinematics: &Kinematics) -> Vec<f64> {
        match self {
            Self::Smooth(speed) => {
                let velocity = kinematics.velocity.iter();
                velocity.map(|v| (v / speed).tanh()).collect()
            }
            Self::Bristles { squared, length } => {
                let z = bristle(&recording.position, &recording.pieces, length, squared);
                z.into_iter().map(|z| z / length).collect()
            }
            Self::Falling {
                squared,
                length,
                within,
            } => {
                let z = bristle(&recording.position, &recording.pieces, length, false);
                let power = if squared { 2 } else { 1 };
                let fallen = |v: &f64| (-(v.abs() / within).powi(power)).exp();
                let both = z.iter().zip(&kinematics.velocity);
                both.map(|(z, v)| z / length * fallen(v)).collect()
            }
        }
    }
}

/// Columns of `laws` for the mixture, filtered as the effort is where it contains inertia; then also what the effort would be a sample later, less
/// what it is.
pub(super) fn columns(
    laws: &[Law],
    recording: &Recording,
    kinematics: &Kinematics,
    effort: &[f64],
) -> Vec<Regressor> {
    let filter = &kinematics.filter;
    let inertial = recording.role.contains_inertia();
    let of_law = laws.par_iter().map(|law| {
        let raw = law.force(recording, kinematics);
        Regressor {
            name: law.name(),
            values: if inertial { filter.smooth(&raw) } else { raw },
        }
    });
    let mut columns: Vec<Regressor> = of_law.collect();
    if inertial {
        let by = recording.sample_time_s();
        let slope = filter.derivative(effort, 1);
        columns.push(Regressor {
            name: SHIFT,
            values: slope.iter().map(|slope| by * slope).collect(),
        });
    }
    columns
}

/// What a mixture of all laws makes of the plain physics.
#[derive(Clone, Debug)]
pub(super) struct Mixture {
    /// NMSE (%) on stretches that were held out in turn, without friction that falls.
    nmse_cross: f64,
    /// Plain physics and the level, as of a candidate.
    parameters: Parameters,
    /// The same beside friction that falls with the speed and a force that is periodic in the position, where they predict better.
    beside: Option<Beside>,
    /// Speed (m/s or rad/s) over which friction reverses, where most of it follows the speed alone.
    speed: Option<f64>,
}

/// Names with what was found.
pub(super) type Parameters = Vec<(&'static str, Estimate)>;

/// What plain physics is beside friction that falls with the speed and a periodic force.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    pub(super) parameters: Parameters,
    /// Whether friction falls.
    pub(super) falls: bool,
}

/// What a mixture is fitted to.
struct Mixed<'a> {
    evidence: &'a Evidence<'a>,
    surface: &'a Surface,
    laws: &'a [Law],
    recording: &'a Recording,
    shown: Shown,
}

/// Columns of a fit with their coefficients.
type Shares = (Vec<usize>, DVector<f64>);

impl Mixed<'_> {
    fn law(&self, column: usize) -> Option<Law> {
        let first = self.evidence.named(LAW).next()?;
        self.laws.get(column.checked_sub(first)?).copied()
    }

    /// Plain physics and the moment of the effort, then columns of such a name.
    fn linear(&self, beside: &str) -> Vec<usize> {
        let evidence = self.evidence;
        let plain = self.shown.plain.among(evidence.columns).into_iter();
        let free = evidence.named(SHIFT).chain(evidence.named(beside));
        plain.chain(free).collect()
    }

    /// The parameters of a fit.
    fn parameters(&self, (chosen, coefficients): &Shares) -> Option<Parameters> {
        let (surface, evidence) = (self.surface, self.evidence);
        let total = Gram::sum(&surface.folds)?;
        let matrix = total.normal(chosen).0;
        let covariance = clustered(&matrix, coefficients, &surface.folds, chosen);
        let level = |column: &usize| match column.checked_sub(evidence.columns.len()) {
            Some(block) => surface.grid[block],
            None => self.law(*column).map_or(0.0, Law::level),
        };
        let levels = DVector::from_iterator(chosen.len(), chosen.iter().map(level));
        let error = |c: &DMatrix<f64>| (c * &levels).dot(&levels).max(0.0).sqrt();
        let coulomb = levels.dot(coefficients);
        let folds = surface.folds.len();
        let plain = self.shown.plain;
        let own = &coefficients.as_slice()[..plain.among(evidence.columns).len()];
        let covariance = covariance.as_ref();
        let mut parameters = plain.parameters(self.recording, own, covariance, folds);
        let estimate = Estimate::new(coulomb, covariance.map(error), folds);
        parameters.push(("coulomb", estimate));
        Some(parameters)
    }

    /// Speed over which friction reverses, where most of the level `coulomb` follows the speed alone.
    fn speed(&self, (chosen, coefficients): &Shares, coulomb: f64) -> Option<f64> {
        let shares = chosen.iter().zip(coefficients);
        let smooth = shares.filter_map(|(column, share)| match self.law(*column)? {
            Law::Smooth(speed) => Some((*share, speed.ln())),
            _ => None,
        });
        let (share, speed) = smooth.fold((0.0, 0.0), |(sum, speed), (share, of)| {
            (sum + share, speed + share * of)
        });
        (share > 0.5 * coulomb).then(|| (speed / share).exp())
    }

    fn fit(&self) -> Option<Mixture> {
        let (evidence, folds) = (self.evidence, &self.surface.folds);
        let plain = self.shown.plain.among(evidence.columns);
        let blocks = evidence.blocks(self.shown.longest);
        let friction: Vec<usize> = evidence.named(LAW).chain(blocks).collect();
        let fit = evidence.fit(folds, &self.linear(""), &friction)?;
        // What the laws are worth by themselves.
        let held_out = evidence.held_out(&plain, &friction)?;
        let parameters = self.parameters(&fit)?;
        let coulomb = parameters.last().map_or(0.0, |p| p.1.value);

        let all: Vec<usize> = (friction.iter().copied())
            .chain(evidence.named(FALLING))
            .collect();
        let waved: Vec<usize> = plain.iter().copied().chain(evidence.named(WAVE)).collect();
        let better = evidence.held_out(&waved, &all);
        let better = better.is_some_and(|own| is_better(&held_out, &own, MATERIAL, false));
        let beside = better.then(|| self.beside(&all));
        Some(Mixture {
            nmse_cross: 100.0 * held_out.iter().sum::<f64>() / Gram::sum(folds)?.force_variation(),
            speed: self.speed(&fit, coulomb),
            beside: beside.flatten(),
            parameters,
        })
    }

    /// With friction that falls among the columns `friction`.
    fn beside(&self, friction: &[usize]) -> Option<Beside> {
        let fit = self
            .evidence
            .fit(&self.surface.folds, &self.linear(WAVE), friction)?;
        let is_falling = |column| matches!(self.law(column), Some(Law::Falling { .. }));
        let shares = fit.0.iter().zip(&fit.1);
        Some(Beside {
            parameters: self.parameters(&fit)?,
            falls: shares
                .into_iter()
                .any(|(j, by)| is_falling(*j) && *by > 0.0),
        })
    }
}

impl Mixture {
    /// Fits `laws`, which the evidence has columns of, and blocks beside the plain physics that is `shown`. Errors are clustered by the folds of
    /// `surface`, which has the evidence's columns.
    pub(super) fn of(
        evidence: &Evidence,
        surface: &Surface,
        laws: &[Law],
        recording: &Recording,
        shown: Shown,
    ) -> Option<Self> {
        let mixed = Mixed {
            evidence,
            surface,
            laws,
            recording,
            shown,
        };
        mixed.fit()
    }
}

impl Candidate {
    /// Intervals that reach to what others make of each parameter, too; the names of those that did not.
    fn reach_to(&mut self, others: &[(&'static str, Estimate)]) -> Vec<&'static str> {
        let mut wider = Vec::new();
        for (name, own) in &mut self.rigid_body {
            let other = others.iter().find(|p| p.0 == *name);
            let other = other.and_then(|p| Some((p.1.value, p.1.ci95?)));
            let value = own.value;
            if let (Some(own), Some((found, other))) = (&mut own.ci95, other) {
                let more = INEXACT * (value - found).abs();
                let both = [own[0].min(other[0] - more), own[1].max(other[1] + more)];
                if both != *own {
                    *own = both;
                    wider.push(*name);
                }
            }
        }
        wider
    }
}

impl Identification {
    /// Lets every interval reach to what a mixture of laws makes of the parameter, and says so where it predicts much better than what is recommended.
    pub(super) fn reach_to_other_laws(&mut self, recording: &Recording) {
        let Some(mixture) = self.mixture.take() else {
            return;
        };
        let candidates = self.candidates.iter_mut();
        candidates.for_each(|c| {
            c.reach_to(&mixture.parameters);
            let beside = mixture.beside.as_ref();
            c.reach_to(beside.map_or(&[], |beside| &beside.parameters));
        });
        let falls = mixture.beside.as_ref().filter(|beside| beside.falls);
        self.beside_falling = falls.map(|beside| beside.parameters.clone());
        let own = self.best().nmse_test;
        if own > HARDLY_ANY && mixture.nmse_cross < WORTH_TELLING * own {
            self.search_notes.push(mixture.words(recording, own));
        }
    }

    /// Leaves out the intervals of what friction bends that falls with the speed, where no fit has it beside: nothing says how far they reach.
    pub(super) fn leave_out_intervals(&mut self, recording: &Recording) {
        if self.beside_falling.is_some() || self.falls_with_speed(recording).is_none() {
            return;
        }
        let all = self.candidates.iter_mut().flat_map(|c| &mut c.rigid_body);
        let bent = all.filter(|p| BENT.contains(&p.0));
        bent.for_each(|(_, e)| e.ci95 = None);
    }

    /// Lets the intervals of a law that the user asked for reach to what the model `before` makes of the parameters, where that leaves much less: the
    /// folds scatter about a law's own values, and do not show how far it bends them.
    pub(super) fn reach_to_a_better(&mut self, before: usize, recording: &Recording) {
        let better = self.candidates[before].clone();
        let Some(own) = self.candidates.get_mut(self.recommended) else {
            return;
        };
        if better.nmse_test >= WORTH_TELLING * own.nmse_test {
            return;
        }
        let reach = own.reach_to(&better.rigid_body);
        let names: Vec<String> = reach
            .iter()
            .map(|name| name_shown(recording, name))
            .collect();
        let [law, other] = [&*own, &better].map(|c| c.model.friction.name());
        let [here, there] = [own.nmse_test, better.nmse_test].map(left);
        let reach = match names.as_slice() {
            [] => String::new(),
            names => format!(": {} reach to its values", names.join(", ")),
        };
        self.search_notes.push(format!(
            "the intervals are those of {law} alone, which leaves {here} of the variance where {other} leaves {there}: what the law lacks bends its parameters, and true values may lie outside{reach}"
        ));
    }
}

impl Mixture {
    /// In words, what laws other than blocks, which leave an error `own` (%), make of this recording.
    fn words(&self, recording: &Recording, own: f64) -> String {
        let [own, here] = [own, self.nmse_cross].map(left);
        let Some(speed) = self.speed else {
            return format!(
                "friction approaches its level along a tail, or forgets inner loops, as Dahl's does: with such bristles added the blocks leave {here} of the variance on held-out data, without them {own}. Intervals include each parameter's value with bristles; `preslide compare` fits Dahl's law and its relatives"
            );
        };
        format!(
            "friction here follows the speed and reverses smoothly over about {}, as tanh(v/v0) does: with such a law {here} of the variance is left on held-out data, with blocks {own}, and the parameters are {}. No model file has this law; the intervals include these figures",
            quantity(speed, &format!("{}/s", recording.position_unit())),
            figures(recording, &self.parameters)
        )
    }
}

/// Names of what a law of friction bends.
const BENT: [&str; 5] = [
    "mass",
    "viscous",
    "viscous_forward",
    "viscous_backward",
    "coulomb",
];

/// Inertia, viscous friction and the level in words.
pub(super) fn figures(recording: &Recording, parameters: &[(&'static str, Estimate)]) -> String {
    let own = parameters.iter().filter(|p| BENT.contains(&p.0));
    let each = own.map(|(name, e)| {
        let size = quantity(e.value, &unit(recording, name));
        format!("{} {size}", name_shown(recording, name))
    });
    each.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::{Identification, Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, Recording, load_csv};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;
    use std::fmt::Write as _;

    const SEED: u64 = 2;
    const MASS: f64 = 8.0;
    const VISCOUS: f64 = 40.0;
    /// Stiffness (N/m) and yield (m) of each block: 10.4 N.
    const BLOCKS: [[f64; 2]; 4] = [[1.2e6, 2e-6], [5e5, 6e-6], [1.5e5, 2e-5], [4e4, 5e-5]];

    /// A machine whose friction at rest is `static_ratio` times that at speed, falling within 4 mm/s.
    struct Made {
        name: &'static str,
        static_ratio: f64,
        /// Amplitude (N) of a force with a period of 2 mm.
        cogging: f64,
        /// N/m.
        spring: f64,
        /// Half of the difference of viscous friction between the directions (N·s/m).
        slant: f64,
    }

    /// Position, velocity and acceleration every 0.5 ms of strokes from 20 mm to 20 µm, each of least jerk.
    fn strokes(random: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
        let mut all = Vec::new();
        let mut x = 0.0;
        let sizes = [20e-3, 5e-3, 5e-4, 5e-5].into_iter().cycle().take(12);
        for size in sizes {
            let aside = 0.3 * size * random.random_range(-1.0..1.0);
            for way in [1.0, -1.0, 1.0, -1.0, 0.6, -0.2, 1.0, -1.0] {
                let to: f64 = aside + way * size;
                let far = (to - x).abs();
                let speed = 0.1 * random.random_range(0.1..1.0);
                let time = (1.875 * far / speed)
                    .max((5.774 * far / 2.0).sqrt())
                    .max(0.08);
                let count = (2000.0 * time).round();
                let time = count / 2000.0;
                for i in 0..count as usize {
                    let s = i as f64 / count;
                    let by = to - x;
                    all.push([
                        x + by * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
                        by / time * 30.0 * s * s * (1.0 - s).powi(2),
                        by / (time * time) * 60.0 * s * (1.0 - 3.0 * s + 2.0 * s * s),
                    ]);
                }
                x = to;
            }
        }
        all
    }

    fn recorded(made: &Made) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        let mut bent = [0.0_f64; 4];
        let mut last = 0.0;
        for (i, [x, v, a]) in strokes(&mut random).into_iter().enumerate() {
            let falls = 1.0 + (made.static_ratio - 1.0) * (-v.abs() / 4e-3).exp();
            let friction: f64 = (bent.iter_mut().zip(BLOCKS))
                .map(|(z, [k, d])| {
                    *z = (*z + x - last).clamp(-d * falls, d * falls);
                    k * *z
                })
                .sum();
            last = x;
            let noise = 0.05 * random.random_range(-1.0..1.0);
            let effort = MASS * a
                + VISCOUS * v
                + made.slant * v.abs()
                + friction
                + made.spring * (x - 2e-3)
                + made.cogging * (TAU * x / 2e-3 + 0.5).sin()
                + noise;
            let t = i as f64 * 5e-4;
            let _ = writeln!(text, "{t:.4},{:.8},{effort:.6}", x);
        }
        load_csv(text.as_bytes(), made.name, &LoadOptions::default()).expect("valid")
    }

    /// Whether the interval of a parameter holds a value; an offset and a level of blocks have no other.
    fn holds(found: &Identification, name: &str, value: f64) {
        let own = found.best().rigid_body.iter().find(|p| p.0 == name);
        let own = own.unwrap_or_else(|| panic!("no {name}")).1;
        let [low, high] = own.ci95.expect("an interval");
        println!(
            "  {name} {:.4} [{low:.4}, {high:.4}], {value} made",
            own.value
        );
        assert!((low..=high).contains(&value), "{name}");
    }

    /// What blocks lack, as friction that falls with the speed and cogging, is neither a spring nor a friction that differs by direction, and bends no
    /// parameter to beyond its interval; springs and differences that are there are found beside it.
    #[test]
    fn what_blocks_lack_is_no_other_physics() {
        let of = |name, static_ratio, cogging, spring, slant| Made {
            name,
            static_ratio,
            cogging,
            spring,
            slant,
        };
        for made in [
            of("plain", 1.0, 0.0, 0.0, 0.0),
            of("falls", 1.4, 0.0, 0.0, 0.0),
            of("cogs", 1.0, 0.8, 0.0, 0.0),
            of("falls beside a spring", 1.4, 0.0, 150.0, 0.0),
            of("cogs beside a difference", 1.0, 0.5, 0.0, 6.0),
        ] {
            println!("{} (seed {SEED})", made.name);
            let recording = recorded(&made);
            let progress = Progress::new("test", 0);
            let found = identify(&recording, &Options::default(), &progress).expect("a fit");
            let has = |name| found.best().rigid_body.iter().any(|p| p.0 == name);
            assert_eq!(has("spring"), made.spring != 0.0);
            assert_eq!(has("viscous_forward"), made.slant != 0.0);
            holds(&found, "mass", MASS);
            holds(&found, "coulomb", 10.4);
            holds(&found, "viscous", VISCOUS);
            match made.spring == 0.0 {
                true => holds(&found, "offset", 0.0),
                false => holds(&found, "spring", made.spring),
            }
            if made.slant != 0.0 {
                holds(&found, "viscous_forward", VISCOUS + made.slant);
                holds(&found, "viscous_backward", VISCOUS - made.slant);
            }
            let said = found.notes(&recording).join("\n");
            let falls = said.contains("beside friction that falls they are mass");
            assert_eq!(falls, made.static_ratio > 1.0, "{said}");
        }
    }
}
