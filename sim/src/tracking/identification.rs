//! The compensators' parameters, from an experiment on the stage and nothing else.

use super::simplex::minimise;
use super::{Axis, Step, TrackingError, motions};
use crate::stage::StageConfig;
use preslide::control::{NoFriction, Settings};
use preslide::{Block, Dahl, Friction, LuGre, Motion, ParamError, Scalar, Sliding, Units};
use preslide_fit::identify::refine::refine;
use preslide_fit::identify::regression::{Exact, Gram, Regression};
use preslide_fit::identify::search::best_choices;
use preslide_fit::identify::weights::Weights;
use rayon::prelude::*;

/// Ticks averaged into one sample: 1 ms at 20 kHz.
const DECIMATION: usize = 20;
/// Repeats of the motion.
const REPEATS: usize = 3;
/// Steps of the simplex per start. Twice as many lower the best cost of LuGre's five parameters by a part in a million.
const STEPS: u64 = 250;
/// Candidates for yield displacements, evenly spaced in their logarithm.
const GRID: usize = 48;

/// What a drive with current sense records while it follows [`motions::identification`] without compensation.
pub struct Experiment {
    /// Encoder position (m), the mean over the ticks of a sample, as the force is.
    pub position_m: Vec<f64>,
    /// Motor force less the mass times the reference's acceleration (N).
    pub friction_n: Vec<f64>,
    /// Samples of the slow part, in which every speed is far below any Stribeck velocity.
    slow: Vec<usize>,
    sample_time: f64,
}

impl Experiment {
    /// Runs it: three repeats of the motion on one stage.
    ///
    /// # Errors
    /// [`TrackingError`] where the controller or the stage cannot be built, or the controller gave up.
    pub fn run(settings: &Settings, stage: StageConfig) -> Result<Self, TrackingError> {
        let force_per_ampere = settings.motor.torque_constant * settings.motor.transmission();
        let mut axis = Axis::try_new(settings, NoFriction::<f64>::new(), Units::SI, stage)?;
        let steps = motions::identification();
        let moves = Step::plan_all(&steps, settings)?;
        let slow_steps: Vec<bool> = steps
            .iter()
            .map(|step| matches!(step, Step::Move { speed_m_s, .. } if *speed_m_s < 0.2e-3))
            .collect();
        let count = settings.encoder.count;
        let (mut position_m, mut force, mut reference, mut slow) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        // Every column is the mean over the same ticks: force and position then belong to the same instant.
        let (mut sums, mut ticks, mut fault) = ([0.0; 3], 0, None);
        for _ in 0..REPEATS {
            axis.follow(&moves, |now| {
                let values = [
                    force_per_ampere * now.current_a,
                    now.command.position as f64 * count,
                    now.command.reference as f64 / 65536.0 * count,
                ];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value / DECIMATION as f64;
                }
                ticks += 1;
                fault = fault.or(now.command.fault);
                if ticks == DECIMATION {
                    if slow_steps[now.step] {
                        slow.push(position_m.len());
                    }
                    let [mean_force, mean_position, mean_reference] = sums;
                    force.push(mean_force);
                    position_m.push(mean_position);
                    reference.push(mean_reference);
                    (sums, ticks) = ([0.0; 3], 0);
                }
            });
        }
        if let Some(fault) = fault {
            return Err(TrackingError::Identification(format!(
                "the uncompensated axis stopped with {fault:?}; the gains do not fit the stage"
            )));
        }
        let sample_time = settings.sample_time() * DECIMATION as f64;
        let mass = settings.feed_forward.mass;
        let friction_n = (0..force.len())
            .map(|i| {
                let (before, after) = (i.saturating_sub(1), (i + 1).min(force.len() - 1));
                let bend = reference[before] - 2.0 * reference[i] + reference[after];
                force[i] - mass * bend / sample_time.powi(2)
            })
            .collect();
        Ok(Self {
            position_m,
            friction_n,
            slow,
            sample_time,
        })
    }

    /// Maxwell-slip blocks with the best `n` yields, and the breakaway force (N).
    ///
    /// # Errors
    /// Where no `n` blocks with positive stiffness explain the force.
    pub fn blocks<const N: usize>(&self) -> Result<([Block; N], f64), TrackingError> {
        let whole = 0..self.position_m.len();
        let regression = Regression {
            position: &self.position_m,
            pieces: std::slice::from_ref(&whole),
            force: self.friction_n.clone(),
            columns: Vec::new(),
            filter: Box::new(<[f64]>::to_vec),
            folds: vec![self.slow.clone()],
            weights: Weights::default(),
        };
        // From one count to the largest amplitude of the experiment's pre-sliding part.
        let (shortest, longest) = (50e-9_f64, 60e-6_f64);
        let grid: Vec<f64> = (0..GRID)
            .map(|i| shortest * (longest / shortest).powf(i as f64 / (GRID - 1) as f64))
            .collect();
        let absent = || {
            TrackingError::Identification(format!(
                "no {N} blocks with positive stiffness explain the force"
            ))
        };
        let gram = Gram::sum(&regression.grams(&grid)).ok_or_else(absent)?;
        let sizes = best_choices(&gram, 0, N);
        let fit = sizes
            .get(N - 1)
            .and_then(|choices| choices.first())
            .map(|choice| choice.yields.iter().map(|&i| grid[i]).collect())
            .and_then(|start| {
                refine(
                    &Exact {
                        regression: &regression,
                        rows: &self.slow,
                    },
                    start,
                    (shortest, longest),
                )
            })
            .ok_or_else(absent)?;
        let breakaway: f64 = fit
            .yields
            .iter()
            .zip(&fit.stiffness)
            .map(|(d, k)| d * k)
            .sum();
        let mut blocks = [Block {
            stiffness: 0.0,
            weight: 0.0,
        }; N];
        for (block, (d, k)) in blocks.iter_mut().zip(fit.yields.iter().zip(&fit.stiffness)) {
            *block = Block {
                stiffness: *k,
                weight: d * k / breakaway,
            };
        }
        Ok((blocks, breakaway))
    }

    /// Coulomb's force (N): the mean of `F·sgn v` over the slow part where it slides.
    pub fn coulomb(&self) -> f64 {
        let level = |fraction: f64| {
            let mut forces: Vec<f64> = self
                .slow
                .iter()
                .map(|&i| self.friction_n[i].abs())
                .collect();
            forces.sort_by(f64::total_cmp);
            let place = (fraction * forces.len() as f64) as usize;
            forces.get(place).copied().unwrap_or(0.0)
        };
        // Where it slides: the upper quarter of |F|, its middle.
        level(0.875)
    }

    /// The mean of `F·sgn v` (N) by speed (m/s), where the axis has slid 40 µm in one direction, beyond the longest yield: what a
    /// drive's commissioning measures at constant speeds.
    pub fn by_speed(&self) -> Vec<(f64, f64)> {
        /// Samples over which a speed is taken.
        const SPAN: usize = 20;
        /// The motion's speeds, in the middle of bins of ±20 %.
        const SPEEDS: [f64; 5] = [40e-6, 80e-6, 0.3e-3, 0.5e-3, 1e-3];
        let mut sums = [(0.0, 0.0); SPEEDS.len()];
        let (mut turned, mut direction) = (0.0, 0.0);
        for i in SPAN..self.position_m.len() - SPAN {
            let travel = self.position_m[i + SPAN / 2] - self.position_m[i - SPAN / 2];
            let here = self.position_m[i];
            if travel * direction <= 0.0 {
                (turned, direction) = (here, travel);
            }
            let speed = travel.abs() / (SPAN as f64 * self.sample_time);
            let bin = SPEEDS.iter().position(|s| (speed / s - 1.0).abs() < 0.2);
            if let Some(bin) = bin.filter(|_| (here - turned).abs() > 40e-6) {
                sums[bin].0 += self.friction_n[i] * travel.signum();
                sums[bin].1 += 1.0;
            }
        }
        let means = SPEEDS.iter().zip(sums);
        means
            .filter(|(_, (_, n))| *n > 0.0)
            .map(|(speed, (sum, n))| (*speed, sum / n))
            .collect()
    }

    /// Dahl's `(σ0, F_c, n)` by least squares on the slow part, from several starts.
    ///
    /// # Errors
    /// Where no start leads to usable parameters.
    pub fn dahl<S: Scalar>(&self) -> Result<Dahl<S>, TrackingError> {
        fn build<S: Scalar>(p: &[f64; 3]) -> Result<Dahl<S>, ParamError> {
            Dahl::try_new(p[0].exp(), p[1].exp(), p[2].exp(), Units::SI)
        }
        let fc = self.coulomb();
        let starts = [3e4_f64, 1e5, 4e5].map(|s| [s.ln(), fc.ln(), 0.0]);
        Ok(build(&self.fit(&self.slow, &starts, build::<f64>)?)?)
    }

    /// LuGre's `(σ0, σp, F_s, F_c, v_s)` by least squares on everything, from several starts; `σp = 0` unless
    /// `damped`.
    ///
    /// # Errors
    /// Where no start leads to usable parameters.
    pub fn lugre<S: Scalar>(&self, damped: bool) -> Result<LuGre<S>, TrackingError> {
        fn build<S: Scalar>(p: &[f64; 5], damped: bool) -> Result<LuGre<S>, ParamError> {
            let damping = if damped { p[1].exp() } else { 0.0 };
            // Any real number gives a Coulomb force between none and the breakaway force.
            let (breakaway, share) = (p[2].exp(), 1.0 / (1.0 + (-p[3]).exp()));
            let sliding = Sliding {
                coulomb: share * breakaway,
                stribeck_velocity: p[4].exp(),
                stribeck_exponent: 1.0,
                attraction: f64::INFINITY,
            };
            LuGre::try_new(p[0].exp(), damping, breakaway, sliding, Units::SI)
        }
        let fc = self.coulomb();
        let starts =
            [3e4_f64, 1e5, 4e5].map(|s| [s.ln(), 10_f64.ln(), fc.ln(), 2.0, 1e-3_f64.ln()]);
        let all: Vec<usize> = (0..self.position_m.len()).collect();
        let best = self.fit(&all, &starts, |p| build::<f64>(p, damped))?;
        Ok(build(&best, damped)?)
    }

    /// Mean squared error of a model over `rows` (N²).
    fn error<F: Friction<Scalar = f64>>(&self, rows: &[usize], model: &F) -> f64 {
        let mut state = model.at_rest();
        let mut last = 0.0;
        let force: Vec<f64> = self
            .position_m
            .iter()
            .map(|&x| {
                let displacement = x - last;
                last = x;
                let velocity = displacement / self.sample_time;
                model.step(
                    &mut state,
                    Motion {
                        displacement,
                        velocity,
                    },
                )
            })
            .collect();
        rows.iter()
            .map(|&i| (force[i] - self.friction_n[i]).powi(2))
            .sum::<f64>()
            / rows.len() as f64
    }

    fn fit<F: Friction<Scalar = f64>, const P: usize>(
        &self,
        rows: &[usize],
        starts: &[[f64; P]],
        build: impl Fn(&[f64; P]) -> Result<F, ParamError> + Sync,
    ) -> Result<[f64; P], TrackingError> {
        let cost = |p: &[f64; P]| build(p).map_or(f64::INFINITY, |model| self.error(rows, &model));
        starts
            .par_iter()
            .filter_map(|start| minimise(cost, *start, STEPS))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(best, _)| best)
            .ok_or_else(|| {
                TrackingError::Identification("a one-state model could not be fitted".into())
            })
    }
}
