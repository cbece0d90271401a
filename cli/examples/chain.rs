//! Steps of the chain that know what the stage conceals; `cargo xtask chain` runs them between those of the tool, which
//! does not.
//!
//! `chain list SEED COUNT` prints the effects; `chain serve SEED INDEX ELF PORT` records: the telemetry goes to `preslide
//! capture tcp:127.0.0.1:PORT`; `chain known SEED INDEX MODEL.toml` writes the truth as a model file; `chain track SEED INDEX
//! NONE.elf FOLDER` follows the judged motion with it and with the other images in the folder; `chain table SEED FOLDER…` prints the result, from `diagnosis.json` and `errors.json` in each folder, and fails where the aim is missed. `chain
//! rehearse SEED COUNT` does it all in one process, with the same control code on the host instead of the firmware. `--electrical` at the
//! end puts all of it on the electrical stage.

use anyhow::{Context, bail};
use preslide_axis::AxisFile;
use preslide_sim::chain::{Errors, Row, Tracked, Trial, known, rehearse, serve, table, track};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let electrical = words.pop_if(|word| *word == "--electrical").is_some();
    let axis = AxisFile::chosen(None)?.axis();
    let draw = |seed: &str, count: usize| -> anyhow::Result<Vec<Trial>> {
        let trials = Trial::draw(seed.parse()?, count).into_iter();
        let on = |trial: Trial| {
            let trial = trial.on(&axis);
            if electrical {
                trial.electrical()
            } else {
                trial
            }
        };
        Ok(trials.map(on).collect())
    };
    let trial = |seed: &str, index: &str| {
        let trial = draw(seed, index.parse::<usize>()? + 1)?.pop();
        trial.context("there is always one")
    };
    match words[..] {
        ["list", seed, count] => {
            for trial in draw(seed, count.parse()?)? {
                println!("{:?}", trial.effect);
            }
        }
        ["serve", seed, index, elf, port] => {
            print!(
                "{}",
                serve(&trial(seed, index)?, Path::new(elf), port.parse()?)?
            );
        }
        ["known", seed, index, file] => {
            let model = known(&trial(seed, index)?).map_err(anyhow::Error::msg)?;
            std::fs::write(file, model.to_toml(&[])).with_context(|| file.to_owned())?;
        }
        ["track", seed, index, none, folder] => {
            let (trial, folder) = (trial(seed, index)?, Path::new(folder));
            let of = |elf: &Path| match elf.exists() {
                true => track(&trial, elf).map(Tracked::from),
                false => Ok(Tracked::NotRun),
            };
            let error = |name: &str| of(&folder.join(name));
            let errors = Errors {
                none: of(Path::new(none))?,
                before: error("before.elf")?,
                refit: error("refit.elf")?,
                after: error("after.elf")?,
                known: error("known.elf")?,
            };
            let text = serde_json::to_string(&errors)?;
            std::fs::write(folder.join("errors.json"), text)?;
        }
        ["table", seed, ref folders @ ..] => {
            let trials = draw(seed, folders.len())?;
            let rows = trials.iter().zip(folders).map(|(trial, folder)| {
                let folder = Path::new(folder);
                anyhow::Ok(Row {
                    concealed: trial.effect.id(),
                    told: read(&folder.join("diagnosis.json"))?,
                    errors: read(&folder.join("errors.json"))?,
                })
            });
            tell(&rows.collect::<anyhow::Result<Vec<_>>>()?)?;
        }
        ["rehearse", seed, count] => {
            let trials = draw(seed, count.parse()?)?;
            let rows = trials.par_iter().map(rehearse);
            tell(&rows.collect::<anyhow::Result<Vec<_>>>()?)?;
        }
        _ => bail!("usage: see the head of cli/examples/chain.rs; `cargo xtask chain` runs it"),
    }
    Ok(())
}

fn tell(rows: &[Row]) -> anyhow::Result<()> {
    let (text, enough) = table(rows);
    print!("{text}");
    if !enough {
        bail!("the aim is missed");
    }
    Ok(())
}

fn read<T: DeserializeOwned>(file: &Path) -> anyhow::Result<T> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    serde_json::from_str(&text).with_context(|| file.display().to_string())
}
