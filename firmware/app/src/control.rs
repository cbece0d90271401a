//! The task at the control rate.

use crate::Bridge;
use crate::queues::{Order, Planned, Seek, Shared, Status};
use core::sync::atomic::Ordering;
use heapless::spsc::{Consumer, Producer};
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

/// Ticks from one [`Status`] to the next where no order came.
const STATUS_TICKS: u8 = 16;

/// Moves of an earlier epoch that are dropped in a tick: a full queue is empty in a millisecond.
const DROPS: usize = 4;

/// Control: from the counter to the bridge, once a sample time.
///
/// **Deadline:** the next tick. A tick that misses it is followed at once by the one that it delayed, told by
/// [`Inputs::late`]; the bridge holds the old code for the time between. The reference advances by ticks, so it
/// waits with the axis and no step follows. After more than [`preslide::control::Watch::overruns`] late ticks
/// in a row the axis goes to its safe state. A task that never ends is the watchdog's business.
pub struct Control<F: Friction + 'static> {
    controller: Controller<F, u32>,
    moves: Consumer<'static, Planned>,
    orders: Consumer<'static, Order<F>>,
    samples: Producer<'static, Sample>,
    statuses: Producer<'static, Status>,
    shared: &'static Shared,
    status: Status,
    /// The bridge opened itself; until it is acknowledged.
    broken: bool,
    /// To be disabled as soon as it stands.
    leaving: bool,
    seek: Option<Seek>,
    /// Where the reference was (2⁻¹⁶ counts).
    reference: i64,
    since_status: u8,
    /// Ticks since the last sample of telemetry.
    since: u16,
    sequence: u32,
    dropped: u32,
}

impl<F: Friction> Control<F> {
    pub(crate) fn new(
        controller: Controller<F, u32>,
        moves: Consumer<'static, Planned>,
        orders: Consumer<'static, Order<F>>,
        samples: Producer<'static, Sample>,
        statuses: Producer<'static, Status>,
        shared: &'static Shared,
    ) -> Self {
        Self {
            controller,
            moves,
            orders,
            samples,
            statuses,
            shared,
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
                supply: 0,
                current: 0,
            },
            broken: false,
            leaving: false,
            seek: None,
            reference: 0,
            since_status: 0,
            since: 0,
            sequence: 0,
            dropped: 0,
        }
    }

    pub(crate) fn status(&self) -> Status {
        self.status
    }

    /// One tick. The bridge gets its code before anything is told.
    #[inline]
    pub fn tick(&mut self, inputs: Inputs, bridge: &mut impl Bridge) {
        if bridge.is_broken() && self.controller.is_enabled() {
            self.broken = true;
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
        if self.seek.is_some() {
            self.seek(&inputs);
        }
        self.feed();
        let measurement = Measurement {
            count: inputs.count,
            supply: inputs.supply,
            current: inputs.current,
            late: inputs.late,
        };
        let command = decide(&mut self.controller, measurement);
        if command.enabled {
            bridge.drive(command.code);
        } else {
            bridge.open();
        }
        self.reference = command.reference;
        self.tell(&inputs, &command, ordered);
    }

    /// The next order. Not in the tick, which would then set aside room for it on the stack.
    #[inline(never)]
    fn obey(&mut self) {
        if let Some(order) = self.orders.dequeue() {
            self.status.outcome = self.carry_out(order);
            self.status.orders = self.status.orders.wrapping_add(1);
        }
    }

    fn carry_out(&mut self, order: Order<F>) -> Result<(), Refusal> {
        match order {
            Order::Swap(coefficients) => self.controller.swap(coefficients),
            Order::Enable => {
                if self.broken {
                    return Err(Refusal::Faulted);
                }
                self.leaving = false;
                self.new_epoch();
                self.controller.enable().map_err(|_| Refusal::Faulted)?;
            }
            Order::Disable => {
                self.brake();
                self.leaving = true;
            }
            Order::Stop => self.brake(),
            Order::Acknowledge => {
                self.broken = false;
                self.controller.acknowledge();
            }
            Order::Jog(jog) => {
                self.new_epoch();
                self.seek = None;
                self.controller.jog(jog).map_err(refusal)?;
            }
            Order::Place(to) => {
                self.new_epoch();
                self.controller.set_position(self.controller.position(), to);
            }
            Order::Seek(seek) => {
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
        self.status.epoch = self.status.epoch.wrapping_add(1);
    }

    /// Looks whether the origin is reached.
    #[inline(never)]
    fn seek(&mut self, inputs: &Inputs) {
        let (position, current) = (self.controller.position(), self.current(inputs));
        let lag = ((self.reference >> 16) - position).abs();
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
        if *epoch != self.status.epoch || self.controller.is_idle() {
            self.take();
        }
    }

    /// Starts it; moves before it that were planned in another epoch are dropped.
    #[inline(never)]
    fn take(&mut self) {
        for _ in 0..DROPS {
            let stale = match self.moves.peek() {
                Some((epoch, _)) => *epoch != self.status.epoch,
                None => return,
            };
            if !stale && !self.controller.is_idle() {
                return;
            }
            let Some((_, next)) = self.moves.dequeue() else {
                return;
            };
            self.status.taken = self.status.taken.wrapping_add(1);
            if !stale {
                if self.controller.start(next).is_err() {
                    self.status.dropped = self.status.dropped.saturating_add(1);
                    self.new_epoch();
                }
                return;
            }
            self.status.dropped = self.status.dropped.saturating_add(1);
        }
    }

    /// Status and telemetry.
    #[inline]
    fn tell(&mut self, inputs: &Inputs, command: &Command, ordered: bool) {
        let status = &mut self.status;
        status.tick = status.tick.wrapping_add(1);
        self.since_status += 1;
        if ordered || self.since_status >= STATUS_TICKS {
            self.since_status = 0;
            let current = self.current(inputs);
            self.tell_status(inputs.supply, current);
        }
        self.since = self.since.saturating_add(1);
        let every = self.shared.every.load(Ordering::Relaxed);
        if self.since >= every && every > 0 {
            self.since = 0;
            self.tell_sample(inputs, command);
        }
    }

    #[inline(never)]
    fn tell_status(&mut self, supply: u16, current: i16) {
        // Asked, not told: a command in memory would cost every tick.
        let enabled = self.controller.is_enabled();
        let standing = self.controller.is_standing();
        if self.leaving && standing {
            self.leaving = false;
            self.controller.disable();
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
        self.status.fault = match self.controller.fault() {
            Some(fault) => Some(on_the_wire(fault)),
            None => self.broken.then_some(FaultCode::Bridge),
        };
        self.status.located = self.controller.is_located();
        self.status.silent = silent;
        self.status.position = self.controller.position();
        // To the nearest count.
        self.status.reference = self.reference.wrapping_add(1 << 15) >> 16;
        self.status.supply = supply;
        self.status.current = current;
        // See `tell_sample`. One that finds no room is followed by another; the answer to an order waits for it.
        let is_queue = self.statuses.capacity().checked_add(1).is_some();
        if !is_queue || self.statuses.enqueue(self.status).is_err() {
            self.since_status = STATUS_TICKS;
        }
    }

    /// The winding's current, less what its sense reads at rest.
    #[inline]
    fn current(&self, inputs: &Inputs) -> i16 {
        inputs
            .current
            .saturating_sub(self.controller.current_at_rest())
    }

    #[inline]
    fn tell_sample(&mut self, inputs: &Inputs, command: &Command) {
        let condition = self.controller.condition();
        let sample = Sample {
            sequence: self.sequence,
            dropped: self.dropped,
            tick: self.status.tick,
            position: command.position as i32,
            reference: command.reference,
            // Within ± the limiter's, which is at most 32000.
            code: command.code as i16,
            current: self.current(inputs),
            supply: inputs.supply,
            fault: match command.fault {
                Some(fault) => Some(on_the_wire(fault)),
                None => self.broken.then_some(FaultCode::Bridge),
            },
            range: condition.range.map(range_on_the_wire),
            level: condition.level.map_or(0, |level| {
                let ten_thousandths = level
                    .sub_input(Scalar::ONE)
                    .mul_input(Scalar::from_int(10_000));
                // The level is within 0.5…1.5.
                ten_thousandths.round_to_int() as i16
            }),
        };
        // The queue divides by its length, `capacity + 1`: asked here, so that the compiler knows that it is not 0 and
        // links no panic.
        let is_queue = self.samples.capacity().checked_add(1).is_some();
        if is_queue && self.samples.enqueue(sample).is_ok() {
            self.sequence = self.sequence.wrapping_add(1);
        } else {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }
}

#[inline]
fn decide<F: Friction>(
    controller: &mut Controller<F, u32>,
    measurement: Measurement<u32>,
) -> Command {
    controller.tick(measurement)
}

/// Why a move was not started, on the wire.
pub(crate) fn refusal(refused: Refused) -> Refusal {
    match refused {
        Refused::NotEnabled | Refused::Silence => Refusal::NotEnabled,
        Refused::TooFast => Refusal::TooFast,
        Refused::TooSteep => Refusal::TooSteep,
        Refused::BeyondTravel => Refusal::BeyondTravel,
        Refused::Broken => Refusal::NotStanding,
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
    }
}
