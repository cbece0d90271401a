//! The messages. Telemetry is raw: counts and codes, scaled on the host.

use serde::{Deserialize, Serialize};

/// Most Maxwell-slip blocks in a [`ModelSettings`].
pub const MOST_BLOCKS: usize = 4;

/// From the host to the controller. SI units.
///
/// Gains and friction model can be changed while the axis runs. Limits, motor, watch and reference cannot: they say what
/// the machine is, and change with the firmware's build.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Answered with [`Report::Done`].
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
    /// Take this friction model between two ticks.
    Model(ModelSettings),
    /// Leave the safe state.
    Restart,
    /// Send every `every`-th tick's telemetry, so that a slow line keeps up.
    Telemetry {
        /// Ticks from sample to sample, at least 1.
        every: u16,
    },
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

/// A quasi-static Maxwell-slip model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelSettings {
    /// Breakaway force `F_s` (N).
    pub breakaway_n: f32,
    /// Stiffness (N/m) and weight (-) of each block.
    pub blocks: [(f32, f32); MOST_BLOCKS],
}

/// From the controller to the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// One tick's telemetry.
    Sample(Sample),
    /// A request was carried out, or queued.
    Done,
    /// A request or a frame was refused; the running parameters stay.
    Refused(Refusal),
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
    /// Position from the first reading (counts).
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
}

/// Why a frame or a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
    /// The queue of moves is full; send it again later.
    Busy,
    /// The controller is in its safe state; send [`Request::Restart`] first.
    Stopped,
    /// The friction model was compiled in as `preslide export` wrote it: it changes with the firmware's build.
    CompiledIn,
}
