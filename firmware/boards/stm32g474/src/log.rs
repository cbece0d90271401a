//! What the background has to say to a debug probe: `defmt` over RTT, with the feature `log`.
//!
//! Never called by the control task. A message is written in a critical section, though, which delays the task by the
//! few microseconds that writing takes; that is why it is a feature, and off when nobody listens.

use preslide_link::{FaultCode, Report};

#[cfg(feature = "log")]
use defmt_rtt as _;

/// The log of the background.
#[derive(Default)]
pub struct Log {
    fault: Option<FaultCode>,
}

impl Log {
    /// Tells of what is out of the ordinary in a report: refusals, and faults as they come and go.
    pub fn report(&mut self, report: &Report) {
        match report {
            Report::Refused(refusal) => {
                #[cfg(feature = "log")]
                defmt::warn!("refused: {}", defmt::Debug2Format(refusal));
                #[cfg(not(feature = "log"))]
                let _ = refusal;
            }
            Report::Sample(sample) if sample.fault != self.fault => {
                self.fault = sample.fault;
                #[cfg(feature = "log")]
                defmt::error!(
                    "tick {}: fault {}, code {}",
                    sample.tick,
                    defmt::Debug2Format(&sample.fault),
                    sample.code
                );
            }
            Report::Sample(_) | Report::Done => {}
        }
    }
}
