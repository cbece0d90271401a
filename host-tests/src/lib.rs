//! Host checks of Preslide: an independent reference, and the paths and parameters that it is driven with;
//! and the trials that the diagnosis is judged by.

pub mod case;
pub mod deviation;
pub mod judge;
pub mod machines;
pub mod path;
pub mod reference;
pub mod table;
pub mod table3;
pub mod trials;

use std::path::PathBuf;

/// The folder of the real recordings; where it is absent, `None` and a loud line.
pub fn recordings() -> Option<PathBuf> {
    let root = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/recordings"
    ));
    if root.is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED: ../shared/recordings is absent");
    None
}
