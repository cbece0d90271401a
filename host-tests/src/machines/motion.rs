//! Where a machine is sent: strokes between drawn ends, jogs with rests, sums of sines, speeds held one way. Nothing repeats.

use std::f64::consts::TAU;

use super::{Dice, Kind, Machine};

/// Reference at each tick: position, velocity, acceleration.
pub type Tick = [f64; 3];

/// Follows targets with limited speed and acceleration.
struct Sent {
    ticks: Vec<Tick>,
    step: f64,
    x: f64,
    v: f64,
}

impl Sent {
    fn tick(&mut self, wanted: f64, acceleration: f64) {
        let v =
            self.v + (wanted - self.v).clamp(-acceleration * self.step, acceleration * self.step);
        let a = (v - self.v) / self.step;
        self.x += 0.5 * (self.v + v) * self.step;
        self.v = v;
        self.ticks.push([self.x, v, a]);
    }

    fn go(&mut self, target: f64, speed: f64, acceleration: f64) {
        loop {
            let left = target - self.x;
            if left.abs() < speed * self.step && self.v.abs() < 2.0 * acceleration * self.step {
                break;
            }
            // A little less than it could brake, so as not to go past.
            let wanted = (1.8 * acceleration * left.abs()).sqrt().min(speed);
            self.tick(left.signum() * wanted, acceleration);
        }
    }

    fn hold(&mut self, speed: f64, seconds: f64, acceleration: f64) {
        for _ in 0..(seconds / self.step) as usize {
            self.tick(speed, acceleration);
        }
    }
}

/// The motion of a machine in ticks of `step` (s).
pub fn draw(machine: &Machine, step: f64, dice: &mut Dice) -> Vec<Tick> {
    let mut sent = Sent {
        ticks: Vec::new(),
        step,
        x: 0.0,
        v: 0.0,
    };
    let (a, ticks) = (machine.acceleration, (machine.seconds / step) as usize);
    let half = 0.5 * machine.travel;
    while sent.ticks.len() < ticks {
        if machine.kind == Kind::Spindle {
            let speed = if dice.chance(0.15) {
                0.0
            } else {
                dice.scale(0.02, 1.0) * machine.speed
            };
            sent.hold(speed, dice.between(1.0, 4.0), a);
            continue;
        }
        match dice.pick(&[0, 0, 1, 2]) {
            0 => {
                for _ in 0..4 {
                    let end = dice.between(0.3, 1.0) * half * if sent.x > 0.0 { -1.0 } else { 1.0 };
                    // A slow way is short, or it would last for ever.
                    let speed = machine.speed * dice.scale(0.05, 1.0);
                    let reach = sent.x + (end - sent.x).clamp(-4.0 * speed, 4.0 * speed);
                    sent.go(reach, speed, a);
                }
            }
            1 => {
                for _ in 0..5 {
                    let jog = machine.presliding * dice.scale(0.5, 300.0) * dice.pick(&[-1.0, 1.0]);
                    let target = (sent.x + jog).clamp(-half, half);
                    sent.go(
                        target,
                        (jog.abs() * dice.between(2.0, 6.0)).min(machine.speed),
                        a,
                    );
                    sent.hold(0.0, dice.scale(0.05, 0.6), a);
                }
            }
            _ => sines(&mut sent, machine, dice),
        }
    }
    sent.ticks.truncate(ticks);
    sent.ticks
}

fn sines(sent: &mut Sent, machine: &Machine, dice: &mut Dice) {
    let start = sent.x;
    let room = (0.5 * machine.travel - start.abs()).max(0.05 * machine.travel);
    let lines: Vec<[f64; 3]> = (0..3)
        .map(|_| {
            let rate = TAU * dice.scale(0.15, 3.0);
            let size = (0.3 * machine.speed / rate)
                .min(0.3 * machine.acceleration / rate.powi(2))
                .min(0.3 * room);
            [size, rate, dice.between(0.0, TAU)]
        })
        .collect();
    let seconds = dice.between(4.0, 9.0);
    for i in 0..(seconds / sent.step) as usize {
        let t = i as f64 * sent.step;
        let edge = (t.min(seconds - t) / 1.0).clamp(0.0, 1.0);
        let fade = edge * edge * (3.0 - 2.0 * edge);
        let x = start
            + fade
                * lines
                    .iter()
                    .map(|[size, rate, phase]| size * (rate * t + phase).sin())
                    .sum::<f64>();
        let v = (x - sent.x) / sent.step;
        let a = (v - sent.v) / sent.step;
        (sent.x, sent.v) = (x, v);
        sent.ticks.push([x, v, a]);
    }
    sent.v = 0.0;
}
