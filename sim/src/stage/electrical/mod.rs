//! The electrical stage: a switching bridge, a winding that warms, and a converter that samples at a time.
//!
//! Off by default ([`StageConfig::electrical`](super::StageConfig::electrical) is `None`): duty then acts as its mean voltage and the
//! current is read as it is.
//!
//! **Bridge.** As the NUCLEO's firmware drives it: one half bridge switches, centre-aligned, one PWM period a tick, its pulse in the
//! middle of the tick; the other half bridge rests on its low side. Both gates of the switching half are off for the
//! [dead time](ElectricalConfig::dead_time_s) after either edge. The current then flows through a diode: the low one while it flows
//! out of the half bridge, the high one while it flows in, none at all once it has come to zero. So a current that keeps its direction
//! over the period loses `t_d·(U + 2·U_d)/T` of voltage against it, and one whose ripple crosses zero loses less or nothing.
//!
//! **Winding.** `L·di/dt = v − R·i − K·v_r` between two edges is solved exactly ([`Winding`]); back-EMF and supply are held over an
//! integration step (6.25 µs). `R` is copper's: `R_20·(1 + 0.00393·(θ − 20 °C))`, and the winding warms with its own `R·i²`.
//!
//! **Converter.** The current at one place in the period or the mean of several ([`Sampling`]), with offset, noise, quantisation and a
//! range. On the paper's axis (75 µH, 3.41 Ω: 22 µs in a period of 50 µs) the current falls from 2.5 to 0.1 times its mean within a
//! period at a duty of 0.02, so the place matters: in the middle of the low side's time it is 0.81 of the mean.
//!
//! Left out: the switches' own resistance (it is in `R`), their rise times and delays, ringing, the supply's source impedance, commutation
//! between the segments of the collector, the fall of the torque constant with temperature, and the time that the processor takes
//! before a new duty acts.

mod sense;
mod winding;

use super::motor::MotorConfig;
use super::range::{StageError, check, not_negative, positive};
use sense::Sense;
use serde::{Deserialize, Serialize};
pub use winding::{Bridge, Passed, Winding};

/// Copper's change of resistance [1/K], of the value at 20 °C (IEC 60028: 0.00393 for annealed copper).
pub const COPPER_PER_K: f64 = 0.003_93;

/// Temperature at which the motor's resistance is told \[°C\].
const TOLD_C: f64 = 20.0;

/// Bridge, winding and converter. Values without another source are assumptions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElectricalConfig {
    /// Both gates of a half bridge are off for so long after either edge \[s\]. 100 ns: what the NUCLEO's firmware sets.
    pub dead_time_s: f64,
    /// Forward voltage of a switch's diode \[V\]. 0.7: assumption, a MOSFET's body diode at some 100 mA.
    pub diode_v: f64,
    /// Temperature around the motor \[°C\]. 20: its resistance is then the one told.
    pub ambient_c: f64,
    /// From winding to surroundings [K/W]. 30: assumption, a motor of 17 mm without a flange.
    pub thermal_k_per_w: f64,
    /// Time constant of the winding's temperature \[s\]. 5: as the firmware's own watch assumes.
    pub thermal_s: f64,
    /// The current's converter.
    pub sense: SenseConfig,
}

/// The converter of the current.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SenseConfig {
    /// When in a period.
    pub sampling: Sampling,
    /// Bits of the converter. 12: the STM32G4's.
    pub bits: u32,
    /// Largest current either way \[A\]. 3.2: as the NUCLEO's firmware assumes; a bit is then 1.6 mA.
    pub range_a: f64,
    /// Reading at no current \[A\]. 5 mA, three bits: assumption; the firmware measures it while the axis is disabled.
    pub offset_a: f64,
    /// Noise of a sample, RMS \[A\]. 1.6 mA, one bit: assumption.
    pub noise_a: f64,
}

/// When in a PWM period the current is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Once, at this part of the period after the middle of the pulse (0…½): triggered by the PWM's timer. ½ is the middle of the low
    /// side's time; the NUCLEO's firmware samples where the current is its mean ([`preslide::control::Axis::sampling_phase`]).
    Synchronous(f64),
    /// So many times, evenly spread over the period; their mean is read.
    Oversampled(u32),
    /// Once, anywhere: a converter that runs on its own.
    Unsynchronised,
}

impl Default for ElectricalConfig {
    fn default() -> Self {
        Self {
            dead_time_s: 100e-9,
            diode_v: 0.7,
            ambient_c: TOLD_C,
            thermal_k_per_w: 30.0,
            thermal_s: 5.0,
            sense: SenseConfig::default(),
        }
    }
}

impl Default for SenseConfig {
    fn default() -> Self {
        Self {
            sampling: Sampling::Synchronous(0.5),
            bits: 12,
            range_a: 3.2,
            offset_a: 5e-3,
            noise_a: 1.6e-3,
        }
    }
}

impl ElectricalConfig {
    /// Checks every value; `period_s` is a tick.
    ///
    /// # Errors
    /// The first key that is out of range, with the reason and what to set.
    pub(super) fn validate(&self, period_s: f64) -> Result<(), StageError> {
        check(
            "electrical.dead_time_s",
            self.dead_time_s,
            (0.0..=0.1 * period_s).contains(&self.dead_time_s),
            "the bridge would hardly conduct",
            "within 0..0.1 of a control period (20e-9..1e-6 is usual)",
        )?;
        not_negative("electrical.diode_v", self.diode_v)?;
        check(
            "electrical.ambient_c",
            self.ambient_c,
            (-60.0..=150.0).contains(&self.ambient_c),
            "no motor runs there",
            "within -60..150",
        )?;
        not_negative("electrical.thermal_k_per_w", self.thermal_k_per_w)?;
        positive("electrical.thermal_s", self.thermal_s)?;
        let sense = &self.sense;
        check(
            "electrical.sense.bits",
            f64::from(sense.bits),
            (4..=24).contains(&sense.bits),
            "no such converter",
            "within 4..24",
        )?;
        positive("electrical.sense.range_a", sense.range_a)?;
        check(
            "electrical.sense.offset_a",
            sense.offset_a,
            sense.offset_a.abs() < sense.range_a,
            "it would leave the range",
            "below electrical.sense.range_a",
        )?;
        not_negative("electrical.sense.noise_a", sense.noise_a)?;
        match sense.sampling {
            Sampling::Synchronous(phase) => check(
                "electrical.sense.sampling.synchronous",
                phase,
                (0.0..=0.5).contains(&phase),
                "the period is symmetrical about the pulse",
                "within 0..0.5",
            ),
            Sampling::Oversampled(samples) => check(
                "electrical.sense.sampling.oversampled",
                f64::from(samples),
                (1..=1024).contains(&samples),
                "no such converter",
                "within 1..1024 (8 or 16 is usual)",
            ),
            Sampling::Unsynchronised => Ok(()),
        }
    }
}

/// Bridge, winding and converter at work.
#[derive(Debug, Clone)]
pub(super) struct Electrical {
    config: ElectricalConfig,
    winding: Winding,
    cold_ohm: f64,
    period_s: f64,
    /// Of the winding above its surroundings \[K\].
    warmth_k: f64,
    /// ∫i² dt of this tick [A²·s].
    square: f64,
    /// Back-EMF at the end of the last step \[V\].
    back_emf_v: f64,
    sense: Sense,
}

impl Electrical {
    pub(super) fn new(
        config: &ElectricalConfig,
        motor: &MotorConfig,
        period_s: f64,
        seed: u64,
    ) -> Self {
        let mut electrical = Self {
            winding: Winding::new(motor.inductance_h, motor.resistance_ohm),
            cold_ohm: motor.resistance_ohm,
            period_s,
            warmth_k: 0.0,
            square: 0.0,
            back_emf_v: 0.0,
            sense: Sense::new(config.sense.clone(), period_s, seed),
            config: config.clone(),
        };
        electrical.warm();
        electrical
    }

    /// What passes between two times of the tick \[s\], the back-EMF being `back_emf_v` at their beginning.
    pub(super) fn step(
        &mut self,
        from_s: f64,
        to_s: f64,
        bridge: Bridge,
        back_emf_v: f64,
    ) -> Passed {
        // In the middle of the step, by its last change: what is held is then right to second order.
        let held_v = back_emf_v + 0.5 * (back_emf_v - self.back_emf_v);
        self.back_emf_v = back_emf_v;
        let mut passed = Passed::default();
        let mut at = from_s;
        while let Some(next) = self.sense.due(to_s) {
            passed += self.winding.pass(&bridge, at, next, held_v);
            at = next;
            self.sense.sample(self.winding.current_a);
        }
        passed += self.winding.pass(&bridge, at, to_s, held_v);
        self.square += passed.square;
        passed
    }

    /// The end of a tick: the winding has warmed, the converter has its value.
    pub(super) fn finish(&mut self) {
        let heat_w = self.winding.resistance_ohm() * self.square / self.period_s;
        let settled = heat_w * self.config.thermal_k_per_w;
        self.warmth_k -=
            (settled - self.warmth_k) * (-self.period_s / self.config.thermal_s).exp_m1();
        self.square = 0.0;
        self.warm();
        self.sense.finish();
    }

    fn warm(&mut self) {
        let above = self.config.ambient_c + self.warmth_k - TOLD_C;
        self.winding
            .set_resistance(self.cold_ohm * (1.0 + COPPER_PER_K * above));
    }

    /// The bridge in a tick.
    pub(super) fn bridge(&self, duty: f64, supply_v: f64) -> Bridge {
        Bridge {
            duty,
            supply_v,
            period_s: self.period_s,
            dead_time_s: self.config.dead_time_s,
            diode_v: self.config.diode_v,
        }
    }

    /// Current now \[A\].
    pub(super) fn current_a(&self) -> f64 {
        self.winding.current_a
    }

    /// Resistance now \[Ω\].
    pub(super) fn resistance_ohm(&self) -> f64 {
        self.winding.resistance_ohm()
    }

    /// What the converter read in the last tick \[A\].
    pub(super) fn read_a(&self) -> f64 {
        self.sense.read_a()
    }
}
