//! The messages. Telemetry is raw: counts and codes, scaled on the host.

use crate::{Name, Parameter};
use serde::{Deserialize, Serialize};

/// Most parameters of a friction model and its effects.
pub const MOST_PARAMETERS: usize = 64;

/// Parameters in a [`ModelPart`]: what a frame has room for.
pub const PART: usize = 12;

/// Points in a [`Request::Points`].
pub const POINTS: usize = 8;

/// What both ends must speak; the controller tells it in [`Identity`].
pub const PROTOCOL: u16 = 6;

/// A request with the number that its answer carries.
///
/// A controller that gets the number of one of the last [`crate::WINDOW`] requests again answers again and does not carry it out
/// again, so a host may repeat what was not answered: a move is made once.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbered {
    /// Told by the host, one more than the last.
    pub id: u16,
    /// What is asked for.
    pub request: Request,
}

/// From the host to the controller. SI units: m and N, or rad and N·m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Tells that the host is there; a controller that hears nothing stops a moving axis.
    Ping,
    /// Move by `distance_m` (signed) at up to `speed_m_s`, reached in `ramp_s`; queued behind earlier moves.
    Move {
        /// Distance (m).
        distance_m: f32,
        /// Speed (m/s).
        speed_m_s: f32,
        /// Time to reach it (s).
        ramp_s: f32,
    },
    /// Rest (s), queued like a move.
    Dwell {
        /// Duration (s).
        time_s: f32,
    },
    /// Take these gains between two ticks.
    Gains(GainSettings),
    /// Take parameters of the friction model; all of them between two ticks, when the last are there.
    Model(ModelPart),
    /// Acknowledge a fault. The axis stays disabled.
    Acknowledge,
    /// Send every `every`-th tick's telemetry, so that a slow line keeps up; 0 for none.
    Telemetry {
        /// Ticks from sample to sample.
        every: u16,
    },
    /// Begins a conversation: numbers of earlier requests are forgotten. Answered with [`Reply::Identity`].
    Hello,
    /// Answered with [`Reply::State`].
    State,
    /// Hold the position from here on.
    Enable,
    /// Stop, then open the bridge.
    Disable,
    /// Brake within the limits, and drop what is queued.
    Stop,
    /// Find the origin.
    Home(Homing),
    /// The axis is at this position (m): its travel counts from there.
    Zero {
        /// Position (m).
        position_m: f32,
    },
    /// Move to `position_m`; else as [`Request::Move`].
    MoveTo {
        /// Position (m).
        position_m: f32,
        /// Speed (m/s).
        speed_m_s: f32,
        /// Time to reach it (s).
        ramp_s: f32,
    },
    /// Go on at this speed (m/s, signed) until a stop.
    Jog {
        /// Speed (m/s).
        speed_m_s: f32,
    },
    /// Points of a stream, queued all or none. The motion ends at rest where the last point is sent twice.
    Points(Points),
    /// Answered with [`Reply::Parameter`].
    Get(Name),
    /// The parameter of this number, counted from 0; [`Refusal::NoParameter`] behind the last.
    GetAt(u8),
    /// Set a parameter.
    Set(Name, f32),
    /// Keep parameters and friction model over a reset.
    Save,
    /// Forget what was saved; what was compiled in rules from the next reset on.
    Forget,
}

/// How to find the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Homing {
    /// What marks it.
    pub mark: Mark,
    /// Speed on the way to it (m/s, signed).
    pub speed_m_s: f32,
    /// What the position there is called (m).
    pub position_m: f32,
    /// How far to move back from a stop (m), at the same speed; 0 stays there.
    pub back_off_m: f32,
}

/// What marks the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mark {
    /// The encoder's index pulse.
    Index,
    /// A mechanical stop: the axis lags by half of the following error that is a fault, or does not come on for half of the time that
    /// is a fault, at a current that moves it whatever the friction.
    Stop,
}

/// Points of a stream, one every `ticks`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Points {
    /// Ticks from point to point.
    pub ticks: u16,
    /// The first point (2⁻¹⁶ counts).
    pub first: i64,
    /// From each point to the next (2⁻¹⁶ counts).
    pub steps: [i32; POINTS - 1],
}

/// Gains of the feedback.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainSettings {
    /// `K_p` (N/m).
    pub proportional: f32,
    /// `K_i` (N/(m·s)).
    pub integral: f32,
    /// `K_d` (N·s/m).
    pub derivative: f32,
}

/// Parameters of the friction model and its effects, in the order in which `preslide export` wrote them; the parts in turn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelPart {
    /// [`Identity::model`] of the model that they are for.
    pub layout: u32,
    /// How many come before these.
    pub first: u8,
    /// SI units; what is beyond the model's last is ignored.
    pub values: [f32; PART],
}

/// From the controller to the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// One tick's telemetry.
    Sample(Sample),
    /// The answer to the request of this number.
    Answer {
        /// Of the request.
        id: u16,
        /// What came of it.
        reply: Reply,
    },
    /// A frame could not be read, so nobody knows which request it was; the running parameters stay.
    Damaged(Refusal),
}

/// What came of a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// It was carried out, or queued.
    Done {
        /// Moves or points that the queue still takes.
        room: u16,
    },
    /// It was refused; nothing of it was taken.
    Refused(Refusal),
    /// To [`Request::Hello`].
    Identity(Identity),
    /// To [`Request::State`].
    State(State),
    /// To [`Request::Get`] and [`Request::GetAt`].
    Parameter(Parameter),
}

/// Who speaks, and what turns its telemetry into SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// [`PROTOCOL`] of the firmware.
    pub protocol: u16,
    /// Ticks per second (Hz).
    pub rate_hz: u32,
    /// One encoder count (m or rad).
    pub count: f64,
    /// Motor force at the stage per ampere (N/A or N·m/A).
    pub effort_per_a: f32,
    /// Moves and points that the empty queue takes.
    pub room: u16,
    /// What it runs with was saved, rather than compiled in.
    pub saved: bool,
    /// Which parameters its friction model has, and in which order (`LAYOUT` of what `preslide export` wrote).
    pub model: u32,
}

/// How the controller is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct State {
    /// What it does.
    pub mode: Mode,
    /// Why the PWM is off, where that is not by order.
    pub fault: Option<FaultCode>,
    /// Positions count from the axis's origin, and its travel has ends.
    pub located: bool,
    /// The host has been silent for too long, and a moving axis was stopped.
    pub silent: bool,
    /// What the controller was last reset by.
    pub reset: ResetCause,
    /// Ticks since then.
    pub tick: u32,
    /// Position (counts).
    pub position: i64,
    /// Moves and points that wait.
    pub queued: u16,
    /// Moves that were planned but not made since the reset: the stream ran dry, or an end of travel.
    pub dropped: u16,
    /// Orders of an outer task that came too late since the reset; 0 without one.
    pub missed: u16,
    /// Supply (mV).
    pub supply: u16,
    /// Winding current (0.1 mA).
    pub current: i16,
}

/// What the controller does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// The bridge is open.
    Disabled,
    /// It holds its position.
    Standing,
    /// The reference moves.
    Moving,
    /// It looks for its origin.
    Homing,
}

/// What a controller was reset by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Power came on.
    Power,
    /// The supply was too low.
    BrownOut,
    /// The watchdog: the control task hung, or the firmware panicked.
    Watchdog,
    /// The reset pin or a debug probe.
    Pin,
    /// The firmware itself.
    Software,
}

/// One tick, raw.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the sample; a gap shows what was lost on the way.
    pub sequence: u32,
    /// Samples that found the queue full, since the start.
    pub dropped: u32,
    /// Number of the tick.
    pub tick: u32,
    /// Position (counts) from the origin: the first reading, or what homing or zeroing made it.
    pub position: i32,
    /// Reference (2⁻¹⁶ counts).
    pub reference: i64,
    /// PWM code.
    pub code: i16,
    /// Winding current (0.1 mA).
    pub current: i16,
    /// Supply voltage (mV).
    pub supply: u16,
    /// Why the PWM is off.
    pub fault: Option<FaultCode>,
    /// What the watch on the friction model says; `None` without a watch. A status: the axis runs on.
    pub range: Option<RangeCode>,
    /// Friction level less 1, in 10⁻⁴; 0 without adaptation.
    pub level: i16,
}

/// `preslide::control::NormalRange` on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RangeCode {
    /// The normal range is being learned.
    Learning,
    /// What the drive spends on friction is within its normal range.
    Inside,
    /// It is above: wear, a new spot.
    Above,
    /// It is below.
    Below,
}

/// `preslide::control::Fault` on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultCode {
    /// The count moved further in a tick than the axis can.
    EncoderJump,
    /// No count came although the command pushed hard.
    EncoderFrozen,
    /// The position error is too large.
    FollowingError,
    /// The supply voltage is out of its range.
    SupplyOutOfRange,
    /// Too many late ticks in a row.
    Overrun,
    /// The command was not a number.
    NotANumber,
    /// The current was too high.
    OverCurrent,
    /// The winding has been above its rated current for too long (I²t).
    Overload,
    /// The current sense reads too much while the bridge is open.
    CurrentOffset,
    /// The bridge's own protection opened it (break input).
    Bridge,
    /// The axis met the limit switch at the low end of its travel, or went on there.
    LimitLow,
    /// The same at the high end.
    LimitHigh,
}

/// Why a frame or a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The frame is longer than any request.
    Oversized,
    /// The frame is too short, or COBS's lengths do not fit.
    Malformed,
    /// The CRC differs: the frame was damaged on its way.
    Checksum,
    /// The CRC fits, but there is no such message.
    Unknown,
    /// A value is not finite or out of its range; nothing of the request was taken.
    OutOfRange,
    /// The queue is full; send it again later.
    Busy,
    /// The controller is in its safe state; send [`Request::Acknowledge`] first.
    Faulted,
    /// The firmware's friction model has other parameters: what it is made of changes with the firmware's build.
    OtherModel,
    /// The axis is not enabled.
    NotEnabled,
    /// Only where the axis is disabled.
    Enabled,
    /// Only where the axis stands.
    NotStanding,
    /// Faster than the axis's speed limit.
    TooFast,
    /// Steeper than the axis's acceleration limit.
    TooSteep,
    /// It ends beyond the ends of travel.
    BeyondTravel,
    /// There is no such parameter.
    NoParameter,
    /// The parameter changes with the firmware's build only.
    ReadOnly,
    /// The board has no memory for parameters, or writing it failed.
    Storage,
}
