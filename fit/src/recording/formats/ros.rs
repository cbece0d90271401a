//! Joint states of ROS 2 (`sensor_msgs/msg/JointState`), as columns.

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::from_bytes;
use serde::Deserialize;

use super::{Variable, spend};

/// The message type that is read.
pub(super) const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// `std_msgs/Header`.
#[derive(Deserialize)]
struct Header {
    stamp: (i32, u32),
    #[allow(dead_code, reason = "part of the message")]
    frame_id: String,
}

/// `sensor_msgs/JointState`: positions in rad or m, velocities, efforts in N·m or N; any of the three may be empty.
#[derive(Deserialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

impl JointState {
    /// From CDR with its four bytes of encapsulation, the second of which gives the byte order.
    fn read(message: &[u8]) -> Result<Self, String> {
        let (head, body) = message.split_at_checked(4).ok_or("an empty message")?;
        let read = match head[1] {
            0 => from_bytes::<Self, BigEndian>(body),
            1 => from_bytes::<Self, LittleEndian>(body),
            other => return Err(format!("an encapsulation ({other}) that is no plain CDR")),
        };
        read.map(|(state, _)| state).map_err(|e| {
            format!(
                "a message that is no {JOINT_STATE} in CDR ({e}); convert the bag without compressing its messages"
            )
        })
    }

    /// Time of the message (s, ns).
    fn stamp(&self) -> (i64, i64) {
        let (seconds, nanoseconds) = self.header.stamp;
        (i64::from(seconds), i64::from(nanoseconds))
    }
}

/// One joint's columns; `None` where its messages have none.
#[derive(Default)]
struct Joint {
    name: String,
    columns: [Vec<f64>; 3],
}

const COLUMNS: [&str; 3] = ["position", "velocity", "effort"];

/// The joint states of one topic.
struct Topic {
    name: String,
    stamps: Vec<(i64, i64)>,
    /// When they were logged (ns).
    logged: Vec<u64>,
    joints: Vec<Joint>,
}

/// The joint states of a bag.
#[derive(Default)]
pub(super) struct Bag {
    topics: Vec<Topic>,
}

impl Bag {
    /// Takes a message of [`JOINT_STATE`].
    pub(super) fn take(
        &mut self,
        topic: &str,
        logged: u64,
        message: &[u8],
        budget: &mut u64,
    ) -> Result<(), String> {
        let state =
            JointState::read(message).map_err(|e| format!("a bag whose topic {topic} has {e}"))?;
        spend(budget, 32 + 24 * state.name.len() as u64)?;
        let at = self.topics.iter().position(|t| t.name == topic);
        let at = at.unwrap_or_else(|| {
            self.topics.push(Topic {
                name: topic.to_owned(),
                stamps: Vec::new(),
                logged: Vec::new(),
                joints: Vec::new(),
            });
            self.topics.len() - 1
        });
        self.topics[at].take(logged, &state);
        Ok(())
    }

    /// `t_s` and the joints' columns; where several topics have joint states, each name follows that of its topic.
    pub(super) fn variables(self) -> Result<Vec<Variable>, String> {
        if self.topics.is_empty() {
            return Err(format!(
                "a bag without {JOINT_STATE}; record the topic of the joint states, such as /joint_states"
            ));
        }
        let several = self.topics.len() > 1;
        let of = |topic: Topic| {
            let prefix = match several {
                true => format!("{}:", topic.name),
                false => String::new(),
            };
            topic.variables(&prefix)
        };
        Ok(self.topics.into_iter().flat_map(of).collect())
    }
}

impl Topic {
    fn take(&mut self, logged: u64, state: &JointState) {
        let before = self.stamps.len();
        self.stamps.push(state.stamp());
        self.logged.push(logged);
        for (k, name) in state.name.iter().enumerate() {
            let at = self.joints.iter().position(|j| j.name == *name);
            let at = at.unwrap_or_else(|| {
                self.joints.push(Joint {
                    name: name.clone(),
                    ..Joint::default()
                });
                self.joints.len() - 1
            });
            let given = [&state.position, &state.velocity, &state.effort];
            for (column, given) in self.joints[at].columns.iter_mut().zip(given) {
                column.resize(before, f64::NAN);
                column.push(given.get(k).copied().unwrap_or(f64::NAN));
            }
        }
    }

    fn variables(self, prefix: &str) -> Vec<Variable> {
        let count = self.stamps.len();
        let mut found = vec![Variable::column(format!("{prefix}t_s"), self.times())];
        for mut joint in self.joints {
            for (mut values, what) in std::mem::take(&mut joint.columns).into_iter().zip(COLUMNS) {
                values.resize(count, f64::NAN);
                if values.iter().any(|v| !v.is_nan()) {
                    let name = format!("{prefix}{}.{what}", joint.name);
                    found.push(Variable::column(name, values));
                }
            }
        }
        found
    }

    /// Seconds since the first message: by the messages' stamps, or by when they were logged where nobody stamped them.
    fn times(&self) -> Vec<f64> {
        let first = self.stamps.first().copied().unwrap_or_default();
        if self.stamps.iter().any(|s| *s != first) {
            let since = |s: &(i64, i64)| (s.0 - first.0) as f64 + 1e-9 * (s.1 - first.1) as f64;
            return self.stamps.iter().map(since).collect();
        }
        let first = self.logged.first().copied().unwrap_or_default();
        let since = |t: &u64| 1e-9 * (*t as i128 - first as i128) as f64;
        self.logged.iter().map(since).collect()
    }
}
