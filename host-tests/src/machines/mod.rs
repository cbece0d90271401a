//! Machines of a second generator: ball screws, belts, servo joints that lift a weight, spindles that turn one way.
//!
//! It shares nothing with [`crate::trials`] but what is judged: friction laws written from their papers' equations, motions without
//! repeats, clocks that jitter and lose rows, machines of other sizes. Nothing of it may be used to tune the diagnosis: reports give sums.

pub mod effect;
pub mod law;
pub mod motion;
pub mod plant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;

use crate::case::{Sort, Truth};
use crate::table::{Recording, Table};
use effect::Concealed;
use law::Law;

/// Which machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Ball screw and carriage.
    Screw,
    /// Toothed belt and carriage.
    Belt,
    /// Geared joint with a weight on its arm.
    Servo,
    /// Turns one way only.
    Spindle,
}

/// What a kind's sizes lie between (SI for a line or a turn), and the steps that its encoders have.
struct Ranges {
    inertia: [f64; 2],
    friction: [f64; 2],
    presliding: [f64; 2],
    travel: [f64; 2],
    speed: [f64; 2],
    acceleration: [f64; 2],
    counts: [f64; 2],
}

impl Kind {
    fn ranges(self) -> Ranges {
        match self {
            Kind::Screw => Ranges {
                inertia: [20.0, 120.0],
                friction: [15.0, 60.0],
                presliding: [5e-6, 40e-6],
                travel: [0.1, 0.4],
                speed: [0.04, 0.25],
                acceleration: [0.5, 3.0],
                counts: [1e-7, 1e-6],
            },
            Kind::Belt => Ranges {
                inertia: [1.0, 8.0],
                friction: [4.0, 20.0],
                presliding: [1e-4, 6e-4],
                travel: [0.3, 1.0],
                speed: [0.15, 1.0],
                acceleration: [2.0, 8.0],
                counts: [5e-6, 2e-5],
            },
            Kind::Servo => Ranges {
                inertia: [4e-3, 0.05],
                friction: [0.05, 0.5],
                presliding: [5e-3, 0.03],
                travel: [2.0, 5.0],
                speed: [1.0, 6.0],
                acceleration: [10.0, 40.0],
                counts: [5e-5, 2e-4],
            },
            Kind::Spindle => Ranges {
                inertia: [1e-3, 1e-2],
                friction: [0.02, 0.1],
                presliding: [0.01, 0.05],
                travel: [300.0, 900.0],
                speed: [8.0, 50.0],
                acceleration: [10.0, 60.0],
                counts: [5e-5, 2e-4],
            },
        }
    }
}

/// Random numbers of a machine.
pub struct Dice(ChaCha12Rng);

impl Dice {
    /// Of a seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha12Rng::seed_from_u64(seed ^ 0x6d61_6368_696e_6573))
    }

    /// Uniform.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// Uniform in the logarithm.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Uniform in the logarithm, of a range.
    fn scale_in(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.scale(low, high)
    }

    /// What is drawn with a probability, and else nothing.
    fn sometimes(&mut self, probability: f64, draw: impl FnOnce(&mut Self) -> f64) -> f64 {
        match self.chance(probability) {
            true => draw(self),
            false => 0.0,
        }
    }

    /// One of several.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.0.random_range(0..of.len())]
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// Nearly normal: twelve uniform ones (limits at six deviations).
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.between(0.0, 1.0)).sum::<f64>() - 6.0
    }
}

/// A machine's sizes, in SI for a line or a turn.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Which.
    pub kind: Kind,
    /// Mass (kg) or inertia (kg·m²).
    pub inertia: f64,
    /// Friction level (N or N·m).
    pub friction: f64,
    /// Length (m) or angle (rad) of presliding.
    pub presliding: f64,
    /// Travel (m or rad).
    pub travel: f64,
    /// Highest speed (m/s or rad/s).
    pub speed: f64,
    /// Acceleration (m/s² or rad/s²).
    pub acceleration: f64,
    /// Step of the encoder (m or rad).
    pub count: f64,
    /// Rows a second.
    pub rate_hz: f64,
    /// Length of the recording (s).
    pub seconds: f64,
    /// Friction law.
    pub law: Law,
    /// Standard deviation of the clock's jitter, in steps.
    pub jitter: f64,
    /// Share of rows lost.
    pub lost: f64,
    /// White noise of the effort, as a share of the friction level.
    pub noise: f64,
    /// Friction that does not repeat, standard deviation of its level.
    pub wander: f64,
}

impl Machine {
    fn draw(dice: &mut Dice) -> Self {
        let kind = dice.pick(&[
            Kind::Screw,
            Kind::Screw,
            Kind::Belt,
            Kind::Belt,
            Kind::Servo,
            Kind::Servo,
            Kind::Spindle,
        ]);
        let ranges = kind.ranges();
        let inertia = dice.scale_in(ranges.inertia);
        let friction = dice.scale_in(ranges.friction);
        let presliding = dice.scale_in(ranges.presliding);
        let travel = dice.scale_in(ranges.travel);
        let speed = dice.scale_in(ranges.speed);
        let acceleration = dice.scale_in(ranges.acceleration);
        Self {
            kind,
            inertia,
            friction,
            presliding,
            travel,
            speed,
            // A drive is sized for its friction as well as its mass.
            acceleration: acceleration.min(5.0 * friction / inertia),
            count: dice.pick(&ranges.counts),
            rate_hz: dice.pick(&[250.0, 500.0, 1000.0, 1000.0]),
            seconds: dice.between(35.0, 90.0),
            law: Law::draw(dice),
            jitter: dice.sometimes(0.4, |dice| dice.between(0.05, 0.25)),
            lost: dice.sometimes(0.3, |dice| dice.scale(5e-4, 1e-2)),
            noise: dice.scale(3e-3, 2e-2),
            wander: dice.between(0.01, 0.05),
        }
    }

    /// Whether it turns.
    pub fn rotary(&self) -> bool {
        matches!(self.kind, Kind::Servo | Kind::Spindle)
    }
}

/// What a machine conceals, and what is recorded of it.
pub struct Made {
    /// Given to the tool.
    pub recording: Recording,
    /// Question.
    pub sort: Sort,
    /// Of typical.
    pub strength: f64,
    /// Answer.
    pub truth: Vec<Truth>,
}

/// The recording of a seed. Of ten, three are clean, five have one effect, one has two, one a stranger.
pub fn make(seed: u64) -> Made {
    let mut dice = Dice::new(seed);
    let machine = Machine::draw(&mut dice);
    let (sort, many) = match seed % 10 {
        0 | 3 | 6 => (Sort::Clean, 0),
        8 => (Sort::Pair, 2),
        5 => (Sort::Stranger, 1),
        _ => (Sort::Single, 1),
    };
    let strength = match sort {
        Sort::Clean => 0.0,
        Sort::Single => [1.0, 0.5, 2.0][(seed / 10 % 3) as usize],
        _ => 1.0,
    };
    let mut concealed: Vec<Concealed> = Vec::new();
    while concealed.len() < many {
        let one = Concealed::draw(&machine, strength, sort == Sort::Stranger, &mut dice);
        if concealed.iter().all(|other| other.id != one.id) {
            concealed.push(one);
        }
    }
    let table = plant::record(&machine, &concealed, &mut dice);
    let model = (!machine.rotary() && dice.chance(0.5)).then(|| model(&machine, &mut dice));
    Made {
        truth: concealed.iter().map(|c| c.truth(&machine)).collect(),
        recording: Recording::new(format!("machine {seed}"), table, model),
        sort,
        strength,
    }
}

/// The machine as someone identified it: mass and four blocks on the virgin curve, a few percent off.
fn model(machine: &Machine, dice: &mut Dice) -> String {
    let mut off = || 1.0 + dice.between(-0.04, 0.04);
    let lengths = [0.3, 0.8, 2.0, 6.0];
    let mut virgin = machine.law.start();
    let mut curve = Vec::new();
    let (mut s, step) = (0.0, 0.005);
    for length in lengths {
        let mut u = 0.0;
        while s < length {
            u = virgin.step(step, 1.0);
            s += step;
        }
        curve.push(u);
    }
    let slope = |i: usize| match i {
        0 => curve[0] / lengths[0],
        i if i < lengths.len() => {
            ((curve[i] - curve[i - 1]) / (lengths[i] - lengths[i - 1])).max(0.0)
        }
        _ => 0.0,
    };
    let limits: Vec<f64> = (0..lengths.len())
        .map(|i| ((slope(i) - slope(i + 1)) * lengths[i]).max(1e-3))
        .collect();
    let sum: f64 = limits.iter().sum();
    let level = machine.friction * off();
    let blocks: Vec<String> = limits
        .iter()
        .zip(lengths)
        .map(|(limit, length)| {
            // Cut, not rounded: the weights must not sum up to more than one.
            let weight = (limit / sum * 1e6).floor() / 1e6;
            let stiffness = level * weight / (length * machine.presliding);
            format!("  {{ stiffness_N_per_m = {stiffness:?}, weight = {weight:?} }},\n")
        })
        .collect();
    format!(
        "schema = \"preslide.model/1\"\nmotion = \"linear\"\n\n[inertia]\nmass_kg = {:?}\n\n[friction]\nkind = \"gms\"\nbreakaway_N = {level:?}\nblocks = [\n{}]\n",
        machine.inertia * off(),
        blocks.concat()
    )
}

/// Names of clock, position and effort.
fn columns(machine: &Machine) -> Table {
    let names = if machine.rotary() {
        ["t_s", "q_rad", "torque_Nm"]
    } else {
        ["t_s", "x_m", "force_N"]
    };
    Table {
        names: names.map(String::from).to_vec(),
        columns: vec![Vec::new(); 3],
    }
}
