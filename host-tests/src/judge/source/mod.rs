//! Sources of recordings with a known truth, each asked of the tool.

pub mod bench;
pub mod generated;
pub mod injection;
pub mod trials;

use std::path::Path;

use super::case::Case;

/// Writes every case for machines.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_json(file: Option<&Path>, cases: &[Case]) -> Result<(), String> {
    let Some(file) = file else { return Ok(()) };
    let cases: Vec<_> = cases.iter().map(Case::to_json).collect();
    let text = serde_json::to_string_pretty(&cases).map_err(|e| e.to_string())?;
    std::fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()))
}
