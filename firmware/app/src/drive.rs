//! The tick of a board: what it measures, the control task, what it drives.

use crate::{Bridge, Control, CountEncoder, Inputs, Sense};
use preslide::Friction;

/// The control task with the board's encoder, converter and bridge.
pub struct Drive<F: Friction + 'static, E, S, B> {
    control: Control<F>,
    encoder: E,
    sense: S,
    bridge: B,
    late: bool,
}

impl<F: Friction, E: CountEncoder, S: Sense, B: Bridge> Drive<F, E, S, B> {
    /// With the bridge open.
    pub const fn new(control: Control<F>, encoder: E, sense: S, bridge: B) -> Self {
        Self {
            control,
            encoder,
            sense,
            bridge,
            late: false,
        }
    }

    /// The control task; see [`Control`] for its deadline and what happens when it is missed. The watchdog is fed after it.
    #[inline(always)]
    pub fn tick(&mut self) {
        self.sense.acknowledge();
        let (supply, current) = self.sense.read();
        let inputs = Inputs {
            index: self.encoder.index(),
            count: self.encoder.count(),
            supply,
            current,
            late: self.late,
        };
        self.control.tick(inputs, &mut self.bridge);
        self.late = self.sense.is_due();
    }
}
