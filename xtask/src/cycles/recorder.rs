//! Runs a program in QEMU under the path recorder and reads what it recorded.

use std::collections::HashMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::process::{root, run, run_for};

/// A run takes seconds; QEMU spins for ever when the guest hangs.
const QEMU_LIMIT: Duration = Duration::from_secs(300);

/// Consecutive instructions, first and last address.
type Stretch = (u32, u32);

/// One distinct path of a function and how many calls took it.
pub struct TakenPath {
    pub calls: u32,
    pub stretches: Vec<Stretch>,
}

pub struct Recording {
    /// Distinct paths by the function's address.
    pub paths: HashMap<u32, Vec<TakenPath>>,
    /// What the program printed.
    pub printed: String,
}

pub struct Recorder {
    /// Where the plugin and the recordings go.
    folder: PathBuf,
    plugin: PathBuf,
}

impl Recorder {
    /// Builds the QEMU plugin.
    pub fn build(folder: PathBuf) -> Result<Self, String> {
        fs::create_dir_all(&folder)
            .map_err(|error| format!("cannot create {}: {error}", folder.display()))?;
        let plugin = folder.join("paths.so");
        let source = root().join("xtask/qemu-plugin/paths.c");
        let mut cc = Command::new("cc");
        cc.args([
            "-std=c11",
            "-D_POSIX_C_SOURCE=200809L",
            "-O2",
            "-Wall",
            "-Wextra",
            "-Werror",
        ]);
        cc.args(["-shared", "-fPIC", "-fvisibility=hidden", "-o"])
            .arg(&plugin)
            .arg(source);
        run(&mut cc)?;
        Ok(Self { folder, plugin })
    }

    /// Records every call of the functions at `entries`.
    pub fn record(&self, program: &Path, entries: &[u32]) -> Result<Recording, String> {
        let list: String = entries.iter().map(|entry| format!("{entry:x}\n")).collect();
        fs::write(self.folder.join("entries"), list)
            .map_err(|error| format!("cannot write the entries: {error}"))?;
        // QEMU spins when its standard output closes early: a file never does.
        let printed = self.folder.join("printed");
        let output = File::create(&printed)
            .map_err(|error| format!("cannot create {}: {error}", printed.display()))?;
        let mut qemu = Command::new("qemu-system-arm");
        qemu.current_dir(&self.folder)
            .args([
                "-machine",
                "mps2-an386",
                "-display",
                "none",
                "-monitor",
                "none",
                "-serial",
                "none",
            ])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-icount", "shift=5,sleep=off"])
            .arg("-plugin")
            .arg(format!(
                "./{},entries=entries,out=paths",
                file_name(&self.plugin)
            ))
            .arg("-kernel")
            .arg(program)
            .stdout(output);
        let result = run_for(&mut qemu, QEMU_LIMIT);
        let printed = fs::read_to_string(&printed)
            .map_err(|error| format!("cannot read {}: {error}", printed.display()))?;
        result.map_err(|error| {
            format!("{error}; it printed:\n{printed}\nThe recorder needs a QEMU with TCG plugins, as Debian's is")
        })?;
        let file = self.folder.join("paths");
        let bytes = fs::read(&file)
            .map_err(|error| format!("the recorder left no {}: {error}", file.display()))?;
        Ok(Recording {
            paths: parse(&bytes)?,
            printed,
        })
    }
}

fn file_name(path: &Path) -> std::borrow::Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}

/// The format is described in `qemu-plugin/paths.c`.
fn parse(bytes: &[u8]) -> Result<HashMap<u32, Vec<TakenPath>>, String> {
    let mut words = bytes
        .chunks_exact(4)
        .map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]]));
    let mut next = || words.next().ok_or("the recording ends early; run it again");
    let mut paths: HashMap<u32, Vec<TakenPath>> = HashMap::new();
    loop {
        let (entry, calls) = (next()?, next()?);
        if entry == 0 {
            return if calls == 0 {
                Ok(paths)
            } else {
                Err("a recorded call had not returned at the end".to_string())
            };
        }
        let count = next()?;
        let stretches = (0..count)
            .map(|_| Ok::<_, String>((next()?, next()?)))
            .collect::<Result<_, _>>()?;
        paths
            .entry(entry)
            .or_default()
            .push(TakenPath { calls, stretches });
    }
}
