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

/// What is concealed, with its parameters in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Concealed {
    /// A magnet or a bent cover beside the way: `f = A/(1 + ((x − x0)/w)²)`, less its mean over the travel.
    PositionForce {
        /// A (N).
        force_n: f64,
        /// x0 (m).
        position_m: f64,
        /// w (m).
        width_m: f64,
    },
    /// Cogging: `f = A·cos(2πx/p + φ)`.
    PeriodicForce {
        /// A (N).
        force_n: f64,
        /// p (m).
        period_m: f64,
        /// φ (rad).
        phase_rad: f64,
    },
    /// Preload that varies over the travel: `m = 1 + a·tanh((x − x0)/w)`.
    PositionFriction {
        /// a (-).
        level: f64,
        /// x0 (m).
        position_m: f64,
        /// w (m).
        width_m: f64,
    },
    /// A dent or dirt: `m = 1 + a·exp(−((x − x0)/w)²)`.
    LocalFrictionSpot {
        /// a (-).
        level: f64,
        /// x0 (m).
        position_m: f64,
        /// w (m).
        width_m: f64,
    },
    /// A screw or nut that binds once a turn: `m = 1 + a·cos(2πx/p + φ)`.
    PeriodicFriction {
        /// a (-).
        level: f64,
        /// p (m).
        period_m: f64,
        /// φ (rad).
        phase_rad: f64,
    },
    /// Friction that falls with speed: [`super::FrictionConfig::stribeck_drop`] and its velocity.
    Stribeck {
        /// Share of the breakaway force that is lost at speed (-).
        drop: f64,
        /// v_s (m/s).
        velocity_m_s: f64,
    },
}

/// Kinds of concealed effects.
pub const KINDS: usize = 6;

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
            let mut kinds: Vec<usize> = (0..KINDS).collect();
            while !kinds.is_empty() && drawn.len() < count {
                let kind = kinds.swap_remove(draw.random_range(0..kinds.len()));
                drawn.push(Self::of_kind(kind, &mut draw));
            }
        }
        drawn
    }

    fn of_kind(kind: usize, draw: &mut ChaCha8Rng) -> Self {
        let mut within = |low: f64, high: f64| draw.random_range(low..high);
        let sign = within(-1.0, 1.0).signum();
        match kind {
            0 => Self::PositionForce {
                force_n: sign * within(0.3, 0.6),
                position_m: within(-1.2e-3, 1.2e-3),
                width_m: within(0.3e-3, 0.5e-3),
            },
            1 => Self::PeriodicForce {
                force_n: within(0.06, 0.12),
                period_m: 2e-3 / [7.0, 3.0, 1.0][within(0.0, 3.0) as usize % 3],
                phase_rad: within(0.0, TAU),
            },
            2 => Self::PositionFriction {
                level: sign * within(0.2, 0.4),
                position_m: within(-0.5e-3, 0.5e-3),
                width_m: within(0.5e-3, 1e-3),
            },
            3 => Self::LocalFrictionSpot {
                level: within(0.5, 1.0),
                position_m: within(-1.2e-3, 1.2e-3),
                width_m: within(0.15e-3, 0.4e-3),
            },
            4 => Self::PeriodicFriction {
                level: within(0.15, 0.3),
                period_m: 2e-3 / [1.0, 2.0][within(0.0, 2.0) as usize % 2],
                phase_rad: within(0.0, TAU),
            },
            _ => Self::Stribeck {
                drop: within(0.4, 0.6),
                velocity_m_s: within(0.2e-3, 0.6e-3),
            },
        }
    }

    /// What the catalogue calls it.
    pub fn id(&self) -> &'static str {
        match self {
            Self::PositionForce { .. } => "position_force",
            Self::PeriodicForce { .. } => "periodic_force",
            Self::PositionFriction { .. } => "position_friction",
            Self::LocalFrictionSpot { .. } => "local_friction_spot",
            Self::PeriodicFriction { .. } => "periodic_friction",
            Self::Stribeck { .. } => "stribeck",
        }
    }

    /// What it is, with its values, for people.
    pub fn words(&self) -> String {
        let (mm, mn, percent) = (1e3, 1e3, 100.0);
        match *self {
            Self::PositionForce {
                force_n,
                position_m,
                width_m,
            } => format!(
                "a force of {:.0} mN about {:.2} mm, {:.2} mm wide",
                force_n * mn,
                position_m * mm,
                width_m * mm
            ),
            Self::PeriodicForce {
                force_n, period_m, ..
            } => format!(
                "cogging of {:.0} mN with a period of {:.3} mm",
                force_n * mn,
                period_m * mm
            ),
            Self::PositionFriction {
                level,
                position_m,
                width_m,
            } => format!(
                "a friction level that changes by ±{:.0} % about {:.2} mm, over {:.2} mm",
                level.abs() * percent,
                position_m * mm,
                width_m * mm
            ),
            Self::LocalFrictionSpot {
                level,
                position_m,
                width_m,
            } => format!(
                "a spot at {:.2} mm, {:.2} mm wide, with {:.0} % more friction",
                position_m * mm,
                width_m * mm,
                level * percent
            ),
            Self::PeriodicFriction {
                level, period_m, ..
            } => format!(
                "friction that varies by ±{:.0} % with a period of {:.3} mm",
                level * percent,
                period_m * mm
            ),
            Self::Stribeck { drop, velocity_m_s } => format!(
                "friction that falls by {:.0} % with speed, at {:.2} mm/s",
                drop * percent,
                velocity_m_s * mm
            ),
        }
    }

    /// Multiplies the friction at the position `x` (m) (-).
    pub fn level(&self, x: f64) -> f64 {
        match *self {
            Self::PositionFriction {
                level,
                position_m,
                width_m,
            } => 1.0 + level * ((x - position_m) / width_m).tanh(),
            Self::LocalFrictionSpot {
                level,
                position_m,
                width_m,
            } => 1.0 + level * (-((x - position_m) / width_m).powi(2)).exp(),
            Self::PeriodicFriction {
                level,
                period_m,
                phase_rad,
            } => 1.0 + level * (TAU * x / period_m + phase_rad).cos(),
            _ => 1.0,
        }
    }

    /// Resists motion in +x at the position `x` (m) (N).
    pub fn force_n(&self, x: f64) -> f64 {
        match *self {
            Self::PositionForce {
                force_n,
                position_m,
                width_m,
            } => {
                let lorentz = |x: f64| 1.0 / (1.0 + ((x - position_m) / width_m).powi(2));
                let angle = |x: f64| ((x - position_m) / width_m).atan();
                let whole = width_m * (angle(HALF_TRAVEL_M) - angle(-HALF_TRAVEL_M));
                force_n * (lorentz(x) - whole / (2.0 * HALF_TRAVEL_M))
            }
            Self::PeriodicForce {
                force_n,
                period_m,
                phase_rad,
            } => force_n * (TAU * x / period_m + phase_rad).cos(),
            _ => 0.0,
        }
    }

    /// The stage's configuration with it, where it is a matter of that.
    pub fn configure(&self, mut config: StageConfig) -> StageConfig {
        if let Self::Stribeck { drop, velocity_m_s } = *self {
            config.friction.stribeck_drop = drop;
            config.friction.stribeck_velocity_m_s = velocity_m_s;
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
        let drawn = Concealed::draw(3, 2 * KINDS);
        for round in drawn.chunks(KINDS) {
            let mut ids: Vec<&str> = round.iter().map(Concealed::id).collect();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), KINDS, "{round:?}");
        }
        assert_eq!(drawn[..4], Concealed::draw(3, 4));
        assert_ne!(drawn[..4], Concealed::draw(4, 4));
    }

    /// An effect of position gives back what it took, one of friction takes: the stage's energies still add up.
    #[test]
    fn the_energies_of_a_concealing_stage_add_up() {
        for effect in Concealed::draw(1, KINDS) {
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
