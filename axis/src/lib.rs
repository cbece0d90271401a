//! `axis.toml`: one description of an axis, which a board's build compiles in and the tool reads.
//!
//! ```
//! let file = preslide_axis::AxisFile::parse("axis.toml", preslide_axis::OWN)?;
//! assert_eq!(file.axis(), preslide::control::Axis::PAPER_AXIS);
//! # Ok::<(), preslide_axis::AxisError>(())
//! ```
//!
//! All values are SI; an axis that turns has rad and N·m. Keys are the fields of [`preslide::control::Axis`], and the names by which
//! `preslide drive PORT set` knows them. Every key must be there but those of a board, of a notch, of a brake and `resistance_span`, so that a misspelt one is told and nothing is
//! taken from another axis.

use preslide::control::{Axis, Coefficients, NoFriction};
use preslide::{ParamError, Units};

mod file;

pub use file::{AxisFile, Board};

/// The project's own file, which a build and the tool take where no other is named.
pub const OWN: &str = include_str!("../../axis.toml");

/// The variable that names the file to take.
pub const VARIABLE: &str = "PRESLIDE_AXIS";

/// What a file must say of itself.
pub const SCHEMA: &str = "preslide.axis/1";

/// Why a file is no axis.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    /// It cannot be read.
    #[error(
        "{file}: {error}; give the path of an axis.toml (the project's own is at the root of the repository)"
    )]
    Read {
        /// Its path.
        file: String,
        /// What the system said.
        error: std::io::Error,
    },
    /// Not TOML, a key that is missing, unknown or of the wrong kind: line and key are in the message.
    #[error("{file}: {error}")]
    Toml {
        /// Its path.
        file: String,
        /// What the parser said.
        error: Box<toml::de::Error>,
    },
    /// Another kind of file.
    #[error("{file}: schema is \"{found}\", not \"{SCHEMA}\"")]
    Schema {
        /// Its path.
        file: String,
        /// What it says.
        found: String,
    },
    /// Values that make no axis.
    #[error("{file}: {}", list(errors))]
    Values {
        /// Its path.
        file: String,
        /// What is wrong with it.
        errors: Vec<String>,
    },
}

fn list(errors: &[String]) -> String {
    errors.join("\n")
}

/// The axis as a Rust expression: what a build script writes for `include!`.
pub fn rust(axis: &Axis) -> String {
    // `Debug` prints structs as they are written, and numbers so that they read back as the same bits.
    format!(
        "{{ #[allow(unused_imports)] use ::preslide::control::{{VelocitySource::*, *}}; {axis:?} }}\n"
    )
}

/// Whether a controller can be built for it, in the arithmetic that has the least room.
fn usable(axis: &Axis) -> Result<(), ParamError> {
    Coefficients::try_new(axis, NoFriction::<f32>::new(), Units::SI).map(|_| ())
}
