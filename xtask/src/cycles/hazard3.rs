//! `cargo xtask cycles --hazard3`: exact cycles on the RP2350's RISC-V core, of which the RTL is simulated.
//!
//! `verilator` makes a program of the RTL in `../shared/hardware/hazard3`, which is not ours and no part of this repository, and of
//! `xtask/hazard3`: the configuration and a testbench with memory that answers in the next cycle. The measuring image of
//! `firmware/cycles` runs on it and counts with the core's own `mcycle` and `minstret`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::sizes::Sizes;
use super::table::{COLUMNS, Counts, grown};
use super::{BUILD, PREFIX, compare_with_host, nowhere, version_of};
use crate::process::{IN_ONE_PIECE, cargo, find, output_for, root, run_for};
use crate::tools::Need;

/// What writes its tables.
pub const COMMAND: &str = "cargo xtask cycles --hazard3";

const TARGET: &str = "riscv32imac-unknown-none-elf";

/// What the RP2350's core has beyond the target's name; Zcmp it has too, but rustc calls that unstable.
const FEATURES: &str = "-C target-feature=+zba,+zbb,+zbs,+zbkb,+zcb";

const RTL: &str = "../shared/hardware/hazard3/hdl";

const TABLE: &str = "firmware/cycles/hazard3-rp2350.csv";

/// The same core with memory that waits, and wait states of every access to instructions and to data; `None` is the table's own run.
const WAITING: &str = "firmware/cycles/hazard3-waiting.csv";
const WAITS: [Option<[u8; 2]>; 4] = [None, Some([1, 0]), Some([0, 1]), Some([1, 1])];

/// The simulation takes minutes.
const LIMIT: Duration = Duration::from_secs(3600);

/// Cycles by which a mean may grow besides the tables' tolerance: they are exact, but the compiler may be another one, and where the linker puts a function decides how many instructions lie across two words.
const ALIGNMENT: f64 = 2.0;

/// What was simulated, in the table's header.
const SIMULATED: &str = "# simulated: ";

/// Measures, prints the table and writes it.
pub fn run_command() -> Result<(), String> {
    if let Some(reason) = absent(&[]) {
        return Err(format!("{reason}: nothing was measured"));
    }
    Need::Verilator.ensure()?;
    Need::RiscvGcc.ensure()?;
    let simulation = Simulation::build()?;
    let table = simulation.table()?;
    print(&table);
    let waiting = simulation.waiting()?;
    println!("\n{waiting}");
    for (file, text) in [(TABLE, table), (WAITING, waiting)] {
        std::fs::write(root().join(file), text)
            .map_err(|error| format!("cannot write {file}: {error}"))?;
        println!("written to {file}");
    }
    Ok(())
}

/// Whether the committed table is what this tree measures. Same image, same core: the same cycles, without simulating them again.
/// The image is the same wherever the tree stands ([`super::nowhere`]), so that a fresh checkout is known.
pub fn check() -> Result<bool, String> {
    if let Some(reason) = absent(&["verilator", "riscv64-unknown-elf-gcc"]) {
        println!("\nSKIPPED: {TABLE} was not checked: {reason}");
        return Ok(false);
    }
    let committed = std::fs::read_to_string(root().join(TABLE))
        .map_err(|error| format!("cannot read {TABLE}: {error}"))?;
    let simulation = Simulation::build()?;
    let simulated = format!("{SIMULATED}{}", simulation.fingerprint()?);
    if committed.lines().any(|line| line == simulated) {
        println!("\n{TABLE} is of this very image on this very core");
        return same_run(&simulated).map(|()| true);
    }
    println!("\n{TABLE} is of another image or core; simulating this one");
    let measured = means(&simulation.table()?)?;
    let worse = grown(&means(&committed)?, &measured, ALIGNMENT, "cycles");
    if worse.is_empty() {
        println!("no mean grew by more than 3 % and two cycles over {TABLE}");
        return Ok(false);
    }
    Err(format!(
        "worse than {TABLE}:\n  {}\nIf that is meant, run `cargo xtask cycles --hazard3` and commit the table",
        worse.join("\n  ")
    ))
}

/// Whether the table of memory that waits is of the same run as the other.
fn same_run(simulated: &str) -> Result<(), String> {
    let waiting = std::fs::read_to_string(root().join(WAITING))
        .map_err(|error| format!("cannot read {WAITING}: {error}"))?;
    if waiting.lines().any(|line| line == simulated) {
        return Ok(());
    }
    Err(format!(
        "{WAITING} is of another image or core than {TABLE}: run `cargo xtask cycles --hazard3` and commit both"
    ))
}

/// Why there is nothing to simulate, or nothing to do it with.
fn absent(programs: &[&str]) -> Option<String> {
    let rtl = root().join(RTL);
    if !rtl.join("hazard3.f").is_file() {
        return Some(format!(
            "no RTL of Hazard3 in {RTL}; it is not part of this repository, clone Wren6991/Hazard3 there"
        ));
    }
    let missing = programs.iter().find(|program| find(program).is_none())?;
    Some(format!(
        "no {missing}; `cargo xtask cycles --hazard3` installs it"
    ))
}

/// What is simulated, and what runs on it.
struct Simulation {
    folder: PathBuf,
    /// The measuring program, and what of it is loaded.
    program: PathBuf,
    image: PathBuf,
    sources: Vec<PathBuf>,
}

impl Simulation {
    fn build() -> Result<Self, String> {
        let folder = root().join("firmware/target/hazard3");
        let told = |error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(&folder).map_err(told)?;
        let program = program(&folder)?;
        Ok(Self {
            image: image(&program)?,
            program,
            sources: sources(&folder)?,
            folder,
        })
    }

    /// One number for the image and the core.
    fn fingerprint(&self) -> Result<String, String> {
        // FNV-1a.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for file in self.sources.iter().chain([&self.image]) {
            let bytes =
                std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
            for byte in bytes {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
        Ok(format!("{hash:016x}"))
    }

    /// What the image prints: simulated, unless it has been before, on this very core. Where wait states are told, it measures little.
    fn printed(&self, waits: Option<[u8; 2]>) -> Result<String, String> {
        let waits = waits.map_or(vec![], |waits| {
            waits.map(|waits| waits.to_string()).to_vec()
        });
        let mut name = vec![format!("printed-{}", self.fingerprint()?)];
        name.extend_from_slice(&waits);
        let file = self.folder.join(name.join("-"));
        if let Ok(printed) = std::fs::read_to_string(&file) {
            println!("simulated before: {}", file.display());
            return Ok(printed);
        }
        let bench = bench(&self.sources, &self.folder)?;
        let (printed, _) = output_for(Command::new(bench).arg(&self.image).args(&waits), LIMIT)?;
        std::fs::write(&file, &printed)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
        Ok(printed)
    }

    /// The file: what was measured and how, the columns, and the rows that the image printed. Its forces must be the host's.
    fn table(&self) -> Result<String, String> {
        let printed = self.printed(None)?;
        let sizes = Sizes::of(&self.program)?;
        let (mut checksums, mut models) = (BTreeMap::new(), BTreeMap::new());
        let (mut rows, mut ticks) = (Vec::new(), "0");
        for line in printed.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            match words[..] {
                [
                    "kernel",
                    kernel,
                    n,
                    "calls",
                    calls,
                    "model",
                    model,
                    "checksum",
                    checksum,
                ] => {
                    checksums.insert(format!("{kernel} {n}"), checksum.to_string());
                    models.insert(format!("{kernel}__{n}"), model);
                    ticks = calls;
                }
                ["#", ..] => {}
                [COLUMNS] => rows.push(COLUMNS.to_string()),
                [row] if row.contains(',') => rows.push(with_flash(row, &sizes, &models)?),
                _ => return Err(format!("the image printed `{line}`")),
            }
        }
        if rows.first().is_none_or(|first| first != COLUMNS) {
            return Err(format!("the image's columns are not `{COLUMNS}`"));
        }
        compare_with_host(&checksums, ticks)?;
        let mut text = header(ticks)?;
        let _ = writeln!(text, "{SIMULATED}{}", self.fingerprint()?);
        for row in rows {
            let _ = writeln!(text, "{row}");
        }
        Ok(text)
    }

    /// What is measured under memory with wait states, too: one column of mean cycles for each.
    fn waiting(&self) -> Result<String, String> {
        let mut rows: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for waits in WAITS {
            for line in self.printed(waits)?.lines().skip(2) {
                let cells: Vec<&str> = line.split(',').collect();
                if let [kernel, n, _, _, cycles, ..] = cells[..]
                    && n != "n"
                {
                    let row = rows.entry(format!("{kernel},{n:>2}")).or_default();
                    row.push(cycles.to_string());
                }
            }
        }
        rows.retain(|_, cycles| cycles.len() == WAITS.len());
        let mut text = String::from(
            "# Mean cycles as in hazard3-rp2350.csv, where every access waits: of instructions (32 bits each), of data, of both.\n\
             # Made by `cargo xtask cycles --hazard3`.\n",
        );
        let _ = writeln!(text, "{SIMULATED}{}", self.fingerprint()?);
        text += "kernel,n";
        for [fetch, data] in WAITS.map(Option::unwrap_or_default) {
            let _ = write!(text, ",fetch_{fetch}_data_{data}");
        }
        text.push('\n');
        for (name, cycles) in rows {
            let _ = writeln!(text, "{},{}", name.replace(' ', ""), cycles.join(","));
        }
        Ok(text)
    }
}

fn header(ticks: &str) -> Result<String, String> {
    let mut text = String::new();
    for line in [
        "Exact cycles of one update on Hazard3, the RP2350's RISC-V core: its RTL, simulated by verilator, with the parameters of",
        "the RP2350's datasheet (section 3.8.8; xtask/hazard3/rp2350.v), counted by its own mcycle. Made by `cargo xtask cycles",
        "--hazard3`. Instructions and data each come from a memory without wait states over a port of its own; no interrupts.",
        "Code in flash behind a cache that misses, or two masters at one bank of SRAM, takes longer: not in these figures.",
        "Rust is built for riscv32imac with zba, zbb, zbs, zbkb and zcb; zcmp is unstable in rustc and left out. The core has no",
        "float unit: f32 is software. The C peers are gcc's with picolibc's exponential.",
        "cycles_mean and cycles_worst are of a call and its return, and nothing else; instructions hold the call and one reading of",
        "the counter: take 2 off for the function alone. cycles_in_tick is by how much a control tick",
        "(PID in f32, sensors in memory) grows with the kernel inlined. Empty columns are not measured.",
        "flash_bytes: code of the kernel and of all that it can call, called or not, and the parameters. Tables are not counted.",
    ] {
        let _ = writeln!(text, "# {line}");
    }
    let _ = writeln!(
        text,
        "# calls: {ticks} each, the first of the motion of cortex-m4.csv"
    );
    for program in ["rustc", "riscv64-unknown-elf-gcc", "verilator"] {
        let _ = writeln!(text, "# {program}: {}", version_of(program)?);
    }
    Ok(text)
}

/// What the simulator is made of: the RTL as it is but for [`fetch_queue`], our configuration and testbench.
fn sources(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let rtl = root().join(RTL);
    let mut sources = Vec::new();
    for folder in [rtl.join("arith"), rtl.clone()] {
        sources.extend(files(&folder, "v")?);
    }
    let frontend = rtl.join("hazard3_frontend.v");
    sources.retain(|file| *file != frontend);
    sources.push(fetch_queue(&frontend, folder)?);
    let ours = root().join("xtask/hazard3");
    sources.extend([ours.join("rp2350.v"), ours.join("bench.cpp")]);
    Ok(sources)
}

/// The instruction fetch with one of its blocks cut in two, which by the language's rules changes nothing.
///
/// The block reads registers of the fetch queue and drives the wire at the queue's end, an element of the same array. Verilator 5.006
/// does not run it again when the registers change, because it takes the array for the block's own, and loses what was fetched.
fn fetch_queue(frontend: &Path, folder: &Path) -> Result<PathBuf, String> {
    const DRIVEN: &str = "\tfifo_valid_hw[FIFO_DEPTH] = 2'b00;\n";
    const CUT: &str = "end\n\nalways @ (*) begin: validity\n\tinteger i;\n";
    let told = |error| format!("{}: {error}", frontend.display());
    let text = std::fs::read_to_string(frontend).map_err(told)?;
    let (before, after) = text.split_once(DRIVEN).ok_or_else(|| {
        format!(
            "{} is not as xtask/src/cycles/hazard3.rs knows it: no `{}`",
            frontend.display(),
            DRIVEN.trim()
        )
    })?;
    let file = folder.join("hazard3_frontend.v");
    std::fs::write(&file, [before, DRIVEN, CUT, after].concat())
        .map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(file)
}

/// The simulator: the core with its testbench.
fn bench(sources: &[PathBuf], folder: &Path) -> Result<PathBuf, String> {
    let rtl = root().join(RTL);
    let mut verilator = Command::new("verilator");
    verilator
        .args([
            "--cc",
            "--exe",
            "--build",
            "-j",
            "2",
            "-O3",
            "-CFLAGS",
            "-O3 -march=native",
        ])
        .args(["-MAKEFLAGS", "OPT_FAST=-O3"])
        // The RTL is taken as it is, warnings included.
        .args(["-Wno-fatal", "-Wno-lint", "-Wno-style", "--noassert"])
        .args(["--x-assign", "fast", "--x-initial", "fast"])
        .args(["--top-module", "rp2350", "--Mdir"])
        .arg(folder.join("bench"))
        .arg(format!("-I{}", rtl.display()))
        .arg(format!("-I{}", rtl.join("arith").display()))
        .args(sources)
        .args(["-o", "bench"]);
    run_for(&mut verilator, LIMIT)?;
    Ok(folder.join("bench/bench"))
}

/// The files of a folder that end in this, in order.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, String> {
    let told = |error| format!("{}: {error}", folder.display());
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(told)? {
        let path = entry.map_err(told)?.path();
        if path.extension().is_some_and(|found| found == ending) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// The row with its flash: the kernel's function with all that it can call, and its parameters.
fn with_flash(row: &str, sizes: &Sizes, models: &BTreeMap<String, &str>) -> Result<String, String> {
    let mut cells: Vec<String> = row.split(',').map(str::to_string).collect();
    let [kernel, n, ..] = &cells[..] else {
        return Err(format!("the image printed `{row}`"));
    };
    let name = format!("{kernel}__{n}");
    let model = models
        .get(&name)
        .and_then(|model| model.parse::<u32>().ok());
    let model = model.ok_or_else(|| format!("the image did not tell the parameters of {name}"))?;
    let flash = sizes.reached_from(&format!("{PREFIX}{name}"))? + model;
    let column = COLUMNS.split(',').position(|name| name == "flash_bytes");
    if let Some(cell) = column.and_then(|at| cells.get_mut(at)) {
        *cell = flash.to_string();
    }
    Ok(cells.join(","))
}

/// What of the measuring program memory holds.
fn image(program: &Path) -> Result<PathBuf, String> {
    let image = program.with_extension("bin");
    let mut copy = Command::new("riscv64-unknown-elf-objcopy");
    run_for(copy.args(["-O", "binary"]).arg(program).arg(&image), LIMIT)?;
    Ok(image)
}

/// The measuring program.
fn program(folder: &Path) -> Result<PathBuf, String> {
    let mut build = cargo(&BUILD);
    build
        .args(["--target", TARGET, "--target-dir"])
        .arg(folder)
        .env("RUSTFLAGS", FEATURES)
        .envs([IN_ONE_PIECE])
        .current_dir(root().join("firmware"));
    nowhere::wrap(&mut build)?;
    run_for(&mut build, LIMIT).map_err(|error| {
        format!("{error}\nIf the target is missing: rustup target add {TARGET}")
    })?;
    Ok(folder.join(TARGET).join("release/cycles"))
}

/// The rows as people read them.
fn print(table: &str) {
    let rows = |line: &&str| !line.starts_with('#');
    let (head, lines) = (
        table.lines().filter(|line| !rows(line)),
        table.lines().filter(rows),
    );
    for line in head {
        println!("{line}");
    }
    println!();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        if let [kernel, n, mean, longest, cycles, worst, _, _, in_tick, ..] = cells[..] {
            println!(
                "{kernel:<30} {n:>3} {mean:>17} {longest:>16} {cycles:>11} {worst:>12} {in_tick:>14}"
            );
        }
    }
}

/// Mean cycles by kernel and N.
fn means(table: &str) -> Result<Counts, String> {
    let lines = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    let mean = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let mean = cells.get(4)?.parse().ok()?;
        let name = format!("{} N={}", cells.first()?, cells.get(1)?);
        Some((name, vec![("the mean", mean)]))
    };
    lines
        .map(|line| mean(line).ok_or_else(|| format!("{TABLE}: cannot read `{line}`")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{ALIGNMENT, Counts, grown, means};

    #[test]
    fn a_mean_may_grow_by_three_percent_and_two_cycles() {
        let table =
            |mean: &str| means(&format!("# made\nkernel,n\na,4,,,{mean},120,,,\n")).unwrap();
        let regressions = |old: &Counts, new: &Counts| grown(old, new, ALIGNMENT, "cycles");
        assert!(regressions(&table("100.0"), &table("105.0")).is_empty());
        assert_eq!(regressions(&table("100.0"), &table("106.0")).len(), 1);
        assert_eq!(regressions(&table("100.0"), &Default::default()).len(), 1);
        assert!(means("kernel,n\na,4,,,x,1\n").unwrap_err().contains("a,4"));
    }
}
