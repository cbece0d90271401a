//! The whole control tick of the firmware: the interrupt of its RTIC task, from exception entry to return.
//!
//! The firmware of `firmware/boards/qemu` follows the motion of `cargo xtask qemu` against the simulated stage, and
//! every interrupt is recorded: queues, controller, friction, bridge, telemetry, timer and watchdog. Left out is the exchange
//! with the stage, which stands for reading a counter and two ADC channels. Peripherals answer without wait states.

use super::disassembly::Disassembly;
use super::recorder::{Recorder, TakenPath, Watched};
use super::table::Row;
use super::{Prices, price, price_paths, stages};
use crate::qemu::{self, LEARNING, LEARNING_FEATURES, PACKED};
use std::path::{Path, PathBuf};
use std::process::Command;

/// RTIC gives the task the name of the interrupt that it is bound to.
const HANDLER: &str = "TIMER0";

/// Part of the mangled name of the function that stands for the sensors.
const EXCHANGE: &str = "preslide_qemu7reading";

/// What the row is called behind the kernel, and what the axis is told for it. A notch or a followed winding takes every tick off the ordinary
/// path.
const TOLD: [(&str, &str); 2] = [
    ("_notch", "notch.frequency=370"),
    ("_winding", "motor.resistance_span=0.4"),
];

/// Kernel, and the build of the firmware with it: name and features.
type Build = (&'static str, &'static str, &'static [&'static str]);

const BUILDS: [Build; 10] = [
    ("quasi_static_i16f16", "qemu-fixed", &[]),
    ("quasi_static_f32", "qemu-float", &["--features", "float"]),
    ("packed_i16f16", PACKED[0].1, &[]),
    ("packed_f32", PACKED[1].1, &[]),
    (
        "quasi_static_i16f16_observer",
        "qemu-fixed-observer",
        &["--features", "observer"],
    ),
    (
        "quasi_static_f32_observer",
        "qemu-float-observer",
        &["--features", "float,observer"],
    ),
    (
        "quasi_static_i16f16_watch",
        "qemu-fixed-watch",
        &["--features", "watch"],
    ),
    (
        "quasi_static_f32_watch",
        "qemu-float-watch",
        &["--features", "float,watch"],
    ),
    (
        "quasi_static_i16f16_adaptation",
        LEARNING,
        LEARNING_FEATURES,
    ),
    (
        "quasi_static_f32_adaptation",
        "qemu-float-adaptation",
        &["--features", "float,adaptation"],
    ),
];

/// `preslide_link::MOST_BLOCKS`.
const BLOCKS: u32 = 4;

/// Adds the rows of every build to the table.
pub fn measure(recorder: &Recorder, prices: &Prices, rows: &mut Vec<Row>) -> Result<(), String> {
    let rig = qemu::build_rig()?;
    let mut measure = |build, (name, told): (&str, Option<&str>)| {
        let tick = Tick::record(recorder, &rig, build, told)?;
        let mut row = price_paths(&tick.disassembly, &tick.paths, prices.of_interrupt)?;
        row.kernel = format!("rtic_tick_{}{name}", tick.kernel);
        row.blocks = BLOCKS;
        rows.push(row);
        Ok::<(), String>(())
    };
    for build in &BUILDS {
        measure(build, ("", None))?;
    }
    for build in &BUILDS[..2] {
        for (name, told) in TOLD {
            measure(build, (name, Some(told)))?;
        }
    }
    Ok(())
}

/// Prints where the cycles of the tick go, with and without float; the instructions stand in a file each.
pub fn print_stages(recorder: &Recorder) -> Result<(), String> {
    let rig = qemu::build_rig()?;
    let listed = |build| {
        let tick = Tick::record(recorder, &rig, build, None)?;
        Ok::<_, String>([
            tick.listed(tick.kernel, &tick.paths)?,
            tick.listed(&format!("longest {}", tick.kernel), tick.longest()?)?,
        ])
    };
    let [fixed, longest_fixed] = listed(&BUILDS[0])?;
    let [float, longest_float] = listed(&BUILDS[1])?;
    stages::print("the mean tick", &[fixed, float]);
    println!();
    stages::print("the longest tick", &[longest_fixed, longest_float]);
    Ok(())
}

/// What was recorded, and its stages.
type Listed = (String, stages::Breakdown);

/// The recorded interrupts of a build.
struct Tick {
    kernel: &'static str,
    program: PathBuf,
    disassembly: Disassembly,
    paths: Vec<TakenPath>,
}

impl Tick {
    fn record(
        recorder: &Recorder,
        rig: &Path,
        build: &Build,
        told: Option<&str>,
    ) -> Result<Self, String> {
        let &(kernel, name, features) = build;
        let exported = PACKED.iter().find(|(_, image)| *image == name);
        let exported = exported.map(|(model, _)| (qemu::MODEL, *model));
        let program = qemu::build_with(exported, "preslide-qemu", name, features)?;
        let disassembly = Disassembly::of(&program)?;
        let address_of = |part: &str| {
            let mut functions = disassembly.functions_named("");
            let found = functions.find(|(_, name)| name.contains(part));
            found.map(|(address, _)| address).ok_or_else(|| {
                format!("{}: no function {part}; was it inlined?", program.display())
            })
        };
        let handler = address_of(HANDLER)?;
        let watched = Watched {
            entries: &[handler],
            skipped: &[address_of(EXCHANGE)?],
            ends_inside: true,
        };
        let mut run = Command::new(rig);
        run.arg("record")
            .arg(&program)
            .arg(recorder.plugin(&watched))
            .args(told);
        let mut recording = recorder.watch(&mut run, &watched)?;
        let paths = recording
            .remove(&handler)
            .ok_or_else(|| format!("{kernel}: no control tick was recorded"))?;
        Ok(Self {
            kernel,
            program,
            disassembly,
            paths,
        })
    }

    /// The stages of some of its paths; each of their instructions stands in a file.
    fn listed(&self, what: &str, paths: &[TakenPath]) -> Result<Listed, String> {
        let breakdown = stages::of(&self.program, &self.disassembly, paths)?;
        let extension = if paths.len() == 1 {
            "longest"
        } else {
            "cycles"
        };
        let file = self.program.with_extension(extension);
        std::fs::write(&file, &breakdown.listing)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
        println!("each instruction of {what}: {}", file.display());
        Ok((what.to_string(), breakdown))
    }

    /// The dearest path, alone.
    fn longest(&self) -> Result<&[TakenPath], String> {
        let (mut longest, mut worst) = (&self.paths[..0], 0);
        for path in &self.paths {
            let cycles = price::of_interrupt(&self.disassembly.steps(path)?).cycles;
            if cycles > worst {
                (longest, worst) = (std::slice::from_ref(path), cycles);
            }
        }
        Ok(longest)
    }
}
