//! Effects that the stage can hide from its controller and from the diagnosis: the truth of `cargo xtask chain`.
//!
//! The laws stand here in the stage's own words and share no code with the terms that compensate them
//! ([`preslide::effects`]) or the host's ([`preslide_fit::effects`]). With friction `F` and motion in +x resisted by positive forces
//!
//! ```text
//! resistance = m(x)·F + f(x)
//! ```
//! A level `m` multiplies all of the friction, a force `f` is the same both ways. Stribeck friction is the stage's own law with a
//! larger drop ([`super::friction`]), which only what slips feels.

use super::StageConfig;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Half of the travel over which effects are drawn (m): positions, and the length of maps.
pub const HALF_TRAVEL_M: f64 = 2e-3;

/// Kinds of effects, in the words of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A magnet or a bent cover beside the way: `f = A/(1 + ((x − x0)/w)²)`, less its mean over the travel.
    PositionForce,
    /// Cogging: `f = A·cos(2πx/p + φ)`.
    PeriodicForce,
    /// Preload that varies over the travel: `m = 1 + a·tanh((x − x0)/w)`.
    PositionFriction,
    /// A dent or dirt: `m = 1 + a·exp(−((x − x0)/w)²)`.
    LocalFrictionSpot,
    /// A screw or nut that binds once a turn: `m = 1 + a·cos(2πx/p + φ)`.
    PeriodicFriction,
    /// Friction that falls with speed: [`super::FrictionConfig::stribeck_drop`] and its velocity.
    Stribeck,
}

/// Every kind.
pub const KINDS: [Kind; 6] = [
    Kind::PositionForce,
    Kind::PeriodicForce,
    Kind::PositionFriction,
    Kind::LocalFrictionSpot,
    Kind::PeriodicFriction,
    Kind::Stribeck,
];

/// What is concealed, with the parameters of its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Concealed {
    /// Its law.
    pub kind: Kind,
    /// A (N) of a force; a (-) of a level; the share of the breakaway force that is lost at speed (-).
    pub size: f64,
    /// x0 (m); of what is periodic p (m); the Stribeck velocity (m/s).
    pub at: f64,
    /// w (m); of what is periodic φ (rad); nothing of a Stribeck curve.
    pub shape: f64,
}

impl Concealed {
    /// Draws `count` effects: every kind once, in random order, before any comes again.
    ///
    /// | effect | range |
    /// |---|---|
    /// | position_force | ±(0.3…0.6) N, 0.3…0.5 mm wide, within ±1.2 mm; narrower ones take more cosines than the catalogue's maps have |
    /// | periodic_force | 60…120 mN; period 1/7 of the screw's lead (the motor's cogging), 1/3 of it or the lead |
    /// | position_friction | ±(20…40) % over 0.5…1 mm about ±0.5 mm |
    /// | local_friction_spot | 50…100 %, 0.15…0.4 mm wide, within ±1.2 mm |
    /// | periodic_friction | 15…30 %; period the screw's lead or half of it |
    /// | stribeck | drop of 40…60 %, 0.2…0.6 mm/s |
    ///
    /// The upper half of what the design expects of such axes and beyond: what the feedback's integrator does not remove
    /// anyway. A constant force, an asymmetry by direction, which is one to such friction, and a cable's spring are not
    /// among them because it does; an encoder's error is not because the feedback follows the encoder whatever is fed forward.
    pub fn draw(seed: u64, count: usize) -> Vec<Self> {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let mut drawn = Vec::new();
        while drawn.len() < count {
            let mut kinds = KINDS.to_vec();
            while !kinds.is_empty() && drawn.len() < count {
                let kind = kinds.swap_remove(draw.random_range(0..kinds.len()));
                drawn.push(Self::of_kind(kind, &mut draw));
            }
        }
        drawn
    }

    fn of_kind(kind: Kind, draw: &mut ChaCha8Rng) -> Self {
        let mut within = |low: f64, high: f64| draw.random_range(low..high);
        let sign = within(-1.0, 1.0).signum();
        let size = match kind {
            Kind::PositionForce => sign * within(0.3, 0.6),
            Kind::PeriodicForce => within(0.06, 0.12),
            Kind::PositionFriction => sign * within(0.2, 0.4),
            Kind::LocalFrictionSpot => within(0.5, 1.0),
            Kind::PeriodicFriction => within(0.15, 0.3),
            Kind::Stribeck => within(0.4, 0.6),
        };
        let at = match kind {
            Kind::PositionForce | Kind::LocalFrictionSpot => within(-1.2e-3, 1.2e-3),
            Kind::PeriodicForce => 2e-3 / [7.0, 3.0, 1.0][within(0.0, 3.0) as usize % 3],
            Kind::PositionFriction => within(-0.5e-3, 0.5e-3),
            Kind::PeriodicFriction => 2e-3 / [1.0, 2.0][within(0.0, 2.0) as usize % 2],
            Kind::Stribeck => within(0.2e-3, 0.6e-3),
        };
        let shape = match kind {
            Kind::PositionForce => within(0.3e-3, 0.5e-3),
            Kind::PositionFriction => within(0.5e-3, 1e-3),
            Kind::LocalFrictionSpot => within(0.15e-3, 0.4e-3),
            Kind::PeriodicForce | Kind::PeriodicFriction => within(0.0, TAU),
            Kind::Stribeck => 0.0,
        };
        Self {
            kind,
            size,
            at,
            shape,
        }
    }

    /// What the catalogue calls it.
    pub fn id(&self) -> &'static str {
        match self.kind {
            Kind::PositionForce => "position_force",
            Kind::PeriodicForce => "periodic_force",
            Kind::PositionFriction => "position_friction",
            Kind::LocalFrictionSpot => "local_friction_spot",
            Kind::PeriodicFriction => "periodic_friction",
            Kind::Stribeck => "stribeck",
        }
    }

    /// What it is, with its values, for people.
    pub fn words(&self) -> String {
        // Of a force in mN, of a share in %; lengths in mm.
        let (mn, percent) = (1e3 * self.size, 100.0 * self.size.abs());
        let (at, wide) = (1e3 * self.at, 1e3 * self.shape);
        match self.kind {
            Kind::PositionForce => {
                format!("a force of {mn:.0} mN about {at:.2} mm, {wide:.2} mm wide")
            }
            Kind::PeriodicForce => format!("cogging of {mn:.0} mN with a period of {at:.3} mm"),
            Kind::PositionFriction => format!(
                "a friction level that changes by ±{percent:.0} % about {at:.2} mm, over {wide:.2} mm"
            ),
            Kind::LocalFrictionSpot => format!(
                "a spot at {at:.2} mm, {wide:.2} mm wide, with {percent:.0} % more friction"
            ),
            Kind::PeriodicFriction => {
                format!("friction that varies by ±{percent:.0} % with a period of {at:.3} mm")
            }
            Kind::Stribeck => {
                format!("friction that falls by {percent:.0} % with speed, at {at:.2} mm/s")
            }
        }
    }

    /// `(x − x0)/w` of what has a place.
    fn aside(&self, x: f64) -> f64 {
        (x - self.at) / self.shape
    }

    /// `cos(2πx/p + φ)` of what is periodic.
    fn wave(&self, x: f64) -> f64 {
        (TAU * x / self.at + self.shape).cos()
    }

    /// Multiplies the friction at the position `x` (m) (-).
    pub fn level(&self, x: f64) -> f64 {
        match self.kind {
            Kind::PositionFriction => 1.0 + self.size * self.aside(x).tanh(),
            Kind::LocalFrictionSpot => 1.0 + self.size * (-self.aside(x).powi(2)).exp(),
            Kind::PeriodicFriction => 1.0 + self.size * self.wave(x),
            Kind::PositionForce | Kind::PeriodicForce | Kind::Stribeck => 1.0,
        }
    }

    /// Resists motion in +x at the position `x` (m) (N).
    pub fn force_n(&self, x: f64) -> f64 {
        match self.kind {
            Kind::PositionForce => {
                let angle = |x: f64| self.aside(x).atan();
                let whole = self.shape * (angle(HALF_TRAVEL_M) - angle(-HALF_TRAVEL_M));
                let lorentz = 1.0 / (1.0 + self.aside(x).powi(2));
                self.size * (lorentz - whole / (2.0 * HALF_TRAVEL_M))
            }
            Kind::PeriodicForce => self.size * self.wave(x),
            _ => 0.0,
        }
    }

    /// The stage's configuration with it, where it is a matter of that.
    pub fn configure(&self, mut config: StageConfig) -> StageConfig {
        if self.kind == Kind::Stribeck {
            config.friction.stribeck_drop = self.size;
            config.friction.stribeck_velocity_m_s = self.at;
        }
        config
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::Stage;

    #[test]
    fn every_kind_comes_once_before_any_comes_again() {
        let drawn = Concealed::draw(3, 2 * KINDS.len());
        for round in drawn.chunks(KINDS.len()) {
            let mut ids: Vec<&str> = round.iter().map(Concealed::id).collect();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), KINDS.len(), "{round:?}");
        }
        assert_eq!(drawn[..4], Concealed::draw(3, 4));
        assert_ne!(drawn[..4], Concealed::draw(4, 4));
    }

    /// An effect of position gives back what it took, one of friction takes: the stage's energies still add up.
    #[test]
    fn the_energies_of_a_concealing_stage_add_up() {
        for effect in Concealed::draw(1, KINDS.len()) {
            let mut stage = Stage::concealing(StageConfig::default(), effect).expect("valid");
            for tick in 0..40_000 {
                let duty = 0.12 * (TAU * f64::from(tick) / 20_000.0).sin();
                stage.tick(duty);
            }
            let energy = stage.energy();
            let gap = energy.residual_j().abs() / energy.supplied_j;
            assert!(gap < 1e-4, "{effect:?}: {gap}");
            assert!(energy.friction_j > 0.0, "{effect:?}");
        }
    }
}
