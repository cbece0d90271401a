//! The whole control tick of the firmware: the interrupt of its RTIC task, from exception entry to return.
//!
//! The firmware of `firmware/boards/qemu` follows the motion of `cargo xtask qemu` against the simulated stage, and
//! every interrupt is recorded: queues, controller, friction, bridge, telemetry, timer and watchdog. Left out is the exchange
//! with the stage, which stands for reading a counter and two ADC channels. Peripherals answer without wait states.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use fs_err as fs;
use preslide_tools::image::{self, MODEL, PACKED, build_rig};

use super::disassembly::Disassembly;
use super::recorder::{Recorder, TakenPath, Watched};
use super::table::Row;
use super::{Prices, price, price_paths, stages};

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

/// A build of the firmware, and how its kernel is called in the table.
struct Build {
    kernel: String,
    image: String,
    features: String,
    /// The exported model that is compiled in.
    model: Option<&'static str>,
}

/// What the firmware can do besides, each a feature of it.
const EXTRAS: [&str; 3] = ["observer", "watch", "adaptation"];

/// The quasi-static law in fixed point and in float, with an extra or with none.
fn quasi_static(extra: Option<&str>) -> [Build; 2] {
    [("i16f16", "fixed", None), ("f32", "float", Some("float"))].map(
        |(scalar, arithmetic, float)| {
            let named =
                |joint: &str| extra.map_or(String::new(), |extra| format!("{joint}{extra}"));
            let features: Vec<&str> = float.into_iter().chain(extra).collect();
            Build {
                kernel: format!("quasi_static_{scalar}{}", named("_")),
                image: format!("qemu-{arithmetic}{}", named("-")),
                features: format!("--features={}", features.join(",")),
                model: None,
            }
        },
    )
}

/// The packed kernel, as it is exported for each arithmetic.
fn packed() -> [Build; 2] {
    let kernels = ["packed_i16f16", "packed_f32"];
    [0, 1].map(|index| Build {
        kernel: kernels[index].to_owned(),
        image: PACKED[index].1.to_owned(),
        features: String::new(),
        model: Some(PACKED[index].0),
    })
}

/// `preslide_link::MOST_BLOCKS`.
const BLOCKS: u32 = 4;

/// Adds the rows of every build to the table.
pub fn measure(recorder: &Recorder, prices: &Prices, rows: &mut Vec<Row>) -> Result<()> {
    let rig = build_rig()?;
    let mut measure = |build: &Build, (name, told): (&str, Option<&str>)| {
        let tick = Tick::record(recorder, &rig, build, told)?;
        let mut row = price_paths(&tick.disassembly, &tick.paths, prices.of_interrupt)?;
        row.kernel = format!("rtic_tick_{}{name}", build.kernel);
        row.blocks = BLOCKS;
        rows.push(row);
        anyhow::Ok(())
    };
    let plain = quasi_static(None);
    let with_extras = EXTRAS
        .into_iter()
        .flat_map(|extra| quasi_static(Some(extra)));
    let others: Vec<Build> = packed().into_iter().chain(with_extras).collect();
    for build in plain.iter().chain(&others) {
        measure(build, ("", None))?;
    }
    for build in &plain {
        for (name, told) in TOLD {
            measure(build, (name, Some(told)))?;
        }
    }
    Ok(())
}

/// Prints where the cycles of the tick go, with and without float; the instructions stand in a file each.
pub fn print_stages(recorder: &Recorder) -> Result<()> {
    let rig = build_rig()?;
    let listed = |build: &Build| {
        let tick = Tick::record(recorder, &rig, build, None)?;
        let longest = format!("longest {}", build.kernel);
        anyhow::Ok([
            tick.listed(&build.kernel, &tick.paths)?,
            tick.listed(&longest, tick.longest()?)?,
        ])
    };
    let [fixed, float] = quasi_static(None);
    let [fixed, longest_fixed] = listed(&fixed)?;
    let [float, longest_float] = listed(&float)?;
    stages::print("the mean tick", &[fixed, float]);
    println!();
    stages::print("the longest tick", &[longest_fixed, longest_float]);
    Ok(())
}

/// What was recorded, and its stages.
type Listed = (String, stages::Breakdown);

/// The recorded interrupts of a build.
struct Tick {
    program: PathBuf,
    disassembly: Disassembly,
    paths: Vec<TakenPath>,
}

impl Tick {
    fn record(recorder: &Recorder, rig: &Path, build: &Build, told: Option<&str>) -> Result<Self> {
        let model = build.model.map(|model| (MODEL, model));
        let program = image::build(&build.image, &build.features, model)?;
        let disassembly = Disassembly::of(&program)?;
        let address_of = |part: &str| {
            let mut functions = disassembly.functions_named("");
            let found = functions.find(|(_, name)| name.contains(part));
            found.map(|(address, _)| address).with_context(|| {
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
        let paths = recording.remove(&handler);
        let paths =
            paths.with_context(|| format!("{}: no control tick was recorded", build.kernel))?;
        Ok(Self {
            program,
            disassembly,
            paths,
        })
    }

    /// The stages of some of its paths; each of their instructions stands in a file.
    fn listed(&self, what: &str, paths: &[TakenPath]) -> Result<Listed> {
        let breakdown = stages::of(&self.program, &self.disassembly, paths)?;
        let extension = if paths.len() == 1 {
            "longest"
        } else {
            "cycles"
        };
        let file = self.program.with_extension(extension);
        fs::write(&file, &breakdown.listing)?;
        println!("each instruction of {what}: {}", file.display());
        Ok((what.to_string(), breakdown))
    }

    /// The dearest path, alone.
    fn longest(&self) -> Result<&[TakenPath]> {
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
