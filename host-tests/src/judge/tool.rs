//! The tool under judgement: a program called as `preslide diagnose REC… [--model M] --json F`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::table::Recording;
use crate::answer::Diagnosis;

/// A build of the tool, and how long it may take.
#[derive(Clone, Debug)]
pub struct Tool {
    /// Program and first arguments, `preslide diagnose` as a rule.
    pub command: Vec<String>,
    /// Longest time for one diagnosis.
    pub limit: Duration,
    /// Where recordings and answers stay, a folder each named after the recording; without it they are removed.
    pub keep: Option<PathBuf>,
}

/// An answer or why there is none, and how long it took (s).
pub type Timed = (Result<Diagnosis, String>, f64);

impl Tool {
    /// The program at `path`, or the one beside this program.
    ///
    /// # Errors
    /// Where there is none.
    pub fn new(path: Option<&Path>) -> Result<Self, String> {
        let program = match path {
            Some(path) => path.to_owned(),
            None => std::env::current_exe()
                .map_err(|e| e.to_string())?
                .with_file_name(format!("preslide{}", std::env::consts::EXE_SUFFIX)),
        };
        if !program.exists() {
            return Err(format!(
                "{} does not exist; run `cargo build --release -p preslide-cli`, or name a program with --preslide",
                program.display()
            ));
        }
        Ok(Self {
            command: vec![program.display().to_string(), "diagnose".to_owned()],
            limit: Duration::from_secs(300),
            keep: None,
        })
    }

    /// For tests: the program named by `PRESLIDE`, or that of this workspace, built with tests' optimisation, once for all of them.
    ///
    /// # Errors
    /// Where it does not build.
    pub fn of_workspace() -> Result<Self, String> {
        static BUILT: LazyLock<Result<Tool, String>> = LazyLock::new(Tool::built);
        BUILT.clone()
    }

    /// For tests: what this workspace's program says of a recording, printed as well.
    ///
    /// # Panics
    /// Where it does not build or gives no answer.
    pub fn told(recording: &Recording) -> Diagnosis {
        let tool = Self::of_workspace().unwrap_or_else(|e| panic!("{e}"));
        let found = tool.diagnose(recording).0.unwrap_or_else(|e| panic!("{e}"));
        println!("{found:?}");
        found
    }

    fn built() -> Result<Self, String> {
        if let Some(path) = std::env::var_os("PRESLIDE") {
            return Self::new(Some(Path::new(&path)));
        }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(cargo)
            // As `cargo test --workspace` builds it: with the features of one package alone it would be built again.
            .args(["build", "--quiet", "--workspace", "--bin", "preslide"])
            // In the profile of this program.
            .args((!cfg!(debug_assertions)).then_some("--release"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .status()
            .map_err(|e| format!("cargo: {e}"))?;
        if !built.success() {
            return Err("preslide does not build".to_owned());
        }
        // Test programs stand in a folder below the programs.
        let own = std::env::current_exe().map_err(|e| e.to_string())?;
        let folder = own.parent().and_then(Path::parent).unwrap_or(&own);
        Self::new(Some(
            &folder.join(format!("preslide{}", std::env::consts::EXE_SUFFIX)),
        ))
    }

    /// Diagnoses files in `folder`, which takes the answer.
    ///
    /// # Errors
    /// What the tool said last, where it gives no answer.
    pub fn ask(
        &self,
        folder: &Path,
        recordings: &[PathBuf],
        model: Option<&Path>,
        arguments: &[String],
    ) -> Result<Diagnosis, String> {
        let (program, first) = self.command.split_first().ok_or("no program to judge")?;
        let (answer, errors) = (folder.join("answer.json"), folder.join("stderr.txt"));
        // Of an earlier run in a folder that was kept: this one may give none.
        let _ = std::fs::remove_file(&answer);
        let stderr = std::fs::File::create(&errors).map_err(|e| e.to_string())?;
        let mut command = Command::new(program);
        command.args(first).args(recordings).args(arguments);
        if let Some(model) = model {
            command.arg("--model").arg(model);
        }
        command.arg("--json").arg(&answer);
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(stderr)
            .spawn()
            .map_err(|e| format!("`{program}` does not start: {e}"))?;
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
                break status;
            }
            if started.elapsed() > self.limit {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("still running after {} s", self.limit.as_secs()));
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let text = std::fs::read_to_string(&answer).map_err(|_| {
            let said = std::fs::read_to_string(&errors).unwrap_or_default();
            let last = said.lines().rev().find(|line| !line.trim().is_empty());
            format!("no JSON ({status}): {}", last.unwrap_or("no message"))
        })?;
        Diagnosis::parse(&text)
    }

    /// Writes a recording into a folder of its own, diagnoses it, and removes the folder unless it is to be kept.
    pub fn diagnose(&self, recording: &Recording) -> Timed {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = match &self.keep {
            Some(keep) => keep.join(recording.name.replace(' ', "_")),
            None => std::env::temp_dir().join(format!("preslide-judge-{}-{n}", std::process::id())),
        };
        let begun = Instant::now();
        let answer = self.in_folder(recording, &folder);
        if self.keep.is_none() {
            let _ = std::fs::remove_dir_all(&folder);
        }
        (answer, begun.elapsed().as_secs_f64())
    }

    fn in_folder(&self, recording: &Recording, folder: &Path) -> Result<Diagnosis, String> {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let files: Vec<PathBuf> = (0..recording.parts.len())
            .map(|i| folder.join(format!("recording{i}.csv")))
            .collect();
        for (part, file) in recording.parts.iter().zip(&files) {
            part.write(file)?;
        }
        let model = folder.join("model.toml");
        if let Some(text) = &recording.model {
            std::fs::write(&model, text).map_err(|e| format!("{}: {e}", model.display()))?;
        }
        let model = recording.model.as_ref().map(|_| model.as_path());
        self.ask(folder, &files, model, &recording.arguments)
    }
}

/// Runs `work` on every item, on `jobs` threads, 0 for as many as there are cores; results in the order of the items.
pub fn parallel<T: Sync, R: Send>(
    items: &[T],
    jobs: usize,
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    match rayon::ThreadPoolBuilder::new().num_threads(jobs).build() {
        Ok(pool) => pool.install(|| items.par_iter().map(&work).collect()),
        // Without threads, one after the other.
        Err(_) => items.iter().map(work).collect(),
    }
}
