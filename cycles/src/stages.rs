//! Where the cycles of a control tick go: each instruction belongs to the source file that it was written in.
//!
//! The compiler inlines nearly all of a tick into one function. `addr2line` tells through which functions each instruction came
//! there; the innermost of them that a stage claims has it. What none claims (arithmetic, queues' insides, copies) belongs to the
//! stage of the instruction before it.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use preslide_tools::process::{command, output_of};

use super::disassembly::Disassembly;
use super::price;
use super::recorder::TakenPath;

/// Exception entry and return, float registers, registers that a function saves, and RTIC's priority.
const FRAME: &str = "interrupt, saved registers";
/// Timer, sensors, watchdog and bridge: another board, other cycles.
const BOARD: &str = "timer, sensors, bridge";

/// How instructions begin that belong to the frame wherever they stand.
const FRAMING: [&str; 11] = [
    "push",
    "pop",
    "vpush",
    "vpop",
    "stmdb\tsp!",
    "ldmia.w\tsp!",
    "sub\tsp",
    "add\tsp",
    "mrs",
    "msr",
    "isb",
];

/// Stages in the order of a tick, and whose code they are: a part of the source file's path, and behind a blank one of the function's name. Of
/// several that claim a function, the last one has it.
const STAGES: [(&str, &str); 16] = [
    (FRAME, ""),
    (BOARD, "boards/qemu/src/, link/src/"),
    ("orders, moves", "app/src/"),
    ("sensing, scaling", "control/controller.rs"),
    ("velocity tracker", "src/encoder.rs"),
    ("monitors", "control/faults.rs"),
    (
        "reference",
        "control/reference.rs, control/smoothing.rs, control/moves.rs",
    ),
    ("PID", "control/pid.rs"),
    (
        "feed-forward",
        "control/compensator.rs, control/coefficients.rs feed_forward",
    ),
    (
        "friction",
        "friction/gms.rs, friction/quasi_static.rs, src/kernels/",
    ),
    ("watch, adaptation", "control/learning/"),
    ("observer", "control/observer.rs, control/observed.rs"),
    ("cross-fade", "control/leaving.rs"),
    (
        "motor map",
        "control/motor.rs, control/coefficients.rs boost",
    ),
    (
        "limiter",
        "control/limiter.rs, control/coefficients.rs is_gentle",
    ),
    (
        "telemetry",
        "app/src/control.rs tell, app/src/control.rs current, app/src/control.rs on_the_wire, app/src/telemetry.rs, \
         control/faults.rs at_rest",
    ),
];

/// The last stage that claims a function of a file.
fn stage_of(file: &str, function: &str) -> Option<usize> {
    let is_whose = |whose: &str| {
        let (path, name) = whose.split_once(' ').unwrap_or((whose, ""));
        !path.is_empty() && file.contains(path) && function.contains(name)
    };
    STAGES
        .iter()
        .rposition(|(_, whose)| whose.split(", ").any(is_whose))
}

/// What the stages of a tick cost in the mean: instructions and cycles, in the order of the table above.
pub struct Breakdown {
    pub stages: Vec<(&'static str, f64, f64)>,
    /// Every instruction with how often it ran a tick, its cycles a tick, and its stage.
    pub listing: String,
}

/// The stages of an interrupt's recorded calls.
pub fn of(program: &Path, disassembly: &Disassembly, paths: &[TakenPath]) -> Result<Breakdown> {
    let calls: f64 = paths.iter().map(|path| f64::from(path.calls)).sum();
    let mut taken = Vec::new();
    // By address: how often, cycles, and the last stage. Both a tick.
    let mut spent: BTreeMap<u32, (f64, f64, usize)> = BTreeMap::new();
    for path in paths {
        let steps = disassembly.steps(path)?;
        spent.extend(steps.iter().map(|(address, _)| (*address, (0.0, 0.0, 0))));
        taken.push((f64::from(path.calls) / calls, steps));
    }
    let claims = claims(program, disassembly, spent.keys().copied())?;
    let mut stages: Vec<_> = STAGES.iter().map(|(name, _)| (*name, 0.0, 0.0)).collect();
    for (share, steps) in &taken {
        let mut stage = 0;
        for ((address, _), price) in steps.iter().zip(price::of_steps(steps)) {
            let here = *claims.get(address).unwrap_or(&stage);
            if here != 0 {
                stage = here;
            }
            let cycles = share * f64::from(price.cycles);
            stages[here].1 += share;
            stages[here].2 += cycles;
            if let Some(at) = spent.get_mut(address) {
                *at = (at.0 + share, at.1 + cycles, here);
            }
        }
        stages[0].2 += share * f64::from(price::of_exception(steps).cycles);
    }
    Ok(Breakdown {
        stages,
        listing: listing(disassembly, &spent),
    })
}

/// The stage of every address that one claims.
fn claims(
    program: &Path,
    disassembly: &Disassembly,
    addresses: impl Iterator<Item = u32>,
) -> Result<HashMap<u32, usize>> {
    let asked: String = addresses.map(|address| format!("{address:#x}\n")).collect();
    let line = "arm-none-eabi-addr2line --addresses --inlines --functions --demangle -e";
    let told = output_of(command(line).arg(program), &asked)?;
    let mut claims = HashMap::new();
    let mut address = 0;
    let mut lines = told.lines();
    while let Some(line) = lines.next() {
        if let Some(digits) = line.strip_prefix("0x") {
            address = u32::from_str_radix(digits, 16).with_context(|| format!("`{line}`"))?;
            let text = disassembly.text(address).unwrap_or_default();
            if FRAMING.iter().any(|name| text.starts_with(name)) {
                claims.insert(address, 0);
            }
            continue;
        }
        // Innermost first: the first claim stays.
        let file = lines.next().unwrap_or_default();
        if let Some(stage) = stage_of(file, line) {
            claims.entry(address).or_insert(stage);
        }
    }
    Ok(claims)
}

fn listing(disassembly: &Disassembly, spent: &BTreeMap<u32, (f64, f64, usize)>) -> String {
    let mut text = String::new();
    for (address, (times, cycles, stage)) in spent {
        let instruction = disassembly.text(*address).unwrap_or_default();
        let _ = writeln!(
            text,
            "{address:8x} {times:7.3} {cycles:7.2}  {:<26} {instruction}",
            STAGES[*stage].0
        );
    }
    text
}

/// Both ticks beside each other, the mean or the longest.
pub fn print(which: &str, ticks: &[(String, Breakdown); 2]) {
    print!("{:<28}", "instructions, cycles");
    for (kernel, _) in ticks {
        print!(" {kernel:>30}");
    }
    println!();
    let line = |name: &str, spent: [(f64, f64); 2]| {
        let [fixed, float] =
            spent.map(|(instructions, cycles)| format!("{instructions:>22.1} {cycles:>7.1}"));
        println!("{name:<28} {fixed} {float}");
    };
    let mut whole = [(0.0, 0.0); 2];
    for (index, (name, _)) in STAGES.iter().enumerate() {
        let spent = [0, 1].map(|tick| {
            let (_, instructions, cycles) = ticks[tick].1.stages[index];
            let sum: &mut (f64, f64) = &mut whole[tick];
            *sum = (sum.0 + instructions, sum.1 + cycles);
            (instructions, cycles)
        });
        line(name, spent);
    }
    line(which, whole);
}
