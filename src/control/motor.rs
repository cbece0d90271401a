//! From force to PWM codes: DC motor, gear and screw, with supply compensation.

use super::Hardware;
use crate::Scalar;
use crate::param::{ParamError, Units, at_most, fits, not_negative, positive, to_gain, to_scalar};

/// A DC motor that drives a stage through a gear and a screw, and the bridge that feeds it (SI).
///
/// For a rotary axis set `screw_lead` to `2π` (rad per turn); forces are then torques.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motor {
    /// Torque constant `k_M` (N·m/A); in SI the back-EMF constant (V·s/rad) is the same number.
    pub torque_constant: f64,
    /// Terminal resistance `R` (Ω).
    pub resistance: f64,
    /// How far the winding's resistance may be from that (-), 0…0.6, where it is followed from the sampled current: copper changes it by 0.39 %
    /// per K. 0 where it is not, or where the board measures no current.
    pub resistance_span: f64,
    /// Inductance `L` (H), which tells how far the current swings about its mean in a PWM period; 0 where it is not known.
    pub inductance: f64,
    /// Turns of the motor per turn of the screw `n` (-).
    pub gear_ratio: f64,
    /// Travel per turn of the screw (m).
    pub screw_lead: f64,
    /// Share of the motor's power that reaches the stage `η` (-), 0…1.
    pub efficiency: f64,
    /// Supply voltage `U` (V) that the PWM codes are computed for.
    pub supply: f64,
    /// A positive duty moves the axis backward.
    pub reversed: bool,
}

impl Motor {
    /// The axis of the paper's Table 1.
    ///
    /// | | value | source |
    /// |---|---|---|
    /// | motor | Faulhaber 1724 006 SR | Table 1 |
    /// | supply | 6 V | nominal voltage, in the type's name |
    /// | `k_M`, `R` | 6.59 mN·m/A, 3.41 Ω | assumption: the winding's catalogue values, not checked against a sheet |
    /// | `L` | 75 µH | assumption, as above |
    /// | lead | 2 mm | Table 1, SKF SH 6×2 R |
    /// | gear | 1 | assumption: the paper names a gearhead but no ratio |
    /// | `η` | 1 | assumption: what gear and screw lose is part of the friction that is identified |
    pub const PAPER_AXIS: Motor = Motor {
        torque_constant: 6.59e-3,
        resistance: 3.41,
        resistance_span: 0.0,
        inductance: 75e-6,
        gear_ratio: 1.0,
        screw_lead: 2e-3,
        efficiency: 1.0,
        supply: 6.0,
        reversed: false,
    };

    /// Angle of the motor per travel of the stage, `2π·n/lead` (rad/m).
    pub fn transmission(&self) -> f64 {
        2.0 * core::f64::consts::PI * self.gear_ratio / self.screw_lead
    }

    /// Force at the stage per volt at standstill, `η·k_M·2π·n/(lead·R)` (N/V).
    pub fn force_per_volt(&self) -> f64 {
        self.efficiency * self.torque_constant * self.transmission() / self.resistance
    }

    /// What the motor brakes at a held voltage, `η·(k_M·2π·n/lead)²/R` (N·s/m).
    pub fn braking(&self) -> f64 {
        self.force_per_volt() * self.torque_constant * self.transmission()
    }

    /// A PWM period in the winding's time constants, `T·R/L` (-); 0 where the inductance is not known.
    pub(super) fn ripple(&self, period: f64) -> f64 {
        if self.inductance > 0.0 {
            period * self.resistance / self.inductance
        } else {
            0.0
        }
    }

    fn check(&self) -> Result<(), ParamError> {
        positive("torque constant", self.torque_constant)?;
        positive("resistance", self.resistance)?;
        not_negative("inductance", self.inductance)?;
        positive("gear ratio", self.gear_ratio)?;
        positive("screw lead", self.screw_lead)?;
        positive("efficiency", self.efficiency)?;
        at_most("efficiency", self.efficiency, 1.0)?;
        positive("supply voltage", self.supply)?;
        Ok(())
    }
}

/// The motor's inverse: force and velocity to PWM codes.
///
/// `code = (F·R/(η·k_M·τ) + k_M·τ·v)·steps/U·(U/U_measured)`, `τ = 2π·n/lead`.
///
/// `v` is the *reference* velocity: with the measured one the back-EMF term would cancel the damping that the
/// motor lends to the loop. The winding's inductance is left out (75 µH/3.4 Ω settles in 22 µs, half a tick). What the bridge's
/// [dead time](Hardware::dead_time) takes is added to the code.
#[derive(Clone, Copy, Debug)]
pub struct MotorDrive<S> {
    codes_per_force: S,
    codes_per_velocity: S,
    dead: Option<DeadTime<S>>,
}

/// What the bridge's dead time takes from the voltage, in codes.
///
/// At each of a pulse's two edges half of `t_d·(U + 2·U_d)/T` is lost against the direction of the current *at that edge*. Its
/// direction is not measured, since noise would decide it where it matters, but computed from what is commanded: mean current `I`
/// (as voltage `R·I`) and back-EMF `E` follow from force and reference. The ripple that the pulses leave on the mean makes
///
/// ```text
/// R·i = R·I − (1 − β)·(R·I + E)   at the pulse's begin     β = x·e^{−x}/(1 − e^{−x}),  x = T·R/L
/// R·i = R·I + (γ − 1)·(R·I + E)   at its end               γ = x/(1 − e^{−x})
/// ```
/// for short pulses. Where the two differ in sign the losses cancel: that is the ripple band, in which the sign of the mean would be
/// wrong. Across zero each edge's part rises linearly, with slope 1 up to its half: a current so small dies within the dead time
/// and loses less, and a step there would be a gain without end that a dead time told too large turns into a limit cycle.
#[derive(Clone, Copy, Debug)]
struct DeadTime<S> {
    /// Of an edge.
    loss: S,
    /// β and 1 − β, γ and γ − 1.
    begin: [S; 2],
    end: [S; 2],
}

impl<S: Scalar> DeadTime<S> {
    fn try_new(motor: &Motor, hardware: &Hardware) -> Result<Option<Self>, ParamError> {
        if hardware.dead_time == 0.0 {
            return Ok(None);
        }
        let of_period = hardware.dead_time / hardware.sample_time();
        let loss = of_period * (1.0 + 2.0 * hardware.diode_drop / motor.supply);
        let x = motor.ripple(hardware.sample_time());
        let (begin, end) = if x > 0.0 {
            let end = x / -libm::expm1(-x);
            (end * libm::exp(-x), end)
        } else {
            (1.0, 1.0)
        };
        let part = |value| to_scalar("ripple of the current", value);
        Ok(Some(Self {
            loss: to_scalar("dead time", 0.5 * loss * f64::from(hardware.steps))?,
            begin: [part(begin)?, part(1.0 - begin)?],
            end: [part(end)?, part(end - 1.0)?],
        }))
    }

    /// What to add, from `R·I` and `E` in codes.
    #[inline]
    fn codes(&self, current: S, back_emf: S) -> S {
        let [own, other] = self.begin;
        let begin = current.mul_input(own).sub_input(back_emf.mul_input(other));
        let [own, other] = self.end;
        let end = current.mul_input(own).add_input(back_emf.mul_input(other));
        begin.limited(self.loss).add_input(end.limited(self.loss))
    }
}

/// What the code's rounding left over, carried to the next tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Rounding<S> {
    rest: S,
}

impl<S: Scalar> Rounding<S> {
    /// Nothing left over.
    pub fn new() -> Self {
        Self { rest: S::ZERO }
    }
}

impl<S: Scalar> Default for Rounding<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> MotorDrive<S> {
    /// Computes the coefficients for a model in `units`, and the bridge of `hardware`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(motor: &Motor, hardware: &Hardware, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        motor.check()?;
        let steps = f64::from(hardware.steps);
        // The sum of two saturated codes is rounded in `S`.
        fits::<S>("PWM steps", steps)?;
        let codes_per_volt = steps / motor.supply;
        Ok(Self {
            codes_per_force: to_gain(
                "PWM codes per unit of force",
                codes_per_volt / motor.force_per_volt() * units.force,
            )?,
            codes_per_velocity: to_gain(
                "PWM codes per unit of velocity",
                codes_per_volt * motor.torque_constant * motor.transmission() * units.velocity,
            )?,
            dead: DeadTime::try_new(motor, hardware)?,
        })
    }

    /// More codes than the largest force makes at the nominal supply (-); infinite in floats.
    pub(super) fn most(&self) -> f64 {
        let force = self.codes_per_force.to_f64() * S::greatest();
        force.min(S::greatest())
    }

    /// The PWM code for a force at a velocity; `None` where the result is not a number.
    ///
    /// `boost` is nominal over measured supply voltage (-). The part of a code that rounding leaves over is
    /// carried to the next tick (first-order noise shaping): one code of the paper's axis is 4.3 mN,
    /// 0.5 % of its breakaway force, and without the carry that would be the resolution of the force.
    // As a call it would save eight registers, because of the dead time.
    #[inline(always)]
    #[must_use]
    pub fn code(&self, rounding: &mut Rounding<S>, force: S, velocity: S, boost: S) -> Option<i32> {
        let back_emf = self.codes_per_velocity.mul_input(velocity);
        let current = self.codes_per_force.mul_input(force);
        let mut wanted = current.add_input(back_emf).mul_input(boost);
        if let Some(dead) = &self.dead {
            wanted = wanted.add_input(dead.codes(current, back_emf));
        }
        wanted = wanted.add_input(rounding.rest);
        // NaN is the only value that is unlike itself.
        wanted.partial_cmp(&wanted)?;
        let code = wanted.round_to_int();
        rounding.rest = (wanted - S::from_int(code)).limited(S::ONE.half());
        Some(code)
    }
}
