//! Position, velocity and disturbance force from counts and the force that acted: a Kalman filter of fixed gains.

use crate::Scalar;
use crate::param::{ParamError, Units, not_negative, positive, to_gain};

/// What an [`Observer`] is built from (SI). The gains are the stationary ones of a Kalman filter; a host computes them
/// (`preslide tune`), since they are the solution of a Riccati equation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObserverSettings {
    /// What of the innovation is added to the position `l₁` (-), 0…1.
    pub position: f64,
    /// To the velocity `l₂` (1/s).
    pub velocity: f64,
    /// To the disturbance `l₃` (N/m or N·m/rad).
    pub disturbance: f64,
    /// Moving mass `m`, the rotor's with it (kg or kg·m²).
    pub mass: f64,
    /// What the motor brakes where it is not as fast as the reference `b` (N·s/m or N·m·s/rad): [`super::Motor::braking`].
    pub braking: f64,
    /// Bound on the disturbance that is compensated (N or N·m).
    pub limit: f64,
    /// Speed (m/s or rad/s) up to twice which a velocity is held.
    pub top_speed: f64,
}

impl ObserverSettings {
    /// For [`super::Axis::PAPER_AXIS`]. The gains are what `preslide tune` proposes for it (asserted by a test of the host).
    pub const PAPER_AXIS: ObserverSettings = ObserverSettings {
        position: 0.068_693,
        velocity: 48.881,
        disturbance: 75_021.0,
        mass: 4.05,
        braking: 125.69,
        limit: 5.0,
        top_speed: 20e-3,
    };
}

/// Parts of a velocity unit at most, as a power of two: 2⁻⁸ of 2⁻¹⁶ mm/s are 0.06 nm/s.
const MOST_PARTS: f64 = 8.0;

/// ```text
/// Δv  = (F − F̂ + b·(v_ref − v̂) − d̂)·T/m          what acted in the last tick; F̂ the model's friction, d̂ what it leaves out
/// x̂⁻ = x̂ + T·(v̂ + Δv/2)     v̂⁻ = v̂ + Δv     d̂⁻ = d̂
/// e   = x − x̂⁻                                      x the position that was counted
/// x̂  = x̂⁻ + l₁·e            v̂ = v̂⁻ + l₂·e    d̂ = d̂⁻ − l₃·e
/// ```
/// The current estimator of a mass under a held force and a disturbance that walks at random: Franklin, Powell, Workman, *Digital
/// Control of Dynamic Systems* (3rd ed., 1998), sections 8.2.4 and 9.4.2. The disturbance is counted as friction is, positive where it
/// opposes motion in the positive direction.
///
/// Positions are counted from the last reading, so that their resolution does not depend on the travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Observer<S> {
    /// `T`, `T/m`: of a velocity in parts.
    travel_per_velocity: S,
    per_force: S,
    /// A part of a velocity unit, a power of two: what a tick adds would vanish in fixed point, and what is rounded down in every tick
    /// would be a force.
    part: S,
    braking: S,
    /// `l₁`; `l₂/l₁` and `l₃/l₁`, which fixed point holds better than the small gains themselves.
    position: S,
    velocity: S,
    disturbance: S,
}

/// What an [`Observer`] knows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObserverState<S> {
    /// Estimated position less the last reading.
    ahead: S,
    /// In the observer's parts.
    fine_velocity: S,
    velocity: S,
    disturbance: S,
    /// The force that acts until the next reading, less the model's friction.
    net: S,
}

impl<S: Scalar> ObserverState<S> {
    /// At rest where the counter stands.
    pub const fn new() -> Self {
        Self {
            ahead: S::ZERO,
            fine_velocity: S::ZERO,
            velocity: S::ZERO,
            disturbance: S::ZERO,
            net: S::ZERO,
        }
    }

    /// Velocity at the last reading.
    #[inline]
    pub fn velocity(&self) -> S {
        self.velocity
    }

    /// Friction that the model leaves out, and every other force that opposes motion in the positive direction.
    #[inline]
    pub fn disturbance(&self) -> S {
        self.disturbance
    }

    /// Estimated position less the last reading.
    #[inline]
    pub fn ahead(&self) -> S {
        self.ahead
    }

    /// Forgets the forces, but not the motion, which goes on without them; one that is not a number is forgotten, too.
    pub(super) fn release(&mut self) {
        self.disturbance = S::ZERO;
        self.net = S::ZERO;
        let known = |value: &S| value.partial_cmp(value).is_some();
        if !(known(&self.ahead) && known(&self.fine_velocity)) {
            *self = Self::new();
        }
    }
}

impl<S: Scalar> Default for ObserverState<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Observer<S> {
    /// Computes the coefficients for the sample time `T` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        settings: &ObserverSettings,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("sample time", sample_time)?;
        // As many as leave room for twice the top speed.
        let room =
            S::greatest() / (2.0 * positive("top speed", settings.top_speed)? / units.velocity);
        let parts = libm::exp2(libm::floor(libm::log2(room)).clamp(0.0, MOST_PARTS));
        let mass = positive("moving mass", settings.mass)?;
        let position = positive("observer's position gain", settings.position)?;
        crate::param::at_most("observer's position gain", position, 1.0)?;
        let velocity = positive("observer's velocity gain", settings.velocity)? / position;
        let disturbance = positive("observer's disturbance gain", settings.disturbance)? / position;
        Ok(Self {
            travel_per_velocity: to_gain(
                "travel of a tick per velocity",
                sample_time * units.velocity / units.length / parts,
            )?,
            per_force: to_gain(
                "velocity that a force adds in a tick",
                sample_time / mass * units.force / units.velocity * parts,
            )?,
            part: to_gain("part of a velocity unit", 1.0 / parts)?,
            braking: to_gain(
                "braking by the motor",
                not_negative("braking by the motor", settings.braking)? * units.velocity
                    / units.force,
            )?,
            position: to_gain("observer's position gain", position)?,
            velocity: to_gain(
                "observer's velocity gain over its position gain",
                velocity * units.length / units.velocity * parts,
            )?,
            disturbance: to_gain(
                "observer's disturbance gain over its position gain",
                disturbance * units.length / units.force,
            )?,
        })
    }

    /// Takes the reading of a tick, `displacement` after the last one.
    #[inline]
    pub fn observe(&self, state: &mut ObserverState<S>, displacement: S) {
        let force = state.net.sub_input(state.disturbance);
        let gained = self.per_force.mul_input(force);
        let mean = state.fine_velocity.add_input(gained.half());
        let travel = self.travel_per_velocity.mul_input(mean);
        let ahead = state.ahead.add_input(travel.sub_input(displacement));
        // `l₁·e`.
        let step = self.position.mul_input(ahead).opposite();
        state.ahead = ahead.add_input(step);
        let gained = gained.add_input(self.velocity.mul_input(step));
        state.fine_velocity = state.fine_velocity.add_input(gained);
        state.velocity = self.part.mul_input(state.fine_velocity);
        let change = self.disturbance.mul_input(step);
        state.disturbance = state.disturbance.sub_input(change);
    }

    /// Takes the force that acts from here on less the model's friction, and by how much the reference is faster than
    /// [`ObserverState::velocity`].
    #[inline]
    pub fn act(&self, state: &mut ObserverState<S>, force: S, velocity_error: S) {
        state.net = force.add_input(self.braking.mul_input(velocity_error));
    }
}
