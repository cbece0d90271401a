//! `cargo run --release --example track` prints the tracking table; with `adaptation` behind `--`, tracking with and without
//! adaptation of the friction level; with `watch`, the watch's false alarms, asked for and measured, and its delays.

use preslide::control::{LearningSettings, Settings};
use preslide_host::stage::StageConfig;
use preslide_host::tracking::{adaptation, print, table, watch};

fn main() -> anyhow::Result<()> {
    let settings = Settings::PAPER_AXIS;
    let learning = LearningSettings::PAPER_AXIS;
    let stage = StageConfig::default();
    let progress = |done, all| eprintln!("{done}/{all}");
    let what = std::env::args().nth(1);
    let text = match what.as_deref() {
        None => print(&table(&settings, &stage, progress)?),
        Some("adaptation") => {
            adaptation::print(&adaptation::table(&settings, &learning, 6, progress)?)
        }
        Some("watch") => watch::print(&watch::study(&settings, &learning, 400, 12, progress)?),
        Some(other) => anyhow::bail!("give `adaptation`, `watch` or nothing, not `{other}`"),
    };
    print!("{text}");
    Ok(())
}
