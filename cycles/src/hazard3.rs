//! `cargo xtask cycles --hazard3`: exact cycles on the RP2350's RISC-V core, of which the RTL is simulated.
//!
//! `verilator` makes a program of the RTL in `../shared/hardware/hazard3`, which is not ours and no part of this repository, and of
//! `cycles/hazard3`: the configuration and a testbench with memory that answers in the next cycle. The measuring image of
//! `firmware/cycles` runs on it and counts with the core's own `mcycle` and `minstret`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use fs_err as fs;
use preslide_tools::need::Need;
use preslide_tools::process::{command, find, output_for, root, run_for};

use super::sizes::Sizes;
use super::table::{COLUMNS, Counts, grown};
use super::{PREFIX, cargo_for, compare_with_host, no_image, nowhere, version_of};

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
pub fn run_command() -> Result<()> {
    if let Some(reason) = absent(&[]) {
        bail!("{reason}: nothing was measured");
    }
    Need::Verilator.ensure()?;
    Need::RiscvGcc.ensure()?;
    let simulation = Simulation::build()?;
    let table = simulation.table()?;
    print(&table);
    let waiting = simulation.waiting()?;
    println!("\n{waiting}");
    for (file, text) in [(TABLE, table), (WAITING, waiting)] {
        fs::write(root().join(file), text)?;
        println!("written to {file}");
    }
    Ok(())
}

/// Whether the committed table is what this tree measures. Same image, same core: the same cycles, without simulating them again.
/// The image is the same wherever the tree stands ([`super::nowhere`]), so that a fresh checkout is known.
pub fn check() -> Result<bool> {
    if let Some(reason) = absent(&["verilator", "riscv64-unknown-elf-gcc"]) {
        println!("\nSKIPPED: {TABLE} was not checked: {reason}");
        return Ok(false);
    }
    let committed = fs::read_to_string(root().join(TABLE))?;
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
    bail!(
        "worse than {TABLE}:\n  {}\nIf that is meant, run `cargo xtask cycles --hazard3` and commit the table",
        worse.join("\n  ")
    )
}

/// Whether the table of memory that waits is of the same run as the other.
fn same_run(simulated: &str) -> Result<()> {
    let waiting = fs::read_to_string(root().join(WAITING))?;
    if waiting.lines().any(|line| line == simulated) {
        return Ok(());
    }
    bail!(
        "{WAITING} is of another image or core than {TABLE}: run `cargo xtask cycles --hazard3` and commit both"
    )
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
    fn build() -> Result<Self> {
        let folder = root().join("firmware/target/hazard3");
        fs::create_dir_all(&folder)?;
        let program = program(&folder)?;
        Ok(Self {
            image: image(&program)?,
            program,
            sources: sources(&folder)?,
            folder,
        })
    }

    /// One number for the image and the core.
    fn fingerprint(&self) -> Result<String> {
        // FNV-1a.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for file in self.sources.iter().chain([&self.image]) {
            for byte in fs::read(file)? {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
        Ok(format!("{hash:016x}"))
    }

    /// What the image prints: simulated, unless it has been before, on this very core. Where wait states are told, it measures little.
    fn printed(&self, waits: Option<[u8; 2]>) -> Result<String> {
        let waits = waits.map_or(vec![], |waits| {
            waits.map(|waits| waits.to_string()).to_vec()
        });
        let mut name = vec![format!("printed-{}", self.fingerprint()?)];
        name.extend_from_slice(&waits);
        let file = self.folder.join(name.join("-"));
        if let Ok(printed) = fs::read_to_string(&file) {
            println!("simulated before: {}", file.display());
            return Ok(printed);
        }
        let bench = bench(&self.sources, &self.folder)?;
        let (printed, _) = output_for(Command::new(bench).arg(&self.image).args(&waits), LIMIT)?;
        fs::write(&file, &printed)?;
        Ok(printed)
    }

    /// The file: what was measured and how, the columns, and the rows that the image printed. Its forces must be the host's.
    fn table(&self) -> Result<String> {
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
                _ => bail!("the image printed `{line}`"),
            }
        }
        if rows.first().is_none_or(|first| first != COLUMNS) {
            bail!("the image's columns are not `{COLUMNS}`");
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
    fn waiting(&self) -> Result<String> {
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

fn header(ticks: &str) -> Result<String> {
    let mut text = String::new();
    for line in [
        "Exact cycles of one update on Hazard3, the RP2350's RISC-V core: its RTL, simulated by verilator, with the parameters of",
        "the RP2350's datasheet (section 3.8.8; cycles/hazard3/rp2350.v), counted by its own mcycle. Made by `cargo xtask cycles",
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
fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let rtl = root().join(RTL);
    let mut sources = Vec::new();
    for folder in [rtl.join("arith"), rtl.clone()] {
        sources.extend(files(&folder, "v")?);
    }
    let frontend = rtl.join("hazard3_frontend.v");
    sources.retain(|file| *file != frontend);
    sources.push(fetch_queue(&frontend, folder)?);
    let ours = root().join("cycles/hazard3");
    sources.extend([ours.join("rp2350.v"), ours.join("bench.cpp")]);
    Ok(sources)
}

/// The instruction fetch with one of its blocks cut in two, which by the language's rules changes nothing.
///
/// The block reads registers of the fetch queue and drives the wire at the queue's end, an element of the same array. Verilator 5.006
/// does not run it again when the registers change, because it takes the array for the block's own, and loses what was fetched.
fn fetch_queue(frontend: &Path, folder: &Path) -> Result<PathBuf> {
    const DRIVEN: &str = "\tfifo_valid_hw[FIFO_DEPTH] = 2'b00;\n";
    const CUT: &str = "end\n\nalways @ (*) begin: validity\n\tinteger i;\n";
    let text = fs::read_to_string(frontend)?;
    let (before, after) = text.split_once(DRIVEN).with_context(|| {
        format!(
            "{} is not as cycles/src/hazard3.rs knows it: no `{}`",
            frontend.display(),
            DRIVEN.trim()
        )
    })?;
    let file = folder.join("hazard3_frontend.v");
    fs::write(&file, [before, DRIVEN, CUT, after].concat())?;
    Ok(file)
}

/// The simulator: the core with its testbench.
fn bench(sources: &[PathBuf], folder: &Path) -> Result<PathBuf> {
    let rtl = root().join(RTL);
    // The RTL is taken as it is, warnings included.
    let mut verilator = command(
        "verilator --cc --exe --build -j 2 -O3 -MAKEFLAGS OPT_FAST=-O3 -Wno-fatal -Wno-lint -Wno-style \
         --noassert --x-assign fast --x-initial fast --top-module rp2350",
    );
    verilator
        .args(["-CFLAGS", "-O3 -march=native", "--Mdir"])
        .arg(folder.join("bench"))
        .arg(format!("-I{}", rtl.display()))
        .arg(format!("-I{}", rtl.join("arith").display()))
        .args(sources)
        .args(["-o", "bench"]);
    run_for(&mut verilator, LIMIT)?;
    Ok(folder.join("bench/bench"))
}

/// The files of a folder that end in this, in order.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>> {
    let paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut files = paths.collect::<Result<Vec<_>>>()?;
    files.retain(|path| path.extension().is_some_and(|found| found == ending));
    files.sort();
    Ok(files)
}

/// The row with its flash: the kernel's function with all that it can call, and its parameters.
fn with_flash(row: &str, sizes: &Sizes, models: &BTreeMap<String, &str>) -> Result<String> {
    let mut cells: Vec<String> = row.split(',').map(str::to_string).collect();
    let [kernel, n, ..] = &cells[..] else {
        bail!("the image printed `{row}`");
    };
    let name = format!("{kernel}__{n}");
    let model = models
        .get(&name)
        .and_then(|model| model.parse::<u32>().ok());
    let model =
        model.with_context(|| format!("the image did not tell the parameters of {name}"))?;
    let flash = sizes.reached_from(&format!("{PREFIX}{name}"))? + model;
    let column = COLUMNS.split(',').position(|name| name == "flash_bytes");
    if let Some(cell) = column.and_then(|at| cells.get_mut(at)) {
        *cell = flash.to_string();
    }
    Ok(cells.join(","))
}

/// What of the measuring program memory holds.
fn image(program: &Path) -> Result<PathBuf> {
    let image = program.with_extension("bin");
    let mut copy = command("riscv64-unknown-elf-objcopy -O binary");
    run_for(copy.arg(program).arg(&image), LIMIT)?;
    Ok(image)
}

/// The measuring program.
fn program(folder: &Path) -> Result<PathBuf> {
    let mut build = cargo_for(TARGET);
    build
        .arg("--target-dir")
        .arg(folder)
        .env("RUSTFLAGS", FEATURES);
    nowhere::wrap(&mut build)?;
    run_for(&mut build, LIMIT).with_context(|| no_image(TARGET))?;
    Ok(folder.join(TARGET).join("release/cycles"))
}

/// The table as people read it.
fn print(table: &str) {
    let (head, rows): (Vec<&str>, Vec<&str>) =
        table.lines().partition(|line| line.starts_with('#'));
    println!("{}\n", head.join("\n"));
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        if let [kernel, n, mean, longest, cycles, worst, _, _, in_tick, ..] = cells[..] {
            println!(
                "{kernel:<30} {n:>3} {mean:>17} {longest:>16} {cycles:>11} {worst:>12} {in_tick:>14}"
            );
        }
    }
}

/// Mean cycles by kernel and N.
fn means(table: &str) -> Result<Counts> {
    let lines = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    let mean = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let mean = cells.get(4)?.parse().ok()?;
        let name = format!("{} N={}", cells.first()?, cells.get(1)?);
        Some((name, vec![("the mean", mean)]))
    };
    lines
        .map(|line| mean(line).with_context(|| format!("{TABLE}: cannot read `{line}`")))
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
        assert!(
            means("kernel,n\na,4,,,x,1\n")
                .unwrap_err()
                .to_string()
                .contains("a,4")
        );
    }
}
