//! The simulated stage: PWM duty in, encoder count out, and a friction that the compensator was not told.
//!
//! Motor with inductance, gear and screw, coupling compliance, moving mass, encoder with interpolation error, supply
//! ripple, and the friction truth of [`friction`]. Defaults are the paper's axis ([`StageConfig`]).
//!
//! ```
//! use preslide_sim::stage::{Stage, StageConfig};
//! let mut stage = Stage::try_new(StageConfig::default())?;
//! for _ in 0..20_000 {
//!     stage.tick(0.01); // 1 % of the supply, for one second
//! }
//! assert!(stage.truth().position_m > 0.0);
//! # Ok::<(), preslide_sim::stage::StageError>(())
//! ```
//!
//! # Integration and its error
//! Strang splitting, second order: half a kick by friction, external force and concealed effect; the linear part exactly, by
//! a matrix exponential; the contacts exactly over the displacement; half a kick. Nothing stiff is left for the step to
//! resolve, so a wild command does not make it diverge. Randomness is a function of slipped path, not of steps.
//!
//! Bound, on the default axis at 8 steps of 6.25 µs: over 2 s of open-loop motion through pre-sliding, reversals and
//! sliding (0.7 mm, up to 9 mm/s) position is within 0.1 nm and velocity within 10 nm/s of a run at half the step, and the
//! energies add up to 0.01 % of what was supplied. `tests.rs` asserts each (seen: 0.01 nm, 0.4 nm/s, 0.0002 %). A closed
//! loop through a quantised encoder is not so tame: one count decided otherwise moves the paths apart by a count.
//!
//! # Left out
//! Commutation, the dependence of gear losses on load (losses are in the
//! friction truth, at the mass), backlash, temperature of the mechanics.

pub mod concealed;
mod config;
mod dynamics;
pub mod electrical;
mod encoder;
mod energy;
pub mod friction;
mod motor;
mod range;
#[cfg(test)]
mod tests;
mod variability;

use std::f64::consts::TAU;

use concealed::Concealed;
pub use config::{
    DriveConfig, EncoderConfig, FrictionConfig, StageConfig, SupplyConfig, VariabilityConfig,
    VirginBlock,
};
use dynamics::{Coefficients, Flow, LinearState};
use electrical::Electrical;
pub use electrical::{ElectricalConfig, Sampling, SenseConfig};
pub use encoder::{count as encoder_count, interpolated_m};
pub use energy::Energy;
use friction::FrictionTruth;
pub use motor::MotorConfig;
pub use range::StageError;

/// What the controller can measure at the end of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderReading {
    /// Encoder count, wrapping.
    pub count: i32,
    /// Winding current as it is measured \[A\].
    pub current_a: f64,
    /// Supply voltage with its ripple \[V\].
    pub supply_v: f64,
}

/// The true state, for scoring only: no controller may see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Time since the start \[s\].
    pub time_s: f64,
    /// Position of the moving mass \[m\].
    pub position_m: f64,
    /// Velocity of the moving mass [m/s].
    pub velocity_m_s: f64,
    /// Position of the rotor, at the stage \[m\].
    pub rotor_position_m: f64,
    /// Friction, viscous part included; positive when it opposes motion in +x \[N\].
    pub friction_n: f64,
    /// External force and that of the concealed effect, in +x \[N\].
    pub external_n: f64,
}

/// The simulated stage.
pub struct Stage {
    config: StageConfig,
    coefficients: Coefficients,
    flow: Flow,
    step_s: f64,
    friction: FrictionTruth,
    concealed: Option<Concealed>,
    electrical: Option<Electrical>,
    state: LinearState,
    position_m: f64,
    external_n: f64,
    supply_v: f64,
    ticks: u64,
    energy: Energy,
}

impl Stage {
    /// A stage at rest, its contacts without memory.
    ///
    /// # Errors
    /// [`StageError`] naming the first key of `config` that is out of range.
    pub fn try_new(config: StageConfig) -> Result<Self, StageError> {
        config.validate()?;
        let step_s = 1.0 / (config.control_rate_hz * f64::from(config.substeps));
        let coefficients = Coefficients::new(&config);
        Ok(Self {
            flow: Flow::new(&config, &coefficients, step_s),
            coefficients,
            step_s,
            friction: FrictionTruth::try_new(&config.friction, config.seed)?,
            concealed: None,
            electrical: config.electrical.as_ref().map(|electrical| {
                let period_s = 1.0 / config.control_rate_hz;
                Electrical::new(electrical, &config.motor, period_s, config.seed)
            }),
            state: LinearState::default(),
            position_m: config.start_m,
            external_n: 0.0,
            supply_v: config.supply.voltage_v,
            ticks: 0,
            energy: Energy::default(),
            config,
        })
    }

    /// Advances one control period with `duty` held, −1..1 of the supply; beyond it saturates, and NaN is zero.
    ///
    /// The reading is that of the end of the period: what the next interrupt finds in its registers.
    pub fn tick(&mut self, duty: f64) -> EncoderReading {
        let duty = if duty.is_nan() {
            0.0
        } else {
            duty.clamp(-1.0, 1.0)
        };
        for step in 0..self.config.substeps {
            let t = self.time_s() + f64::from(step) * self.step_s;
            let supply_v = self.supply_at(t + 0.5 * self.step_s);
            self.kick();
            self.drift(step, duty, supply_v);
            self.kick();
        }
        if let Some(electrical) = &mut self.electrical {
            electrical.finish();
        }
        self.ticks += 1;
        self.reading()
    }

    /// What the controller can measure now.
    pub fn reading(&self) -> EncoderReading {
        EncoderReading {
            count: encoder::count(&self.config.encoder, self.position_m),
            current_a: match &self.electrical {
                Some(electrical) => electrical.read_a(),
                None => self.state.current_a,
            },
            supply_v: self.supply_at(self.time_s()),
        }
    }

    /// Holds an external force on the moving mass, in +x \[N\]: the micro-tensile machine of the paper.
    ///
    /// # Errors
    /// When it is not finite; the force then stays as it was.
    pub fn set_external_force_n(&mut self, force_n: f64) -> Result<(), StageError> {
        if !force_n.is_finite() {
            return Err(StageError::OutOfRange {
                key: "external force",
                value: force_n,
                reason: "it must be finite",
                remedy: "to a number of newtons",
            });
        }
        self.external_n = force_n;
        Ok(())
    }

    /// Changes the mean supply voltage \[V\]: a sag.
    ///
    /// # Errors
    /// When it is negative or not finite; the supply then stays as it was.
    pub fn set_supply_v(&mut self, voltage_v: f64) -> Result<(), StageError> {
        if !(voltage_v.is_finite() && voltage_v >= 0.0) {
            return Err(StageError::OutOfRange {
                key: "supply voltage",
                value: voltage_v,
                reason: "it must be zero or more, and finite",
                remedy: "to zero or above",
            });
        }
        self.supply_v = voltage_v;
        Ok(())
    }

    /// Multiplies the friction, viscous part left out, by `level` from now on \[–\]: wear, or a spot where it is told by position.
    ///
    /// # Errors
    /// When it is negative or not finite; the level then stays as it was.
    pub fn set_friction_level(&mut self, level: f64) -> Result<(), StageError> {
        if !(level.is_finite() && level >= 0.0) {
            return Err(StageError::OutOfRange {
                key: "friction level",
                value: level,
                reason: "it must be zero or more, and finite",
                remedy: "to zero or above",
            });
        }
        self.friction.set_level(level);
        Ok(())
    }

    /// A stage that hides an effect, as [`Stage::try_new`].
    ///
    /// # Errors
    /// [`StageError`] naming the first key of `config` that is out of range.
    pub fn concealing(config: StageConfig, effect: Concealed) -> Result<Self, StageError> {
        let mut stage = Self::try_new(effect.configure(config))?;
        stage.concealed = Some(effect);
        Ok(stage)
    }

    /// The true state, for scoring only.
    pub fn truth(&self) -> Truth {
        let v = self.state.velocity_m_s;
        Truth {
            time_s: self.time_s(),
            position_m: self.position_m,
            velocity_m_s: v,
            rotor_position_m: self.position_m + self.state.lead_m,
            friction_n: self.friction_n(v) + self.config.friction.viscous_n_s_per_m * v,
            external_n: self.acting_n(),
        }
    }

    /// The friction truth, for scoring only.
    pub fn friction(&self) -> &FrictionTruth {
        &self.friction
    }

    /// Where the energy went.
    pub fn energy(&self) -> Energy {
        let s = self.state;
        Energy {
            stored_j: 0.5
                * (self.config.motor.inductance_h * s.current_a.powi(2)
                    + self.coefficients.rotor_kg * s.rotor_m_s.powi(2)
                    + self.config.mass_kg * s.velocity_m_s.powi(2)
                    + self.config.drive.stiffness_n_per_m * s.lead_m.powi(2)),
            ..self.energy
        }
    }

    /// Time since the start \[s\].
    pub fn time_s(&self) -> f64 {
        // From the tick number, so that an hour does not accumulate rounding.
        self.ticks as f64 / self.config.control_rate_hz
    }

    /// The configuration it was built from.
    pub fn config(&self) -> &StageConfig {
        &self.config
    }

    /// Force of the motor per ampere, at the stage [N/A]; back-EMF per velocity of the rotor [V·s/m].
    pub fn force_constant_n_per_a(&self) -> f64 {
        self.coefficients.force_constant
    }

    /// Rotor inertia as mass at the stage \[kg\].
    pub fn reflected_rotor_kg(&self) -> f64 {
        self.coefficients.rotor_kg
    }

    fn supply_at(&self, t_s: f64) -> f64 {
        let supply = &self.config.supply;
        (self.supply_v + supply.ripple_v * (TAU * supply.ripple_hz * t_s).sin()).max(0.0)
    }

    /// Friction at velocity `v`, viscous part left out \[N\].
    fn friction_n(&self, v: f64) -> f64 {
        let level = self.concealed.map_or(1.0, |c| c.level(self.position_m));
        level * self.friction.force_n(v)
    }

    /// External force and that of the concealed effect \[N\].
    fn acting_n(&self) -> f64 {
        self.external_n - self.concealed.map_or(0.0, |c| c.force_n(self.position_m))
    }

    /// Half a step of the mass under friction and what acts from outside, by the explicit midpoint rule.
    fn kick(&mut self) {
        let v = self.state.velocity_m_s;
        let per_kg = 0.5 * self.step_s / self.config.mass_kg;
        let acting = self.acting_n();
        let middle = v + 0.5 * per_kg * (acting - self.friction_n(v));
        let friction = self.friction_n(middle);
        let after = v + per_kg * (acting - friction);
        // A constant force over a change of velocity does exactly this work.
        let path = 0.25 * self.step_s * (v + after);
        self.energy.external_j += acting * path;
        self.energy.friction_j += friction * path;
        self.state.velocity_m_s = after;
    }

    /// Step number `step` of a tick: the linear part and the contacts.
    fn drift(&mut self, step: u32, duty: f64, supply_v: f64) {
        let before = self.state;
        let (after, dx, winding) = match &mut self.electrical {
            None => {
                let voltage_v = duty * supply_v;
                let (after, dx) = self.flow.step(before, voltage_v);
                let mean = 0.5 * (before.current_a + after.current_a);
                let winding = [
                    self.step_s * voltage_v * mean,
                    self.config.motor.resistance_ohm
                        * self.square(before.current_a, after.current_a),
                ];
                (after, dx, winding)
            }
            Some(electrical) => {
                let back_emf_v = self.coefficients.force_constant * before.rotor_m_s;
                let bridge = electrical.bridge(duty, supply_v);
                let from_s = f64::from(step) * self.step_s;
                let passed = electrical.step(from_s, from_s + self.step_s, bridge, back_emf_v);
                let mean = LinearState {
                    current_a: passed.charge / self.step_s,
                    ..before
                };
                let (mut after, dx) = self.flow.step(mean, 0.0);
                after.current_a = electrical.current_a();
                let heat = electrical.resistance_ohm() * passed.square;
                (after, dx, [passed.work_j, heat])
            }
        };
        self.state = after;
        self.position_m += dx;
        self.friction.advance(dx);
        let slip = |s: LinearState| s.rotor_m_s - s.velocity_m_s;
        let [supplied_j, winding_j] = winding;
        self.energy.supplied_j += supplied_j;
        self.energy.winding_j += winding_j;
        self.energy.viscous_j += self.config.friction.viscous_n_s_per_m
            * self.square(before.velocity_m_s, after.velocity_m_s)
            + self.coefficients.rotor_damping * self.square(before.rotor_m_s, after.rotor_m_s)
            + self.config.drive.damping_n_s_per_m * self.square(slip(before), slip(after));
    }

    /// ∫a² dt over a step in which a goes straight from one value to the other.
    fn square(&self, from: f64, to: f64) -> f64 {
        self.step_s * (from * from + from * to + to * to) / 3.0
    }
}
