//! The RISC-V example in QEMU, against the same blocks computed here in double precision.

use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use preslide_tools::process::{output_for, root, with_folder};
use preslide_tools::thumb::Toolchain;

const TARGET: &str = "riscv32imac-unknown-none-elf";
const NAME: &str = "riscv-virt";

/// Where the exported model comes from, and what the example has for its units: a count of 25 nm.
const MODEL: &str = "cli/tests/exported/packed.toml";
const COUNT: f64 = 25e-9;

/// Lines that it prints: one every 50 ticks of 9900.
const LINES: usize = 198;

/// How far the printed force may be from the computed one (mN): largest, RMS and mean. Packed blocks round yield displacement and stiffness
/// to 16 bits together, which is 0.013 % of the breakaway force RMS at six blocks, and some four times that at most.
const BOUNDS: [f64; 3] = [0.45, 0.12, 0.03];

/// A minute on two cores, of which half a second is the run.
const LIMIT: Duration = Duration::from_secs(600);

/// Where a newcomer reads how, and the line there that says where this tree is.
const README: &str = "src/README.md";
const CLONE: &str = "P=~/preslide";

/// Does in a fresh folder what the library's README says, and compares every force that it prints.
pub fn run_in_qemu() -> Result<()> {
    if Toolchain::or_skipped(TARGET, NAME).is_none() {
        return Ok(());
    }
    let readme = fs::read_to_string(root().join(README))?;
    let block = readme.split_once("```sh\n");
    let commands = block.and_then(|(_, rest)| rest.split("```").next());
    let commands = commands.filter(|commands| commands.contains(CLONE));
    let commands = commands
        .with_context(|| format!("{README}: its first commands do not begin with {CLONE}"))?
        .replace(CLONE, &format!("P={}", root().display()));
    let (printed, log) = with_folder("stranger", |folder| {
        let mut shell = Command::new("sh");
        shell.args(["-ec", &commands]).current_dir(folder);
        shell.env_remove("CARGO_TARGET_DIR").stdin(Stdio::null());
        output_for(&mut shell, LIMIT)
    })?;
    let model = fs::read_to_string(root().join(MODEL))?;
    let off = deviations(&printed, &blocks(&model)?)
        .with_context(|| format!("{README}:\n{printed}{log}"))?;
    let largest = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));
    let lines = off.len() as f64;
    let rms = (off.iter().map(|off| off * off).sum::<f64>() / lines).sqrt();
    let mean = off.iter().sum::<f64>() / lines;
    println!(
        "{README}, from cargo new: {LINES} forces; off the blocks in double precision by {largest:.3} mN at most, RMS {rms:.3}, mean {mean:+.3}"
    );
    let within = [largest, rms, mean.abs()]
        .iter()
        .zip(BOUNDS)
        .all(|(off, bound)| *off <= bound);
    ensure!(within, "more than {BOUNDS:?} mN");
    Ok(())
}

/// Stiffness (mN per count) and largest force (mN) of each block.
fn blocks(model: &str) -> Result<Vec<[f64; 2]>> {
    let value = |line: &str, key: &str| {
        let rest = line.split_once(key)?.1.trim_start_matches([' ', '=']);
        let end = rest.find([',', ' ', '}']).unwrap_or(rest.len());
        rest[..end].parse::<f64>().ok()
    };
    let breakaway = model.lines().find_map(|line| value(line, "breakaway_N"));
    let breakaway = breakaway.with_context(|| format!("{MODEL} has no breakaway_N"))?;
    let block = |line| {
        let stiffness = value(line, "stiffness_N_per_m")? * COUNT * 1e3;
        Some([stiffness, value(line, "weight")? * breakaway * 1e3])
    };
    let blocks: Vec<_> = model.lines().filter_map(block).collect();
    match blocks.len() {
        0 => bail!("{MODEL} has no blocks"),
        _ => Ok(blocks),
    }
}

/// Printed less computed force (mN) of every line `tick N: at P counts F mN`. Between two lines the motion turns at most once, at a place
/// that a line tells, so that the places of the lines are all that blocks which stick and slip ask for.
fn deviations(printed: &str, blocks: &[[f64; 2]]) -> Result<Vec<f64>> {
    let mut forces = vec![0.0_f64; blocks.len()];
    let (mut last, mut off) = (0.0, Vec::new());
    for line in printed.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let ["tick", _, "at", place, "counts", force, "mN"] = words[..] else {
            bail!("printed `{line}`");
        };
        let number = |word: &str| word.parse::<f64>().with_context(|| format!("`{word}`"));
        let (place, force) = (number(place)?, number(force)?);
        for (own, [stiffness, limit]) in forces.iter_mut().zip(blocks) {
            *own = (*own + stiffness * (place - last)).clamp(-limit, *limit);
        }
        last = place;
        off.push(force - forces.iter().sum::<f64>());
    }
    match off.len() {
        LINES => Ok(off),
        other => bail!("printed {other} forces, not {LINES}"),
    }
}
