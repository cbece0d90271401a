//! MCAP: the joint states of ROS 2 in it.

use super::ros::{Bag, JOINT_STATE};
use super::{Input, Variable};

pub(super) fn variables(mut input: Input) -> Result<Vec<Variable>, String> {
    let bytes = input.bytes()?;
    let broken = |e: ::mcap::McapError| {
        format!("an MCAP file that cannot be read ({e}); copy it again, or `mcap recover` it")
    };
    let mut bag = Bag::default();
    for message in ::mcap::MessageStream::new(&bytes).map_err(broken)? {
        let message = message.map_err(broken)?;
        let channel = &message.channel;
        let schema = channel.schema.as_ref().map_or("", |s| s.name.as_str());
        if schema == JOINT_STATE && channel.message_encoding == "cdr" {
            bag.take(
                &channel.topic,
                message.log_time,
                &message.data,
                &mut input.budget,
            )?;
        }
    }
    bag.variables()
}
