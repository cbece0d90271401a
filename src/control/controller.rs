//! The tick.

use super::coefficients::Moment;
use super::faults::Readings;
use super::leaving::Leaving;
use super::reference::saturate;
use super::{
    Coefficients, Condition, Fault, Jog, Move, Pace, PidState, Reference, Refused, Rounding,
    Saturation, Suspicion,
};
use crate::encoder::EdgeTiming;
use crate::{Count, Friction, Motion, Scalar};

/// What a board measures in a tick, raw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<C> {
    /// The quadrature counter.
    pub count: C,
    /// The supply voltage in the codes that [`super::Hardware::supply_code`] scales.
    pub supply: u16,
    /// The winding's current in the codes that [`super::Hardware::current_code`] scales; 0 where it is not measured.
    pub current: i16,
    /// This tick started after the next one was due.
    pub late: bool,
}

/// What a tick decided, raw, for the PWM and the telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// PWM code, within ± the limiter's; 0 while not enabled.
    pub code: i32,
    /// Position (counts) from the axis's origin: the first reading, or what [`Controller::set_position`] told.
    pub position: i64,
    /// Reference position (2⁻¹⁶ counts).
    pub reference: i64,
    /// Why the PWM is off, where that is not by order.
    pub fault: Option<Fault>,
    /// The bridge is to be driven; where it is not, open: all switches off.
    pub enabled: bool,
}

/// Encoder count in, PWM code out.
///
/// `count → displacement → reference → PID + feed-forward → limiter → code`, with the friction model `F` and its
/// number type. Nothing here divides by a parameter, allocates or panics; the one division is by a measured time
/// ([`crate::EncoderScale`]), another by the measured supply, both held above zero ([`Scalar::rate`]).
///
/// It begins *disabled*, and so it is again after every fault: PWM off until [`Controller::enable`]. Disabled, it follows the
/// count and learns what the current sense reads at rest.
// In this order, so that what only a change of parameters needs does not push the rest out of the reach of a load.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Controller<F: Friction, C> {
    /// The last reading, and the position (counts) from an origin that is the axis's own if it is located.
    last: C,
    position: i64,
    located: bool,
    /// Position within the turn of an endless axis; the low bits of the position elsewhere.
    place: i32,
    pid: PidState<F::Scalar>,
    rounding: Rounding<F::Scalar>,
    cut: Saturation,
    /// The last tick's code in the axis's direction.
    code: i32,
    /// Ticks until the host's silence has lasted too long.
    patience: u32,
    enabled: bool,
    /// There is one in `leaving`.
    fades: bool,
    fault: Option<Fault>,
    suspicion: Suspicion,
    friction: F::State,
    coefficients: Coefficients<F>,
    timing: EdgeTiming<F::Scalar>,
    reference: Reference,
    leaving: Option<Leaving<F>>,
}

impl<F: Friction, C: Count> Controller<F, C> {
    /// Disabled, at position 0 with the counter at `first`.
    pub fn new(coefficients: Coefficients<F>, first: C) -> Self {
        Self {
            last: first,
            position: 0,
            located: false,
            place: 0,
            timing: coefficients.scale.at_rest(),
            reference: Reference::at(0, &coefficients.pace),
            pid: PidState::new(),
            friction: coefficients.compensator.friction().at_rest(),
            rounding: Rounding::new(),
            leaving: None,
            suspicion: Suspicion::default(),
            cut: Saturation::None,
            code: 0,
            patience: 0,
            enabled: false,
            fades: false,
            fault: None,
            coefficients,
        }
    }

    /// The axis holds its position from here on, with empty memories. Without effect where it does already.
    ///
    /// # Errors
    /// The fault that has not been acknowledged, or what the current sense shows.
    #[inline(never)]
    pub fn enable(&mut self) -> Result<(), Fault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if self.enabled {
            return Ok(());
        }
        self.fault = self.coefficients.monitor.at_rest(&self.suspicion);
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        // It may have been disabled in this very tick.
        self.forget();
        self.reference.stand(self.position, &self.coefficients.pace);
        self.reference.locate(self.located);
        self.suspicion.clear();
        self.heard();
        self.enabled = true;
        Ok(())
    }

    /// PWM off from the next tick on. A moving axis coasts: [`Controller::stop`] first.
    pub fn disable(&mut self) {
        self.enabled = false;
    }

    /// Forgets the fault; the axis stays disabled.
    pub fn acknowledge(&mut self) {
        self.fault = None;
    }

    /// The axis is driven.
    #[inline]
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Why the PWM is off, where that is not by order.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// The next move may be started; moves started earlier stop the running one first.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.reference.is_idle()
    }

    /// The reference stands still.
    #[inline]
    pub fn is_standing(&self) -> bool {
        self.reference.is_standing()
    }

    /// Starts a move from where the last one ends. One that runs is stopped first.
    ///
    /// # Errors
    /// [`Refused`]; nothing changes then.
    #[inline]
    pub fn start(&mut self, next: Move) -> Result<(), Refused> {
        self.may_move()?;
        self.reference.start(next, &self.coefficients.pace)
    }

    /// Goes on at a speed until the next order or the end of travel.
    ///
    /// # Errors
    /// [`Refused`]; nothing changes then.
    pub fn jog(&mut self, jog: Jog) -> Result<(), Refused> {
        self.may_move()?;
        self.reference.jog(jog, &self.coefficients.pace);
        Ok(())
    }

    fn may_move(&self) -> Result<(), Refused> {
        if !self.enabled {
            Err(Refused::NotEnabled)
        } else if self.is_silent() {
            Err(Refused::Silence)
        } else {
            Ok(())
        }
    }

    /// Brakes to rest within the limits, from whatever motion. What waits in a queue is the caller's to drop.
    pub fn stop(&mut self) {
        self.reference.stop();
    }

    /// The host has been heard. [`super::Axis::silence`] after the last time a moving axis stops.
    #[inline]
    pub fn heard(&mut self) {
        self.patience = self.coefficients.silence;
    }

    /// The host has been silent for too long.
    pub fn is_silent(&self) -> bool {
        self.patience == 0 && self.coefficients.silence > 0
    }

    /// Position (counts) from the axis's origin.
    #[inline]
    pub fn position(&self) -> i64 {
        self.position
    }

    /// Position (counts) where the counter showed `reading`, less than half its range ago: a latched index.
    pub fn position_at(&self, reading: C) -> i64 {
        let counts = reading
            .since(self.last)
            .wrapping_mul(self.coefficients.count_sign);
        self.position.wrapping_add(counts.into())
    }

    /// The place that is called `from` (counts) is `to`: homing, or zeroing where `to` is 0. From here on the axis is located, its
    /// travel has ends, and what acts by position acts. In motion as well: reference and axis are renamed together.
    #[inline(never)]
    pub fn set_position(&mut self, from: i64, to: i64) {
        let by = to.wrapping_sub(from);
        self.position = self.position.wrapping_add(by);
        self.reference.shift(by);
        self.located = true;
        self.reference.locate(true);
        let turn = i64::from(self.coefficients.turn);
        self.place = if turn > 0 {
            self.position.rem_euclid(turn) as i32
        } else {
            self.position as i32
        };
    }

    /// Positions are counted from the axis's own origin.
    pub fn is_located(&self) -> bool {
        self.located
    }

    /// What the current sense read while the axis was disabled (codes): what it adds to every reading.
    #[inline]
    pub fn current_at_rest(&self) -> i16 {
        self.suspicion.at_rest()
    }

    /// What a friction model that learns has to say ([`super::Learning`]).
    #[inline]
    pub fn condition(&self) -> Condition<F::Scalar> {
        let friction = self.coefficients.compensator.friction();
        friction.condition(&self.friction)
    }

    /// The friction model's memory, to tell it what the tick does not measure: temperature, load
    /// ([`crate::effects::WithState`]). Disabling empties it, a swap to another model may.
    pub fn friction_state(&mut self) -> &mut F::State {
        &mut self.friction
    }

    /// How fast the reference may move.
    pub fn pace(&self) -> &Pace {
        &self.coefficients.pace
    }

    /// Takes new coefficients between two ticks, without a bump.
    ///
    /// The friction model goes on with what it remembers ([`Friction::take_over`]). Feedback, feed-forward and model cross-fade:
    /// the old ones run on beside the new ones for [`super::Axis::fade_time`]. What says what the machine is (encoder, motor,
    /// limits, watch) takes effect at once.
    #[inline(never)]
    pub fn swap(&mut self, coefficients: Coefficients<F>) {
        let old = core::mem::replace(&mut self.coefficients, coefficients);
        let (new, left) = (&self.coefficients.compensator, &old.compensator);
        let memory = new.friction().take_over(left.friction(), &self.friction);
        let memory = core::mem::replace(&mut self.friction, memory);
        let added = match &self.leaving {
            Some(leaving) if self.fades => leaving.added(),
            _ => F::Scalar::ZERO,
        };
        if self.enabled {
            let friction = (new != left).then_some(memory);
            let fade = &self.coefficients.fade;
            self.leaving = Some(Leaving::start(old, friction, fade, added));
        }
        self.fades = self.enabled;
    }

    /// One tick. Call it once a sample time, with the counter read at its start.
    #[inline]
    pub fn tick(&mut self, measured: Measurement<C>) -> Command {
        let c = &self.coefficients;
        let counts = measured.count.since(self.last).wrapping_mul(c.count_sign);
        self.last = measured.count;
        self.position = self.position.wrapping_add(counts.into());
        self.place = within(self.place.wrapping_add(counts), c.turn);
        let velocity = c.scale.velocity(&mut self.timing, counts);
        if !self.enabled {
            self.suspicion.calibrate(measured.current);
            return self.off();
        }
        let code = self.code;
        let read = || Readings {
            counts,
            code,
            supply: measured.supply,
            current: measured.current,
            late: measured.late,
        };
        if let Some(fault) = c.monitor.measured(&mut self.suspicion, read) {
            return self.trip(fault);
        }
        if self.patience > 0 {
            self.patience -= 1;
            if self.patience == 0 {
                self.reference.stop();
            }
        }
        let reference = self.reference.step(&c.pace);
        // Both wrap; their difference does not.
        let error_q16 = reference.position.wrapping_sub(self.position << 32) >> 16;
        let error = F::Scalar::from_q16(saturate(error_q16)).mul_input(c.length_per_count);
        if let Some(fault) = c.monitor.followed(error) {
            return self.trip(fault);
        }

        let displacement =
            F::Scalar::from_q16(reference.displacement).mul_input(c.length_per_count);
        let wanted = Motion {
            displacement,
            velocity: displacement.mul_input(c.velocity_per_length),
        };
        let acceleration = F::Scalar::from_q16((reference.change >> 16) as i32)
            .mul_input(c.acceleration_per_change);
        let velocity_error = wanted.velocity.sub_input(velocity);
        let (place, located) = (self.place, self.located);
        // Asked for twice, so that the ordinary tick has it in registers.
        let now = || Moment {
            error,
            velocity_error,
            wanted,
            counts,
            velocity,
            acceleration,
            places: [place.wrapping_add((error_q16 >> 16) as i32), place],
            located,
        };
        let feedback = c.pid.step(&mut self.pid, error, velocity_error, self.cut);
        let feed_forward = c.feed_forward(&mut self.friction, &now());
        let mut force = feedback.add_input(feed_forward);
        if self.fades {
            force = force.add_input(self.fade(&now(), feed_forward));
        }
        let c = &self.coefficients;

        let boost = c.boost(measured.supply);
        let Some(code) = c
            .motor
            .code(&mut self.rounding, force, wanted.velocity, boost)
        else {
            return self.trip(Fault::NotANumber);
        };
        let (code, cut) = c.limiter.apply(code);
        self.code = code;
        self.cut = cut;
        // What was cut, bumped by another model or held for longer than a tick does not tell the friction.
        let leaving = if self.fades { &self.leaving } else { &None };
        let told = || {
            let fades = leaving.as_ref().is_some_and(Leaving::changes_model);
            let tells = cut == Saturation::None && !fades && !measured.late;
            tells.then_some(force)
        };
        c.compensator.spent(&mut self.friction, told, acceleration);
        Command {
            code: code.wrapping_mul(c.code_sign),
            position: self.position,
            reference: (self.position << 16).wrapping_add(error_q16),
            fault: None,
            enabled: true,
        }
    }

    /// What the old parameters add to the new ones' force.
    #[inline(never)]
    fn fade(&mut self, now: &Moment<F::Scalar>, feed_forward: F::Scalar) -> F::Scalar {
        let Some(leaving) = &mut self.leaving else {
            return F::Scalar::ZERO;
        };
        let immediate = |c: &Coefficients<F>| c.pid.immediate(now.error, now.velocity_error);
        let mut difference = immediate(&leaving.old).sub_input(immediate(&self.coefficients));
        if let Some(state) = &mut leaving.friction {
            let left = leaving.old.feed_forward(state, now);
            difference = difference.add_input(left.sub_input(feed_forward));
        }
        let added = leaving.step(difference);
        self.fades = !leaving.is_over();
        added
    }

    /// Into the safe state.
    #[inline]
    fn trip(&mut self, fault: Fault) -> Command {
        self.fault = Some(fault);
        self.enabled = false;
        self.off()
    }

    /// PWM off; every memory but the position is emptied, so that enabling begins at rest.
    #[inline]
    fn off(&mut self) -> Command {
        self.forget();
        Command {
            code: 0,
            position: self.position,
            reference: self.position << 16,
            fault: self.fault,
            enabled: false,
        }
    }

    #[inline(never)]
    fn forget(&mut self) {
        self.code = 0;
        self.cut = Saturation::None;
        self.pid = PidState::new();
        self.rounding = Rounding::new();
        self.fades = false;
        self.reference.stop();
        let friction = self.coefficients.compensator.friction();
        friction.release(&mut self.friction);
    }
}

/// A place in the turn, which is passed in one tick at most once; `turn` is 0 for an axis with ends.
#[inline]
fn within(place: i32, turn: i32) -> i32 {
    if turn == 0 {
        place
    } else if place < 0 {
        place.wrapping_add(turn)
    } else if place >= turn {
        place.wrapping_sub(turn)
    } else {
        place
    }
}
