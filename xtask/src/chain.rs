//! `cargo xtask chain`: the whole chain for effects that only the stage knows of.
//!
//! Each trial: the firmware in QEMU on a stage that conceals an effect, its telemetry captured; rigid body and friction
//! identified; `preslide diagnose`, which is given that recording and that model and nothing else; the model before and
//! after and the stage's own parameters exported as Rust and compiled into the firmware; the same motion tracked with each.
//! The programs are those that a user has; only the steps of `cli/examples/chain.rs` know the truth.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::process::{build_as_tests, free_port, output, released};
use crate::qemu::{build, build_command, capture};
use crate::tools::Need;

/// No friction at all.
const NONE: &str = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 0.0\n";

/// Ticks of a row of the recording: 2 ms, two samples of the telemetry.
const ROW: &str = "40";

/// Before that (s) the firmware does not know where it was switched on (`FIRST` in sim/src/chain/on_emulator.rs): positions jump then,
/// and to an identification a jump is a motion.
const LOCATED: &str = "0.020";
/// The same where it first finds the zero of its current sense (`CALIBRATED` in sim/src/rig).
const LOCATED_CALIBRATED: &str = "0.124";

/// Trials at a time; a trial keeps one core busy.
const WORKERS: usize = 2;

pub fn run_command(arguments: &[String]) -> Result<(), String> {
    let (mut seed, mut count, mut electrical, mut brief) = (1_u64, 6_usize, false, false);
    let mut kernel = None;
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let flag = match word.as_str() {
            "--electrical" => Some(&mut electrical),
            "--brief" => Some(&mut brief),
            _ => None,
        };
        if let Some(flag) = flag {
            *flag = true;
            continue;
        }
        let value = words.next().map(String::as_str).unwrap_or_default();
        let known = match word.as_str() {
            "--seed" => value.parse().map(|value| seed = value).is_ok(),
            "--count" => value.parse().map(|value| count = value).is_ok() && count > 0,
            "--kernel" => {
                kernel = Some(value.to_owned());
                !value.is_empty()
            }
            _ => false,
        };
        if !known {
            return Err(format!(
                "`chain` takes --seed N, --count K, --kernel NAME, --electrical and --brief, got `{}`",
                arguments.join(" ")
            ));
        }
    }
    chain((seed, count), kernel, electrical, brief)
}

fn chain(
    (seed, count): (u64, usize),
    kernel: Option<String>,
    electrical: bool,
    brief: bool,
) -> Result<(), String> {
    Need::Qemu.ensure()?;
    build_as_tests(&["--bin", "preslide", "--example", "chain"])?;
    let shipped = build("preslide-qemu", "qemu-fixed", &[])?;
    let folder = std::env::temp_dir().join(format!("preslide-chain-{}", std::process::id()));
    let chain = Chain {
        seed: seed.to_string(),
        kernel,
        electrical,
        brief,
        shipped,
        folder,
        building: Mutex::new(()),
    };
    let start = Instant::now();
    let folders = chain.run(count)?;
    println!(
        "\nseed {seed}, {count} trials, {:.0} s",
        start.elapsed().as_secs_f64()
    );
    let mut table = chain.steps(&["table"]);
    table.args(&folders).args(chain.stage());
    let met = run_shown(&mut table);
    if met.is_ok() {
        // What stays of a chain that missed its aim is there to be looked at.
        let _ = std::fs::remove_dir_all(&chain.folder);
    } else {
        println!("recordings and models are in {}", chain.folder.display());
    }
    met
}

struct Chain {
    seed: String,
    /// What the firmware computes friction with, as `preslide export --kernel` takes it.
    kernel: Option<String>,
    /// On the electrical stage.
    electrical: bool,
    /// What decides alone is tracked: the model after the diagnosis and the stage's own.
    brief: bool,
    /// The firmware as it comes, which is recorded.
    shipped: PathBuf,
    folder: PathBuf,
    /// Only one build at a time: they share a folder, and the image in it is copied away.
    building: Mutex<()>,
}

impl Chain {
    /// All trials; their folders.
    fn run(&self, count: usize) -> Result<Vec<PathBuf>, String> {
        make(&self.folder)?;
        let model = self.folder.join("none.toml");
        std::fs::write(&model, NONE).map_err(|e| format!("{}: {e}", model.display()))?;
        if !self.brief {
            self.image(&self.folder, "none", &[])?;
        }
        let none = self.folder.join("none.elf");
        let folders: Vec<PathBuf> = (0..count)
            .map(|index| self.folder.join(index.to_string()))
            .collect();
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(folder) = folders.get(index) else {
                    return Ok(());
                };
                let start = Instant::now();
                self.trial(index, folder, &none)
                    .inspect_err(|_| next.store(count, Ordering::Relaxed))?;
                println!(
                    "trial {} of {count}: {:.0} s",
                    index + 1,
                    start.elapsed().as_secs_f64()
                );
            }
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..WORKERS).map(|_| scope.spawn(work)).collect();
            workers.into_iter().try_for_each(|worker| {
                let ended = worker.join();
                ended.unwrap_or_else(|_| Err("a trial ended early".to_owned()))
            })
        })?;
        Ok(folders)
    }

    /// Once around; everything that is found stays in `folder`.
    fn trial(&self, index: usize, folder: &Path, none: &Path) -> Result<(), String> {
        make(folder)?;
        let file = |name: &str| folder.join(name);
        let index = index.to_string();
        let port = free_port()?;
        let mut serve = self.steps(&["serve"]);
        serve
            .arg(&index)
            .arg(&self.shipped)
            .arg(&port)
            .args(self.stage());
        serve.stdout(Stdio::null()).stderr(Stdio::null());
        let recording = file("recording.csv");
        capture(&mut serve, &port, |tool| {
            quiet(
                tool.args(["--every", ROW, "--after", self.located()])
                    .arg("-o")
                    .arg(&recording),
            )
        })?;

        let model = file("before.toml");
        quiet(tool("identify").arg(&recording).arg("-o").arg(&model))?;
        let mut diagnose = tool("diagnose");
        diagnose.arg(&recording).arg("--model").arg(&model);
        diagnose.arg("-o").arg(file("after.toml"));
        quiet(diagnose.arg("--json").arg(file("diagnosis.json")))?;
        quiet(self.steps(&["known"]).arg(&index).arg(file("known.toml")))?;

        for name in ["after", "known"] {
            self.image(folder, name, &[])?;
        }
        let mut track = self.steps(&["track"]);
        track.arg(&index).arg(none).arg(folder).args(self.stage());
        if self.brief {
            return quiet(&mut track);
        }
        self.image(folder, "before", &[])?;
        // What the refitted blocks do by themselves.
        let after = std::fs::read_to_string(file("after.toml")).map_err(|e| e.to_string())?;
        let ids = after.lines().filter_map(|line| line.strip_prefix("id = "));
        // Some come twice, but a name leaves out all of them.
        let ids: BTreeSet<&str> = ids.map(|id| id.trim_matches('"')).collect();
        let ids: Vec<&str> = ids.into_iter().collect();
        let refit = file("refit.toml");
        std::fs::write(&refit, &after).map_err(|e| format!("{}: {e}", refit.display()))?;
        self.image(folder, "refit", &ids)?;
        quiet(&mut track)
    }

    /// When the firmware knows where it stands (s).
    fn located(&self) -> &'static str {
        if self.electrical {
            LOCATED_CALIBRATED
        } else {
            LOCATED
        }
    }

    /// Exports the model of that name `without` some effects, and builds the firmware with it; the image.
    fn image(&self, folder: &Path, name: &str, without: &[&str]) -> Result<PathBuf, String> {
        let file = |kind: &str| folder.join(format!("{name}.{kind}"));
        let export = |without: &[&str]| {
            let mut export = tool("export");
            export.args(without.iter().flat_map(|id| ["--without", id]));
            // Without friction there is none to compute.
            let kernel = self.kernel.iter().filter(|_| name != "none");
            export.args(kernel.flat_map(|kernel| ["--kernel", kernel]));
            quiet(export.arg(file("toml")).arg("-o").arg(file("rs")))
        };
        if let Err(refusal) = export(without) {
            // What no controller can compensate is left out, as the refusal says.
            let mut words = refusal.split_whitespace();
            let mut without = without.to_vec();
            while words.by_ref().any(|word| word == "--without") {
                without.extend(words.next());
            }
            export(&without).map_err(|_| refusal.clone())?;
        }
        let building = self.building.lock().map_err(|e| e.to_string())?;
        let (mut build, image) = build_command("preslide-qemu")?;
        quiet(build.env("PRESLIDE_MODEL", file("rs")))?;
        let copy = file("elf");
        std::fs::copy(&image, &copy).map_err(|e| format!("{}: {e}", image.display()))?;
        drop(building);
        Ok(copy)
    }

    /// What a step knows of the stage, behind everything else.
    fn stage(&self) -> Option<&'static str> {
        self.electrical.then_some("--electrical")
    }

    /// A step that knows the truth.
    fn steps(&self, words: &[&str]) -> Command {
        let mut command = Command::new(released("examples/chain"));
        command.args(words).arg(&self.seed);
        command
    }
}

/// A command of the tool.
fn tool(command: &str) -> Command {
    let mut tool = Command::new(released("preslide"));
    tool.arg(command);
    tool
}

/// Runs it; its output is shown where it failed.
fn quiet(command: &mut Command) -> Result<(), String> {
    output(command).map(|_| ())
}

fn make(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

/// Runs it with its output shown.
fn run_shown(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| e.to_string())?;
    if status.success() {
        Ok(())
    } else {
        Err("the chain missed its aim; see above".to_owned())
    }
}
