//! The stage: motor, mass, friction, encoder and a PID loop that closes them, integrated by velocity Verlet.

use std::f64::consts::TAU;

use super::body::{MOTOR_SHARE, TICK_S};
use super::draw::Draw;
use super::effect::Id;
use super::friction::{Friction, LOAD_N, Now, TEMPERATURE_C};
use super::motion::Reference;
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

/// What does not repeat: friction's level from pass to pass (a gain for each repeat, and a wander along the path), and a
/// coloured force on the motor.
struct Variability {
    repeat: Option<u32>,
    target: f64,
    gain: f64,
    wander: f64,
    x: f64,
    /// Force on the motor (N), and the share of it that is left after a tick.
    disturbance: f64,
    disturbance_kept: f64,
}

impl Variability {
    fn new(scenario: &Scenario) -> Self {
        Variability {
            repeat: None,
            target: 0.0,
            gain: 0.0,
            wander: 0.0,
            x: 0.0,
            disturbance: 0.0,
            disturbance_kept: (-TAU * scenario.noise.disturbance_corner_hz * TICK_S).exp(),
        }
    }

    /// The level of friction (-) and the disturbing force (N) of a tick with the load at `x` (m).
    fn tick(&mut self, scenario: &Scenario, repeat: u32, x: f64, draw: &mut Draw) -> (f64, f64) {
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
        let level = (1.0 + self.gain + self.wander).max(0.3);
        let kept = self.disturbance_kept;
        self.disturbance = kept * self.disturbance
            + noise.disturbance * (1.0 - kept * kept).sqrt() * draw.normal();
        (level, self.disturbance)
    }
}

/// What is measured besides the force: the encoder's reading, temperature and preload.
struct Sensors {
    ideal_encoder: bool,
    preload: f64,
}

impl Sensors {
    fn position(&self, scenario: &Scenario, x: f64, draw: &mut Draw) -> f64 {
        if self.ideal_encoder {
            return x;
        }
        let count = scenario.encoder_count;
        let residual = scenario.noise.interpolation * (TAU * x / super::ENCODER_PERIOD_M).sin();
        let read = x + encoder_error(scenario, x)[0] + residual + 0.2 * count * draw.normal();
        (read / count).round() * count
    }

    fn temperature(scenario: &Scenario, t: f64) -> f64 {
        TEMPERATURE_C + scenario.warming * (1.0 - (-t / scenario.warming_s).exp())
    }

    /// The preload (N), which follows its steps within 0.2 s.
    fn preload(&mut self, scenario: &Scenario, reference: &Reference) -> f64 {
        if scenario.load_varies {
            let step = (reference.segment + 2 * reference.repeat) % 4;
            self.preload += (LOAD_N + 5.0 * f64::from(step) - self.preload) * TICK_S / 0.2;
        }
        self.preload
    }
}

/// A PID loop whose crossover is at the scenario's bandwidth, velocity from a filtered difference.
struct Controller {
    mass: f64,
    kp: f64,
    ki: f64,
    kd: f64,
    smooth: f64,
    integral: f64,
    velocity: f64,
    before: Option<f64>,
}

impl Controller {
    /// Slower with two masses: in the gap, and above the resonance, the loop moves the motor alone.
    fn new(scenario: &Scenario, two_masses: bool) -> Self {
        let w = TAU * scenario.bandwidth_hz * if two_masses { 0.6 } else { 1.0 };
        let mass = scenario.mass;
        Controller {
            mass,
            kp: mass * w * w,
            ki: mass * w * w * w / 5.0,
            kd: 1.6 * mass * w,
            smooth: 1.0 - (-if two_masses { 14.0 } else { 7.0 } * w * TICK_S).exp(),
            integral: 0.0,
            velocity: 0.0,
            before: None,
        }
    }

    /// The force to ask for (N).
    fn command(&mut self, reference: &Reference, tick: &Tick) -> f64 {
        let measured = tick.measured;
        let difference = measured - self.before.unwrap_or(measured);
        self.velocity += self.smooth * (difference / TICK_S - self.velocity);
        self.before = Some(measured);
        let error = reference.x - measured;
        // The drive reports that it saturates, and the integral waits.
        if (tick.commanded - tick.acted).abs() < 0.5 {
            self.integral = (self.integral + self.ki * error * TICK_S).clamp(-4.0, 4.0);
        }
        let command = self.kp * error
            + self.integral
            + self.kd * (reference.v - self.velocity)
            + 0.9 * self.mass * reference.a;
        command.clamp(-12.0, 12.0)
    }
}

/// The current loop, and motor and load behind it, integrated by velocity Verlet.
struct Bodies<'a> {
    scenario: &'a Scenario,
    friction: Friction<'a>,
    two_masses: bool,
    /// Steps in a tick.
    steps: usize,
    /// Force commanded, after the current loop (N).
    commanded: f64,
    /// Position (m), velocity (m/s) and acceleration (m/s²) of each; the load's only where it is a mass of its own.
    motor: [f64; 3],
    load: [f64; 3],
}

impl Bodies<'_> {
    /// The side on which friction acts.
    fn loaded(&self) -> [f64; 3] {
        if self.two_masses {
            self.load
        } else {
            self.motor
        }
    }

    /// One tick that begins at `t` (s), with friction's level and a disturbing force (N) that stay for its length.
    fn tick(&mut self, t: f64, tick: &Tick, command: f64, (level, disturbance): (f64, f64)) {
        let h = TICK_S / self.steps as f64;
        let follow = 1.0 - (-h / CURRENT_LOOP_S).exp();
        let mass = self.scenario.mass;
        for step in 1..=self.steps {
            self.commanded += follow * (command - self.commanded);
            let acted = actuator(self.scenario, self.commanded);
            let t = t + step as f64 * h;
            let (x1, p1) = predicted(self.motor, h);
            if self.two_masses {
                let (x2, p2) = predicted(self.load, h);
                let link = drive(self.scenario, x1 - x2, p1 - p2);
                let now = tick.now(t, [x2, p2, self.load[2]]);
                let resisting = self.friction.step(h, &now, level);
                let m1 = MOTOR_SHARE * mass;
                let m2 = (1.0 - MOTOR_SHARE) * mass;
                self.motor = corrected(self.motor, h, x1, (acted - link - disturbance) / m1);
                self.load = corrected(self.load, h, x2, (link - resisting) / m2);
            } else {
                let now = tick.now(t, [x1, p1, self.motor[2]]);
                let resisting = self.friction.step(h, &now, level);
                let acceleration = (acted - resisting - disturbance) / mass;
                self.motor = corrected(self.motor, h, x1, acceleration);
            }
        }
    }
}

/// Position, and velocity as if the acceleration stayed, after `h` (s).
fn predicted([x, v, a]: [f64; 3], h: f64) -> (f64, f64) {
    (x + h * (v + 0.5 * h * a), v + h * a)
}

/// The state at the new position, with the acceleration that was found there.
fn corrected([_, v, a]: [f64; 3], h: f64, x: f64, acceleration: f64) -> [f64; 3] {
    [x, v + 0.5 * h * (a + acceleration), acceleration]
}

/// Runs the scenario in closed loop; one entry for each tick of its motion.
pub fn march(scenario: &Scenario, marching: Marching) -> Vec<Tick> {
    let two_masses = scenario.effects.iter().any(|e| e.id.needs_two_masses());
    let mut draw = Draw::new(scenario.seed, 2);
    let mut variability = Variability::new(scenario);
    let mut controller = Controller::new(scenario, two_masses);
    let mut sensors = Sensors {
        ideal_encoder: marching.ideal_encoder,
        preload: LOAD_N,
    };
    let mut bodies = Bodies {
        scenario,
        friction: scenario.friction(&scenario.effects),
        two_masses,
        steps: if two_masses {
            2 * marching.steps
        } else {
            marching.steps
        },
        commanded: 0.0,
        motor: [0.0; 3],
        load: [0.0; 3],
    };
    let mut ticks = Vec::with_capacity(scenario.motion.ticks.len());
    for (i, reference) in scenario.motion.ticks.iter().enumerate() {
        let t = i as f64 * TICK_S;
        let tick = Tick {
            motor: bodies.motor,
            load: bodies.loaded(),
            commanded: bodies.commanded,
            acted: actuator(scenario, bodies.commanded),
            measured: sensors.position(scenario, bodies.motor[0], &mut draw),
            temperature: Sensors::temperature(scenario, t),
            preload: sensors.preload(scenario, reference),
        };
        ticks.push(tick);
        let command = controller.command(reference, &tick);
        let unrepeated = if marching.noise {
            variability.tick(scenario, reference.repeat, tick.load[0], &mut draw)
        } else {
            (1.0, 0.0)
        };
        bodies.tick(t, &tick, command, unrepeated);
    }
    ticks
}
