//! What the stage is made of: SI values, each with its source or the word *assumption*.
//!
//! Looked for and not found in public text: the data sheets of the motor, the coupling and the screw's stiffness, and the
//! gearhead's ratio. Where a value is an assumption, it is one that a user is expected to replace.

use super::electrical::ElectricalConfig;
use super::motor::MotorConfig;
use super::range::{StageError, check, not_negative, positive, share};
use preslide::control::Axis;
use preslide_host::paper;
use serde::{Deserialize, Serialize};

/// The axis and its simulation. `Default` is the paper's axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StageConfig {
    /// Control rate \[Hz\]; one [`tick`](super::Stage::tick) is one period. 20 kHz, the project's default.
    pub control_rate_hz: f64,
    /// Integration steps in one control period. 8: the error bound in [`super`] is stated for it.
    pub substeps: u32,
    /// Moving mass, without the rotor \[kg\]. 30 N of weight (paper, "Experimental set-up") / 9.81 m/s².
    pub mass_kg: f64,
    /// The DC motor.
    pub motor: MotorConfig,
    /// Gear, screw and what joins them to the mass.
    pub drive: DriveConfig,
    /// The encoder and its interpolation.
    pub encoder: EncoderConfig,
    /// The supply of the PWM bridge.
    pub supply: SupplyConfig,
    /// The friction truth.
    pub friction: FrictionConfig,
    /// Switching, dead time, temperature and sampling; `None`: duty acts as its mean voltage.
    pub electrical: Option<ElectricalConfig>,
    /// Where it stands when it is switched on \[m\]. 0.
    pub start_m: f64,
    /// Seed of everything random. Equal configurations give equal bits.
    pub seed: u64,
}

/// Gear, ball screw, and the compliance between the rotor and the moving mass, all seen at the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DriveConfig {
    /// Motor revolutions per screw revolution [–]. 1: assumption; the paper has a gearhead and does not give its ratio,
    /// and 1 agrees with the motor period of lead/7 and the 3.9 kg of the project's example model.
    pub gear_ratio: f64,
    /// Screw travel per revolution \[m\]. SKF SH6x2R: 2 mm (paper, Table 1).
    pub screw_lead_m: f64,
    /// Stiffness between rotor and mass: coupling, screw, nut and bearings in series [N/m]. 4 N/µm: assumption, a
    /// locked-rotor resonance of 182 Hz, inside the 50–300 Hz expected of this axis.
    pub stiffness_n_per_m: f64,
    /// Damping beside that stiffness [N·s/m]. 100: assumption, 3 % of critical.
    pub damping_n_s_per_m: f64,
}

/// The linear incremental encoder with its interpolation unit. Heidenhain MT 60k, EXE 102 (paper, Table 1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EncoderConfig {
    /// Travel per count \[m\]. 25 nm: 10 µm, 100-fold interpolation (paper, Table 1), four edges each.
    pub count_m: f64,
    /// Period of the scale \[m\]. 10 µm (paper, Table 1).
    pub period_m: f64,
    /// Interpolation error of order 1, amplitude \[m\]. 50 nm: assumption; with order 2 it stays within ±1 % of the period.
    pub error_order1_m: f64,
    /// Interpolation error of order 2, amplitude \[m\]. 30 nm: assumption.
    pub error_order2_m: f64,
    /// Phases of orders 1 and 2 at the origin \[rad\]. Assumption.
    pub error_phase_rad: [f64; 2],
    /// Count at the origin. 0; near `i32::MAX` it exercises the wrap.
    pub origin_count: i32,
}

/// The supply of the bridge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SupplyConfig {
    /// Mean voltage \[V\]. 6: the motor's nominal voltage (its type code, 006).
    pub voltage_v: f64,
    /// Ripple amplitude \[V\]. 50 mV: assumption.
    pub ripple_v: f64,
    /// Ripple frequency \[Hz\]. 100: assumption, a rectified 50 Hz mains.
    pub ripple_hz: f64,
}

/// One Maxwell-slip block of the virgin curve that the truth is calibrated to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VirginBlock {
    /// Stiffness k [N/m].
    pub stiffness_n_per_m: f64,
    /// Weight α [–]; the weights add up to 1.
    pub weight: f64,
}

/// The friction truth; its law is told in [`super::friction`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FrictionConfig {
    /// Breakaway force F_s \[N\]. 0.9 (paper, "up to ~0.9 N").
    pub breakaway_n: f64,
    /// The virgin curve to have, as piecewise-linear blocks. Table 3 of the paper, ten blocks.
    pub virgin_curve: Vec<VirginBlock>,
    /// Number of smooth elements [–]. 64: assumption; more than six times the largest compensator.
    pub elements: usize,
    /// Share of its yield displacement over which an element is elastic [–]. 0.8: assumption; 1 would be a hard clamp.
    pub elastic_share: f64,
    /// Stribeck drop, (F_s − F_c)/F_s [–]. 0.1: assumption, from the 5–50 % expected; 0 switches it off.
    pub stribeck_drop: f64,
    /// Stribeck velocity v_s [m/s]. 1 mm/s: assumption, from the 0.1–3 mm/s expected.
    pub stribeck_velocity_m_s: f64,
    /// Stribeck exponent δ [–]. 1: assumption.
    pub stribeck_exponent: f64,
    /// Viscous coefficient [N·s/m]. 10: assumption, from the 2–40 expected.
    pub viscous_n_s_per_m: f64,
    /// The part that does not repeat.
    pub variability: VariabilityConfig,
}

/// Friction that does not repeat: every element's force is multiplied by `1 + bound·r`, `|r| ≤ 1`.
///
/// `r` mixes a constant of the repeat, a gain that wanders along the slipped path, and a shape that wanders apart in each
/// of four bands of yields. Assumption throughout, but for the bound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VariabilityConfig {
    /// Largest relative deviation [–]. 0.15 (paper, "dispersion of up to ±15 %"); 0 switches it off.
    pub bound: f64,
    /// Share of the repeat's constant gain in the bound [–]. Assumption.
    pub repeat_share: f64,
    /// Share of the wandering gain in the bound [–]. The rest, 1 − both, is the wandering shape. Assumption.
    pub gain_share: f64,
    /// Slipped path between two independent values \[m\]. 100 µm: assumption. Not below the largest yield displacement D: a
    /// gain wanders by at most 3·bound/correlation per path, and `D·3·bound/correlation ≤ 2·(1 − bound)` keeps slipping
    /// from returning energy.
    pub correlation_m: f64,
}

impl Default for StageConfig {
    fn default() -> Self {
        Self {
            control_rate_hz: 20_000.0,
            substeps: 8,
            mass_kg: 30.0 / 9.81,
            motor: MotorConfig::default(),
            drive: DriveConfig::default(),
            encoder: EncoderConfig::default(),
            supply: SupplyConfig::default(),
            friction: FrictionConfig::default(),
            electrical: None,
            start_m: 0.0,
            seed: 0,
        }
    }
}

impl Default for DriveConfig {
    fn default() -> Self {
        Self {
            gear_ratio: 1.0,
            screw_lead_m: 2e-3,
            stiffness_n_per_m: 4e6,
            damping_n_s_per_m: 100.0,
        }
    }
}

impl Default for EncoderConfig {
    fn default() -> Self {
        Self {
            count_m: 25e-9,
            period_m: 10e-6,
            error_order1_m: 50e-9,
            error_order2_m: 30e-9,
            error_phase_rad: [0.0, 1.0],
            origin_count: 0,
        }
    }
}

impl Default for SupplyConfig {
    fn default() -> Self {
        Self {
            voltage_v: 6.0,
            ripple_v: 0.05,
            ripple_hz: 100.0,
        }
    }
}

impl Default for FrictionConfig {
    fn default() -> Self {
        Self {
            breakaway_n: 0.9,
            virgin_curve: paper::REFERENCE
                .blocks
                .iter()
                .map(|&(stiffness_n_per_m, weight)| VirginBlock {
                    stiffness_n_per_m,
                    weight,
                })
                .collect(),
            elements: 64,
            elastic_share: 0.8,
            stribeck_drop: 0.1,
            stribeck_velocity_m_s: 1e-3,
            stribeck_exponent: 1.0,
            viscous_n_s_per_m: 10.0,
            variability: VariabilityConfig::default(),
        }
    }
}

impl Default for VariabilityConfig {
    fn default() -> Self {
        Self {
            bound: 0.15,
            repeat_share: 0.4,
            gain_share: 0.3,
            correlation_m: 100e-6,
        }
    }
}

impl StageConfig {
    /// The same stage with what an axis is described by: its rate, motor, transmission, count and supply. What no description has
    /// stays: friction, compliance, the encoder's errors.
    #[must_use]
    pub fn on(self, axis: &Axis) -> Self {
        let motor = &axis.motor;
        // The paper's is rounded, and holds the rotor's share: what another differs from it by is added.
        let heavier = axis.feed_forward.mass - Axis::PAPER_AXIS.feed_forward.mass;
        Self {
            control_rate_hz: axis.hardware.rate_hz.into(),
            mass_kg: self.mass_kg + heavier,
            motor: MotorConfig {
                resistance_ohm: motor.resistance,
                inductance_h: motor.inductance,
                torque_constant_nm_per_a: motor.torque_constant,
                ..self.motor
            },
            drive: DriveConfig {
                gear_ratio: motor.gear_ratio,
                screw_lead_m: motor.screw_lead,
                ..self.drive
            },
            encoder: EncoderConfig {
                count_m: axis.encoder.count,
                ..self.encoder
            },
            supply: SupplyConfig {
                voltage_v: motor.supply,
                ..self.supply
            },
            ..self
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first key that is out of range, with the reason and what to set.
    pub fn validate(&self) -> Result<(), StageError> {
        check(
            "control_rate_hz",
            self.control_rate_hz,
            (1e2..=1e6).contains(&self.control_rate_hz),
            "no such controller",
            "within 100..1e6 (10–40 kHz is usual)",
        )?;
        check(
            "substeps",
            f64::from(self.substeps),
            (1..=4096).contains(&self.substeps),
            "the integrator needs at least one step a tick",
            "within 1..4096 (8 for the stated error bound)",
        )?;
        positive("mass_kg", self.mass_kg)?;
        positive("motor.resistance_ohm", self.motor.resistance_ohm)?;
        positive("motor.inductance_h", self.motor.inductance_h)?;
        positive(
            "motor.torque_constant_nm_per_a",
            self.motor.torque_constant_nm_per_a,
        )?;
        positive("motor.rotor_inertia_kg_m2", self.motor.rotor_inertia_kg_m2)?;
        not_negative(
            "motor.damping_nm_s_per_rad",
            self.motor.damping_nm_s_per_rad,
        )?;
        positive("drive.gear_ratio", self.drive.gear_ratio)?;
        positive("drive.screw_lead_m", self.drive.screw_lead_m)?;
        positive("drive.stiffness_n_per_m", self.drive.stiffness_n_per_m)?;
        not_negative("drive.damping_n_s_per_m", self.drive.damping_n_s_per_m)?;
        self.encoder.validate()?;
        positive("supply.voltage_v", self.supply.voltage_v)?;
        check(
            "supply.ripple_v",
            self.supply.ripple_v,
            (0.0..=self.supply.voltage_v).contains(&self.supply.ripple_v),
            "the supply would change its sign",
            "within 0..supply.voltage_v",
        )?;
        not_negative("supply.ripple_hz", self.supply.ripple_hz)?;
        check(
            "start_m",
            self.start_m,
            true,
            "it must be finite",
            "to a number of metres",
        )?;
        if let Some(electrical) = &self.electrical {
            electrical.validate(1.0 / self.control_rate_hz)?;
        }
        self.friction.validate()
    }
}

impl EncoderConfig {
    fn validate(&self) -> Result<(), StageError> {
        positive("encoder.count_m", self.count_m)?;
        positive("encoder.period_m", self.period_m)?;
        not_negative("encoder.error_order1_m", self.error_order1_m)?;
        not_negative("encoder.error_order2_m", self.error_order2_m)?;
        let slope = std::f64::consts::TAU * (self.error_order1_m + 2.0 * self.error_order2_m)
            / self.period_m;
        check(
            "encoder.error_order1_m",
            self.error_order1_m,
            slope < 1.0,
            "with order 2 the count would run backwards over part of the period",
            "so that 2π·(order1 + 2·order2) stays below encoder.period_m",
        )?;
        for phase in self.error_phase_rad {
            check(
                "encoder.error_phase_rad",
                phase,
                true,
                "it must be finite",
                "to an angle",
            )?;
        }
        Ok(())
    }
}

impl FrictionConfig {
    /// Checks every value of the friction truth.
    ///
    /// # Errors
    /// The first key that is out of range, with the reason and what to set.
    pub fn validate(&self) -> Result<(), StageError> {
        positive("friction.breakaway_n", self.breakaway_n)?;
        self.validate_virgin_curve()?;
        self.validate_elements()?;
        self.validate_sliding()?;
        self.validate_variability()
    }

    fn validate_virgin_curve(&self) -> Result<(), StageError> {
        if self.virgin_curve.is_empty() {
            return Err(StageError::Empty {
                key: "friction.virgin_curve",
                remedy: "at least one { stiffness_n_per_m, weight }",
            });
        }
        for block in &self.virgin_curve {
            positive(
                "friction.virgin_curve.stiffness_n_per_m",
                block.stiffness_n_per_m,
            )?;
            positive("friction.virgin_curve.weight", block.weight)?;
        }
        let weights = self.virgin_curve.iter().map(|b| b.weight).sum::<f64>();
        check(
            "friction.virgin_curve.weight",
            weights,
            (weights - 1.0).abs() <= 0.01,
            "the weights must add up to 1",
            "so that they do (to 0.01)",
        )
    }

    fn validate_elements(&self) -> Result<(), StageError> {
        check(
            "friction.elements",
            self.elements as f64,
            (8..=1024).contains(&self.elements),
            "too few for a smooth curve, or too many to be of use",
            "within 8..1024",
        )?;
        check(
            "friction.elastic_share",
            self.elastic_share,
            (0.0..=0.99).contains(&self.elastic_share),
            "yielding must be smooth",
            "within 0..0.99",
        )
    }

    fn validate_sliding(&self) -> Result<(), StageError> {
        check(
            "friction.stribeck_drop",
            self.stribeck_drop,
            (0.0..1.0).contains(&self.stribeck_drop),
            "sliding friction must stay above zero",
            "within 0..1, without 1",
        )?;
        positive("friction.stribeck_velocity_m_s", self.stribeck_velocity_m_s)?;
        check(
            "friction.stribeck_exponent",
            self.stribeck_exponent,
            (0.5..=4.0).contains(&self.stribeck_exponent),
            "no such Stribeck curve is published",
            "within 0.5..4 (1 or 2 is usual)",
        )?;
        not_negative("friction.viscous_n_s_per_m", self.viscous_n_s_per_m)
    }

    /// A gain that wanders must not let the contact return energy.
    fn validate_variability(&self) -> Result<(), StageError> {
        let variability = &self.variability;
        check(
            "friction.variability.bound",
            variability.bound,
            (0.0..=0.4).contains(&variability.bound),
            "a gain that varies so much would return more energy than slipping takes",
            "within 0..0.4",
        )?;
        share(
            "friction.variability.repeat_share",
            variability.repeat_share,
        )?;
        share("friction.variability.gain_share", variability.gain_share)?;
        check(
            "friction.variability.gain_share",
            variability.gain_share,
            variability.repeat_share + variability.gain_share <= 1.0,
            "the shares exceed the bound together",
            "to at most 1 − repeat_share",
        )?;
        let longest = self.longest_yield_m();
        check(
            "friction.variability.correlation_m",
            variability.correlation_m,
            variability.correlation_m >= longest,
            "a gain that wanders faster than the contact yields would return energy",
            "to the largest yield displacement of the elements or above (see FrictionConfig::longest_yield_m)",
        )
    }

    /// Largest yield displacement among the elements \[m\].
    pub fn longest_yield_m(&self) -> f64 {
        self.yield_range_m().1
    }

    /// Shortest and longest yield displacement of the elements \[m\].
    ///
    /// They reach beyond the blocks' `D = α·F_s/k` on both sides: a smooth knee needs neighbours to make a corner.
    pub(super) fn yield_range_m(&self) -> (f64, f64) {
        let (short, long) = self
            .virgin_curve
            .iter()
            .map(|b| b.weight * self.breakaway_n / b.stiffness_n_per_m)
            .fold((f64::INFINITY, 0.0f64), |(s, l), d| (s.min(d), l.max(d)));
        (0.3 * short, 1.2 * long)
    }
}
