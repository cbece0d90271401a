//! The tick.

use super::reference::saturate;
use super::{
    Coefficients, Condition, FadeState, Fault, Move, PidState, Reference, Rounding, Saturation,
    Suspicion,
};
use crate::encoder::EdgeTiming;
use crate::{Count, CountTracker, Friction, Motion, Scalar};

/// What a board measures in a tick, raw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<C> {
    /// The quadrature counter.
    pub count: C,
    /// The supply voltage in the codes that [`super::Settings::supply_code`] scales.
    pub supply: u16,
    /// This tick started after the next one was due.
    pub late: bool,
}

/// What a tick decided, raw, for the PWM and the telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// PWM code, within ± the limiter's; 0 in the safe state.
    pub code: i32,
    /// Position from the first reading (counts).
    pub position: i64,
    /// Reference position (2⁻¹⁶ counts).
    pub reference: i64,
    /// Why the PWM is off.
    pub fault: Option<Fault>,
}

/// Encoder count in, PWM code out.
///
/// `count → displacement → reference → PID + feed-forward → limiter → code`, with the friction model `F` and its
/// number type. Nothing here divides by a parameter, allocates or panics; the one division is by a measured time
/// ([`crate::EncoderScale`]), another by the measured supply, both single-precision and held above zero.
#[derive(Clone, Debug)]
pub struct Controller<F: Friction, C> {
    coefficients: Coefficients<F>,
    tracker: CountTracker<C>,
    timing: EdgeTiming,
    reference: Reference<F::Scalar>,
    pid: PidState<F::Scalar>,
    friction: F::State,
    rounding: Rounding<F::Scalar>,
    fade: FadeState<F::Scalar>,
    suspicion: Suspicion,
    cut: Saturation,
    /// The last tick's force before the motor, and what the PID saw.
    force: F::Scalar,
    errors: (F::Scalar, F::Scalar),
    code: i32,
    fault: Option<Fault>,
}

impl<F: Friction, C: Count> Controller<F, C> {
    /// Stands at position 0 with the counter at `first`.
    pub fn new(coefficients: Coefficients<F>, first: C) -> Self {
        Self {
            tracker: CountTracker::new(first),
            timing: coefficients.scale.at_rest(),
            reference: Reference::at(0),
            pid: PidState::new(),
            friction: coefficients.compensator.friction().at_rest(),
            rounding: Rounding::new(),
            fade: FadeState::new(),
            suspicion: Suspicion::default(),
            cut: Saturation::None,
            force: F::Scalar::ZERO,
            errors: (F::Scalar::ZERO, F::Scalar::ZERO),
            code: 0,
            fault: None,
            coefficients,
        }
    }

    /// The next move may be started; moves started earlier end the running one.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.reference.is_idle()
    }

    /// Starts a move. Without effect in the safe state.
    #[inline]
    pub fn start(&mut self, next: Move<F::Scalar>) {
        if self.fault.is_none() {
            self.reference.start(next);
        }
    }

    /// Why the PWM is off.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// What a friction model that learns has to say ([`super::Learning`]).
    #[inline]
    pub fn condition(&self) -> Condition<F::Scalar> {
        let friction = self.coefficients.compensator.friction();
        friction.condition(&self.friction)
    }

    /// The friction model's memory, to tell it what the tick does not measure: temperature, load
    /// ([`crate::effects::WithState`]). A swap, a fault and a restart empty it.
    pub fn friction_state(&mut self) -> &mut F::State {
        &mut self.friction
    }

    /// Leaves the safe state: stands where the axis is, with empty memories.
    pub fn restart(&mut self) {
        self.reference = Reference::at(saturate(self.tracker.position()));
        self.suspicion = Suspicion::default();
        self.fault = None;
    }

    /// Takes new coefficients between two ticks, without a bump.
    ///
    /// The friction model starts without memory. The difference that the change makes to the present command is
    /// faded out over [`super::Settings::fade_time`].
    pub fn swap(&mut self, coefficients: Coefficients<F>) {
        let (error, velocity_error) = self.errors;
        let mut pid = self.pid.clone();
        let feedback = coefficients
            .pid
            .step(&mut pid, error, velocity_error, self.cut);
        coefficients
            .fade
            .start(&mut self.fade, self.force.sub_input(feedback));
        self.friction = coefficients.compensator.friction().at_rest();
        self.pid = pid;
        self.coefficients = coefficients;
    }

    /// One tick. Call it once a sample time, with the counter read at its start.
    #[inline]
    pub fn tick(&mut self, measured: Measurement<C>) -> Command {
        let c = &self.coefficients;
        let counts = self.tracker.update(measured.count);
        let motion = c.scale.step(&mut self.timing, counts);
        let position = self.tracker.position();
        if self.fault.is_none() {
            self.fault = c.monitor.measured(
                &mut self.suspicion,
                counts,
                self.code,
                measured.supply,
                measured.late,
            );
        }
        if self.fault.is_some() {
            return self.safe(position);
        }

        let reference = self.reference.step();
        let error = reference.position.wrapping_sub(position.wrapping_shl(16));
        let error = F::Scalar::from_q16(saturate(error)).mul_input(c.length_per_count);
        self.fault = c.monitor.followed(error);
        if self.fault.is_some() {
            return self.safe(position);
        }

        let displacement =
            F::Scalar::from_q16(reference.displacement).mul_input(c.length_per_count);
        let wanted = Motion {
            displacement,
            velocity: displacement.mul_input(c.velocity_per_length),
        };
        let velocity_error = wanted.velocity.sub_input(motion.velocity);
        let feedback = c.pid.step(&mut self.pid, error, velocity_error, self.cut);
        // Whole counts do for maps and ripples, and are exact in `f32` up to 2²⁴ of them.
        let place =
            |counts: i64| F::Scalar::from_int(saturate(counts)).mul_input(c.length_per_count);
        c.compensator.place(
            &mut self.friction,
            place(reference.position >> 16),
            place(position),
        );
        let feed_forward =
            c.compensator
                .step(&mut self.friction, wanted, motion, reference.acceleration);
        let force = feedback
            .add_input(feed_forward)
            .add_input(c.fade.step(&mut self.fade));
        self.force = force;
        self.errors = (error, velocity_error);

        let supply = f32::from(c.monitor.usable(measured.supply));
        let boost = F::Scalar::from_f32(c.supply_nominal / supply);
        let Some(code) = c
            .motor
            .code(&mut self.rounding, force, wanted.velocity, boost)
        else {
            self.fault = Some(Fault::NotANumber);
            return self.safe(position);
        };
        let (code, cut) = c.limiter.apply(code);
        self.code = code;
        self.cut = cut;
        // What was cut, bumped by a swap or held for longer than a tick does not tell the friction.
        let fades = &self.fade;
        let told = || {
            let tells = cut == Saturation::None && !fades.is_running() && !measured.late;
            tells.then_some(force)
        };
        c.compensator
            .spent(&mut self.friction, told, reference.acceleration);
        Command {
            code,
            position,
            reference: reference.position,
            fault: None,
        }
    }

    /// PWM off; every memory but the position is emptied, so that a restart begins at rest.
    fn safe(&mut self, position: i64) -> Command {
        self.code = 0;
        self.cut = Saturation::None;
        self.pid = PidState::new();
        self.rounding = Rounding::new();
        self.fade = FadeState::new();
        let friction = self.coefficients.compensator.friction();
        friction.release(&mut self.friction);
        Command {
            code: 0,
            position,
            reference: position.wrapping_shl(16),
            fault: self.fault,
        }
    }
}
