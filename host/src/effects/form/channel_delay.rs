//! The force is recorded `τ` after the motion.

use super::Range::Any;
use super::{BARE, Form};

/// `channel_delay`.
pub(crate) static CHANNEL_DELAY: Form = Form {
    id: "channel_delay",
    keys: &[("delay_s", Any)],
    controller: Err(
        "it is a matter of the recording: the force was sampled later than the position",
    ),
    ..BARE
};
