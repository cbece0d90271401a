//! Trials for `preslide diagnose`: recordings of a simulated stage in which some physics is concealed, with
//! the truth kept aside.
//!
//! Nothing here is shared with the diagnosis, the library's models or the host tool's simulated stage:
//! other hysteresis laws, plant, integrator and noise, so that a diagnosis tuned to its own simulator shows.
//! A trial is its seed and its [`Kind`]; the law follows from the seed (`seed % 5`, [`law::LAWS`]).
//!
//! What is generated: a stage of 3 to 4 kg and 0.72 to 1.13 N of friction under a PID loop of 15 to 35 Hz;
//! 3 to 6 repeats of nested triangles, slides, rests, long strokes and a sum of sines; 40 to 180 s at 1 kHz
//! or 500 Hz; an encoder of 25 to 100 nm; coloured force noise; friction that differs by ±5 to ±15 % (two
//! standard deviations) between repeats and along the path. Sample times of force and position agree, and
//! the force is that of a current loop, so that no zero-order hold looks like a delay.

pub mod body;
pub mod draw;
pub mod effect;
pub mod files;
pub mod friction;
pub mod law;
pub mod motion;
pub mod plant;
pub mod scenario;
pub mod truth;

use effect::{CATALOGUE, CORNER, Effect, Id, OUTSIDE, PAIRS, Strength};
use law::Law;
use plant::{Marching, march};
use scenario::Scenario;
use truth::{Achievable, sample};

/// Period of the encoder's signal (m).
pub const ENCODER_PERIOD_M: f64 = 10e-6;

/// How many times larger than the hidden effect the one before it is, by RMS of the force.
pub const MASKING: f64 = 3.0;

/// What is concealed in a trial, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: the answer is `consistent`.
    Clean,
    /// Nothing, on a stage unlike the others.
    CleanOf(Family),
    /// One effect of the catalogue.
    Single(Id, Strength),
    /// One effect of [`CORNER`], strong, that acts at one end of the travel only.
    Corner(Id),
    /// Two effects at typical strength.
    Pair(Id, Id),
    /// The first at typical strength, behind the second, made [`MASKING`] times larger.
    Masked(Id, Id),
    /// One effect at typical strength; the model file's mass and friction are wrong by up to 30 %.
    WrongBaseline(Id),
    /// One effect of [`OUTSIDE`]: the answer is `unknown-physics`.
    Outside(Id),
}

/// Clean stages unlike those of the plan: a false alarm that only some family raises would not show there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// As in the plan.
    Usual,
    /// An encoder of 1 µm.
    Coarse,
    /// Three times the mass.
    Heavy,
    /// Friction that differs by up to ±30 %.
    Loose,
    /// Friction that repeats perfectly.
    Even,
    /// 250 rows a second.
    Slow,
    /// No columns that number segments and repeats.
    Bare,
}

/// All families.
pub const FAMILIES: [Family; 7] = [
    Family::Usual,
    Family::Coarse,
    Family::Heavy,
    Family::Loose,
    Family::Even,
    Family::Slow,
    Family::Bare,
];

impl Family {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Family::Usual => "usual",
            Family::Coarse => "coarse",
            Family::Heavy => "heavy",
            Family::Loose => "loose",
            Family::Even => "even",
            Family::Slow => "slow",
            Family::Bare => "bare",
        }
    }
}

/// `n` clean trials, over all families and laws in turn.
pub fn clean_plan(n: usize) -> Vec<(u64, Kind)> {
    // Seven families and five laws have no common factor: 35 trials meet all pairs.
    let family = |i: usize| Kind::CleanOf(FAMILIES[i % FAMILIES.len()]);
    (0..n).map(|i| (40_000_000 + i as u64, family(i))).collect()
}

impl Kind {
    /// Name in labels and tables.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Clean | Kind::CleanOf(_) => "clean",
            Kind::Single(..) => "single",
            Kind::Corner(..) => "corner",
            Kind::Pair(..) => "pair",
            Kind::Masked(..) => "masked",
            Kind::WrongBaseline(..) => "wrong_baseline",
            Kind::Outside(..) => "outside",
        }
    }

    /// The effects, the hidden one of a masked pair first.
    pub fn ids(self) -> Vec<Id> {
        match self {
            Kind::Clean | Kind::CleanOf(_) => Vec::new(),
            Kind::Single(id, _)
            | Kind::Corner(id)
            | Kind::WrongBaseline(id)
            | Kind::Outside(id) => {
                vec![id]
            }
            Kind::Pair(a, b) | Kind::Masked(a, b) => vec![a, b],
        }
    }

    /// Strength of the effects.
    pub fn strength(self) -> Strength {
        match self {
            Kind::Single(_, strength) => strength,
            Kind::Corner(_) => Strength::Strong,
            _ => Strength::Typical,
        }
    }
}

/// What was recorded: columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Time (s).
    pub t_s: Vec<f64>,
    /// Position as the encoder reads it (m).
    pub x_m: Vec<f64>,
    /// Force of the motor (N), positive in +x.
    pub force_n: Vec<f64>,
    /// Number of the part of the motion, the same in each repeat.
    pub segment: Vec<u32>,
    /// Number of the repeat.
    pub repeat: Vec<u32>,
    /// Whether segments and repeats are numbered in the file.
    pub numbered: bool,
    /// Temperature (°C).
    pub temperature_c: Option<Vec<f64>>,
    /// Preload of the guide (N).
    pub normal_n: Option<Vec<f64>>,
}

/// A part of an axis on which an effect acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// `position` or `velocity` (its magnitude).
    pub axis: &'static str,
    /// Start (m or m/s).
    pub from: f64,
    /// End (m or m/s).
    pub to: f64,
}

/// The truth about a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Seed of the trial.
    pub seed: u64,
    /// Kind of the trial.
    pub kind: Kind,
    /// Hysteresis law.
    pub law: Law,
    /// Effects with their parameters in SI.
    pub effects: Vec<Effect>,
    /// Strength of the effects: `none`, `weak`, `typical` or `strong`.
    pub strength: &'static str,
    /// Where the first effect acts, if only there.
    pub region: Option<Region>,
    /// Moving mass (kg).
    pub mass: f64,
    /// Breakaway force (N).
    pub breakaway: f64,
}

/// A recording, its label, and the model file that a diagnosis starts from.
pub struct Trial {
    /// What the diagnosis sees.
    pub recording: Columns,
    /// What it does not see.
    pub label: Label,
    /// What a perfect diagnosis could reach.
    pub achievable: Achievable,
    /// Text of the model file.
    pub model_toml: String,
}

/// Makes the trial of a seed.
pub fn trial(seed: u64, kind: Kind) -> Trial {
    let mut relative = [1.0, 1.0];
    if let Kind::Masked(..) = kind {
        // The ratio is nearly proportional to the strength, but for what the loop makes of it.
        for _ in 0..2 {
            let rms = run(seed, kind, &relative).2.effect_rms;
            if let [hidden, masking] = rms[..] {
                relative[1] *= (MASKING * hidden / masking).clamp(0.05, 20.0);
            }
        }
    }
    let (scenario, recording, achievable) = run(seed, kind, &relative);
    Trial {
        label: label(&scenario, kind),
        model_toml: files::model_toml(&scenario),
        recording,
        achievable,
    }
}

/// The trial of a seed along another motion than its own.
pub fn trial_along(seed: u64, kind: Kind, ticks: Vec<motion::Reference>) -> Trial {
    let mut scenario = Scenario::new(seed, kind, &[1.0, 1.0]);
    scenario.motion.ticks = ticks;
    let (scenario, recording, achievable) = record(scenario, Marching::default());
    Trial {
        label: label(&scenario, kind),
        model_toml: files::model_toml(&scenario),
        recording,
        achievable,
    }
}

/// Half of the travel (m) of a seed's stage.
pub fn half_travel(seed: u64, kind: Kind) -> f64 {
    Scenario::new(seed, kind, &[1.0, 1.0]).motion.half_travel
}

/// A clean stage whose friction is that of its model file, block by block, and repeats perfectly; only the reading of the force
/// has noise. Its mass and friction are the file's: the answer is `consistent`.
pub fn repeatable(seed: u64) -> Trial {
    let mut scenario = Scenario::new(seed, Kind::Clean, &[]);
    scenario.hysteresis = law::Hysteresis::of_blocks(&scenario.model_blocks);
    scenario.model_mass = scenario.mass;
    scenario.noise.interpolation = 0.0;
    let marching = Marching {
        noise: false,
        ..Marching::default()
    };
    let (scenario, recording, achievable) = record(scenario, marching);
    Trial {
        label: label(&scenario, Kind::Clean),
        model_toml: files::model_toml(&scenario),
        recording,
        achievable,
    }
}

fn run(seed: u64, kind: Kind, relative: &[f64]) -> (Scenario, Columns, Achievable) {
    record(Scenario::new(seed, kind, relative), Marching::default())
}

fn record(scenario: Scenario, marching: Marching) -> (Scenario, Columns, Achievable) {
    let ticks = march(&scenario, marching);
    let commanded: Vec<f64> = ticks.iter().map(|tick| tick.commanded).collect();
    let mut reading = draw::Draw::new(scenario.seed, 5);
    let force_n: Vec<f64> = sample(&scenario, &commanded, &scenario.effects)
        .iter()
        .map(|force| force + scenario.noise.reading * reading.normal())
        .collect();
    let every = scenario.ticks_per_sample;
    let achievable = Achievable::new(&scenario, &ticks, &force_n);
    let samples = || ticks.iter().step_by(every);
    let references = || scenario.motion.ticks.iter().step_by(every);
    let recording = Columns {
        t_s: (0..force_n.len())
            .map(|i| (i * every) as f64 * body::TICK_S)
            .collect(),
        x_m: samples().map(|tick| tick.measured).collect(),
        force_n,
        segment: references().map(|r| r.segment).collect(),
        repeat: references().map(|r| r.repeat).collect(),
        numbered: scenario.numbered,
        temperature_c: scenario
            .temperature_recorded
            .then(|| samples().map(|tick| tick.temperature).collect()),
        normal_n: scenario
            .load_varies
            .then(|| samples().map(|tick| tick.preload).collect()),
    };
    (scenario, recording, achievable)
}

fn label(scenario: &Scenario, kind: Kind) -> Label {
    let region = scenario.effects.first().and_then(|effect| {
        let half = scenario.motion.half_travel;
        match (effect.corner, effect.id) {
            (Some(edge), _) if edge > 0.0 => Some(("position", edge, half)),
            (Some(edge), _) => Some(("position", -half, edge)),
            (None, Id::LocalFrictionSpot) => {
                let [_, position, width, _] = effect.values;
                // Where 97 % of it is.
                Some(("position", position - 1.5 * width, position + 1.5 * width))
            }
            (None, Id::Stribeck) => Some(("velocity", 0.0, 2.0 * effect.values[1])),
            _ => None,
        }
    });
    Label {
        seed: scenario.seed,
        kind,
        law: scenario.law,
        effects: scenario.effects.clone(),
        strength: Scenario::strength_name(kind),
        region: region.map(|(axis, from, to)| Region { axis, from, to }),
        mass: scenario.mass,
        breakaway: scenario.breakaway,
    }
}

/// A plan of `n` trials: of 20, 4 clean, 7 single (each effect typical, then weak, then strong), 2 pairs, 1
/// masked, 1 on a wrong baseline, 2 in a corner, 3 outside the catalogue; every kind meets every law.
/// The seeds are those of the first plan; add multiples of 5 for another.
pub fn catalogue_plan(n: usize) -> Vec<(u64, Kind)> {
    const WHEEL: &[u8; 20] = b"CSOSPSCSMSOSCSWSPCXO";
    let mut counts = [0usize; 256];
    (0..n)
        .map(|i| {
            let slot = WHEEL[i % WHEEL.len()];
            let k = counts[usize::from(slot)];
            counts[usize::from(slot)] += 1;
            let (kind, variants) = match slot {
                b'C' => (Kind::Clean, 1),
                b'S' => {
                    let strengths = [Strength::Typical, Strength::Weak, Strength::Strong];
                    let strength = strengths[(k / CATALOGUE.len()) % 3];
                    // 7 and 25 have no common factor: a short plan already meets unlike effects.
                    (
                        Kind::Single(CATALOGUE[7 * k % CATALOGUE.len()], strength),
                        CATALOGUE.len(),
                    )
                }
                b'P' => {
                    let (a, b) = PAIRS[k % PAIRS.len()];
                    (Kind::Pair(a, b), PAIRS.len())
                }
                b'M' => {
                    let (a, b) = PAIRS[(5 * k + 1) % PAIRS.len()];
                    (
                        if k % 2 == 0 {
                            Kind::Masked(a, b)
                        } else {
                            Kind::Masked(b, a)
                        },
                        PAIRS.len(),
                    )
                }
                b'W' => {
                    const ABSORBED: [Id; 8] = [
                        Id::Stribeck,
                        Id::Viscous,
                        Id::ConstantForce,
                        Id::PositionSpring,
                        Id::PeriodicForce,
                        Id::PositionFriction,
                        Id::ChannelDelay,
                        Id::CoulombAsymmetry,
                    ];
                    (
                        Kind::WrongBaseline(ABSORBED[k % ABSORBED.len()]),
                        ABSORBED.len(),
                    )
                }
                b'X' => (Kind::Corner(CORNER[k % CORNER.len()]), CORNER.len()),
                _ => (Kind::Outside(OUTSIDE[k % OUTSIDE.len()]), OUTSIDE.len()),
            };
            // Each round through the variants moves on by one law.
            let law = if variants == 1 { k } else { k + k / variants };
            (5 * (i as u64 + 1) + (law % law::LAWS.len()) as u64, kind)
        })
        .collect()
}
