//! The columns of a recording, by the format's own names.

use super::units::Dimension;
use super::{EffortRole, MotionKind};

/// A role that a column can have in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    Time,
    /// Time since the sample before.
    Step,
    Position,
    Reference,
    Velocity,
    Effort,
    Temperature,
    Load,
    Pressure,
    Segment,
    Repeat,
}

impl Slot {
    pub(super) fn words(self) -> &'static str {
        match self {
            Slot::Time => "time",
            Slot::Step => "time step",
            Slot::Position => "position",
            Slot::Reference => "reference position",
            Slot::Velocity => "velocity",
            Slot::Effort => "effort (force, friction, torque, current or voltage)",
            Slot::Temperature => "temperature",
            Slot::Load => "normal load",
            Slot::Pressure => "pressure",
            Slot::Segment => "segment",
            Slot::Repeat => "repeat",
        }
    }
    /// Segment and repeat hold numbers of parts, not physical quantities.
    pub(super) fn is_label(self) -> bool {
        matches!(self, Slot::Segment | Slot::Repeat)
    }
}

/// A column name that is understood.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) name: &'static str,
    pub(super) slot: Slot,
    pub(super) axis: Option<MotionKind>,
    pub(super) role: Option<EffortRole>,
    /// None where any number will do.
    pub(super) dimension: Option<Dimension>,
}

const fn known(
    name: &'static str,
    slot: Slot,
    axis: Option<MotionKind>,
    role: Option<EffortRole>,
    dimension: Option<Dimension>,
) -> Known {
    Known {
        name,
        slot,
        axis,
        role,
        dimension,
    }
}

const LINEAR: Option<MotionKind> = Some(MotionKind::Linear);
const ROTARY: Option<MotionKind> = Some(MotionKind::Rotary);

impl Known {
    /// How far from the load an effort is measured: of a force and the current that makes it, the force is the effort. 0 for all else.
    pub(super) fn steps_to_the_load(&self) -> u8 {
        match self.role {
            Some(EffortRole::Current) => 1,
            Some(EffortRole::Voltage) => 2,
            Some(EffortRole::Raw) => 3,
            Some(EffortRole::Force | EffortRole::Friction | EffortRole::Torque) | None => 0,
        }
    }
}

/// The format's column names (design, "Recording").
#[rustfmt::skip]
pub(super) const KNOWN: [Known; 21] = [
    known("t_s", Slot::Time, None, None, Some(Dimension::Time)),
    known("dt_s", Slot::Step, None, None, Some(Dimension::Time)),
    known("x_m", Slot::Position, LINEAR, None, Some(Dimension::Length)),
    known("q_rad", Slot::Position, ROTARY, None, Some(Dimension::Angle)),
    known("x_ref_m", Slot::Reference, LINEAR, None, Some(Dimension::Length)),
    known("q_ref_rad", Slot::Reference, ROTARY, None, Some(Dimension::Angle)),
    known("v_m_s", Slot::Velocity, LINEAR, None, Some(Dimension::Speed)),
    known("qd_rad_s", Slot::Velocity, ROTARY, None, Some(Dimension::AngularSpeed)),
    known("force_N", Slot::Effort, LINEAR, Some(EffortRole::Force), Some(Dimension::Force)),
    known("friction_N", Slot::Effort, LINEAR, Some(EffortRole::Friction), Some(Dimension::Force)),
    known("torque_Nm", Slot::Effort, ROTARY, Some(EffortRole::Torque), Some(Dimension::Torque)),
    known("current_A", Slot::Effort, None, Some(EffortRole::Current), Some(Dimension::Current)),
    known("voltage_V", Slot::Effort, None, Some(EffortRole::Voltage), Some(Dimension::Voltage)),
    known("effort_raw", Slot::Effort, None, Some(EffortRole::Raw), None),
    known("temperature_C", Slot::Temperature, None, None, Some(Dimension::Temperature)),
    known("normal_N", Slot::Load, None, None, Some(Dimension::Force)),
    known("load_N", Slot::Load, None, None, Some(Dimension::Force)),
    known("load_Nm", Slot::Load, ROTARY, None, Some(Dimension::Torque)),
    known("pressure_Pa", Slot::Pressure, None, None, Some(Dimension::Pressure)),
    known("segment", Slot::Segment, None, None, None),
    known("repeat", Slot::Repeat, None, None, None),
];
