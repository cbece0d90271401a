//! Everything that a trial is made of before it is run: the machine, its motion, its noise, its effects.

use super::body::{TICK_S, resonance_hz};
use super::draw::Draw;
use super::effect::{CORNER, Effect, Id, Strength};
use super::friction::{Friction, burst_times};
use super::law::{Hysteresis, LAWS, Law};
use super::motion::Motion;
use super::{Family, Kind};

/// What does not repeat.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Standard deviation of the friction gain from repeat to repeat.
    pub gain: f64,
    /// Standard deviation of the friction level's wander along the path, which no repeat shares …
    pub wander: f64,
    /// … and its correlation length (m).
    pub wander_length: f64,
    /// Force on the motor, first-order coloured: standard deviation (N) …
    pub disturbance: f64,
    /// … and corner (Hz).
    pub disturbance_corner_hz: f64,
    /// White noise of the force reading, standard deviation (N).
    pub reading: f64,
    /// Amplitude of the encoder's interpolation error in every trial (m).
    pub interpolation: f64,
}

/// A machine with its motion, noise and effects.
pub struct Scenario {
    /// Seed of everything here.
    pub seed: u64,
    /// Hysteresis law.
    pub law: Law,
    /// The law with its parameters.
    pub hysteresis: Hysteresis,
    /// Breakaway force (N).
    pub breakaway: f64,
    /// Moving mass (kg).
    pub mass: f64,
    /// Crossover of the position loop (Hz).
    pub bandwidth_hz: f64,
    /// Count of the encoder (m).
    pub encoder_count: f64,
    /// Ticks of the controller in a sample of the recording.
    pub ticks_per_sample: usize,
    /// Rise of the temperature over the recording (K) …
    pub warming: f64,
    /// … and its time constant (s).
    pub warming_s: f64,
    /// The recording has a temperature column.
    pub temperature_recorded: bool,
    /// The preload changes, and the recording has a column of it.
    pub load_varies: bool,
    /// Segments and repeats are numbered in the recording.
    pub numbered: bool,
    /// What does not repeat.
    pub noise: Noise,
    /// Motion asked of the stage.
    pub motion: Motion,
    /// Effects, the one asked for first.
    pub effects: Vec<Effect>,
    /// Blocks `(stiffness (N/m), limit (N))` of the model file.
    pub model_blocks: Vec<(f64, f64)>,
    /// Mass of the model file (kg).
    pub model_mass: f64,
    bursts: Vec<f64>,
}

impl Scenario {
    /// The scenario of a seed. `relative` multiplies the strength of each effect.
    pub fn new(seed: u64, kind: Kind, relative: &[f64]) -> Self {
        let law = LAWS[(seed % LAWS.len() as u64) as usize];
        let mut draw = Draw::new(seed, 0);
        let breakaway = 0.9 * draw.uniform(0.8, 1.25);
        let hysteresis = Hysteresis::draw(law, breakaway, &mut draw);
        let mass = draw.uniform(3.0, 4.0);
        let motion = Motion::draw(&mut draw, TICK_S);
        let duration = motion.ticks.len() as f64 * TICK_S;
        // ±5 to ±15 % of the friction level, as two standard deviations of gain and wander together.
        let spread = 0.5 * draw.uniform(0.05, 0.15);
        let split = draw.uniform(0.2, 0.8);
        let noise = Noise {
            gain: spread * split.sqrt(),
            wander: spread * (1.0 - split).sqrt(),
            wander_length: draw.log_uniform(20e-6, 500e-6),
            disturbance: draw.log_uniform(1e-3, 8e-3),
            disturbance_corner_hz: draw.log_uniform(3.0, 60.0),
            reading: draw.log_uniform(0.5e-3, 3e-3),
            interpolation: draw.uniform(1e-9, 4e-9),
        };
        let has = |id| kind.ids().contains(&id);
        let mut scenario = Scenario {
            seed,
            law,
            hysteresis,
            breakaway,
            mass,
            bandwidth_hz: draw.uniform(15.0, 35.0),
            encoder_count: [25e-9, 50e-9, 100e-9][draw.whole(0, 3)],
            ticks_per_sample: if draw.chance(0.7) { 4 } else { 8 },
            warming: draw.uniform(3.0, 7.0) * draw.sign(),
            warming_s: duration * draw.uniform(0.3, 1.0),
            // Not only where they matter: the column's presence must not give the answer away.
            temperature_recorded: draw.chance(0.3) || has(Id::ThermalDrift),
            load_varies: draw.chance(0.25) || has(Id::LoadDependentFriction),
            numbered: true,
            noise,
            motion,
            effects: Vec::new(),
            model_blocks: Vec::new(),
            model_mass: mass,
            bursts: Vec::new(),
        };
        if let Kind::CleanOf(family) = kind {
            scenario.vary(family);
        }
        for (i, id) in kind.ids().into_iter().enumerate() {
            let strength = kind.strength().factor() * relative.get(i).copied().unwrap_or(1.0);
            // A stream for each effect: its shape does not depend on strength or company.
            let mut own = Draw::new(seed, 16 + id as u64);
            let half_travel = scenario.motion.half_travel;
            let mut effect = Effect::draw(id, strength, half_travel, breakaway, &mut own);
            if id == Id::DriveCompliance {
                effect.values[1] = resonance_hz(mass, effect.values[0]);
            }
            if matches!(kind, Kind::Corner(..)) && CORNER.contains(&id) {
                effect.corner = Some(own.sign() * half_travel * own.uniform(0.5, 0.75));
            }
            scenario.effects.push(effect);
        }
        scenario.bursts = burst_times(&scenario.effects, duration, &mut Draw::new(seed, 3));
        scenario.model(kind, &mut Draw::new(seed, 4));
        scenario
    }

    fn vary(&mut self, family: Family) {
        match family {
            Family::Usual => {}
            Family::Coarse => self.encoder_count = 1e-6,
            Family::Heavy => (self.mass, self.model_mass) = (3.0 * self.mass, 3.0 * self.mass),
            Family::Loose => {
                self.noise.gain *= 2.0;
                self.noise.wander *= 2.0;
            }
            Family::Even => (self.noise.gain, self.noise.wander) = (0.0, 0.0),
            Family::Slow => self.ticks_per_sample = 16,
            Family::Bare => self.numbered = false,
        }
    }

    /// The model file's mass and blocks: six blocks on the true virgin curve, roughly as a user would have
    /// identified them, further off in [`Kind::WrongBaseline`].
    fn model(&mut self, kind: Kind, draw: &mut Draw) {
        let off = if matches!(kind, Kind::WrongBaseline(..)) {
            0.3
        } else {
            0.03
        };
        self.model_mass = self.mass * (1.0 + off * draw.uniform(-1.0, 1.0));
        let scale = 1.0 + off * draw.uniform(-1.0, 1.0);
        let shape = self.effects.iter().find(|e| e.id == Id::PreslidingShape);
        let (blocks, factor) = shape.map_or((6, 1.0), |e| (2, e.values[0]));
        // Corners of the broken line, log-spaced; slopes that do not fall are left out.
        let corner = |i: usize| 1e-6 * 150f64.powf((i + 1) as f64 / blocks as f64);
        let corners: Vec<(f64, f64)> = (0..blocks)
            .map(|i| (corner(i), self.hysteresis.virgin(corner(i))))
            .collect();
        let slope = |i: usize| match (i.checked_sub(1).map(|j| corners[j]), corners.get(i)) {
            (Some((s0, f0)), Some((s1, f1))) => (f1 - f0) / (s1 - s0),
            (None, Some((s, f))) => f / s,
            _ => 0.0,
        };
        self.model_blocks = (0..blocks)
            .map(|i| (factor * (slope(i) - slope(i + 1)), corners[i].0 / factor))
            .filter(|(stiffness, _)| *stiffness > 1.0)
            .map(|(stiffness, yielding)| (stiffness, scale * stiffness * yielding))
            .collect();
    }

    /// Friction at rest with the given effects of this scenario.
    pub fn friction<'a>(&'a self, effects: &'a [Effect]) -> Friction<'a> {
        Friction::new(
            self.hysteresis.clone(),
            effects,
            &self.bursts,
            self.motion.half_travel,
            self.breakaway,
        )
    }

    /// Friction that follows the model file's blocks instead of the law.
    pub fn friction_of_model<'a>(&'a self, effects: &'a [Effect]) -> Friction<'a> {
        Friction::new(
            Hysteresis::of_blocks(&self.model_blocks),
            effects,
            &self.bursts,
            self.motion.half_travel,
            self.breakaway,
        )
    }

    /// Strength in words, for labels.
    pub fn strength_name(kind: Kind) -> &'static str {
        match kind {
            Kind::Clean | Kind::CleanOf(_) => "none",
            _ => Strength::name(kind.strength()),
        }
    }
}
