//! What the background has to say to a debug probe: `defmt`, with the feature of that name.
//!
//! Never called by the control task. A message is written in a critical section, though, which delays the task by the
//! few microseconds that writing takes; that is why it is a feature, and off when nobody listens.

use preslide_link::{FaultCode, Refusal};

/// The log of the background.
#[derive(Default)]
pub(crate) struct Log {
    #[cfg(feature = "defmt")]
    fault: Option<FaultCode>,
}

impl Log {
    /// Tells of faults as they come and go.
    #[cfg(feature = "defmt")]
    pub(crate) fn fault(&mut self, fault: Option<FaultCode>) {
        if fault != self.fault {
            self.fault = fault;
            defmt::error!("fault: {}", fault);
        }
    }

    #[cfg(not(feature = "defmt"))]
    #[inline(always)]
    pub(crate) fn fault(&mut self, _: Option<FaultCode>) {}

    /// Tells of a request that was not carried out.
    #[inline(always)]
    pub(crate) fn refused(&self, _id: u16, _refusal: Refusal) {
        #[cfg(feature = "defmt")]
        defmt::warn!("request {}: refused: {}", _id, _refusal);
    }
}
