//! The SQLite files of ROS 2 bags (`.db3`): the joint states in them.

use rusqlite::{Connection, OpenFlags};

use super::ros::{Bag, JOINT_STATE};
use super::{Input, Variable};

const MESSAGES: &str = "SELECT topics.name, messages.timestamp, messages.data FROM messages JOIN topics ON messages.topic_id = topics.id \
     WHERE topics.type = ?1 AND topics.serialization_format = 'cdr' ORDER BY messages.timestamp, messages.id";

pub(super) fn variables(mut input: Input) -> Result<Vec<Variable>, String> {
    let broken = |e: rusqlite::Error| {
        format!("no ROS 2 bag that can be read ({e}); copy or record it again")
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(input.path, flags).map_err(broken)?;
    let mut statement = connection.prepare(MESSAGES).map_err(broken)?;
    let mut rows = statement.query([JOINT_STATE]).map_err(broken)?;
    let mut bag = Bag::default();
    while let Some(row) = rows.next().map_err(broken)? {
        let topic: String = row.get(0).map_err(broken)?;
        let logged: i64 = row.get(1).map_err(broken)?;
        let message = row.get_ref(2).map_err(broken)?;
        let message = message.as_blob().map_err(|e| broken(e.into()))?;
        let logged = logged.try_into().unwrap_or_default();
        bag.take(&topic, logged, message, &mut input.budget)?;
    }
    bag.variables()
}
