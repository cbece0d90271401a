//! The stage: motor, mass, friction, encoder and a PID loop that closes them, integrated by velocity Verlet.

use std::f64::consts::TAU;

use super::body::{MOTOR_SHARE, TICK_S};
use super::draw::Draw;
use super::effect::Id;
use super::friction::{Friction, LOAD_N, Now, TEMPERATURE_C};
use super::scenario::Scenario;

/// Time constant of the current loop (s).
const CURRENT_LOOP_S: f64 = 0.3e-3;
/// Stiffness (N/m) and damping (N·s/m) of the contact behind a backlash; the damping serves a compliant
/// drive as well (about 10 % of critical).
const CONTACT: (f64, f64) = (3e6, 120.0);

/// How a scenario is marched; [`Marching::default`] is what trials use.
#[derive(Clone, Copy, Debug)]
pub struct Marching {
    /// Steps of the integrator in a tick.
    pub steps: usize,
    /// The controller reads the true position: for comparing step lengths, which a quantised loop,
    /// chaotic at the scale of a count, does not allow.
    pub ideal_encoder: bool,
    /// Force noise and friction that does not repeat.
    pub noise: bool,
}

impl Default for Marching {
    fn default() -> Self {
        Marching {
            steps: 5,
            ideal_encoder: false,
            noise: true,
        }
    }
}

/// What happened at one tick of the controller.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tick {
    /// Motor side, where the encoder is: position (m), velocity (m/s), acceleration (m/s²).
    pub motor: [f64; 3],
    /// Load side, where friction acts; the same without a compliant drive.
    pub load: [f64; 3],
    /// Force commanded, after the current loop (N).
    pub commanded: f64,
    /// Force that acted (N).
    pub acted: f64,
    /// Encoder reading (m).
    pub measured: f64,
    /// Temperature (°C).
    pub temperature: f64,
    /// Preload (N).
    pub preload: f64,
}

impl Tick {
    /// The state that friction sees, at time `t` (s), from `(x, v, a)` of one side.
    pub fn now(&self, t: f64, side: [f64; 3]) -> Now {
        Now {
            t,
            x: side[0],
            v: side[1],
            temperature: self.temperature,
            load: self.preload,
        }
    }
}

/// Error of the encoder's interpolation at `x` and its first two derivatives by `x`.
pub fn encoder_error(scenario: &Scenario, x: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for effect in scenario.effects.iter().filter(|e| e.id == Id::EncoderError) {
        let [error, period, phase, _] = effect.values;
        let k = TAU / period;
        let (sin, cos) = (k * x + phase).sin_cos();
        sum[0] += error * cos;
        sum[1] -= error * k * sin;
        sum[2] -= error * k * k * cos;
    }
    sum
}

/// The force that acts for a commanded one (N).
fn actuator(scenario: &Scenario, command: f64) -> f64 {
    scenario
        .effects
        .iter()
        .fold(command, |force, effect| match effect.id {
            Id::ActuatorDeadZone => {
                force.signum() * (force.abs() - 0.5 * effect.values[0]).max(0.0)
            }
            Id::ActuatorSaturation => force.clamp(-effect.values[0], effect.values[0]),
            _ => force,
        })
}

/// The force in the drive for a difference of position and velocity between motor and load (N).
fn drive(scenario: &Scenario, apart: f64, speed: f64) -> f64 {
    scenario
        .effects
        .iter()
        .map(|effect| match effect.id {
            Id::DriveCompliance => effect.values[0] * apart + CONTACT.1 * speed,
            Id::Backlash => {
                let pressed = apart - apart.clamp(-0.5 * effect.values[0], 0.5 * effect.values[0]);
                // Damping grows with the indentation and never pulls (Hunt and Crossley 1975).
                let damped =
                    CONTACT.0 * pressed + CONTACT.1 * speed * (pressed.abs() / 1e-7).min(1.0);
                if damped * pressed > 0.0 { damped } else { 0.0 }
            }
            _ => 0.0,
        })
        .sum()
}

/// Friction's level from pass to pass: a gain for each repeat, and a wander along the path.
struct Variability {
    repeat: Option<u32>,
    target: f64,
    gain: f64,
    wander: f64,
    x: f64,
}

impl Variability {
    fn tick(&mut self, scenario: &Scenario, repeat: u32, x: f64, draw: &mut Draw) -> f64 {
        let noise = &scenario.noise;
        if self.repeat != Some(repeat) {
            self.target = noise.gain * draw.normal();
            if self.repeat.is_none() {
                self.gain = self.target;
                self.wander = noise.wander * draw.normal();
            }
            self.repeat = Some(repeat);
        }
        // The gain moves to its new value within 0.2 s: friction does not jump.
        self.gain += (self.target - self.gain) * TICK_S / 0.2;
        let kept = (-(x - self.x).abs() / noise.wander_length).exp();
        self.wander =
            kept * self.wander + noise.wander * (1.0 - kept * kept).sqrt() * draw.normal();
        self.x = x;
        1.0 + self.gain + self.wander
    }
}

/// Runs the scenario in closed loop; one entry for each tick of its motion.
pub fn march(scenario: &Scenario, marching: Marching) -> Vec<Tick> {
    let two_masses = scenario.effects.iter().any(|e| e.id.needs_two_masses());
    let steps = if two_masses {
        2 * marching.steps
    } else {
        marching.steps
    };
    let h = TICK_S / steps as f64;
    let follow = 1.0 - (-h / CURRENT_LOOP_S).exp();
    let (m1, m2) = if two_masses {
        (
            MOTOR_SHARE * scenario.mass,
            (1.0 - MOTOR_SHARE) * scenario.mass,
        )
    } else {
        (scenario.mass, 0.0)
    };
    let mut draw = Draw::new(scenario.seed, 2);
    let mut friction: Friction = scenario.friction(&scenario.effects);
    let mut variability = Variability {
        repeat: None,
        target: 0.0,
        gain: 0.0,
        wander: 0.0,
        x: 0.0,
    };
    let noise = &scenario.noise;
    let disturbance_kept = (-TAU * noise.disturbance_corner_hz * TICK_S).exp();
    let mut disturbance = 0.0;

    // Gains of a PID whose crossover is at `bandwidth`, velocity from a filtered difference.
    // Slower with two masses: in the gap, and above the resonance, the loop moves the motor alone.
    let w = TAU * scenario.bandwidth_hz * if two_masses { 0.6 } else { 1.0 };
    let (kp, ki, kd) = (
        scenario.mass * w * w,
        scenario.mass * w * w * w / 5.0,
        1.6 * scenario.mass * w,
    );
    let smooth = 1.0 - (-if two_masses { 14.0 } else { 7.0 } * w * TICK_S).exp();
    let (mut integral, mut velocity, mut before) = (0.0, 0.0, None);

    let (mut x1, mut v1, mut a1, mut x2, mut v2, mut a2) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut commanded = 0.0;
    let mut preload = LOAD_N;
    let mut ticks = Vec::with_capacity(scenario.motion.ticks.len());
    for (i, reference) in scenario.motion.ticks.iter().enumerate() {
        let t = i as f64 * TICK_S;
        let count = scenario.encoder_count;
        let measured = if marching.ideal_encoder {
            x1
        } else {
            let residual = noise.interpolation * (TAU * x1 / super::ENCODER_PERIOD_M).sin();
            let read = x1 + encoder_error(scenario, x1)[0] + residual + 0.2 * count * draw.normal();
            (read / count).round() * count
        };
        let temperature =
            TEMPERATURE_C + scenario.warming * (1.0 - (-t / scenario.warming_s).exp());
        if scenario.load_varies {
            let step = (reference.segment + 2 * reference.repeat) % 4;
            preload += (LOAD_N + 5.0 * f64::from(step) - preload) * TICK_S / 0.2;
        }
        let tick = Tick {
            motor: [x1, v1, a1],
            load: if two_masses {
                [x2, v2, a2]
            } else {
                [x1, v1, a1]
            },
            commanded,
            acted: actuator(scenario, commanded),
            measured,
            temperature,
            preload,
        };
        ticks.push(tick);

        velocity += smooth * ((measured - before.unwrap_or(measured)) / TICK_S - velocity);
        before = Some(measured);
        let error = reference.x - measured;
        // The drive reports that it saturates, and the integral waits.
        if (tick.commanded - tick.acted).abs() < 0.5 {
            integral = (integral + ki * error * TICK_S).clamp(-4.0, 4.0);
        }
        let command = kp * error
            + integral
            + kd * (reference.v - velocity)
            + 0.9 * scenario.mass * reference.a;
        let command = command.clamp(-12.0, 12.0);

        let mut level = 1.0;
        if marching.noise {
            level = variability
                .tick(scenario, reference.repeat, tick.load[0], &mut draw)
                .max(0.3);
            disturbance = disturbance_kept * disturbance
                + noise.disturbance
                    * (1.0 - disturbance_kept * disturbance_kept).sqrt()
                    * draw.normal();
        }
        for step in 1..=steps {
            commanded += follow * (command - commanded);
            let acted = actuator(scenario, commanded);
            let t = t + step as f64 * h;
            x1 += h * (v1 + 0.5 * h * a1);
            let p1 = v1 + h * a1;
            if two_masses {
                x2 += h * (v2 + 0.5 * h * a2);
                let p2 = v2 + h * a2;
                let link = drive(scenario, x1 - x2, p1 - p2);
                let resisting = friction.step(h, &tick.now(t, [x2, p2, a2]), level);
                let n1 = (acted - link - disturbance) / m1;
                let n2 = (link - resisting) / m2;
                v1 += 0.5 * h * (a1 + n1);
                v2 += 0.5 * h * (a2 + n2);
                (a1, a2) = (n1, n2);
            } else {
                let resisting = friction.step(h, &tick.now(t, [x1, p1, a1]), level);
                let n1 = (acted - resisting - disturbance) / m1;
                v1 += 0.5 * h * (a1 + n1);
                a1 = n1;
            }
        }
    }
    ticks
}
