//! The limit switches, as the control task watches them.

use preslide_link::FaultCode;

/// Which of an axis's limit switches are open, as one that the axis stands on is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// At the low end of travel.
    pub low: bool,
    /// At the high end.
    pub high: bool,
}

impl Limits {
    /// One of them is open.
    #[inline]
    pub fn any(self) -> bool {
        self.low || self.high
    }
}

/// Ticks in a row that a switch is open before it is met, which spikes on its wire do not last, and closed before it is left: 20 ms at
/// 20 kHz, for which its contact does not bounce.
const MET: u16 = 4;
const LEFT: u16 = 400;

/// A switch without its bouncing.
#[derive(Clone, Copy, Default)]
struct Switch {
    met: bool,
    /// Ticks in a row that speak against it.
    against: u16,
}

impl Switch {
    /// Whether it is met now and was not before.
    fn take(&mut self, open: bool) -> bool {
        self.against = if open == self.met {
            0
        } else {
            self.against + 1
        };
        let changes = self.against == if self.met { LEFT } else { MET };
        if changes {
            (self.met, self.against) = (open, 0);
        }
        changes && open
    }

    /// It is met, or is not sure.
    fn is_up(&self) -> bool {
        self.met || self.against > 0
    }
}

/// Both switches.
#[derive(Default)]
pub(crate) struct LimitWatch {
    low: Switch,
    high: Switch,
}

impl LimitWatch {
    /// Every tick is to be told.
    pub(crate) fn any(&self) -> bool {
        self.low.is_up() || self.high.is_up()
    }

    /// The fault of a tick before which the reference moved by `moved`.
    ///
    /// A switch that is met is a fault whichever way the axis went, since the two may be swapped. One on which the axis stands when it is
    /// enabled again lets it move away, and is a fault as soon as it moves on.
    pub(crate) fn take(&mut self, limits: Limits, moved: i64) -> Option<FaultCode> {
        let low = self.low.take(limits.low) || (self.low.met && moved < 0);
        let high = self.high.take(limits.high) || (self.high.met && moved > 0);
        if low {
            Some(FaultCode::LimitLow)
        } else if high {
            Some(FaultCode::LimitHigh)
        } else {
            None
        }
    }
}
