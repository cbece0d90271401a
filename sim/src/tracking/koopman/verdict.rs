//! Who should use which: on stages that are, and are not, as the controllers' models say.

use super::contender::{Contender, Known, Ride};
use crate::stage::concealed::{Concealed, Kind};
use crate::stage::{Stage, StageConfig};
use crate::tracking::{Instant, Step, TRACKING_SEEDS, Tracking, TrackingError, motions};
use preslide::control::Settings;
use preslide_fit::report::Table;
use preslide_host::tune::observer::{UNCERTAINTY, UNMODELLED_KG};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// An error that counts as settled (m).
const SETTLED_M: f64 = 100e-9;

/// What the controllers do not know of a stage.
#[derive(Clone, Copy, Debug)]
struct Unmodelled {
    name: &'static str,
    /// Friction, of what was identified, from the start and from the middle of each motion on (-).
    level: f64,
    half_way: Option<f64>,
    more_kg: f64,
    concealed: Option<Concealed>,
}

const AS_MODELLED: Unmodelled = Unmodelled {
    name: "as modelled",
    level: 1.0,
    half_way: None,
    more_kg: 0.0,
    concealed: None,
};

/// A tenth of the breakaway force with the motor's period, a magnet's pull.
const COGGING: Concealed = Concealed {
    kind: Kind::PeriodicForce,
    size: 0.09,
    at: 2.857e-4,
    shape: 0.7,
};

const CONDITIONS: [Unmodelled; 6] = [
    AS_MODELLED,
    Unmodelled {
        name: "friction +15 %",
        level: 1.0 + UNCERTAINTY,
        ..AS_MODELLED
    },
    Unmodelled {
        name: "friction −15 %",
        level: 1.0 - UNCERTAINTY,
        ..AS_MODELLED
    },
    Unmodelled {
        name: "payload +1 kg",
        more_kg: UNMODELLED_KG,
        ..AS_MODELLED
    },
    Unmodelled {
        name: "cogging of 0.09 N",
        concealed: Some(COGGING),
        ..AS_MODELLED
    },
    Unmodelled {
        // What a lubricant does that warms.
        name: "warmed half way: friction −15 %",
        half_way: Some(1.0 - UNCERTAINTY),
        ..AS_MODELLED
    },
];

/// What a controller did in one condition, over all seeds.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// Nested triangles, whose peak is at a reversal.
    pub nested: Tracking,
    /// The slide with reversals.
    pub slide: Tracking,
    /// Moves made, and those after which the error stayed within 100 nm.
    pub moves: [usize; 2],
    /// The longest that this took from the reference's end (s).
    pub slowest_s: f64,
    squares_n2: f64,
    ticks: f64,
}

impl Score {
    /// RMS force of the motor over the nested triangles (N).
    pub fn force_n(&self) -> f64 {
        (self.squares_n2 / self.ticks).sqrt()
    }
}

/// A controller as tuned.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// Which.
    pub contender: Contender,
    /// Logarithms of what its three parameters were multiplied by, and the cost (m).
    pub parameters: [f64; 3],
    /// The worse RMS error of the tuning's two stages, before and after (m).
    pub cost_m: [f64; 2],
    /// The largest gain that was tried with which its loop does not ring, of what it is (-).
    pub gain: Option<f64>,
    /// What part of a bad start's cost the iterations leave at most (-).
    pub contraction: Option<f64>,
}

/// All controllers on a stage.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// `ideal` or `electrical`.
    pub stage: &'static str,
    /// RMS errors of the loops' predicted errors 1, 4 and 16 ms ahead, what was predicted (m), and the ridge.
    pub learnt: Vec<(Contender, [f64; 3], f64, f64)>,
    /// In the contenders' order.
    pub tuned: Vec<Tuned>,
    /// By condition, then contender.
    pub scores: Vec<(&'static str, Vec<Score>)>,
}

/// Moves of 20 µm there and back, with time to settle.
fn settling() -> Vec<Step> {
    let go = |i: usize| {
        [
            Step::Move {
                distance_m: if i.is_multiple_of(2) { 20e-6 } else { -20e-6 },
                speed_m_s: 1e-3,
                ramp_s: 5e-3,
            },
            Step::Dwell(0.3),
        ]
    };
    (0..6).flat_map(go).collect()
}

/// Tunes every controller and runs it in every condition, on the ideal or on the `electrical` stage, whose dead time is known.
/// `progress` gets (runs done, runs in all).
///
/// # Errors
/// [`TrackingError`] where an identification or a tuning fails.
pub fn study(
    settings: &Settings,
    stage: &StageConfig,
    electrical: bool,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Verdict, TrackingError> {
    let (mut settings, mut stage) = (*settings, stage.clone());
    if electrical {
        stage = crate::tracking::electrical(&mut settings, stage);
    }
    let all = Contender::ALL.len() * (1 + CONDITIONS.len());
    let done = AtomicUsize::new(0);
    let tell = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
    let known = Known::from_experiments(&settings, &stage)?;
    let tune = |contender: &Contender| {
        let (parameters, cost) = known.tuned(*contender)?;
        tell();
        Ok::<_, TrackingError>(Tuned {
            contender: *contender,
            parameters,
            cost_m: [known.cost(*contender, &[0.0; 3]), cost],
            gain: known.borne(*contender, &parameters),
            contraction: known.contraction(*contender, &parameters),
        })
    };
    let tuned = Contender::ALL.par_iter().map(tune);
    let tuned = tuned.collect::<Result<Vec<_>, _>>()?;
    let scores = CONDITIONS.iter().map(|unmodelled| {
        let scores = tuned.par_iter().map(|tuned| {
            let score = score(&known, tuned, &settings, &stage, unmodelled);
            tell();
            score
        });
        Ok((
            unmodelled.name,
            scores.collect::<Result<Vec<_>, TrackingError>>()?,
        ))
    });
    Ok(Verdict {
        stage: if electrical { "electrical" } else { "ideal" },
        learnt: known
            .learnt()
            .map(|(c, l)| (c, l.errors_m, l.size_m, l.ridge))
            .collect(),
        scores: scores.collect::<Result<Vec<_>, TrackingError>>()?,
        tuned,
    })
}

fn score(
    known: &Known,
    tuned: &Tuned,
    settings: &Settings,
    stage: &StageConfig,
    unmodelled: &Unmodelled,
) -> Result<Score, TrackingError> {
    let force_per_ampere = settings.motor.torque_constant * settings.motor.transmission();
    let count = settings.encoder.count;
    let mut score = Score::default();
    for seed in TRACKING_SEEDS {
        let ride = |steps: Vec<Step>, observe: &mut dyn FnMut(Instant)| {
            let moves = Step::plan_all(&steps, settings)?;
            let config = StageConfig {
                seed,
                mass_kg: stage.mass_kg + unmodelled.more_kg,
                ..stage.clone()
            };
            let mut stage = match unmodelled.concealed {
                Some(effect) => Stage::concealing(config, effect)?,
                None => Stage::try_new(config)?,
            };
            stage.set_friction_level(unmodelled.level)?;
            let ride = Ride {
                stage,
                moves: &moves,
                half_way: unmodelled.half_way,
                observe,
            };
            known.ride(tuned.contender, &tuned.parameters, ride)
        };
        ride(motions::nested_triangles(), &mut |now| {
            score.nested.add(&now, count);
            score.squares_n2 += (force_per_ampere * now.current_a).powi(2);
            score.ticks += 1.0;
        })?;
        ride(motions::slide(), &mut |now| score.slide.add(&now, count))?;
        let mut settles = Settles::default();
        ride(settling(), &mut |now| settles.add(&now, settings))?;
        settles.finish(&mut score);
    }
    Ok(score)
}

/// Dwells after moves.
#[derive(Default)]
struct Settles {
    resting: bool,
    now_s: f64,
    outside_s: f64,
    ended: Vec<(f64, f64)>,
}

impl Settles {
    fn add(&mut self, now: &Instant, settings: &Settings) {
        // Moves and dwells take turns; halves of the motion are of an even number of them.
        let resting = !now.step.is_multiple_of(2);
        if self.resting && !resting {
            self.end();
        }
        self.resting = resting;
        if resting {
            self.now_s += settings.sample_time();
            let error =
                now.command.reference as f64 / 65536.0 * settings.encoder.count - now.encoder_m;
            if error.abs() > SETTLED_M || now.command.fault.is_some() {
                self.outside_s = self.now_s;
            }
        }
    }

    fn end(&mut self) {
        self.ended.push((self.now_s, self.outside_s));
        (self.now_s, self.outside_s) = (0.0, 0.0);
    }

    fn finish(mut self, score: &mut Score) {
        self.end();
        for (whole, outside) in self.ended {
            score.moves[0] += 1;
            if outside < whole {
                score.moves[1] += 1;
                score.slowest_s = score.slowest_s.max(outside);
            }
        }
    }
}

/// The study for people.
pub fn print(verdict: &Verdict) -> String {
    let stage = verdict.stage;
    let nm = |error: f64| format!("{:.0}", 1e9 * error);
    let learnt = Table::of(
        format!("{stage} stage: what the maps err of the loop's following error 1, 4 and 16 ms ahead, on a repeat that was not fitted (nm RMS)"),
        &verdict.learnt,
    )
    .column("", |(contender, ..)| contender.name().to_owned())
    .column("1 ms", |(_, errors, ..)| nm(errors[0]))
    .column("4 ms", |(_, errors, ..)| nm(errors[1]))
    .column("16 ms", |(_, errors, ..)| nm(errors[2]))
    .column("of", |(_, _, size, _)| nm(*size))
    .column("ridge", |(.., ridge)| format!("{ridge:.0e}"));
    let tuned = Table::of(
        "tuned on the identification's stage and motion, the worse of as modelled and +1 kg (nm RMS)",
        &verdict.tuned,
    )
    .column("", |tuned| tuned.contender.name().to_owned())
    .column("before", |tuned| nm(tuned.cost_m[0]))
    .column("after", |tuned| nm(tuned.cost_m[1]))
    .column("logarithms", |tuned| {
        let [a, b, c] = tuned.parameters;
        format!("{a:+.2} {b:+.2} {c:+.2}")
    })
    .column("bears", |tuned| {
        tuned.gain.map_or("rings".to_owned(), |g| format!("×{g}"))
    })
    .column("contraction", |tuned| {
        tuned
            .contraction
            .map_or(String::new(), |c| format!("{c:.2e}"))
    });
    let both = |t: &Tracking| match t.rms_m() {
        Some(rms) => format!("{:.0} / {:.0}", rms * 1e9, t.peak_m() * 1e9),
        None => "fault".to_owned(),
    };
    let scores = verdict.scores.iter().map(|(name, scores)| {
        let caption = format!(
            "{stage} stage, {name}: RMS / peak (nm) over nested triangles and slides of 1 mm/s, moves within 100 nm, the slowest (ms), force (N)"
        );
        Table::of(caption, verdict.tuned.iter().zip(scores))
            .column("", |(tuned, _)| tuned.contender.name().to_owned())
            .column("nested", |(_, score)| both(&score.nested))
            .column("slide", |(_, score)| both(&score.slide))
            .column("within", |(_, Score { moves: [made, settled], .. })| format!("{settled}/{made}"))
            .column("slowest", |(_, score)| format!("{:.0}", score.slowest_s * 1e3))
            .column("force", |(_, score)| format!("{:.3}", score.force_n()))
    });
    let tables = [learnt.table(), tuned.table()].into_iter();
    let tables = tables.chain(scores.map(|scores| scores.table()));
    tables
        .map(|table| table.to_text())
        .collect::<Vec<_>>()
        .join("\n")
}
