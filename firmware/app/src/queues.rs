//! What lies between the two tasks.

use crate::telemetry::Samples;
use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use preslide::Friction;
use preslide::control::{Coefficients, Jog, Move};
use preslide_link::{FaultCode, Mark, Mode, Refusal};

/// Moves and points that wait; one more is used up by the queue itself.
pub const ROOM: u16 = 96;

/// A move, and the epoch that it was planned in.
pub(crate) type Planned = (u8, Move);

/// What the background tells the control task to do between two ticks.
// The large variant is copied once, from the queue to where it acts; there is no heap to box it in.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Order<F: Friction> {
    /// Take new parameters.
    Swap(Coefficients<F>),
    /// Anything else.
    Act(Act),
}

#[derive(Clone, Copy)]
pub(crate) enum Act {
    /// Hold the position.
    Enable,
    /// Stop, then open the bridge.
    Disable,
    /// Brake.
    Stop,
    /// Forget the fault.
    Acknowledge,
    /// Go on at a speed.
    Jog(Jog),
    /// The axis is at this position (counts).
    Place(i64),
    /// Find the origin.
    Seek(Seek),
}

/// How long an axis has not come on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stall {
    /// Where the axis came to, and for how many ticks it has been pushed there.
    place: i64,
    ticks: u16,
}

/// How the origin is found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seek {
    /// What marks it.
    pub mark: Mark,
    /// The way to it.
    pub jog: Jog,
    /// What the position there is called (counts).
    pub to: i64,
    /// How far the axis lags at a stop (counts).
    pub lag: i64,
    /// Current that moves it whatever the friction (codes), and for how many ticks it does not at a stop.
    pub push: u16,
    pub timeout: u16,
    pub stall: Stall,
    /// The move away from a stop.
    pub back: Option<Move>,
}

impl Seek {
    /// Whether the axis has met a stop: it lags far behind, or is pushed and does not come on by two counts.
    pub(crate) fn is_met(&mut self, lag: i64, position: i64, current: i16) -> bool {
        let stall = &mut self.stall;
        if position.abs_diff(stall.place) > 1 || current.unsigned_abs() < self.push {
            *stall = Stall {
                place: position,
                ticks: 0,
            };
        }
        stall.ticks = stall.ticks.saturating_add(1);
        lag >= self.lag || stall.ticks > self.timeout
    }
}

/// What the control task tells the background, every few ticks and after every order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Status {
    /// Orders carried out since the start, and what came of the last one.
    pub orders: u16,
    pub outcome: Result<(), Refusal>,
    /// Moves taken out of the queue since the start.
    pub taken: u16,
    /// Moves that were planned in another epoch are not made.
    pub epoch: u8,
    pub mode: Mode,
    pub fault: Option<FaultCode>,
    pub located: bool,
    pub silent: bool,
    pub tick: u32,
    /// Position and reference (counts).
    pub position: i64,
    pub reference: i64,
    pub dropped: u16,
    /// Orders of an outer task that came too late.
    pub missed: u16,
    pub supply: u16,
    pub current: i16,
}

/// What both tasks see.
pub(crate) struct Shared {
    /// The background has put something into a queue, or `heard`: the next tick looks.
    pub(crate) calls: AtomicBool,
    /// A frame came from the host.
    pub(crate) heard: AtomicBool,
    /// Ticks from one sample of telemetry to the next; 0 for none.
    pub(crate) every: AtomicU16,
    pub(crate) samples: Samples,
}

impl Shared {
    /// Has the next tick look for what has been put into a queue.
    pub(crate) fn call(&self) {
        self.calls.store(true, Ordering::Release);
    }
}
