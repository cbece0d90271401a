//! The task at the control rate.

use crate::{Bridge, Change};
use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use embedded_hal::pwm::SetDutyCycle;
use heapless::spsc::{Consumer, Producer};
use preslide::control::{Command, Controller, Fault, Measurement, Move, NormalRange};
use preslide::{Friction, Scalar};
use preslide_link::{FaultCode, RangeCode, Sample};

/// What a board measured at the start of a tick, raw.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Quadrature counter.
    pub count: u32,
    /// Supply (mV).
    pub supply: u16,
    /// Winding current (0.1 mA).
    pub current: i16,
    /// The last tick had not ended when this one was due.
    pub late: bool,
}

/// Control: from the counter to the bridge, once a sample time.
///
/// **Deadline:** the next tick. A tick that misses it is followed at once by the one that it delayed, told by
/// [`Inputs::late`]; the bridge holds the old code for the time between. The reference advances by ticks, so it
/// waits with the axis and no step follows. After more than [`preslide::control::Watch::overruns`] late ticks
/// in a row the axis goes to its safe state. A task that never ends is the watchdog's business.
pub struct Control<F: Friction + 'static> {
    pub(crate) controller: Controller<F, u32>,
    pub(crate) moves: Consumer<'static, Move>,
    pub(crate) changes: Consumer<'static, Change<F>>,
    pub(crate) samples: Producer<'static, Sample>,
    pub(crate) stopped: &'static AtomicBool,
    pub(crate) heard: &'static AtomicBool,
    /// Ticks from one sample of telemetry to the next, and since the last.
    pub(crate) every: &'static AtomicU16,
    pub(crate) since: u16,
    pub(crate) tick: u32,
    pub(crate) sequence: u32,
    pub(crate) dropped: u32,
}

impl<F: Friction> Control<F> {
    /// One tick. The bridge gets its code before the telemetry is written.
    #[inline]
    pub fn tick<A, B>(&mut self, inputs: Inputs, bridge: &mut Bridge<A, B>)
    where
        A: SetDutyCycle<Error = Infallible>,
        B: SetDutyCycle<Error = Infallible>,
    {
        let change = self.changes.dequeue();
        // Not one exchange: a word heard between the two is followed by others.
        if self.heard.load(Ordering::Relaxed) {
            self.heard.store(false, Ordering::Relaxed);
            self.controller.heard();
        }
        // In the safe state the queue is emptied, one move a tick: nobody can ask for a restart faster than that.
        let wanted = self.controller.is_idle() || !self.controller.is_enabled();
        let next = if wanted { self.moves.dequeue() } else { None };
        let measurement = Measurement {
            count: inputs.count,
            supply: inputs.supply,
            current: inputs.current,
            late: inputs.late,
        };
        let command = decide(&mut self.controller, change, next, measurement);
        bridge.set(command.code);
        self.stopped
            .store(!command.enabled, Ordering::Relaxed);

        self.tick = self.tick.wrapping_add(1);
        self.since = self.since.saturating_add(1);
        if self.since < self.every.load(Ordering::Relaxed) {
            return;
        }
        self.since = 0;
        let condition = self.controller.condition();
        let sample = Sample {
            sequence: self.sequence,
            dropped: self.dropped,
            tick: self.tick,
            position: command.position as i32,
            reference: command.reference,
            // Within ± the limiter's, which is at most 32000.
            code: command.code as i16,
            current: inputs.current,
            supply: inputs.supply,
            fault: command.fault.map(on_the_wire),
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
    change: Option<Change<F>>,
    next: Option<Move>,
    measurement: Measurement<u32>,
) -> Command {
    match change {
        Some(Change::Swap(coefficients)) => controller.swap(coefficients),
        Some(Change::Restart) => {
            controller.acknowledge();
            // What speaks against it shows as the fault of the next sample.
            let _ = controller.enable();
        }
        None => {}
    }
    if let Some(next) = next {
        // Refused beyond the axis's limits and in the safe state.
        let _ = controller.start(next);
    }
    controller.tick(measurement)
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
        // The wire has no words of their own for these yet.
        Fault::NotANumber | Fault::OverCurrent | Fault::Overload | Fault::CurrentOffset => {
            FaultCode::NotANumber
        }
    }
}
