//! The task at the control rate.

use crate::Bridge;
use crate::brake::Brake;
use crate::limits::LimitWatch;
use crate::queues::{Act, Order, Planned, Seek, Shared, Status};
use crate::telemetry;
use core::sync::atomic::{Ordering, compiler_fence};
use heapless::spsc::{Consumer, Producer};
use preslide::control::koopman::{Desk, Guided};
use preslide::control::{Command, Controller, Fault, Measurement, NormalRange, Refused};
use preslide::{Friction, Scalar};
use preslide_link::{FaultCode, Mark, Mode, RangeCode, Refusal, Sample};

/// What a board measured at the start of a tick, raw.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Quadrature counter.
    pub count: u32,
    /// What the counter showed at the index pulse, if one came since the last tick.
    pub index: Option<u32>,
    /// Supply (mV).
    pub supply: u16,
    /// Winding current (0.1 mA).
    pub current: i16,
    /// The last tick had not ended when this one was due.
    pub late: bool,
}

impl Inputs {
    #[inline]
    fn measurement(&self) -> Measurement<u32> {
        Measurement {
            count: self.count,
            supply: self.supply,
            current: self.current,
            late: self.late,
        }
    }
}

/// Ticks from one [`Status`] to the next where no order came.
const STATUS_TICKS: u32 = 16;

/// Moves of an earlier epoch that are dropped in a tick: a full queue is empty in a millisecond.
const DROPS: usize = 4;

/// Control: from the counter to the bridge, once a sample time.
///
/// **Deadline:** the next tick. A tick that misses it is followed at once by the one that it delayed, told by
/// [`Inputs::late`]; the bridge holds the old code for the time between. The reference advances by ticks, so it
/// waits with the axis and no step follows. After more than [`preslide::control::FaultLimits::overruns`] late ticks
/// in a row the axis goes to its safe state. A task that never ends is the watchdog's business.
pub struct Control<F: Friction + 'static> {
    controller: Controller<F, u32>,
    moves: Consumer<'static, Planned>,
    orders: Consumer<'static, Order<F>>,
    statuses: Producer<'static, Status>,
    shared: &'static Shared,
    /// There is something to do beside the ordinary tick, and the background did not say so: see [`Control::attends`].
    attend: bool,
    status: Status,
    /// What opened the bridge beside the controller's faults: its own protection, a limit switch; until it is acknowledged.
    opened: Option<FaultCode>,
    limits: LimitWatch,
    /// How far the reference came in the last tick that was not an ordinary one (2⁻¹⁶ counts).
    moved: i64,
    brake: Brake,
    /// Ticks that it takes to be released, and to hold.
    brake_delays: [u32; 2],
    /// To be disabled as soon as it stands.
    disables_at_rest: bool,
    seek: Option<Seek>,
    /// A status found no room, so that the next tick tells it.
    owes_status: bool,
    /// Ticks from one sample of telemetry to the next, and to the next one; both 0 for none.
    every: u16,
    until_sample: u16,
    dropped: u32,
}

impl<F: Friction> Control<F> {
    pub(crate) fn new(
        controller: Controller<F, u32>,
        moves: Consumer<'static, Planned>,
        orders: Consumer<'static, Order<F>>,
        statuses: Producer<'static, Status>,
        shared: &'static Shared,
    ) -> Self {
        Self {
            controller,
            moves,
            orders,
            statuses,
            shared,
            attend: true,
            status: Status {
                orders: 0,
                outcome: Ok(()),
                taken: 0,
                epoch: 0,
                mode: Mode::Disabled,
                fault: None,
                located: false,
                silent: false,
                tick: 0,
                position: 0,
                reference: 0,
                dropped: 0,
                missed: 0,
                supply: 0,
                current: 0,
            },
            opened: None,
            limits: LimitWatch::default(),
            moved: 0,
            brake: Brake::default(),
            brake_delays: [0, 0],
            disables_at_rest: false,
            seek: None,
            owes_status: false,
            every: 0,
            until_sample: 0,
            dropped: 0,
        }
    }

    pub(crate) fn status(&self) -> Status {
        self.status
    }

    /// One tick. The bridge gets its code before anything is told.
    ///
    /// An ordinary one asks two flags whether there is an order, a move or a word of the host, and looks at none of the queues.
    #[inline]
    pub fn tick(&mut self, inputs: Inputs, bridge: &mut impl Bridge) {
        let calm = !self.attend
            && !self.shared.calls.load(Ordering::Relaxed)
            && !bridge.is_broken()
            && !bridge.limits().any();
        if calm && let Some(command) = self.controller.ordinary_tick(inputs.measurement()) {
            self.act(inputs, &command, false, bridge);
        } else {
            let Inputs {
                count,
                index,
                supply,
                current,
                late,
            } = inputs;
            self.attended_tick(
                count,
                index,
                [supply, current.cast_unsigned()],
                late,
                bridge,
            );
        }
    }

    /// A tick in which anything may happen.
    // The inputs one by one: as a structure in memory they would cost the ordinary tick, too.
    #[cold]
    #[inline(never)]
    fn attended_tick<B: Bridge>(
        &mut self,
        count: u32,
        index: Option<u32>,
        [supply, current]: [u16; 2],
        late: bool,
        bridge: &mut B,
    ) {
        let inputs = Inputs {
            count,
            index,
            supply,
            current: current.cast_signed(),
            late,
        };
        // Before the queues are looked at: what comes after that calls again.
        self.shared.calls.store(false, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        let mut opened = bridge.is_broken().then_some(FaultCode::Bridge);
        if B::GUARDED {
            opened = opened.or(self.limits.take(bridge.limits(), self.moved));
            self.brake_delays = bridge.brake_delays();
        }
        if opened.is_some() && self.controller.is_enabled() {
            self.opened = opened;
            self.controller.disable();
        }
        if B::GUARDED && self.brake.next() {
            self.controller.disable();
        }
        let ordered = self.orders.ready();
        if ordered {
            self.obey();
        }
        if self.shared.heard.load(Ordering::Relaxed) {
            self.shared.heard.store(false, Ordering::Relaxed);
            self.controller.heard();
        }
        let every = self.shared.every.load(Ordering::Relaxed);
        if every != self.every {
            self.every = every;
            self.until_sample = every.min(1);
        }
        if self.seek.is_some() {
            self.seek(&inputs);
        }
        self.feed();
        let before = self.controller.reference();
        let command = self.controller.any_tick(inputs.measurement());
        self.moved = command.reference.wrapping_sub(before);
        self.attend = self.attends();
        if B::GUARDED {
            self.attend |= self.limits.any() || self.brake.is_moving();
        }
        let tells = ordered || core::mem::take(&mut self.owes_status);
        self.act(inputs, &command, tells, bridge);
        if B::GUARDED && command.enabled {
            // Behind the bridge, which then drives already.
            bridge.release_brake(self.brake.released);
        }
    }

    /// Drives the bridge, then tells.
    #[inline(always)]
    fn act(&mut self, inputs: Inputs, command: &Command, tells: bool, bridge: &mut impl Bridge) {
        let readings = [inputs.supply, inputs.current.cast_unsigned()];
        if command.enabled {
            bridge.drive(command.code);
            self.tell(readings, command, None, tells);
        } else {
            bridge.open();
            bridge.release_brake(false);
            self.brake = Brake::default();
            // One by one, as the inputs above.
            self.tell_stopped(command.position, command.fault, readings, tells);
        }
    }

    #[cold]
    #[inline(never)]
    fn tell_stopped(
        &mut self,
        position: i64,
        fault: Option<Fault>,
        [supply, current]: [u16; 2],
        tells: bool,
    ) {
        let told = fault.map(on_the_wire).or(self.opened);
        let command = Command {
            code: 0,
            position,
            reference: position << 16,
            fault,
            enabled: false,
        };
        self.tell([supply, current], &command, told, tells);
    }

    /// The next tick has something to do that no one will call for: another order, the search for the origin, a move of another epoch
    /// to drop. A move that may begin needs no word: a tick in which it may is never an ordinary one.
    fn attends(&self) -> bool {
        let stale = |(epoch, _): &Planned| *epoch != self.status.epoch;
        self.orders.ready() || self.seek.is_some() || self.moves.peek().is_some_and(stale)
    }

    /// The next order. Not in the tick, which would then set aside room for it on the stack.
    #[inline(never)]
    fn obey(&mut self) {
        let act = match self.orders.peek() {
            None => return,
            Some(Order::Swap(coefficients)) => {
                self.controller.swap(coefficients);
                None
            }
            Some(&Order::Act(act)) => Some(act),
        };
        // Done, or known: an order is as long as all parameters, and none is copied out of the queue.
        let _ = self.orders.dequeue();
        self.status.outcome = act.map_or(Ok(()), |act| self.carry_out(act));
        self.status.orders = self.status.orders.wrapping_add(1);
    }

    fn carry_out(&mut self, act: Act) -> Result<(), Refusal> {
        match act {
            Act::Enable => {
                if self.opened.is_some() {
                    return Err(Refusal::Faulted);
                }
                self.disables_at_rest = false;
                self.new_epoch();
                self.controller.enable().map_err(|_| Refusal::Faulted)?;
                self.brake.tell(true, self.brake_delays[0]);
            }
            Act::Disable => {
                self.brake();
                self.disables_at_rest = true;
            }
            Act::Stop => self.brake(),
            Act::Acknowledge => {
                self.opened = None;
                self.controller.acknowledge();
            }
            Act::Jog(_) | Act::Seek(_) if self.brake.is_moving() => return Err(Refusal::Busy),
            Act::Jog(jog) => {
                self.new_epoch();
                self.seek = None;
                self.controller.jog(jog).map_err(refusal)?;
            }
            Act::Place(to) => {
                self.new_epoch();
                self.controller.set_position(self.controller.position(), to);
            }
            Act::Seek(seek) => {
                self.new_epoch();
                self.controller.jog(seek.jog).map_err(refusal)?;
                self.seek = Some(seek);
            }
        }
        Ok(())
    }

    fn brake(&mut self) {
        self.new_epoch();
        self.seek = None;
        self.controller.stop();
    }

    /// What waits was planned for another place.
    fn new_epoch(&mut self) {
        self.attend = true;
        self.status.epoch = self.status.epoch.wrapping_add(1);
    }

    /// Looks whether the origin is reached.
    #[inline(never)]
    fn seek(&mut self, inputs: &Inputs) {
        let (position, current) = (self.controller.position(), self.current(inputs.current));
        let lag = ((self.controller.reference() >> 16) - position).abs();
        let Some(seek) = &mut self.seek else {
            return;
        };
        match seek.mark {
            Mark::Index => {
                let Some(reading) = inputs.index else {
                    return;
                };
                let there = self.controller.position_at(reading);
                self.controller.set_position(there, seek.to);
                self.controller.stop();
            }
            Mark::Stop => {
                if !seek.is_met(lag, position, current) {
                    return;
                }
                self.controller.set_position(position, seek.to);
                // Enabled anew it holds where it is, instead of where the reference has gone.
                self.controller.disable();
                // The fault that this may find shows in the status, and where it stands afterwards that it could not move back.
                let _ = self.controller.enable();
                if let Some(back) = seek.back {
                    let _ = self.controller.start(back);
                }
            }
        }
        self.seek = None;
        self.new_epoch();
    }

    /// The next move, when the one before it is done.
    #[inline]
    fn feed(&mut self) {
        let Some((epoch, _)) = self.moves.peek() else {
            return;
        };
        if *epoch != self.status.epoch || self.may_start() {
            self.take();
        }
    }

    fn may_start(&self) -> bool {
        self.controller.is_idle() && !self.brake.is_moving()
    }

    /// Starts it; moves before it that were planned in another epoch are dropped.
    #[inline(never)]
    fn take(&mut self) {
        for _ in 0..DROPS {
            let Some((epoch, next)) = self.moves.peek() else {
                return;
            };
            let stale = *epoch != self.status.epoch;
            if !stale && !self.may_start() {
                return;
            }
            // Started where it lies: none is copied out of the queue.
            let starts = !stale && self.controller.start(*next).is_ok();
            let _ = self.moves.dequeue();
            self.status.taken = self.status.taken.wrapping_add(1);
            if starts {
                return;
            }
            self.status.dropped = self.status.dropped.saturating_add(1);
            if !stale {
                self.new_epoch();
                return;
            }
        }
    }

    /// Status and telemetry.
    #[inline(always)]
    fn tell(
        &mut self,
        [supply, current]: [u16; 2],
        command: &Command,
        fault: Option<FaultCode>,
        tells: bool,
    ) {
        let tick = self.status.tick.wrapping_add(1);
        self.status.tick = tick;
        if tells || tick.is_multiple_of(STATUS_TICKS) {
            self.tell_status(supply, self.current(current.cast_signed()));
        }
        if self.until_sample > 1 {
            self.until_sample -= 1;
        } else if self.until_sample == 1 {
            self.until_sample = self.every;
            self.tell_sample(tick, [supply, current], command, fault);
        }
    }

    #[inline(never)]
    fn tell_status(&mut self, supply: u16, current: i16) {
        // Asked, not told: a command in memory would cost every tick.
        let enabled = self.controller.is_enabled();
        let reference = self.controller.reference();
        let standing = self.controller.is_standing();
        if self.disables_at_rest && standing {
            self.disables_at_rest = false;
            match self.brake_delays[1] {
                0 => self.controller.disable(),
                ticks => {
                    self.brake.tell(false, ticks);
                    self.attend = true;
                }
            }
        }
        let silent = enabled && self.controller.is_silent();
        let mode = match (enabled, self.seek.is_some()) {
            (false, _) => Mode::Disabled,
            // The end of travel, the host's silence.
            (true, true) if standing => Mode::Standing,
            (true, true) => Mode::Homing,
            (true, false) if standing => Mode::Standing,
            (true, false) => Mode::Moving,
        };
        if mode == Mode::Disabled || mode == Mode::Standing {
            self.seek = None;
        }
        if (silent && !self.status.silent) || (mode == Mode::Disabled && self.status.mode != mode) {
            self.new_epoch();
        }
        self.status.mode = mode;
        self.status.fault = self.controller.fault().map(on_the_wire).or(self.opened);
        self.status.located = self.controller.is_located();
        self.status.silent = silent;
        self.status.position = self.controller.position();
        // To the nearest count.
        self.status.reference = reference.wrapping_add(1 << 15) >> 16;
        self.status.supply = supply;
        self.status.current = current;
        // The queue divides by its length, `capacity + 1`: asked here, so that the compiler knows that it is not 0 and
        // links no panic. One that finds no room is followed by another; the answer to an order waits for it.
        let is_queue = self.statuses.capacity().checked_add(1).is_some();
        if !is_queue || self.statuses.enqueue(self.status).is_err() {
            self.owes_status = true;
            self.attend = true;
        }
    }

    /// The winding's current, less what its sense reads at rest.
    #[inline]
    fn current(&self, read: i16) -> i16 {
        read.saturating_sub(self.controller.current_at_rest())
    }

    #[inline(always)]
    fn tell_sample(
        &mut self,
        tick: u32,
        [supply, current]: [u16; 2],
        command: &Command,
        fault: Option<FaultCode>,
    ) {
        let condition = self.controller.condition();
        let sample = |sequence| Sample {
            sequence,
            dropped: self.dropped,
            tick,
            position: command.position as i32,
            reference: command.reference,
            // Within ± the limiter's, which is at most 32000.
            code: command.code as i16,
            current: self.current(current.cast_signed()),
            supply,
            fault,
            range: condition.range.map(range_on_the_wire),
            level: condition.level.map_or(0, |level| {
                let ten_thousandths = level
                    .sub_input(Scalar::ONE)
                    .mul_input(Scalar::from_int(10_000));
                // The level is within 0.5…1.5.
                ten_thousandths.round_to_int() as i16
            }),
        };
        if !telemetry::put(&self.shared.samples, sample) {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }
}

impl<F: Friction<Scalar = f32>> Control<Guided<F>> {
    /// For a board with an outer task, after every tick: leaves and takes what lies on the desk. Whether the outer task is to be started.
    #[inline]
    pub fn attend(&mut self, desk: &mut Desk) -> bool {
        let (moves, epoch) = (&self.moves, self.status.epoch);
        let next = || match moves.peek() {
            Some((of, next)) if *of == epoch => Some(*next),
            _ => None,
        };
        let starts = desk.attend(&mut self.controller, next);
        let state = self.controller.friction_state();
        if state.is_due() {
            // What the wire holds.
            self.status.missed = state.missed().min(u16::MAX.into()) as u16;
        }
        starts
    }

    /// What is to lie between this task and the outer one.
    pub fn desk(&self) -> Desk {
        Desk::new(&self.controller)
    }
}

/// Why a move was not started, on the wire.
pub(crate) fn refusal(refused: Refused) -> Refusal {
    match refused {
        Refused::NotEnabled | Refused::Silence => Refusal::NotEnabled,
        Refused::TooFast => Refusal::TooFast,
        Refused::TooSteep => Refusal::TooSteep,
        Refused::BeyondTravel => Refusal::BeyondTravel,
        Refused::Broken => Refusal::NotStanding,
        // None that there is yet.
        _ => Refusal::OutOfRange,
    }
}

fn range_on_the_wire(range: NormalRange) -> RangeCode {
    match range {
        NormalRange::Learning => RangeCode::Learning,
        NormalRange::Inside => RangeCode::Inside,
        NormalRange::Above => RangeCode::Above,
        NormalRange::Below => RangeCode::Below,
    }
}

// One that is new in the library would be told as the last one below: it is to have a name here first.
const _: () = assert!(Fault::ALL.len() == 9);

fn on_the_wire(fault: Fault) -> FaultCode {
    match fault {
        Fault::EncoderJump => FaultCode::EncoderJump,
        Fault::EncoderFrozen => FaultCode::EncoderFrozen,
        Fault::FollowingError => FaultCode::FollowingError,
        Fault::SupplyOutOfRange => FaultCode::SupplyOutOfRange,
        Fault::Overrun => FaultCode::Overrun,
        Fault::NotANumber => FaultCode::NotANumber,
        Fault::OverCurrent => FaultCode::OverCurrent,
        Fault::Overload => FaultCode::Overload,
        Fault::CurrentOffset => FaultCode::CurrentOffset,
        _ => FaultCode::NotANumber,
    }
}
