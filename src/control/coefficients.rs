//! From an axis in SI units to the coefficients of a tick, once, outside the interrupt.

use super::winding::Winding;
use super::{
    Axis, Compensator, Encoder, Fade, Limiter, Monitor, MotorDrive, NotchFilter, NotchState, Pace,
    Pid, VelocitySource,
};
use crate::hint::cold_path;
use crate::param::{
    ParamError, fits, nearest, not_negative, reachable, reachable_ticks, to_gain, to_scalar,
};
use crate::scalar::Arithmetic;
use crate::{EncoderScale, Friction, Motion, Scalar, Units};

/// What a tick computes with: validated, scaled, no division left.
///
/// Built where there is time, then handed to [`super::Controller::swap`].
#[derive(Clone, Debug)]
pub struct Coefficients<F: Friction> {
    pub(crate) law: Law<F>,
    pub(crate) machine: Machine<F::Scalar>,
}

/// What makes the force: what is left runs on beside what takes its place.
#[derive(Clone, Debug)]
pub(crate) struct Law<F: Friction> {
    pub(crate) pid: Pid<F::Scalar>,
    pub(crate) notch: Option<NotchFilter<F::Scalar>>,
    pub(crate) compensator: Compensator<F>,
    /// What of the moving mass is fed forward beside the feedback (force per acceleration in velocity units per second).
    mass_beside: F::Scalar,
}

/// What the machine is, and is watched by: it takes effect at once. `Copy`, because a swap in the interrupt copies it as one piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Machine<S> {
    pub(crate) scale: EncoderScale<S>,
    pub(crate) length_per_count: S,
    /// For [`Arithmetic::of_q16`], as the acceleration.
    length_per_q16: S,
    pub(crate) velocity_per_length: S,
    /// Of a change of the reference's speed that is still to be divided by the smoothing.
    acceleration_per_change: S,
    /// The moving mass.
    mass: S,
    pub(crate) motor: MotorDrive<S>,
    /// The nominal supply in whole codes, and what it is of that.
    pub(crate) supply_nominal: i32,
    pub(crate) supply_part: S,
    /// The force of a code at that supply in whole codes.
    force_per_code: S,
    pub(crate) limiter: Limiter,
    /// The largest |code| that is neither cut nor a push to watch.
    pub(crate) gentle: i32,
    pub(crate) monitor: Monitor<S>,
    pub(crate) fade: Fade<S>,
    pub(crate) pace: Pace,
    /// ±1: the counter's direction and the bridge's.
    pub(crate) count_sign: i32,
    pub(crate) code_sign: i32,
    pub(crate) turn: i32,
    /// Ticks without a word of the host; 0 for no end.
    pub(crate) silence: u32,
    pub(crate) winding: Winding<S>,
}

impl<F: Friction> Coefficients<F> {
    /// Validates `axis` and computes the coefficients in `units`, in which `friction` must have been built.
    ///
    /// # Errors
    /// The first parameter that is not finite, out of range, or does not fit the number type.
    pub fn try_new(axis: &Axis, friction: F, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        axis.check()?;
        let sample_time = axis.sample_time();
        let Encoder {
            count,
            window,
            timeout,
            reversed,
            turn,
        } = axis.encoder;
        let hardware = &axis.hardware;
        let pace = Pace::try_new(&axis.limits, axis.grid())?;
        let smoothing = f64::from(pace.smoothing());
        let limiter = Limiter::try_new(axis.duty_limit, hardware.steps.into())?;
        let codes = axis.motor.supply / hardware.supply_code;
        let nominal = libm::ceil(codes);
        let length_per_count: F::Scalar = to_gain("length of a count", count / units.length)?;
        let length_per_q16 = length_per_count.per_q16();
        let monitor =
            Monitor::<F::Scalar>::try_new(axis, units, length_per_q16, limiter.largest())?;
        let motor = MotorDrive::try_new(&axis.motor, hardware, units)?;
        // Else forces would end below the limit and the integral not learn that they are cut, at the highest supply as well.
        reachable(
            "duty limit",
            limiter.largest().into(),
            motor.most() * axis.motor.supply / axis.motor.supply.max(axis.watch.supply_max),
            1.0 / f64::from(hardware.steps),
        )?;
        // What a motion within the limits makes.
        fits::<F::Scalar>("top speed", axis.watch.top_speed / units.velocity)?;
        fits::<F::Scalar>(
            "acceleration limit",
            axis.limits.acceleration / units.velocity,
        )?;
        let acceleration_per_change: F::Scalar = to_gain(
            "acceleration of a count per tick², smoothed,",
            count / (sample_time * sample_time) / units.velocity / smoothing,
        )?;
        let scale = EncoderScale::try_new(count, sample_time, window, timeout, units)?;
        // The velocity is measured d ago, so that `K_d·(v_ref − v)` is `K_d·d·a` in a motion without an error: as much mass.
        let per_mass = units.velocity / units.force;
        let mass = not_negative("moving mass", axis.feed_forward.mass)?;
        // An observed velocity is of now.
        let delay = match F::OBSERVES {
            true => 0.0,
            false => scale.delay() * sample_time,
        };
        let by_delay = match mass > 0.0 {
            true => axis.gains.derivative * delay,
            // Who feeds none forward has what the feedback adds.
            false => 0.0,
        };
        let sign = |reversed| if reversed { -1 } else { 1 };
        let law = Law {
            pid: Pid::try_new(&axis.gains, sample_time, units)?,
            notch: NotchFilter::try_new(&axis.notch, sample_time)?,
            compensator: Compensator::try_new(friction, &axis.feed_forward, units)?,
            // Whatever the difference is, the two that it is of are held to a hundredth.
            mass_beside: nearest(
                "moving mass less the derivative gain times the velocity's delay",
                (mass - by_delay) * per_mass,
            )?,
        };
        let machine = Machine {
            scale,
            length_per_count,
            length_per_q16,
            velocity_per_length: to_gain(
                "velocity per displacement of a tick",
                units.length / sample_time / units.velocity,
            )?,
            acceleration_per_change: acceleration_per_change.per_q16(),
            mass: to_gain("moving mass", mass * per_mass)?,
            force_per_code: nearest(
                "force of a PWM code",
                axis.motor.force_per_volt() * hardware.supply_code * nominal
                    / f64::from(hardware.steps)
                    / units.force,
            )?,
            motor,
            supply_nominal: nominal as i32,
            supply_part: to_scalar("supply voltage in codes", codes / nominal)?,
            gentle: limiter.largest().min(monitor.gentle()),
            limiter,
            monitor,
            fade: Fade::try_new(axis.fade_time, sample_time)?,
            pace,
            count_sign: sign(reversed),
            code_sign: sign(axis.motor.reversed),
            // At most 10⁹, by the check above.
            turn: turn as i32,
            silence: reachable_ticks("silence of the host", axis.silence, sample_time)?,
            winding: Winding::try_new(axis, units, delay)?,
        };
        Ok(Self { law, machine })
    }

    /// There is more to do than an ordinary tick does: a notch, or the winding's resistance to follow.
    #[inline]
    pub(super) fn does_more(&self) -> bool {
        self.law.notch.is_some() || self.machine.winding.follows()
    }

    /// Neither cut nor a push to watch.
    #[inline]
    pub(super) fn is_gentle(&self, code: i32) -> bool {
        // One comparison for both signs.
        code.wrapping_add(self.machine.gentle).cast_unsigned()
            <= 2 * self.machine.gentle.cast_unsigned()
    }

    /// A length from 2⁻¹⁶ counts.
    #[inline]
    pub(super) fn length(&self, q16: i32) -> F::Scalar {
        self.machine.length_per_q16.of_q16(q16)
    }

    /// The reference's acceleration, from the change of its speed (2⁻¹⁶ counts per tick², times the smoothing).
    #[inline]
    pub(super) fn acceleration(&self, q16: i32) -> F::Scalar {
        self.machine.acceleration_per_change.of_q16(q16)
    }

    /// What of a `force` is not spent on the mass.
    #[inline]
    pub(super) fn beside_mass(&self, force: F::Scalar, acceleration: F::Scalar) -> F::Scalar {
        force.sub_input(self.machine.mass.mul_input(acceleration))
    }

    /// The force against friction by this law or the one that is left; its model advances by a tick.
    #[inline(always)]
    pub(super) fn feed_forward(
        &self,
        compensator: &Compensator<F>,
        state: &mut F::State,
        now: &Moment<F::Scalar>,
    ) -> F::Scalar {
        let [reference, measured] = now.places;
        let (place, motion) = match compensator.drive() {
            VelocitySource::Reference => (reference, now.wanted),
            VelocitySource::Measured => {
                cold_path();
                let displacement = self.machine.scale.displacement(now.counts);
                let velocity = now.velocity;
                (
                    measured,
                    Motion {
                        displacement,
                        velocity,
                    },
                )
            }
        };
        // What belongs to a place waits until the place is known.
        if now.located {
            // Whole counts do for maps and ripples, and are exact in `f32` up to 2²⁴ of them.
            let place = F::Scalar::from_int(place).mul_input(self.machine.length_per_count);
            compensator.friction().set_position(state, place);
        }
        compensator.step(state, motion)
    }

    /// The force of so many codes at the measured supply voltage.
    #[inline]
    pub(super) fn force(&self, codes: i32, supply: u16) -> F::Scalar {
        // At least 1 by construction.
        let nominal = self.machine.supply_nominal.cast_unsigned();
        let per_code = self.machine.force_per_code.rate(supply.into(), nominal);
        per_code.mul_input(F::Scalar::from_int(codes))
    }

    /// Nominal over measured supply voltage, the latter within what is healthy.
    #[inline]
    pub(super) fn boost(&self, supply: u16) -> F::Scalar {
        self.machine
            .supply_part
            .rate(self.machine.supply_nominal, supply.into())
    }
}

impl<F: Friction> Law<F> {
    /// The force on the mass that the feedback leaves to be fed forward.
    #[inline]
    pub(super) fn inertial(&self, acceleration: F::Scalar) -> F::Scalar {
        self.mass_beside.mul_input(acceleration)
    }

    /// The force without memory: of the feedback, and on the mass.
    #[inline]
    pub(super) fn immediate(&self, now: &Moment<F::Scalar>) -> F::Scalar {
        let feedback = self.pid.immediate(now.error, now.velocity_error);
        feedback.add_input(self.inertial(now.acceleration))
    }

    /// What the notch takes off [`Law::immediate`].
    ///
    /// Off the feedback without its integral alone. A mode rings by what answers the count: `K_d` and `K_p`; the integral's part is
    /// `K_i/(K_p·ω)` of the latter, next to nothing there, and a force that holds a load is left as it is. What is fed forward answers the
    /// reference, whose smoothing has little at a mode, and would come late. It is taken off before motor and limiter, so that nothing is
    /// added behind the limit, and learners and observers are told the force that acts.
    #[inline(never)]
    pub(super) fn notched(
        &self,
        state: &mut NotchState<F::Scalar>,
        error: F::Scalar,
        velocity_error: F::Scalar,
    ) -> F::Scalar {
        match &self.notch {
            Some(notch) => notch.step(state, self.pid.immediate(error, velocity_error)),
            None => F::Scalar::ZERO,
        }
    }
}

/// What a tick knows before it computes a force.
pub(super) struct Moment<S> {
    pub(super) error: S,
    pub(super) velocity_error: S,
    /// The reference's motion.
    pub(super) wanted: Motion<S>,
    /// What was measured.
    pub(super) counts: i32,
    pub(super) velocity: S,
    /// The reference's, in velocity units per second.
    pub(super) acceleration: S,
    /// The reference's and the measured one (counts).
    pub(super) places: [i32; 2],
    /// Whether they count from the axis's own origin.
    pub(super) located: bool,
}
