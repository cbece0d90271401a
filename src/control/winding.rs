//! The winding's resistance, followed from the sampled current.

use super::Axis;
use crate::Scalar;
use crate::param::{ParamError, Units, at_most, not_negative, to_gain};

/// 1 in 2⁻¹⁶.
const ONE: i32 = 1 << 16;

/// A current that tells: this part of the rated one. Below, offset, noise and what is left of the dead time are percents of it.
const TELLS: f64 = 0.1;

/// What is looked at before the share changes: as much as the rated current tells in this time (s).
const LOOK: f64 = 1e-3;

/// The most that the share changes at once (2⁻¹⁶).
const CHANGE: i32 = ONE / 128;

/// Follows `ρ`, the winding's resistance over the configured one.
///
/// What is commanded is the voltage `ρ̂·R·i* + k·τ·v*`, with the current `i*` of the force that is asked for and the reference's speed; what
/// the winding makes of it is `ρ·R·i + k·τ·v`. So
///
/// ```text
/// ρ·i = a,   a = ρ̂·i* + (k·τ/R)·(v* − v)        ρ = Σ a·i / Σ i²
/// ```
/// over ticks in which the last command was not cut and the current tells. `v` is measured over a window; by how much it has come on since, the
/// reference's acceleration says. `ρ̂` then goes
/// towards that by a quarter, at most by 1/128, so that a wrong reading cannot move it far. Sums are whole numbers, in codes of the current, in
/// any arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Winding<S> {
    /// Codes of `i*` per unit of force, of `(k·τ/R)·v` per unit of velocity.
    per_force: S,
    per_velocity: S,
    /// Codes of what the velocity comes on by at a unit of acceleration since it was measured.
    per_acceleration: S,
    /// Between these a current tells.
    least: i32,
    most: i32,
    enough: i64,
    /// Bits that `enough` has beyond 12.
    shift: u32,
    /// How far ρ may be from 1 (2⁻¹⁶).
    span: i32,
}

/// What a [`Winding`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindingState {
    /// `a` of the last tick, unless it was cut.
    asked: Option<i32>,
    products: i64,
    squares: i64,
    /// ρ̂ (2⁻¹⁶).
    share: i32,
}

impl WindingState {
    /// As told.
    pub(crate) fn new() -> Self {
        Self {
            asked: None,
            products: 0,
            squares: 0,
            share: ONE,
        }
    }

    /// ρ̂ (2⁻¹⁶).
    pub(crate) fn share(&self) -> i32 {
        self.share
    }

    /// The last command was not what was asked for.
    #[inline]
    pub(crate) fn cut(&mut self) {
        self.asked = None;
    }
}

impl<S: Scalar> Winding<S> {
    /// Of span 0 where the resistance is not followed; `delay` (s) is how old the measured velocity is.
    pub(crate) fn try_new(axis: &Axis, units: Units, delay: f64) -> Result<Self, ParamError> {
        let (motor, hardware) = (&axis.motor, &axis.hardware);
        let span = not_negative("span of the resistance", motor.resistance_span)?;
        at_most("span of the resistance", span, 0.6)?;
        let per_volt = 1.0 / (motor.resistance * hardware.current_code);
        let per_velocity = per_volt * motor.torque_constant * motor.transmission() * units.velocity;
        let rated = axis.watch.current_rated / hardware.current_code;
        let enough = rated * rated * (LOOK / axis.sample_time()).max(1.0);
        let gain = |name, gain| match span {
            0.0 => Ok(S::ZERO),
            _ => to_gain(name, gain),
        };
        Ok(Self {
            per_force: gain(
                "codes of the current per unit of force",
                per_volt / motor.force_per_volt() * units.force,
            )?,
            per_velocity: gain("codes of the current per unit of velocity", per_velocity)?,
            per_acceleration: gain(
                "codes of the current per unit of acceleration",
                per_velocity * delay,
            )?,
            least: libm::ceil(TELLS * rated) as i32,
            most: (2.0 * rated) as i32,
            enough: enough as i64,
            shift: 52 - (enough as i64).leading_zeros().min(52),
            span: (span * f64::from(ONE)) as i32,
        })
    }

    /// It is followed.
    #[inline]
    pub(crate) fn follows(&self) -> bool {
        self.span > 0
    }

    /// Takes the `current` that came of the last tick's command (codes, without offset); the force that makes up for the resistance.
    pub(crate) fn step(
        &self,
        state: &mut WindingState,
        current: i32,
        force: S,
        velocity_error: S,
        acceleration: S,
    ) -> S {
        if let Some(asked) = state.asked
            && current.abs() >= self.least
            && current.abs() <= self.most
        {
            // No tick says more than twice the resistance.
            let most = 2 * current.abs();
            let asked = asked.max(-most).min(most);
            state.products += i64::from(asked) * i64::from(current);
            state.squares += i64::from(current) * i64::from(current);
            if state.squares >= self.enough {
                self.follow(state);
            }
        }
        let made_up = S::from_q16(state.share).mul_input(force);
        let asked = self.per_force.mul_input(made_up);
        let asked = asked.add_input(self.per_velocity.mul_input(velocity_error));
        let asked = asked.sub_input(self.per_acceleration.mul_input(acceleration));
        state.asked = Some(asked.round_to_int());
        made_up
    }

    fn follow(&self, state: &mut WindingState) {
        // `squares` is at most five times 2¹² then, with the last tick, and `products` twice that: nothing below is beyond 31 bits.
        let short = |sum: i64| (sum >> self.shift) as i32;
        let (products, squares) = (short(state.products), short(state.squares));
        let error = (products << 14) - (state.share >> 2) * squares;
        // In 2⁻¹⁴, of which a quarter is as much in 2⁻¹⁶.
        let change = error.checked_div(squares).unwrap_or(0);
        let share = state.share + change.clamp(-CHANGE, CHANGE);
        // Not `clamp`, which links a panic where it cannot see the ends.
        state.share = share.max(ONE - self.span).min(ONE + self.span);
        (state.products, state.squares) = (0, 0);
    }
}
