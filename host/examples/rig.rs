//! Runs a firmware ELF in QEMU: `rig fixed|float ELF` compares its commands with the host's simulation,
//! `rig faults ELF FOLDER [--bless]` injects the faults and compares with the golden files. `rig serve ELF PORT` follows
//! the identification motion and hands its telemetry to `preslide capture tcp:127.0.0.1:PORT`. `rig record ELF PLUGIN` has
//! a QEMU plugin watch the motion. `cargo xtask qemu` and `cargo xtask cycles` call it.

use anyhow::{Context, bail};
use fixed::types::I16F16;
use preslide::control::Settings;
use preslide::{Block, QuasiStaticGms, Units};
use preslide_host::rig::{Listener, Script, agreement, injections, motion, requests, run};
use preslide_host::tracking::FIXED_UNITS;
use preslide_host::tracking::motions::identification;
use std::path::Path;

/// What the firmware starts with: the paper's Table 3, four blocks, through the command link's single precision.
fn blocks() -> ([Block; 4], f64) {
    let blocks = [
        (313_728.0_f32, 0.339_f32),
        (43_670.0, 0.236),
        (10_545.0, 0.171),
        (5_858.0, 0.253),
    ];
    let blocks = blocks.map(|(stiffness, weight)| Block {
        stiffness: stiffness.into(),
        weight: weight.into(),
    });
    (blocks, 0.9_f32.into())
}

/// Codes by which a command in `f32` may differ: one, by rounding. In fixed point none may differ.
const FLOAT_BOUND: u32 = 1;

/// Ticks that the motion takes, but for the rest at its end.
const MOVING: u64 = 10_000;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (blocks, breakaway) = blocks();
    match words[..] {
        [kind @ ("fixed" | "float"), elf] => {
            let elf = Path::new(elf);
            let (agreement, record) = if kind == "fixed" {
                let model = QuasiStaticGms::<4, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
                agreement(elf, model, FIXED_UNITS)?
            } else {
                let model = QuasiStaticGms::<4, f32>::try_new(&blocks, breakaway, Units::SI)?;
                agreement(elf, model, Units::SI)?
            };
            println!(
                "{kind}: {agreement:?}, {} reports",
                record.remains.reports.len()
            );
            print!("{}", record.remains.log);
            let bound = if kind == "fixed" { 0 } else { FLOAT_BOUND };
            if agreement.largest > bound || agreement.reach < 100 {
                bail!(
                    "QEMU and the host differ by {} codes; the bound is {bound}",
                    agreement.largest
                );
            }
        }
        ["serve", elf, port] => {
            let port = port.parse().context("the port")?;
            println!("waiting for `preslide capture` on tcp:127.0.0.1:{port}");
            let mut script = Script::quiet(0);
            // One request a move, each in time for the one before it to end.
            let mut tick = 20;
            for step in identification() {
                let request = requests(&[step]);
                script = script.send(tick, &request);
                tick += step.plan::<f32>(&Settings::PAPER_AXIS, Units::SI)?.ticks() as u64;
            }
            script.ticks = tick + 200;
            let record = run(Path::new(elf), &script, Listener::Tcp(port))?;
            print!("{}", record.remains.log);
        }
        ["record", elf, plugin] => {
            let mut script = Script::quiet(MOVING).send(20, &requests(&motion()));
            script.plugin = Some(plugin.to_owned());
            let record = run(Path::new(elf), &script, Listener::File)?;
            if record.broke_off {
                bail!("the firmware ended early: {}", record.remains.log);
            }
        }
        ["faults", elf, folder] => faults(Path::new(elf), Path::new(folder), false)?,
        ["faults", elf, folder, "--bless"] => faults(Path::new(elf), Path::new(folder), true)?,
        _ => bail!(
            "usage: rig fixed|float ELF, rig faults ELF FOLDER [--bless], rig serve ELF PORT, or rig record ELF PLUGIN"
        ),
    }
    Ok(())
}

fn faults(elf: &Path, folder: &Path, bless: bool) -> anyhow::Result<()> {
    let undisturbed = run(
        elf,
        &Script::quiet(14_000).send(20, &requests(&motion())),
        Listener::File,
    )?;
    let mut different = Vec::new();
    for injection in injections() {
        let text = injection.tell(elf, &undisturbed)?;
        println!("== {}\n{text}", injection.name);
        let golden = folder.join(format!("{}.txt", injection.name));
        if bless {
            std::fs::write(&golden, text).with_context(|| golden.display().to_string())?;
        } else if std::fs::read_to_string(&golden).unwrap_or_default() != text {
            different.push(injection.name);
        }
    }
    if !different.is_empty() {
        bail!(
            "unlike the golden files: {}; look at the output above, and `cargo xtask qemu --bless` if it is right",
            different.join(", ")
        );
    }
    Ok(())
}
