//! A machine under its position loop, and what is logged of it.

use std::f64::consts::TAU;

use super::effect::Concealed;
use super::motion::draw;
use super::{Dice, Machine, columns};
use crate::table::Table;

/// Step of the integrator (s), and steps in a tick of the controller.
const STEP_S: f64 = 50e-6;
const STEPS: usize = 20;

/// What strangers and friction that does not repeat remember.
struct Memory {
    wander: f64,
    /// Last reversal and the farthest point since.
    turn: [f64; 2],
    heading: f64,
    heat: f64,
    jumped: f64,
}

impl Memory {
    /// Once a tick, after a way of `dx`.
    fn tick(
        &mut self,
        machine: &Machine,
        concealed: &[Concealed],
        x: f64,
        dx: f64,
        effort: f64,
        dice: &mut Dice,
    ) {
        let kept = (-dx.abs() / (0.02 * machine.travel.min(50.0))).exp();
        self.wander =
            kept * self.wander + machine.wander * (1.0 - kept * kept).sqrt() * dice.normal();
        if (x - self.turn[1]) * self.heading >= 0.0 {
            self.turn[1] = x;
        } else if (x - self.turn[1]).abs() > 3.0 * machine.presliding {
            (self.heading, self.turn) = (-self.heading, [x, x]);
        }
        let tick = STEP_S * STEPS as f64;
        for c in concealed {
            match c.id {
                "weak_when_hot" => {
                    let power = (effort / (1.5 * machine.friction)).powi(2);
                    self.heat += (power - self.heat) * tick / c.at;
                }
                "cage_jumps" if dice.chance(tick / c.at) => self.jumped = 1.0 - self.jumped,
                _ => {}
            }
        }
    }

    /// Friction level and force besides, and the share of the effort that arrives.
    fn act(&self, machine: &Machine, concealed: &[Concealed], t: f64, x: f64, v: f64) -> [f64; 3] {
        let (mut level, mut force, mut arrives) = (1.0 + self.wander, 0.0, 1.0);
        let half = 0.5 * machine.travel;
        for c in concealed {
            if c.time.is_some_and(|[from, to]| t < from || t > to) {
                continue;
            }
            match c.id {
                "constant_force" => force += c.size,
                "coulomb_asymmetry" => level += c.size * (v / (1e-3 * machine.speed)).tanh(),
                "viscous" => force += c.size * v,
                "quadratic_drag" => force += c.size * v * v.abs(),
                "stribeck" => level += c.size * (-v.abs() / c.at).exp(),
                "position_spring" => force += c.size * (x - c.at),
                "gravity" => force += c.size * (x - c.at).sin(),
                "position_friction" => level += c.size * x / half,
                "local_friction_spot" => level += c.size * (-((x - c.at) / c.width).powi(2)).exp(),
                "periodic_force" => force += c.size * (TAU * x / c.at + c.phase).cos(),
                "periodic_friction" => level += c.size * (TAU * x / c.at + c.phase).cos(),
                "external_vibration" => force += c.size * (TAU * c.at * t + c.phase).sin(),
                "pile_up" => level += c.size * (1.0 - (-(x - self.turn[0]).abs() / c.at).exp()),
                "tooth_resonance" => {
                    // Second order, excited by the teeth: amplitude and phase turn over at a speed.
                    let r = v.abs() / c.width;
                    let (re, im) = (1.0 - r * r, 0.3 * r);
                    let gain = 0.3 * r * r / (re * re + im * im).sqrt();
                    force += c.size * gain * (TAU * x / c.at - im.atan2(re)).cos();
                }
                "weak_when_hot" => arrives = 1.0 - 2.0 * c.size * self.heat / (1.0 + self.heat),
                "cage_jumps" => level += c.size * self.jumped,
                _ => {}
            }
        }
        [level.max(0.05), force, arrives]
    }
}

/// Position and effort at every step, from rest.
fn march(machine: &Machine, concealed: &[Concealed], dice: &mut Dice) -> Vec<[f64; 2]> {
    let tick = STEP_S * STEPS as f64;
    let motion = draw(machine, tick, dice);
    let w = TAU * dice.between(8.0, 18.0);
    let j = machine.inertia;
    let mut friction = machine.law.start();
    let mut memory = Memory {
        wander: 0.0,
        turn: [0.0; 2],
        heading: 1.0,
        heat: 0.0,
        jumped: 0.0,
    };
    let (mut x, mut v, mut effort, mut integral) = (0.0, 0.0, 0.0, 0.0);
    // A velocity from counts is smoothed, as every drive does.
    let (mut seen, mut measured, smooth) = (0.0, 0.0, 1.0 - (-3.0 * w * tick).exp());
    // A bristle's own damping, a tenth of critical; nothing while it slides.
    let bristle = 0.2 * (machine.friction / machine.presliding * j).sqrt();
    let (mut before, mut path) = (0.0, Vec::with_capacity(motion.len() * STEPS));
    for [wanted, speed, acceleration] in motion {
        let read = (x / machine.count).round() * machine.count;
        measured += smooth * ((read - seen) / tick - measured);
        seen = read;
        let error = wanted - read;
        integral = (integral + w * w * w / 4.0 * j * error * tick)
            .clamp(-3.0 * machine.friction, 3.0 * machine.friction);
        let command = j * (acceleration + w * w * error + 1.4 * w * (speed - measured)) + integral;
        let start = x;
        for _ in 0..STEPS {
            effort += (command - effort) * STEP_S / 0.4e-3;
            let t = path.len() as f64 * STEP_S;
            let [level, force, arrives] = memory.act(machine, concealed, t, x, v);
            let u = friction.step(v * STEP_S / machine.presliding, level);
            let rate = (u - before) / STEP_S * machine.presliding;
            before = u;
            let held = machine.friction * u + bristle * rate.clamp(-v.abs(), v.abs());
            v += STEP_S * (arrives * effort - held - force) / j;
            x += STEP_S * v;
            path.push([x, effort]);
        }
        memory.tick(machine, concealed, x, x - start, effort, dice);
    }
    path
}

/// What the drive logs: clocks that jitter, rows that get lost, counts and noise.
pub fn record(machine: &Machine, concealed: &[Concealed], dice: &mut Dice) -> Table {
    let path = march(machine, concealed, dice);
    let late = concealed
        .iter()
        .find(|c| c.id == "channel_delay")
        .map_or(0.0, |c| c.size);
    let mut table = columns(machine);
    let every = 1.0 / machine.rate_hz;
    let mut last = 0;
    for row in 1.. {
        let t = every * (f64::from(row) + (machine.jitter * dice.normal()).clamp(-0.4, 0.4));
        let step = (t / STEP_S).round() as usize;
        if step >= path.len() {
            break;
        }
        if step <= last || dice.chance(machine.lost) {
            continue;
        }
        last = step;
        let x = (path[step][0] / machine.count).round() * machine.count;
        let then = step.saturating_sub((late / STEP_S).round() as usize);
        let effort = path[then][1] + machine.noise * machine.friction * dice.normal();
        for (column, value) in table
            .columns
            .iter_mut()
            .zip([step as f64 * STEP_S, x, effort])
        {
            column.push(value);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{STEP_S, march};
    use crate::machines::effect::Concealed;
    use crate::machines::{Dice, Kind, Machine, make};

    /// Every machine moves as it is told, without a loop that rings, and its effort is of the order of its friction.
    #[test]
    fn machines_follow_their_references() {
        for seed in 0..24 {
            let mut dice = Dice::new(seed);
            let machine = Machine::draw(&mut dice);
            let table = make(seed).recording.parts[0].clone();
            let [t, x, effort] = &table.columns[..] else {
                panic!("three columns")
            };
            assert!(t.windows(2).all(|t| t[1] > t[0]));
            let high = x.iter().copied().fold(f64::MIN, f64::max);
            let low = x.iter().copied().fold(f64::MAX, f64::min);
            let share = (effort.iter().map(|f| f * f).sum::<f64>() / effort.len() as f64).sqrt()
                / machine.friction;
            println!(
                "{seed} {:?} {:?}: {} rows, travel {:.3} of {:.3}, effort {share:.2} of friction",
                machine.kind,
                machine.law,
                x.len(),
                high - low,
                machine.travel
            );
            assert!((0.3..6.0).contains(&share));
            let within = machine.kind == Kind::Spindle || high - low < 1.3 * machine.travel;
            assert!(within && high - low > 0.05 * machine.travel);
        }
    }

    /// What the mass does not take is friction within its level, and the effect on top of it: step for step, from the path alone.
    #[test]
    fn an_effort_is_mass_friction_and_what_is_concealed() {
        for (seed, share) in [(3, 0.0), (4, 0.5), (6, -0.5)] {
            let machine = Machine {
                seconds: 10.0,
                ..Machine::draw(&mut Dice::new(seed))
            };
            let force = share * machine.friction;
            let constant = Concealed {
                id: "constant_force",
                size: force,
                at: 0.0,
                width: 0.0,
                phase: 0.0,
                time: None,
            };
            let path = march(&machine, &[constant], &mut Dice::new(1000 + seed));
            let held = path.windows(3).map(|p| {
                let a = (p[2][0] - 2.0 * p[1][0] + p[0][0]) / (STEP_S * STEP_S);
                (p[2][1] - machine.inertia * a - force) / machine.friction
            });
            let mut held: Vec<f64> = held.collect();
            held.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            // A bristle's damping adds to it for a moment after each reversal.
            let most = held[held.len() * 99 / 100].abs();
            let rms = (held.iter().map(|h| h * h).sum::<f64>() / held.len() as f64).sqrt();
            println!("{seed}: at most {most:.3}, RMS {rms:.3} of the friction level");
            // Five deviations of what does not repeat; a bristle's damping while it yields.
            assert!(
                most < 2.0 + 5.0 * machine.wander && rms > 0.3 && rms < 1.0 + 2.0 * machine.wander
            );
        }
    }
}
