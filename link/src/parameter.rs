//! Parameters by name.

use serde::{Deserialize, Serialize};

/// Longest name of a parameter (bytes).
pub const LONGEST_NAME: usize = 24;

/// The name of a parameter, such as `gains.proportional`; filled up with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Name([u8; LONGEST_NAME]);

impl Name {
    /// `None` where the text is longer than [`LONGEST_NAME`].
    pub fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; LONGEST_NAME];
        bytes
            .get_mut(..text.len())?
            .copy_from_slice(text.as_bytes());
        Some(Self(bytes))
    }

    /// As text; empty where it is none.
    pub fn as_str(&self) -> &str {
        let length = self.0.iter().position(|byte| *byte == 0);
        let bytes = self.0.get(..length.unwrap_or(LONGEST_NAME));
        core::str::from_utf8(bytes.unwrap_or_default()).unwrap_or_default()
    }
}

/// A parameter and its value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: Name,
    /// SI units.
    pub value: f32,
    /// It can be set; some only while the axis is disabled.
    pub settable: bool,
}
