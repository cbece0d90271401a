//! What the background has to say to a debug probe: `defmt` over RTT, with the feature `log`.
//!
//! Never called by the control task. A message is written in a critical section, though, which delays the task by the
//! few microseconds that writing takes; that is why it is a feature, and off when nobody listens.

use preslide_link::FaultCode;

#[cfg(feature = "log")]
use defmt_rtt as _;

/// The log of the background.
#[derive(Default)]
pub struct Log {
    fault: Option<FaultCode>,
}

impl Log {
    /// Tells of faults as they come and go.
    pub fn fault(&mut self, fault: Option<FaultCode>) {
        if fault != self.fault {
            self.fault = fault;
            #[cfg(feature = "log")]
            defmt::error!("fault: {}", defmt::Debug2Format(&fault));
        }
    }
}
