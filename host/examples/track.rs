//! The tracking table: `cargo run --release --example track`.

use preslide::control::Settings;
use preslide_host::stage::StageConfig;
use preslide_host::tracking::{print, table};

fn main() -> Result<(), preslide_host::tracking::TrackingError> {
    let rows = table(
        &Settings::PAPER_AXIS,
        &StageConfig::default(),
        |done, all| {
            eprintln!("{done}/{all}");
        },
    )?;
    print!("{}", print(&rows));
    Ok(())
}
