//! What a machine conceals: effects of the catalogue, sized by the machine, and strangers.

use std::f64::consts::TAU;

use super::{Dice, Kind, Machine};
use crate::case::{Check, Place, Truth};

/// An effect with its numbers.
#[derive(Clone, Debug)]
pub struct Concealed {
    /// Name in the catalogue, or this module's.
    pub id: &'static str,
    /// Its size: N, N·m, a share of the friction level, or what `id` says.
    pub size: f64,
    /// A place, period, speed, frequency.
    pub at: f64,
    /// A width, or a second length.
    pub width: f64,
    /// A phase, or a drawn number in 0…1 turns.
    pub phase: f64,
    /// When it acts (s).
    pub time: Option<[f64; 2]>,
}

const ANY: [&str; 12] = [
    "constant_force",
    "coulomb_asymmetry",
    "viscous",
    "quadratic_drag",
    "stribeck",
    "position_spring",
    "position_friction",
    "local_friction_spot",
    "periodic_force",
    "periodic_friction",
    "external_vibration",
    "channel_delay",
];
/// One way only, no force is told from friction by its sign.
const ONE_WAY: [&str; 5] = [
    "viscous",
    "quadratic_drag",
    "stribeck",
    "periodic_force",
    "external_vibration",
];
const STRANGERS: [&str; 4] = ["pile_up", "tooth_resonance", "weak_when_hot", "cage_jumps"];

impl Concealed {
    /// One that this machine can show.
    pub fn draw(machine: &Machine, strength: f64, stranger: bool, dice: &mut Dice) -> Self {
        let id = match (stranger, machine.kind) {
            (true, _) => dice.pick(&STRANGERS),
            (_, Kind::Spindle) => dice.pick(&ONE_WAY),
            (_, Kind::Servo) if dice.chance(0.25) => "gravity",
            _ => dice.pick(&ANY),
        };
        let s = strength * dice.scale(0.8, 1.25);
        let (f, v, x) = (machine.friction, machine.speed, machine.travel);
        let sign = dice.pick(&[-1.0, 1.0]);
        let phase = dice.between(0.0, TAU);
        let turn = match machine.kind {
            Kind::Screw => dice.pick(&[5e-3, 10e-3, 20e-3]),
            Kind::Belt => dice.pick(&[40e-3, 60e-3, 90e-3]),
            Kind::Servo => TAU / dice.pick(&[7.0, 12.0, 28.0]),
            Kind::Spindle => TAU / dice.pick(&[1.0, 6.0, 24.0]),
        };
        let (size, at, width) = match id {
            "constant_force" => (0.12 * s * sign * f, 0.0, 0.0),
            "coulomb_asymmetry" => (0.08 * s * sign, 0.0, 0.0),
            "viscous" => (0.25 * s * f / v, 0.0, 0.0),
            "quadratic_drag" => (0.25 * s * f / (v * v), 0.0, 0.0),
            "stribeck" => (0.25 * s, v * dice.scale(0.02, 0.12), 0.0),
            "position_spring" => (0.5 * s * f / x, 0.3 * x * dice.between(-1.0, 1.0), 0.0),
            "gravity" => (0.5 * s * f, phase, 0.0),
            "position_friction" => (0.15 * s * sign, 0.0, 0.0),
            "local_friction_spot" => (
                0.5 * s,
                0.35 * x * dice.between(-1.0, 1.0),
                x * dice.scale(0.02, 0.06),
            ),
            "periodic_force" => (0.07 * s * f, turn, 0.0),
            "periodic_friction" => (0.12 * s, turn, 0.0),
            "external_vibration" => (0.06 * s * f, dice.scale(3.0, 40.0), 0.0),
            "channel_delay" => (s * dice.between(2e-3, 4e-3), 0.0, 0.0),
            "pile_up" => (0.25 * s, x.min(20.0) * dice.between(0.1, 0.25), 0.0),
            "tooth_resonance" => (0.12 * s * f, turn, v * dice.between(0.15, 0.4)),
            "weak_when_hot" => (0.15 * s, dice.between(5.0, 20.0), 0.0),
            _ => (0.2 * s, dice.between(1.0, 5.0), 0.0),
        };
        let from = dice.between(0.1, 0.4) * machine.seconds;
        let time = (id == "external_vibration" && dice.chance(0.5))
            .then_some([from, from + 0.45 * machine.seconds]);
        Self {
            id,
            size,
            at,
            width,
            phase,
            time,
        }
    }

    /// For the judge.
    pub fn truth(&self, machine: &Machine) -> Truth {
        let unit = if machine.rotary() { "rad" } else { "m" };
        let place = match self.id {
            "stribeck" => Some(Place::new("velocity", 0.0, 2.0 * self.at)),
            "local_friction_spot" => Some(Place::new(
                "position",
                self.at - 1.5 * self.width,
                self.at + 1.5 * self.width,
            )),
            _ => self.time.map(|[from, to]| Place::new("time", from, to)),
        };
        let checks = match self.id {
            "periodic_force" | "periodic_friction" => {
                vec![Check::relative("period", self.at, 0.05)]
            }
            "external_vibration" => vec![Check::relative("frequency", self.at, 0.05)],
            "local_friction_spot" => vec![Check::within("position", self.at, 2.0 * self.width)],
            _ => vec![],
        };
        let parameters: Vec<(String, f64)> = match self.id {
            "constant_force" if !machine.rotary() => vec![("force_N".to_owned(), self.size)],
            "viscous" if !machine.rotary() => vec![("viscous_N_s_per_m".to_owned(), self.size)],
            "stribeck" => vec![
                ("level".to_owned(), self.size),
                (format!("velocity_{unit}_s"), self.at),
            ],
            "periodic_force" | "periodic_friction" => vec![(format!("period_{unit}"), self.at)],
            "external_vibration" => vec![("frequency_Hz".to_owned(), self.at)],
            "local_friction_spot" => vec![(format!("position_{unit}"), self.at)],
            "channel_delay" => vec![("delay_s".to_owned(), self.size)],
            _ => vec![],
        };
        Truth {
            checks,
            place,
            parameters,
            ..Truth::named(self.id)
        }
    }
}
