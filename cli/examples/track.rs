//! `cargo run --release --example track` prints the tracking table; behind `--`: `adaptation`, tracking with and without adaptation of
//! the friction level; `observer`, the observer's rows
//! with friction and mass off from its model; `koopman`, every controller tuned alike, Koopman MPC among them, on stages that differ from the model (`koopman-electrical` on the electrical one); `koopman-firmware`, the file for a board's outer task (PRESLIDE_KOOPMAN); `watch`, the watch's false alarms, asked for and measured, and its delays; `dead-time`, what the bridge's dead
//! time costs and what making up for it wins back; `notch`, what a notch at the drive's first mode buys; `winding`, what a warm winding costs and what following its resistance wins back; `identify`, what a capture says of friction by how the current is sampled.
//!
//! `--electrical` puts the table on the electrical stage, its dead time known to the controller; not with `--electrical=uncompensated`;
//! `centre`, `unsynchronised` and `oversampled` in place of `uncompensated` sample the current otherwise than the firmware does. Behind `only`: parts of the names of the rows wanted, as in `only none tanh GMS`.

use anyhow::bail;
use preslide::control::{LearningSettings, Settings};
use preslide_axis::AxisFile;
use preslide_sim::rig::sensed;
use preslide_sim::stage::{ElectricalConfig, Sampling, SenseConfig, StageConfig};
use preslide_sim::tracking::{
    TRACKING_SEEDS, adaptation, dead_time, electrical, koopman, notch, observer, print, table,
    watch, winding,
};

fn main() -> anyhow::Result<()> {
    let mut settings = AxisFile::chosen(None)?.axis();
    let learning = LearningSettings::PAPER_AXIS;
    let mut stage = StageConfig::default().on(&settings);
    let progress = |done, all| eprintln!("{done}/{all}");
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let only = match words.iter().position(|word| word == "only") {
        Some(at) => words.split_off(at).split_off(1),
        None => Vec::new(),
    };
    let what = words.first();
    let text = match what.map(String::as_str) {
        None => print(&table(&settings, &stage, &only, progress)?),
        Some("adaptation") => {
            adaptation::print(&adaptation::table(&settings, &learning, 6, progress)?)
        }
        Some("watch") => watch::print(&watch::study(&settings, &learning, 400, 12, progress)?),
        Some("observer") => observer::print(&observer::study(&settings, &stage, progress)?),
        Some(word @ ("koopman" | "koopman-electrical")) => {
            let electrical = word != "koopman";
            koopman::print(&koopman::study(&settings, &stage, electrical, progress)?)
        }
        Some("koopman-firmware") => koopman::source(&koopman::firmware(&settings, stage)?),
        Some("dead-time") => dead_time::print(&dead_time::study(
            &settings,
            &ElectricalConfig::default(),
            &TRACKING_SEEDS,
        )?),
        Some("notch") => notch::print(&notch::study::<f32>(
            &settings,
            &stage,
            preslide::Units::SI,
            [&notch::DRIVES, &notch::NOTCHES],
            &TRACKING_SEEDS,
        )?),
        Some("winding") => winding::print(&winding::study(&settings, &TRACKING_SEEDS)?),
        Some("identify") => sensed::print(&sensed::study()?),
        Some(word) if word.starts_with("--electrical") => {
            stage = electrical(&mut settings, stage);
            otherwise(word, &mut settings, &mut stage)?;
            print(&table(&settings, &stage, &only, progress)?)
        }
        Some(other) => bail!(
            "give `adaptation`, `observer`, `koopman`, `koopman-electrical`, `koopman-firmware`, `watch`, `dead-time`, `notch`, `winding`, `identify`, `--electrical` or nothing, not `{other}`"
        ),
    };
    print!("{text}");
    Ok(())
}

fn otherwise(word: &str, settings: &mut Settings, stage: &mut StageConfig) -> anyhow::Result<()> {
    let sampling = match word.strip_prefix("--electrical") {
        Some("") => return Ok(()),
        Some("=uncompensated") => {
            settings.hardware.dead_time = 0.0;
            return Ok(());
        }
        Some("=centre") => Sampling::Synchronous(0.5),
        Some("=unsynchronised") => Sampling::Unsynchronised,
        Some("=oversampled") => Sampling::Oversampled(16),
        _ => bail!(
            "give --electrical or --electrical=uncompensated, centre, unsynchronised or oversampled, not `{word}`"
        ),
    };
    if let Some(electrical) = &mut stage.electrical {
        electrical.sense = SenseConfig {
            sampling,
            ..electrical.sense.clone()
        };
    }
    Ok(())
}
