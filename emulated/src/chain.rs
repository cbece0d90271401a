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

use anyhow::{Result, anyhow, bail, ensure};
use fs_err as fs;
use preslide_tools::image::{MODEL, build, build_command};
use preslide_tools::need::Need;
use preslide_tools::process::{build_as_tests, free_port, output, released, with_folder};

use crate::qemu::capture;

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

/// `cargo xtask chain`.
pub fn run_command(arguments: &[String]) -> Result<()> {
    let mut asked = Asked {
        seed: 1,
        count: 6,
        kernel: None,
        electrical: false,
        brief: false,
    };
    let wrong = || {
        let given = arguments.join(" ");
        anyhow!(
            "it takes --seed N, --count K, --kernel NAME, --electrical and --brief, got `{given}`"
        )
    };
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let mut value = || {
            words
                .next()
                .filter(|value| !value.is_empty())
                .ok_or_else(wrong)
        };
        match word.as_str() {
            "--electrical" => asked.electrical = true,
            "--brief" => asked.brief = true,
            "--seed" => asked.seed = value()?.parse().map_err(|_| wrong())?,
            "--count" => asked.count = value()?.parse().map_err(|_| wrong())?,
            "--kernel" => asked.kernel = Some(value()?.clone()),
            _ => bail!(wrong()),
        }
    }
    ensure!(asked.count > 0, wrong());
    Need::Qemu.ensure()?;
    build_as_tests("--bin preslide --example chain")?;
    let shipped = build("qemu-fixed", "", None)?;
    with_folder("chain", |folder| {
        let chain = Chain {
            asked,
            shipped,
            folder,
            building: Mutex::new(()),
        };
        let start = Instant::now();
        let folders = chain.run()?;
        let Asked { seed, count, .. } = chain.asked;
        let seconds = start.elapsed().as_secs_f64();
        println!("\nseed {seed}, {count} trials, {seconds:.0} s");
        let mut table = chain.steps("table");
        // With its output shown.
        let met = table.args(&folders).args(chain.stage()).status()?;
        ensure!(
            met.success(),
            "the chain missed its aim; see above (recordings and models are in {})",
            folder.display()
        );
        Ok(())
    })
}

/// What the command line says.
struct Asked {
    seed: u64,
    /// How many trials.
    count: usize,
    /// What the firmware computes friction with, as `preslide export --kernel` takes it.
    kernel: Option<String>,
    /// On the electrical stage.
    electrical: bool,
    /// What decides alone is tracked: the model after the diagnosis and the stage's own.
    brief: bool,
}

struct Chain<'a> {
    asked: Asked,
    /// The firmware as it comes, which is recorded.
    shipped: PathBuf,
    folder: &'a Path,
    /// Only one build at a time: they share a folder, and the image in it is copied away.
    building: Mutex<()>,
}

impl Chain<'_> {
    /// All trials; their folders.
    fn run(&self) -> Result<Vec<PathBuf>> {
        fs::write(self.folder.join("none.toml"), NONE)?;
        if !self.asked.brief {
            self.image(self.folder, "none", &[])?;
        }
        let count = self.asked.count;
        let folders = (0..count).map(|index| self.folder.join(index.to_string()));
        let folders: Vec<PathBuf> = folders.collect();
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(folder) = folders.get(index) else {
                    return Ok(());
                };
                let start = Instant::now();
                self.trial(index, folder)
                    .inspect_err(|_| next.store(count, Ordering::Relaxed))?;
                let seconds = start.elapsed().as_secs_f64();
                println!("trial {} of {count}: {seconds:.0} s", index + 1);
            }
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..WORKERS).map(|_| scope.spawn(work)).collect();
            workers.into_iter().try_for_each(|worker| {
                let ended = worker.join();
                ended.unwrap_or_else(|_| bail!("a trial ended early"))
            })
        })?;
        Ok(folders)
    }

    /// Once around; everything that is found stays in `folder`.
    fn trial(&self, index: usize, folder: &Path) -> Result<()> {
        fs::create_dir_all(folder)?;
        let file = |name: &str| folder.join(name);
        let index = index.to_string();
        let port = free_port()?;
        let mut serve = self.steps("serve");
        serve.arg(&index).arg(&self.shipped).arg(&port);
        serve.args(self.stage());
        serve.stdout(Stdio::null()).stderr(Stdio::null());
        let recording = file("recording.csv");
        capture(&mut serve, &port, |tool| {
            tool.args(["--every", ROW, "--after", self.located()]);
            quiet(tool.arg("-o").arg(&recording))
        })?;

        let model = file("before.toml");
        quiet(tool("identify").arg(&recording).arg("-o").arg(&model))?;
        let mut diagnose = tool("diagnose");
        diagnose.arg(&recording).arg("--model").arg(&model);
        diagnose.arg("-o").arg(file("after.toml"));
        quiet(diagnose.arg("--json").arg(file("diagnosis.json")))?;
        quiet(self.steps("known").arg(&index).arg(file("known.toml")))?;

        for name in ["after", "known"] {
            self.image(folder, name, &[])?;
        }
        let mut track = self.steps("track");
        track.arg(&index).arg(self.folder.join("none.elf"));
        track.arg(folder).args(self.stage());
        if self.asked.brief {
            return quiet(&mut track);
        }
        self.image(folder, "before", &[])?;
        // What the refitted blocks do by themselves.
        let after = fs::read_to_string(file("after.toml"))?;
        let ids = after.lines().filter_map(|line| line.strip_prefix("id = "));
        // Some come twice, but a name leaves out all of them.
        let ids: BTreeSet<&str> = ids.map(|id| id.trim_matches('"')).collect();
        let ids: Vec<&str> = ids.into_iter().collect();
        fs::write(file("refit.toml"), &after)?;
        self.image(folder, "refit", &ids)?;
        quiet(&mut track)
    }

    /// When the firmware knows where it stands (s).
    fn located(&self) -> &'static str {
        match self.asked.electrical {
            true => LOCATED_CALIBRATED,
            false => LOCATED,
        }
    }

    /// Exports the model of that name `without` some effects, and builds the firmware with it.
    fn image(&self, folder: &Path, name: &str, without: &[&str]) -> Result<()> {
        let file = |kind: &str| folder.join(format!("{name}.{kind}"));
        let export = |without: &[&str]| {
            let mut export = tool("export");
            export.args(without.iter().flat_map(|id| ["--without", id]));
            // Without friction there is none to compute.
            let kernel = self.asked.kernel.iter().filter(|_| name != "none");
            export.args(kernel.flat_map(|kernel| ["--kernel", kernel]));
            quiet(export.arg(file("toml")).arg("-o").arg(file("rs")))
        };
        if let Err(refusal) = export(without) {
            // What no controller can compensate is left out, as the refusal says.
            let said = refusal.to_string();
            let mut words = said.split_whitespace();
            let mut without = without.to_vec();
            while words.by_ref().any(|word| word == "--without") {
                without.extend(words.next());
            }
            export(&without).map_err(|_| refusal)?;
        }
        let building = self.building.lock();
        let _building = building.map_err(|_| anyhow!("another build ended early"))?;
        let (mut build, image) = build_command("preslide-qemu")?;
        quiet(build.env(MODEL, file("rs")))?;
        fs::copy(image, file("elf"))?;
        Ok(())
    }

    /// What a step knows of the stage, behind everything else.
    fn stage(&self) -> Option<&'static str> {
        self.asked.electrical.then_some("--electrical")
    }

    /// A step that knows the truth.
    fn steps(&self, step: &str) -> Command {
        let mut command = Command::new(released("examples/chain"));
        command.arg(step).arg(self.asked.seed.to_string());
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
fn quiet(command: &mut Command) -> Result<()> {
    output(command).map(|_| ())
}
