//! What drives ship against friction, tuned as well as we can: smoothed Coulomb friction, and a table over velocity that looks ahead.
//!
//! **Fairness.** Both get what the other compensators get, the [`Experiment`] on the identification stage, and something more: their
//! parameters are then tuned in closed loop, on that stage and its motion, for the smallest RMS error, by a simplex from the
//! experiment's values. The motions that are judged, and their stages, are not seen. What is not modelled of vendors' products: pulses
//! whose height depends on the acceleration at the reversal, and what they learn on the machine.

use super::simplex::minimise;
use super::{Axis, Experiment, Step, Tracking, TrackingError, motions};
use crate::stage::StageConfig;
use preslide::control::{Coefficients, Controller, Move, NoFriction, Reference, Settings};
use preslide::{Friction, Motion, Units};
use std::sync::Arc;

/// Steps of the simplex, of one or two runs each: what a study can afford; whether more would gain was not measured.
const STEPS: u64 = 30;
/// Integration steps in a tick while tuning: a quarter of the stage's, for four times as many runs.
const SUBSTEPS: u32 = 2;

/// `F_c·tanh(v/v_s) + b·v` of the reference's velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothedCoulomb {
    coulomb_n: f32,
    /// v_s (m/s).
    velocity_m_s: f32,
    viscous_n_s_per_m: f32,
}

impl Friction for SmoothedCoulomb {
    type Scalar = f32;
    type State = ();

    fn at_rest(&self) {}

    fn step(&self, _: &mut (), motion: Motion<f32>) -> f32 {
        let v = motion.velocity;
        self.coulomb_n * (v / self.velocity_m_s).tanh() + self.viscous_n_s_per_m * v
    }

    fn limit(&self) -> Option<f32> {
        None
    }
}

impl SmoothedCoulomb {
    /// Tuned on the identification stage.
    ///
    /// # Errors
    /// [`TrackingError`] where no parameters lead through the motion.
    pub fn tuned(
        experiment: &Experiment,
        settings: &Settings,
        stage: &StageConfig,
    ) -> Result<Self, TrackingError> {
        let build = |p: &[f64; 3]| {
            let [coulomb_n, velocity_m_s, viscous_n_s_per_m] = p.map(|p| p.exp() as f32);
            Self {
                coulomb_n,
                velocity_m_s,
                viscous_n_s_per_m,
            }
        };
        let start = [experiment.coulomb().ln(), 50e-6_f64.ln(), 10_f64.ln()];
        tune(settings, stage, start, |p, _| build(p)).map(|best| build(&best))
    }
}

/// Friction by speed, as it was measured at constant speeds, of the reference's velocity some time ahead: the pulse comes before the
/// reversal and has risen when the axis turns. Below the first speed it goes straight through zero.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAhead {
    /// Speed (m/s) and force (N), rising.
    table: Vec<(f32, f32)>,
    lead: usize,
    /// The reference's velocity in every tick of the motion (m/s).
    velocities: Arc<[f32]>,
}

impl Friction for LookAhead {
    type Scalar = f32;
    /// Ticks since the start.
    type State = usize;

    fn at_rest(&self) -> usize {
        0
    }

    fn step(&self, tick: &mut usize, _: Motion<f32>) -> f32 {
        let v = self.velocities.get(*tick + self.lead).unwrap_or(&0.0);
        *tick += 1;
        let (mut before, speed) = ((0.0, 0.0), v.abs());
        for &point in &self.table {
            if speed < point.0 {
                let share = (speed - before.0) / (point.0 - before.0);
                return v.signum() * (before.1 + share * (point.1 - before.1));
            }
            before = point;
        }
        v.signum() * before.1
    }

    fn limit(&self) -> Option<f32> {
        None
    }
}

/// The parameters of a [`LookAhead`], whatever the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct LookAheadSettings {
    table: Vec<(f32, f32)>,
    lead: usize,
}

impl LookAheadSettings {
    /// Level, knee and lead tuned on the identification stage; the table's form is the experiment's.
    ///
    /// # Errors
    /// [`TrackingError`] where no parameters lead through the motion, or none was measured.
    pub fn tuned(
        experiment: &Experiment,
        settings: &Settings,
        stage: &StageConfig,
    ) -> Result<Self, TrackingError> {
        let measured = experiment.by_speed();
        let Some(&(_, slowest)) = measured.first() else {
            return Err(TrackingError::Identification(
                "nowhere did the axis slide at a constant speed".into(),
            ));
        };
        let build = |p: &[f64; 3]| {
            let [level, knee, lead] = p.map(f64::exp);
            let points = std::iter::once((knee, slowest))
                .chain(measured.iter().copied().filter(|(speed, _)| *speed > knee));
            Self {
                table: points
                    .map(|(v, f)| (v as f32, (level * f) as f32))
                    .collect(),
                lead: (lead / settings.sample_time()).round() as usize,
            }
        };
        let start = [0.0, 50e-6_f64.ln(), 5e-3_f64.ln()];
        tune(settings, stage, start, |p, velocities| {
            build(p).follow(velocities)
        })
        .map(|best| build(&best))
    }

    fn follow(&self, velocities: &Arc<[f32]>) -> LookAhead {
        LookAhead {
            table: self.table.clone(),
            lead: self.lead,
            velocities: Arc::clone(velocities),
        }
    }

    /// For a motion that is known beforehand.
    ///
    /// # Errors
    /// [`TrackingError`] where the settings are not usable.
    pub fn on(&self, settings: &Settings, moves: &[Move]) -> Result<LookAhead, TrackingError> {
        Ok(self.follow(&velocities(settings, moves)?))
    }
}

/// The reference's velocity (m/s) in every tick of the moves.
pub(super) fn velocities(settings: &Settings, moves: &[Move]) -> Result<Arc<[f32]>, TrackingError> {
    let coefficients = Coefficients::try_new(settings, NoFriction::<f64>::new(), Units::SI)?;
    let controller = Controller::new(coefficients, 0_u32);
    let pace = controller.pace();
    let mut reference = Reference::at(0, pace);
    let mut velocities = Vec::new();
    let scale = settings.encoder.count / 65536.0 / settings.sample_time();
    for &next in moves {
        // As the axis does: what is refused is not made.
        let _ = reference.start(next, pace);
        while !reference.is_idle() {
            let displacement = reference.step(pace).displacement;
            velocities.push((f64::from(displacement) * scale) as f32);
        }
    }
    Ok(velocities.into())
}

/// The parameters with the smallest RMS error over the identification motion.
fn tune<F: Friction>(
    settings: &Settings,
    stage: &StageConfig,
    start: [f64; 3],
    build: impl Fn(&[f64; 3], &Arc<[f32]>) -> F,
) -> Result<[f64; 3], TrackingError> {
    let moves = Step::plan_all(&motions::identification(), settings)?;
    let velocities = velocities(settings, &moves)?;
    let stage = StageConfig {
        substeps: SUBSTEPS,
        ..stage.clone()
    };
    let cost = |p: &[f64; 3]| {
        let friction = build(p, &velocities);
        let Ok(mut axis) = Axis::try_new(settings, friction, Units::SI, stage.clone()) else {
            return f64::INFINITY;
        };
        let mut tracking = Tracking::default();
        axis.follow(&moves, |now| tracking.add(&now, settings.encoder.count));
        tracking.rms_m().unwrap_or(f64::INFINITY)
    };
    let (best, _) = minimise(cost, start, STEPS).ok_or_else(|| {
        TrackingError::Identification("no parameters of a rival led through the motion".into())
    })?;
    Ok(best)
}
