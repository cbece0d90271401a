//! The tick.

use super::coefficients::Moment;
use super::cross_fade::CrossFade;
use super::faults::Readings;
use super::reference::saturate;
use super::winding::WindingState;
use super::{
    Coefficients, Command, Condition, Fault, Jog, Measurement, Move, NotchState, Pace, PidState,
    Reference, Refused, Rounding, Saturation, Suspicion,
};
use crate::encoder::{EdgeTiming, in_turn, within};
use crate::hint::cold_path;
use crate::{Count, Friction, Motion, Scalar};

/// Encoder count in, PWM code out.
///
/// `count → displacement → reference → PID + feed-forward → limiter → code`, with the friction model `F` and its
/// number type. Nothing here divides by a parameter, allocates or panics; the one division is by a measured time
/// ([`crate::EncoderScale`]), another by the measured supply, both held above zero.
///
/// It begins *disabled*, and so it is again after every fault: PWM off until [`Controller::enable`]. Disabled, it follows the
/// count and learns what the current sense reads at rest.
///
/// ```
/// use preslide::Units;
/// use preslide::control::{Axis, Coefficients, Controller, Measurement, NoFriction, Planner};
/// let axis = Axis::PAPER_AXIS;
/// let coefficients = Coefficients::try_new(&axis, NoFriction::<f32>::new(), Units::SI)?;
/// let mut controller = Controller::new(coefficients, 0_u32);
/// let mut planner = Planner::try_new(&axis)?;
/// controller.enable().expect("nothing speaks against it");
/// controller.start(planner.by(1e-3, 5e-3, 0.5)?).expect("within the limits");
/// // In the control interrupt; an axis that does not come on is pushed.
/// let measured = Measurement { count: 0, supply: 6000, current: 0, late: false };
/// let codes = [(); 100].map(|()| controller.tick(measured).code);
/// assert!(codes[99] > 0);
/// # Ok::<(), preslide::ParamError>(())
/// ```
// In this order, so that what only a change of parameters needs does not push the rest out of the reach of a load.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Controller<F: Friction, C> {
    /// The last reading, and the position (counts) from an origin that is the axis's own if it is located.
    last: C,
    position: i64,
    located: bool,
    /// Position (counts) within the turn, of an endless axis.
    turn_count: i32,
    pid: PidState<F::Scalar>,
    rounding: Rounding<F::Scalar>,
    cut: Saturation,
    /// The last tick's code in the axis's direction.
    code: i32,
    /// Ticks until the host's silence has lasted too long.
    timeout: u32,
    enabled: bool,
    /// There is one in `cross_fade`.
    fades: bool,
    /// The axis is driven, nothing fades or is suspected, and the last code was neither cut nor a push worth watching: the next tick is
    /// an ordinary one if what it measures is. For [`Controller::tick`] alone to set.
    steady: bool,
    fault: Option<Fault>,
    suspicion: Suspicion,
    friction: F::State,
    coefficients: Coefficients<F>,
    timing: EdgeTiming<F::Scalar>,
    reference: Reference,
    notch: NotchState<F::Scalar>,
    winding: WindingState,
    cross_fade: Option<CrossFade<F>>,
}

impl<F: Friction, C: Count> Controller<F, C> {
    /// Disabled, at position 0 with the counter at `first`.
    pub fn new(coefficients: Coefficients<F>, first: C) -> Self {
        Self {
            last: first,
            position: 0,
            located: false,
            turn_count: 0,
            timing: coefficients.machine.scale.at_rest(),
            reference: Reference::at(0, &coefficients.machine.pace),
            pid: PidState::new(),
            friction: coefficients.law.compensator.friction().at_rest(),
            rounding: Rounding::new(),
            notch: NotchState::new(),
            winding: WindingState::new(),
            cross_fade: None,
            suspicion: Suspicion::default(),
            cut: Saturation::None,
            code: 0,
            timeout: 0,
            enabled: false,
            fades: false,
            steady: false,
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
        self.fault = self.coefficients.machine.monitor.at_rest(&self.suspicion);
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        // It may have been disabled in this very tick.
        self.forget();
        self.reference
            .stand(self.position, &self.coefficients.machine.pace);
        self.reference.locate(self.located);
        self.suspicion.clear();
        self.heard();
        self.enabled = true;
        Ok(())
    }

    /// PWM off from the next tick on. A moving axis coasts: [`Controller::stop`] first.
    pub fn disable(&mut self) {
        self.enabled = false;
        self.steady = false;
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
        self.reference.start(next, &self.coefficients.machine.pace)
    }

    /// Goes on at a speed until the next order or the end of travel.
    ///
    /// # Errors
    /// [`Refused`]; nothing changes then.
    pub fn jog(&mut self, jog: Jog) -> Result<(), Refused> {
        self.may_move()?;
        self.reference.jog(jog, &self.coefficients.machine.pace);
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
        self.timeout = self.coefficients.machine.silence;
    }

    /// The host has been silent for too long.
    pub fn is_silent(&self) -> bool {
        self.timeout == 0 && self.coefficients.machine.silence > 0
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
            .wrapping_mul(self.coefficients.machine.count_sign);
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
        if self.coefficients.machine.turn > 0 {
            self.turn_count = in_turn(self.position, self.coefficients.machine.turn);
        }
    }

    /// Where the reference was at the end of the last tick (2⁻¹⁶ counts); the position itself where the axis is not driven.
    #[inline]
    pub fn reference(&self) -> i64 {
        let error_q16 = if self.enabled {
            self.error_q16(self.reference.position())
        } else {
            0
        };
        (self.position << 16).wrapping_add(error_q16)
    }

    /// From the position to the reference's `position` (2⁻¹⁶ counts). Both wrap; their difference does not.
    #[inline]
    fn error_q16(&self, position: i64) -> i64 {
        position.wrapping_sub(self.position << 32) >> 16
    }

    /// Positions are counted from the axis's own origin: it has been told, and nothing has happened since by which the count may be
    /// wrong ([`Fault::doubts_count`], or a jump while disabled).
    pub fn is_located(&self) -> bool {
        self.located
    }

    /// What the current sense read while the axis was disabled (codes): what it adds to every reading.
    #[inline]
    pub fn current_at_rest(&self) -> i16 {
        self.suspicion.at_rest()
    }

    /// The winding's resistance over the configured one (2⁻¹⁶), as far as it is followed ([`super::Motor::resistance_span`]).
    pub fn resistance_share(&self) -> i32 {
        self.winding.share()
    }

    /// What a friction model that learns has to say ([`super::Learning`]).
    #[inline]
    pub fn condition(&self) -> Condition<F::Scalar> {
        let friction = self.coefficients.law.compensator.friction();
        friction.condition(&self.friction)
    }

    /// The friction model's memory, to tell it what the tick does not measure: temperature, load
    /// ([`crate::effects::WithState`]). Disabling empties it, a swap to another model may.
    pub fn friction_state(&mut self) -> &mut F::State {
        &mut self.friction
    }

    /// What the controller follows, for a look ahead on a copy.
    pub(super) fn followed(&self) -> &Reference {
        &self.reference
    }

    /// How fast the reference may move.
    pub fn pace(&self) -> &Pace {
        &self.coefficients.machine.pace
    }

    /// Takes new coefficients between two ticks, without a bump.
    ///
    /// The friction model goes on with what it remembers ([`Friction::take_over`]). Feedback, feed-forward and model cross-fade:
    /// the old ones run on beside the new ones for [`super::Axis::fade_time`]. What says what the machine is (encoder, motor,
    /// limits, watch) takes effect at once.
    #[inline(never)]
    // By reference, and the old parameters copied only where they run on: what is copied here is most of the longest tick.
    pub fn swap(&mut self, coefficients: &Coefficients<F>) {
        let new = &coefficients.law.compensator;
        let left = &self.coefficients.law.compensator;
        let memory = new.friction().take_over(left.friction(), &self.friction);
        let memory = core::mem::replace(&mut self.friction, memory);
        // Another notch goes on from there: it settles while it has little weight.
        let notch = self.notch.clone();
        self.notch.left();
        if self.enabled {
            let added = match &self.cross_fade {
                Some(cross_fade) if self.fades => cross_fade.added(),
                _ => F::Scalar::ZERO,
            };
            let friction = (new != left).then_some(memory);
            // What a lower limit takes from the integral fades, too.
            let added = added.add_input(coefficients.law.pid.shorten(&mut self.pid));
            let (old, fade) = (self.coefficients.law.clone(), &coefficients.machine.fade);
            self.cross_fade = Some(CrossFade::start(old, friction, notch, fade, added));
        } else {
            // Another resistance may be told.
            self.winding = WindingState::new();
        }
        self.coefficients.law.clone_from(&coefficients.law);
        self.coefficients.machine = coefficients.machine;
        self.fades = self.enabled;
        self.steady = false;
    }

    /// One tick. Call it once a sample time, with the counter read at its start.
    #[inline]
    pub fn tick(&mut self, measured: Measurement<C>) -> Command {
        match self.ordinary_tick(measured) {
            Some(command) => command,
            None => self.any_tick(measured),
        }
    }

    /// [`Controller::tick`] where it is an ordinary one; `None`, and nothing is done, where it is not.
    ///
    /// Nearly all ticks of a moving axis are ordinary: it is driven, no value is unusual, the reference goes on evenly, nothing fades. What
    /// those need not ask is left out. A task that has more to do in other ticks asks for this first, and then for
    /// [`Controller::any_tick`].
    #[inline]
    #[must_use = "a tick that was an ordinary one is over, and its command is this"]
    pub fn ordinary_tick(&mut self, measured: Measurement<C>) -> Option<Command> {
        let monitor = &self.coefficients.machine.monitor;
        let ordinary = self.steady
            && self.timeout != 1
            && self.reference.is_even()
            && monitor.finds_usual(&self.suspicion, self.counts(&measured), &measured);
        ordinary.then(|| self.advance::<true>(measured))
    }

    /// [`Controller::tick`], ordinary or not, in one function that is not inlined.
    #[cold]
    #[inline(never)]
    pub fn any_tick(&mut self, measured: Measurement<C>) -> Command {
        self.advance::<false>(measured)
    }

    /// Counts that the axis travelled since the last tick.
    #[inline]
    fn counts(&self, measured: &Measurement<C>) -> i32 {
        let counts = measured.count.since(self.last);
        counts.wrapping_mul(self.coefficients.machine.count_sign)
    }

    #[inline(always)]
    fn advance<const ORDINARY: bool>(&mut self, measured: Measurement<C>) -> Command {
        let c = &self.coefficients;
        let counts = self.counts(&measured);
        self.last = measured.count;
        self.position = self.position.wrapping_add(counts.into());
        if c.machine.turn != 0 {
            cold_path();
            self.turn_count = within(self.turn_count.wrapping_add(counts), c.machine.turn);
        }
        let window = || c.machine.scale.velocity(&mut self.timing, counts);
        let displacement = c.machine.scale.displacement(counts);
        let velocity =
            (c.law.compensator.friction()).velocity(&mut self.friction, displacement, window);
        if !ORDINARY && let Some(command) = self.watch(&measured, counts) {
            return command;
        }
        if self.timeout > 0 {
            self.timeout -= 1;
            if !ORDINARY && self.timeout == 0 {
                self.reference.stop();
            }
        }
        let c = &self.coefficients;
        let supply = if ORDINARY {
            measured.supply
        } else {
            c.machine.monitor.usable(measured.supply)
        };
        let boost = c.boost(supply);
        let reference = if ORDINARY {
            self.reference.step_evenly()
        } else {
            self.reference.step(&c.machine.pace)
        };
        let error_q16 = self.error_q16(reference.position);
        let error = c.length(saturate(error_q16));
        if let Some(fault) = c.machine.monitor.followed(error) {
            return self.trip(fault);
        }

        let displacement = c.length(reference.displacement);
        let wanted = Motion {
            displacement,
            velocity: displacement.mul_input(c.machine.velocity_per_length),
        };
        let acceleration = c.acceleration(reference.change);
        let velocity_error = wanted.velocity.sub_input(velocity);
        let (turn_count, located) = (self.turn_count(), self.located);
        // Asked for twice, so that the ordinary tick has it in registers.
        let now = || Moment {
            error,
            velocity_error,
            wanted,
            counts,
            velocity,
            acceleration,
            places: [
                turn_count.wrapping_add((error_q16 >> 16) as i32),
                turn_count,
            ],
            located,
        };
        let cut = if ORDINARY { Saturation::None } else { self.cut };
        let feedback = c.law.pid.step(&mut self.pid, error, velocity_error, cut);
        let friction = c.feed_forward(&c.law.compensator, &mut self.friction, &now());
        let mut force = feedback.add_input(friction.add_input(c.law.inertial(acceleration)));
        if !ORDINARY && c.law.notch.is_some() {
            cold_path();
            force = force.sub_input(c.law.notched(&mut self.notch, error, velocity_error));
        }
        if !ORDINARY && self.fades {
            force = force.add_input(self.fade(&now(), friction));
        }
        let c = &self.coefficients;

        let mut driven = force;
        if !ORDINARY && c.machine.winding.follows() {
            cold_path();
            let current = i32::from(measured.current) - i32::from(self.suspicion.at_rest());
            driven = c.machine.winding.step(
                &mut self.winding,
                current,
                force,
                velocity_error,
                acceleration,
            );
        }
        let Some(code) = c
            .machine
            .motor
            .code(&mut self.rounding, driven, wanted.velocity, boost)
        else {
            return self.trip(Fault::NotANumber);
        };
        let mut lost = F::Scalar::ZERO;
        let (code, cut) = if c.is_gentle(code) {
            if !ORDINARY {
                self.cut = Saturation::None;
                self.steady = !self.fades && !self.suspicion.any() && !c.does_more();
            }
            (code, Saturation::None)
        } else {
            cold_path();
            self.steady = false;
            let (passed, cut) = c.machine.limiter.apply(code);
            self.cut = cut;
            if !ORDINARY && cut != Saturation::None {
                self.winding.cut();
            }
            lost = c.force(code.wrapping_sub(passed), supply);
            (passed, cut)
        };
        self.code = code;
        // What was cut, bumped by another model or held for longer than a tick does not tell the friction.
        let cross_fade = if !ORDINARY && self.fades {
            &self.cross_fade
        } else {
            &None
        };
        let told = || {
            let fades = cross_fade.as_ref().is_some_and(CrossFade::changes_model);
            let tells = cut == Saturation::None && !fades && (ORDINARY || !measured.late);
            tells.then(|| c.beside_mass(force, acceleration))
        };
        c.law.compensator.friction().spent(&mut self.friction, told);
        let acted = || force.sub_input(lost);
        (c.law.compensator.friction()).acted(&mut self.friction, velocity_error, acted);
        Command {
            code: code.wrapping_mul(c.machine.code_sign),
            position: self.position,
            reference: (self.position << 16).wrapping_add(error_q16),
            fault: None,
            enabled: true,
        }
    }

    /// What a tick that is not ordinary looks at before it computes; the command of one that ends there.
    #[inline(always)]
    fn watch(&mut self, measured: &Measurement<C>, counts: i32) -> Option<Command> {
        if !self.enabled {
            self.suspicion.calibrate(measured.current);
            let monitor = &self.coefficients.machine.monitor;
            monitor.cool(&mut self.suspicion);
            if monitor.jumped(counts) {
                self.located = false;
            }
            return Some(self.off());
        }
        if self.suspicion.knows_no_rest() {
            // Enabled before any tick: what is read now is from before the bridge is driven.
            self.suspicion.calibrate(measured.current);
            if let Some(fault) = self.coefficients.machine.monitor.at_rest(&self.suspicion) {
                return Some(self.trip(fault));
            }
        }
        let readings = Readings {
            counts,
            stands: self.reference.is_at_rest(),
            code: self.code,
            supply: measured.supply,
            current: measured.current,
            late: measured.late,
        };
        let monitor = &self.coefficients.machine.monitor;
        let usual = self.coefficients.is_gentle(self.code)
            && monitor.finds_usual(&self.suspicion, counts, measured)
            && !self.suspicion.any();
        if usual {
            return None;
        }
        let fault = monitor.suspect(&mut self.suspicion, &readings)?;
        Some(self.trip(fault))
    }

    /// Position within the turn of an endless axis; the low bits of the position elsewhere.
    #[inline]
    fn turn_count(&self) -> i32 {
        if self.coefficients.machine.turn != 0 {
            self.turn_count
        } else {
            self.position as i32
        }
    }

    /// What the old parameters add to the new ones' force.
    #[cold]
    #[inline(never)]
    fn fade(&mut self, now: &Moment<F::Scalar>, friction: F::Scalar) -> F::Scalar {
        let Some(cross_fade) = &mut self.cross_fade else {
            return F::Scalar::ZERO;
        };
        let c = &self.coefficients;
        let immediate = cross_fade.old.immediate(now);
        let mut difference = immediate.sub_input(c.law.immediate(now));
        let (old, state) = (&cross_fade.old, &mut cross_fade.notch);
        let taken = old.notched(state, now.error, now.velocity_error);
        difference = difference.add_input(self.notch.taken().sub_input(taken));
        if let Some(state) = &mut cross_fade.friction {
            let model = c.law.compensator.friction();
            model.hand_observed(&self.friction, state);
            let left = c.feed_forward(&cross_fade.old.compensator, state, now);
            difference = difference.add_input(left.sub_input(friction));
        }
        let added = cross_fade.step(difference);
        self.fades = !cross_fade.is_over();
        added
    }

    /// Into the safe state.
    #[cold]
    #[inline]
    fn trip(&mut self, fault: Fault) -> Command {
        self.fault = Some(fault);
        if fault.doubts_count() {
            self.located = false;
        }
        self.disable();
        self.off()
    }

    /// PWM off; every memory but the position is emptied, so that enabling begins at rest.
    #[inline]
    fn off(&mut self) -> Command {
        self.forget();
        self.reference.stop();
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
        self.notch = NotchState::new();
        self.winding.cut();
        self.fades = false;
        let friction = self.coefficients.law.compensator.friction();
        friction.release(&mut self.friction);
    }
}
