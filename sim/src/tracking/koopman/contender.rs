//! The controllers that are held against each other, each with three parameters, tuned by the same code.

use super::learnt::{Learnt, learn};
use super::outer::Outer;
use super::predictive::{Predictive, Weights};
use super::{BLOCKS, FORCE_N};
use crate::stage::{Stage, StageConfig};
use crate::tracking::simplex::minimise;
use crate::tracking::{
    Axis, Experiment, IDENTIFICATION_SEED, Instant, Step, Tracking, TrackingError, motions,
    observer,
};
use preslide::control::learning::Adaptation;
use preslide::control::{
    Learning, LearningSettings, Move, NoFriction, Observed, ObserverSettings, PidGains, Settings,
};
use preslide::{Block, Friction, QuasiStaticGms, Units};
use preslide_host::tune::observer::{Proposal, UNMODELLED_KG};

/// Steps of the simplex, of one or two tries each.
const STEPS: u64 = 25;
/// Integration steps in a tick while tuning: a quarter of the stage's, for four times as many tries.
const SUBSTEPS: u32 = 2;

/// By what a step of a weight is longer than one of a gain, in the logarithm: weights matter by their order of magnitude.
const COARSE: f64 = 3.0;

/// Where the weights' search starts: 0.1 N weigh as an error of 1 nm, their change as one of 30 nm; a fiftieth of what was not foreseen
/// is believed.
const START: Weights = Weights {
    effort: 1e-16,
    change: 1e-13,
    gain: 0.02,
};

/// By what its loop's gain may grow that every controller has to bear while it is tuned (-): a motor's constant and a mass that are each a
/// quarter off. More is looked for when it is tuned.
const GAIN: f64 = 1.5;
const GAINS: [f64; 4] = [GAIN, 2.0, 3.0, 4.0];
/// Error (m) that ringing counts as at least while it is tuned: more than any controller leaves, so that a search that begins where a
/// loop rings finds its way.
const RINGING_M: f64 = 1e-6;
/// What is judged of it: so long, until so long before the end (s), in which the reference brakes.
const JUDGED_S: [f64; 2] = [0.2, 0.05];
/// A rest after the slide (s).
const REST_S: f64 = 0.4;
/// Standard deviations of the error that ring, in a slide and at rest (m): several times what the encoder's interpolation and its counts
/// make.
const RINGS_M: [f64; 2] = [300e-9, 50e-9];

fn ringing() -> [Step; 2] {
    let slide = Step::Move {
        distance_m: 0.5e-3,
        speed_m_s: 1e-3,
        ramp_s: 0.02,
    };
    [slide, Step::Dwell(REST_S)]
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / n).sqrt()
}

/// A controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contender {
    /// Feedback alone.
    Pid,
    /// With four blocks fed forward.
    Gms,
    /// With the observer in the integral's place.
    Observer,
    /// Both.
    ObserverGms,
    /// Both, the blocks' level adapted.
    Adaptive,
    /// Koopman over proportional and derivative feedback, the friction in its lift only.
    Koopman,
    /// Over four blocks fed forward.
    KoopmanGms,
    /// Over the observer.
    KoopmanObserver,
    /// Over both.
    KoopmanObserverGms,
}

impl Contender {
    /// All of them.
    pub const ALL: [Contender; 9] = [
        Contender::Pid,
        Contender::Gms,
        Contender::Observer,
        Contender::ObserverGms,
        Contender::Adaptive,
        Contender::Koopman,
        Contender::KoopmanGms,
        Contender::KoopmanObserver,
        Contender::KoopmanObserverGms,
    ];

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Contender::Pid => "PID",
            Contender::Gms => "PID + GMS",
            Contender::Observer => "observer",
            Contender::ObserverGms => "obs + GMS",
            Contender::Adaptive => "obs + adaptive",
            Contender::Koopman => "Koopman",
            Contender::KoopmanGms => "Koopman + GMS",
            Contender::KoopmanObserver => "Koopman + obs",
            Contender::KoopmanObserverGms => "Koop + obs + GMS",
        }
    }
}

/// What experiments on the identification stage showed.
#[derive(Clone)]
pub struct Known {
    settings: Settings,
    stage: StageConfig,
    blocks: [Block; BLOCKS],
    breakaway: f64,
    yields: [f64; BLOCKS],
    observer: Proposal,
    /// The loops' maps: over nothing, blocks, observer, both.
    learnt: [Learnt; 4],
}

/// A motion on a stage.
pub(super) struct Ride<'a> {
    pub(super) stage: Stage,
    pub(super) moves: &'a [Move],
    /// Friction's level from the middle of the moves on (-).
    pub(super) half_way: Option<f64>,
    pub(super) observe: &'a mut dyn FnMut(Instant),
}

impl Ride<'_> {
    fn on<F: Friction>(self, settings: &Settings, friction: F) -> Result<(), TrackingError> {
        let mut axis = Axis::on(settings, friction, Units::SI, self.stage)?;
        let middle = self.moves.len() / 2;
        axis.follow(&self.moves[..middle], &mut *self.observe);
        if let Some(level) = self.half_way {
            axis.stage_mut().set_friction_level(level)?;
        }
        axis.follow(&self.moves[middle..], &mut *self.observe);
        Ok(())
    }
}

impl Known {
    /// Runs the experiments.
    ///
    /// # Errors
    /// [`TrackingError`] where the identification fails or no observer's gains leave their margins.
    pub fn from_experiments(
        settings: &Settings,
        stage: &StageConfig,
    ) -> Result<Self, TrackingError> {
        let stage = StageConfig {
            seed: IDENTIFICATION_SEED,
            ..stage.clone()
        };
        let (blocks, breakaway) = Experiment::run(settings, stage.clone())?.blocks::<BLOCKS>()?;
        let proposal = observer::proposal(settings, &stage, &blocks, breakaway)?;
        let yields = blocks.map(|block| block.yield_displacement(breakaway));
        // The loops below the predictive controller: it has the integral's place.
        let below = Settings {
            gains: proposal.gains,
            ..*settings
        };
        let gms = QuasiStaticGms::<BLOCKS, f32>::try_new(&blocks, breakaway, Units::SI)?;
        let (none, told) = (NoFriction::<f32>::new(), &proposal.settings);
        let (time, units) = (settings.sample_time(), Units::SI);
        let seen = Observed::try_new(none.clone(), told, time, units)?;
        let both = Observed::try_new(gms.clone(), told, time, units)?;
        let on = || stage.clone();
        let learnt = [
            learn(&below, none, on(), &yields, false)?,
            learn(&below, gms, on(), &yields, true)?,
            learn(&below, seen, on(), &yields, false)?,
            learn(&below, both, on(), &yields, true)?,
        ];
        Ok(Self {
            settings: *settings,
            stage,
            blocks,
            breakaway,
            yields,
            observer: proposal,
            learnt,
        })
    }

    /// The loops' maps, with the controllers that predict by them.
    pub fn learnt(&self) -> impl Iterator<Item = (Contender, &Learnt)> {
        Contender::ALL[5..].iter().copied().zip(&self.learnt)
    }

    fn gms(&self) -> Result<QuasiStaticGms<BLOCKS, f32>, TrackingError> {
        Ok(QuasiStaticGms::try_new(
            &self.blocks,
            self.breakaway,
            Units::SI,
        )?)
    }

    /// PID gains, each times e to the power of its parameter.
    fn pid(&self, p: &[f64; 3]) -> Settings {
        let gains = self.settings.gains;
        Settings {
            gains: PidGains {
                proportional: gains.proportional * p[0].exp(),
                integral: gains.integral * p[1].exp(),
                derivative: gains.derivative * p[2].exp(),
                ..gains
            },
            ..self.settings
        }
    }

    /// Feedback and filter: proportional, derivative, and the disturbance's walk.
    fn observed(&self, p: &[f64; 3]) -> Result<(Settings, ObserverSettings), TrackingError> {
        let mut belief = self.observer.belief;
        belief.walk *= (COARSE * p[2]).exp();
        let gains = belief.gains();
        let gains = gains.ok_or_else(|| TrackingError::Observer("it does not settle".into()))?;
        let settings = self.pid(&[p[0], f64::NEG_INFINITY, p[1]]);
        let observer = ObserverSettings {
            position: gains.position,
            velocity: gains.velocity,
            disturbance: gains.disturbance,
            ..self.observer.settings
        };
        Ok((settings, observer))
    }

    fn predictive(
        &self,
        which: usize,
        p: &[f64; 3],
        moves: &[Move],
    ) -> Result<(Settings, Predictive), TrackingError> {
        let settings = Settings {
            gains: self.observer.gains,
            ..self.settings
        };
        let weights = Weights {
            effort: START.effort * (COARSE * p[0]).exp(),
            change: START.change * (COARSE * p[1]).exp(),
            gain: (START.gain * (COARSE * p[2]).exp()).min(1.0),
        };
        let compensated = which % 2 == 1;
        let (learnt, yields) = (&self.learnt[which], &self.yields);
        let task = Predictive::try_new(learnt, yields, compensated, weights, &settings, moves)?;
        Ok((settings, task))
    }

    /// A controller with its parameters on a ride.
    pub(super) fn ride(
        &self,
        contender: Contender,
        p: &[f64; 3],
        ride: Ride,
    ) -> Result<(), TrackingError> {
        let none = NoFriction::<f32>::new();
        let (time, units) = (self.settings.sample_time(), Units::SI);
        let told = &self.observer.settings;
        match contender {
            Contender::Pid => ride.on(&self.pid(p), none),
            Contender::Gms => ride.on(&self.pid(p), self.gms()?),
            Contender::Observer => {
                let (settings, observer) = self.observed(p)?;
                ride.on(&settings, Observed::try_new(none, &observer, time, units)?)
            }
            Contender::ObserverGms => {
                let (settings, observer) = self.observed(p)?;
                ride.on(
                    &settings,
                    Observed::try_new(self.gms()?, &observer, time, units)?,
                )
            }
            Contender::Adaptive => {
                let (settings, observer) = self.observed(p)?;
                let learning = LearningSettings::PAPER_AXIS;
                let gms = Learning::<_, Adaptation<f32>>::try_new(self.gms()?, &learning, units)?;
                ride.on(&settings, Observed::try_new(gms, &observer, time, units)?)
            }
            Contender::Koopman => {
                let (settings, task) = self.predictive(0, p, ride.moves)?;
                ride.on(&settings, Outer::try_new(none, FORCE_N, task)?)
            }
            Contender::KoopmanGms => {
                let (settings, task) = self.predictive(1, p, ride.moves)?;
                ride.on(&settings, Outer::try_new(self.gms()?, FORCE_N, task)?)
            }
            Contender::KoopmanObserver => {
                let (settings, task) = self.predictive(2, p, ride.moves)?;
                let inner = Observed::try_new(none, told, time, units)?;
                ride.on(&settings, Outer::try_new(inner, FORCE_N, task)?)
            }
            Contender::KoopmanObserverGms => {
                let (settings, task) = self.predictive(3, p, ride.moves)?;
                let inner = Observed::try_new(self.gms()?, told, time, units)?;
                ride.on(&settings, Outer::try_new(inner, FORCE_N, task)?)
            }
        }
    }

    /// What part of a bad start's cost the iterations leave at most, of a predictive controller with its parameters (-).
    pub(super) fn contraction(&self, contender: Contender, p: &[f64; 3]) -> Option<f64> {
        let which = self
            .learnt()
            .position(|(predictive, _)| predictive == contender)?;
        let moves = Step::plan_all(&motions::rest(), &self.settings).ok()?;
        let (_, task) = self.predictive(which, p, &moves).ok()?;
        Some(task.contraction())
    }

    /// By how much (m) the loop rings with `gain` times its gain; `None` where it does not. The margin that
    /// [`observer::proposal`] asks of its loops by their linear model is asked of every controller by a run, since not every one has such
    /// a model: a slide at a constant speed and a rest, each judged in its last part. A fault rings, too.
    fn rings(&self, contender: Contender, p: &[f64; 3], gain: f64) -> Option<f64> {
        let mut louder = self.clone();
        // Every force takes the voltage of a larger resistance than there is; what makes up for the back-EMF stays.
        louder.settings.motor.resistance *= gain;
        let moves = ringing().map(|step| step.plan(&self.settings));
        let (Ok(stage), [Ok(slide), Ok(rest)]) = (Stage::try_new(self.stage.clone()), moves) else {
            return Some(RINGING_M);
        };
        let (mut errors, mut fault) = (Vec::new(), false);
        let mut observe = |now: Instant| {
            let reference = now.command.reference as f64 / 65536.0 * self.settings.encoder.count;
            errors.push(reference - now.encoder_m);
            fault |= now.command.fault.is_some();
        };
        let ride = Ride {
            stage,
            moves: &[slide, rest],
            half_way: None,
            observe: &mut observe,
        };
        let made = louder.ride(contender, p, ride).is_ok();
        let ticks = |time_s: f64| (time_s / self.settings.sample_time()) as usize;
        let (sliding, resting) = errors.split_at(errors.len().saturating_sub(ticks(REST_S)));
        let spread = |part: &[f64]| {
            let end = part.len().saturating_sub(ticks(JUDGED_S[1]));
            deviation(&part[end.saturating_sub(ticks(JUDGED_S[0]))..end])
        };
        let [sliding, resting] = [spread(sliding), spread(resting)];
        let quiet = made && !fault && sliding < RINGS_M[0] && resting < RINGS_M[1];
        (!quiet).then_some(sliding.max(resting).min(RINGING_M))
    }

    /// The largest of the gains that were tried, one after the other, with which the loop does not ring (-).
    pub(super) fn borne(&self, contender: Contender, p: &[f64; 3]) -> Option<f64> {
        let borne = |gain: &f64| self.rings(contender, p, *gain).is_none();
        GAINS.into_iter().take_while(borne).last()
    }

    /// The worse of two RMS errors (m) over the identification's motion: on its stage, and with an unknown payload. Where half
    /// as much gain again rings it is more than a micrometre.
    pub(super) fn cost(&self, contender: Contender, p: &[f64; 3]) -> f64 {
        if let Some(ringing) = self.rings(contender, p, GAIN) {
            return RINGING_M + ringing;
        }
        let Ok(moves) = Step::plan_all(&motions::identification(), &self.settings) else {
            return f64::INFINITY;
        };
        let of = |more_kg: f64| {
            let stage = Stage::try_new(StageConfig {
                mass_kg: self.stage.mass_kg + more_kg,
                substeps: SUBSTEPS,
                ..self.stage.clone()
            });
            let mut tracking = Tracking::default();
            let mut observe = |now: Instant| tracking.add(&now, self.settings.encoder.count);
            let ride = Ride {
                stage: stage.ok()?,
                moves: &moves,
                half_way: None,
                observe: &mut observe,
            };
            self.ride(contender, p, ride).ok()?;
            tracking.rms_m()
        };
        let [told, unmodelled] = [0.0, UNMODELLED_KG].map(|kg| of(kg).unwrap_or(f64::INFINITY));
        told.max(unmodelled)
    }

    /// The parameters of the least cost that the search finds, and the cost (m).
    ///
    /// # Errors
    /// Where no parameters lead through the motion.
    pub(super) fn tuned(&self, contender: Contender) -> Result<([f64; 3], f64), TrackingError> {
        minimise(|p| self.cost(contender, p), [0.0; 3], STEPS).ok_or_else(|| {
            let name = contender.name();
            TrackingError::Identification(format!("no parameters lead {name} through the motion"))
        })
    }
}
