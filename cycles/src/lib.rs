//! `cargo xtask cycles`: what an update of each kernel costs on a Cortex-M4F and on other cores, without a board.
//!
//! QEMU is not cycle accurate: it yields exact instruction paths, and `price` puts cycles on them by the table of
//! the core's manual. Instruction counts are facts of the build, cycles an estimate with a stated range.

mod board;
mod control_task;
mod disassembly;
mod harness;
mod hazard3;
mod inputs;
mod instruction;
mod m0plus;
pub mod nowhere;
mod price;
mod recorder;
mod sizes;
mod stages;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use fs_err as fs;
use preslide_tools::need::Need;
use preslide_tools::process::{
    IN_ONE_PIECE, build_as_tests, cargo, output, released, root, run, target_of,
};
use preslide_tools::thumb::{TARGET, Toolchain};

use disassembly::Disassembly;
use harness::Run;
use instruction::Instruction;
use price::Price;
use recorder::{Recorder, TakenPath};
use table::Row;

/// Every measured function is called this, its kernel's name, `__` and N (`firmware/cycles/src/stub.rs`).
const PREFIX: &str = "cycles__";

/// A core whose instruction paths QEMU gives.
struct Core {
    target: &'static str,
    /// What writes the tables.
    command: &'static str,
    prices: Prices,
    /// It has the FPU and the DSP instructions that the firmware, the board's image and the floor are about.
    is_m4f: bool,
}

/// What a core asks for a path, and where that is written.
struct Prices {
    table: &'static str,
    /// What the table's header says before the compilers.
    header: &'static [&'static str],
    of_path: PriceOf,
    of_interrupt: PriceOf,
}

type PriceOf = fn(&[(u32, Instruction)]) -> Price;

const CORTEX_M4F: Core = Core {
    target: TARGET,
    command: "cargo xtask cycles",
    prices: Prices {
        table: "firmware/cycles/cortex-m4.csv",
        header: &[
            "Cost of one update on a Cortex-M4F without wait states, made by `cargo xtask cycles`.",
            "QEMU is not cycle accurate: it gives the exact instruction paths, and the cycle table of the core's manual",
            "prices them. No board has confirmed these figures. A row's cycles include call and return (`empty_call`).",
            "cycles_low and cycles_high: the mean, where the manual leaves the cost open (cycles/src/price.rs).",
            "cycles_in_tick: by how much a control tick (PID, sensors in memory) grows with the kernel inlined, saved registers",
            "included. floor: the least that the quasi-static law takes by argument (cycles/src/table.rs); compare it with",
            "cycles_in_tick.",
            "with_EFFECT_SCALAR: `With<Gms<4>, (Effect,)>`; compare cycles_in_tick with that of gms_SCALAR. with_nothing: `()`.",
            "exported_c_KERNEL: what `preslide export --lang c` writes of the same six blocks, by gcc -O2; its forces are KERNEL's.",
            "rtic_tick_KERNEL: the whole interrupt of the QEMU firmware's control task with that friction model, exception entry",
            "and return included (firmware/cycles/README.md says what else).",
            "flash_bytes: code of all functions on the paths and the parameters; libraries' constant tables not counted.",
        ],
        of_path: price::of_path,
        of_interrupt: price::of_interrupt,
    },
    is_m4f: true,
};

/// Ticks of the whole motion (`firmware/cycles/src/motion.rs`).
const ALL_TICKS: &str = "10000";

/// What `cargo xtask cycles` takes.
pub const FLAGS: [&str; 5] = ["--check", "--recount", "--tick", "--m0plus", "--hazard3"];

/// `cargo xtask cycles`, with one of [`FLAGS`] or none.
pub fn run_command(flag: Option<&str>) -> Result<()> {
    match flag {
        Some("--tick") => tick(),
        Some("--m0plus") => write(&m0plus::CORE),
        Some("--hazard3") => hazard3::run_command().and_then(|()| inputs::record(hazard3::COMMAND)),
        Some("--recount") => recount(),
        Some(_) => check_changed(),
        None => write(&CORTEX_M4F),
    }
}

/// The command that writes a table, and what compares this tree with it: whether all counts were found as recorded.
type Check = (&'static str, fn() -> Result<bool>);

const CHECKS: [Check; 3] = [
    (CORTEX_M4F.command, || check(&CORTEX_M4F)),
    (m0plus::CORE.command, m0plus::check),
    (hazard3::COMMAND, hazard3::check),
];

/// Counts everything again. A table whose counts were all found, none skipped, is of these sources, too: nobody need count it once more.
fn recount() -> Result<()> {
    for (command, check) in CHECKS {
        if check()? {
            inputs::record(command)?;
        }
    }
    Ok(())
}

/// Counts again only what was counted from other sources than stand here.
fn check_changed() -> Result<()> {
    let changed = inputs::changed(&CHECKS.map(|(command, _)| command))?;
    let is_changed = |(command, _): &&Check| changed.contains(command);
    let (again, same): (Vec<_>, Vec<_>) = CHECKS.iter().partition(is_changed);
    for (command, _) in same {
        println!(
            "the sources are those that `{command}` counted; `cargo xtask cycles --recount` counts again"
        );
    }
    again.iter().try_for_each(|(_, check)| check().map(drop))
}

/// Measures, prints the core's table and writes it.
fn write(core: &Core) -> Result<()> {
    let (header, rows) = measured(core)?;
    let file = core.prices.table;
    fs::write(root().join(file), table::to_csv(&header, &rows))?;
    println!("\nwritten to {file}");
    inputs::record(core.command)
}

/// Measures, and compares with the committed tables.
fn check(core: &Core) -> Result<bool> {
    let (_, rows) = measured(core)?;
    let file = core.prices.table;
    let text = fs::read_to_string(root().join(file))?;
    let committed = table::from_csv(&text).context(file)?;
    let regressions = table::regressions(&committed, &rows);
    if !regressions.is_empty() {
        bail!(
            "worse than {file}:\n  {}\nIf that is meant (or the compilers differ from those in its header), run `{}` and commit the table",
            regressions.join("\n  "),
            core.command
        );
    }
    println!("\nno instruction count grew by more than 3 % over {file}");
    Ok(table::same(&committed, &rows))
}

/// A table's header and rows.
type Table = (Vec<String>, Vec<Row>);

/// Measures, and prints the table.
fn measured(core: &Core) -> Result<Table> {
    let (header, rows) = measure(core)?;
    println!();
    for line in &header {
        println!("{line}");
    }
    println!();
    table::print(&rows);
    println!();
    table::print_effects(&rows);
    Ok((header, rows))
}

/// Prints where the cycles of the control tick go.
fn tick() -> Result<()> {
    Need::ArmGcc.ensure()?;
    Need::Qemu.ensure()?;
    control_task::print_stages(&Recorder::build(recordings())?)
}

/// Where the recorder works.
fn recordings() -> PathBuf {
    root().join("firmware/target/recorder")
}

/// What builds the harness.
const BUILD: &str = "build --release --locked --package preslide-cycles";

/// The first line of what a program says of its version.
fn version_of(program: &str) -> Result<String> {
    let printed = output(Command::new(program).arg("--version"))?;
    Ok(printed.lines().next().unwrap_or_default().to_string())
}

/// Builds the harness; the program, and the compiler's version.
fn build(core: &Core) -> Result<(PathBuf, String)> {
    let firmware = root().join("firmware");
    let version = if core.target == TARGET {
        let toolchain = Toolchain::ensure()?;
        run(&mut toolchain.cargo(&firmware, BUILD))?;
        toolchain.version()?
    } else {
        run(&mut cargo_for(core.target)).with_context(|| no_image(core.target))?;
        version_of("rustc")?
    };
    let built = target_of(&firmware).join(core.target);
    Ok((built.join("release/cycles"), version))
}

/// What builds the harness for another core.
fn cargo_for(target: &str) -> Command {
    let mut build = cargo(BUILD);
    build.args(["--target", target]).envs([IN_ONE_PIECE]);
    build.current_dir(root().join("firmware"));
    build
}

/// What a failed build means, and may want.
fn no_image(target: &str) -> String {
    format!("no image for {target} (if the target is missing: rustup target add {target})")
}

/// Builds the harness, runs it under the recorder, and prices what was recorded.
fn measure(core: &Core) -> Result<Table> {
    Need::ArmGcc.ensure()?;
    Need::Qemu.ensure()?;
    let (program, version) = build(core)?;
    let recorder = Recorder::build(recordings())?;
    let run = Run::of(&program, &recorder)?;

    let mut rows = run.rows(core.prices.of_path)?;
    if core.is_m4f {
        for row in &mut rows {
            row.floor = table::floor(row);
        }
    }
    compare_with_host(&run.printed.checksums, &run.printed.ticks().to_string())?;
    if core.is_m4f {
        board::check(&rows)?;
        control_task::measure(&recorder, &core.prices, &mut rows)?;
    }
    Ok((header(&core.prices, &version, &run.printed.seed)?, rows))
}

/// The forces that every kernel computed on the target in so many ticks must be, bit for bit, those it computes here.
fn compare_with_host(target: &BTreeMap<String, String>, ticks: &str) -> Result<()> {
    build_as_tests("--example kernel_forces")?;
    let printed = output(Command::new(released("examples/kernel_forces")).arg(ticks))?;
    let mut compared = 0;
    for line in printed.lines() {
        let (kernel, checksum) = line
            .rsplit_once(' ')
            .with_context(|| format!("kernel_forces printed `{line}`"))?;
        match target.get(kernel) {
            Some(found) if found == checksum => compared += 1,
            Some(found) => {
                bail!(
                    "{kernel}: the forces on the target (checksum {found}) differ from the host's ({checksum})"
                );
            }
            // The long runs are another machine's.
            None if kernel.contains("steps") && ticks != ALL_TICKS => {}
            None => bail!("{kernel} ran on the host but not on the target"),
        }
    }
    let long = target.keys().filter(|key| key.contains("steps")).count();
    println!(
        "the forces of {} kernels are the host's, bit for bit, and those of {long} over a million random steps",
        compared - long
    );
    Ok(())
}

/// A row but for what only the measured program knows.
fn price_paths(disassembly: &Disassembly, paths: &[TakenPath], price_of: PriceOf) -> Result<Row> {
    let mut functions = BTreeSet::new();
    let (mut calls, mut instructions, mut longest, mut worst) = (0, 0, 0, 0);
    let (mut cycles, mut low, mut high) = (0, 0, 0);
    for path in paths {
        let steps = disassembly.steps(path)?;
        let starts = path.stretches.iter();
        functions.extend(starts.filter_map(|(first, _)| disassembly.function_at(*first)));
        let price = price_of(&steps);
        let weight = u64::from(path.calls);
        calls += path.calls;
        instructions += weight * steps.len() as u64;
        longest = longest.max(steps.len() as u32);
        worst = worst.max(price.cycles);
        cycles += weight * u64::from(price.cycles);
        low += weight * u64::from(price.low);
        high += weight * u64::from(price.high);
    }
    let mean = |sum: u64| sum as f64 / f64::from(calls);
    Ok(Row {
        instructions_mean: mean(instructions),
        instructions_max: longest,
        cycles_mean: mean(cycles),
        cycles_worst: worst,
        cycles_low: mean(low),
        cycles_high: mean(high),
        flash_bytes: functions.iter().map(|(_, length)| length).sum(),
        paths: paths.len() as u32,
        calls,
        ..Row::default()
    })
}

fn header(prices: &Prices, version: &str, seed: &str) -> Result<Vec<String>> {
    let mut lines: Vec<String> = prices.header.iter().map(ToString::to_string).collect();
    lines.push(format!("motion seed: {seed}"));
    lines.push(format!("rustc: {version}"));
    lines.push(format!("gcc: {}", version_of("arm-none-eabi-gcc")?));
    lines.push(format!("qemu: {}", version_of("qemu-system-arm")?));
    Ok(lines)
}
