//! Runs programs in QEMU under the path recorder and reads what it recorded.

use std::collections::HashMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::process::{root, run, run_for};

/// A run takes seconds; QEMU spins for ever when the guest hangs.
pub const QEMU_LIMIT: Duration = Duration::from_secs(300);

const PLUGIN: &str = "paths.so";
const RECORDED: &str = "paths";

/// Consecutive instructions, first and last address.
type Stretch = (u32, u32);

/// One distinct path of a function and how many calls took it.
pub struct TakenPath {
    pub calls: u32,
    pub stretches: Vec<Stretch>,
}

/// Distinct paths by the function's address.
pub type Paths = HashMap<u32, Vec<TakenPath>>;

/// What is recorded.
pub struct Watched<'a> {
    /// Functions, by address.
    pub entries: &'a [u32],
    /// Functions whose calls are passed over with all that they call.
    pub skipped: &'a [u32],
    /// Whether a recorded call may be under way at the end: the program stops itself from within one.
    pub ends_inside: bool,
}

pub struct Recorder {
    /// Where the plugin and the recordings go.
    folder: PathBuf,
}

impl Recorder {
    /// Builds the QEMU plugin.
    pub fn build(folder: PathBuf) -> Result<Self, String> {
        fs::create_dir_all(&folder)
            .map_err(|error| format!("cannot create {}: {error}", folder.display()))?;
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
            .arg(folder.join(PLUGIN))
            .arg(source);
        run(&mut cc)?;
        Ok(Self { folder })
    }

    /// Records a program that needs nothing but a console; what it printed, beside the paths.
    pub fn record(&self, program: &Path, watched: &Watched) -> Result<(Paths, String), String> {
        // QEMU spins when its standard output closes early: a file never does.
        let printed = self.folder.join("printed");
        let output = File::create(&printed)
            .map_err(|error| format!("cannot create {}: {error}", printed.display()))?;
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args([
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
        .arg(self.plugin(watched))
        .arg("-kernel")
        .arg(program)
        .stdout(output);
        let result = self.watch(&mut qemu, watched);
        let printed = fs::read_to_string(&printed)
            .map_err(|error| format!("cannot read {}: {error}", printed.display()))?;
        let paths = result.map_err(|error| format!("{error}; it printed:\n{printed}"))?;
        Ok((paths, printed))
    }

    /// QEMU's argument for a run under [`Recorder::watch`].
    pub fn plugin(&self, watched: &Watched) -> String {
        let skip = if watched.skipped.is_empty() {
            ""
        } else {
            ",skip=skipped"
        };
        format!("./{PLUGIN},entries=entries,out={RECORDED}{skip}")
    }

    /// Runs a command that starts QEMU with [`Recorder::plugin`].
    pub fn watch(&self, command: &mut Command, watched: &Watched) -> Result<Paths, String> {
        for (name, addresses) in [("entries", watched.entries), ("skipped", watched.skipped)] {
            let list: String = addresses.iter().map(|at| format!("{at:x}\n")).collect();
            fs::write(self.folder.join(name), list)
                .map_err(|error| format!("cannot write the list of {name}: {error}"))?;
        }
        let file = self.folder.join(RECORDED);
        // What an earlier run left must not pass for this one's.
        let _ = fs::remove_file(&file);
        run_for(command.current_dir(&self.folder), QEMU_LIMIT).map_err(|error| {
            format!("{error}\nThe recorder needs a QEMU with TCG plugins, as Debian's is")
        })?;
        let bytes = fs::read(&file)
            .map_err(|error| format!("the recorder left no {}: {error}", file.display()))?;
        let (paths, ended_inside) = parse(&bytes)?;
        if ended_inside && !watched.ends_inside {
            return Err("a recorded call had not returned at the end".to_string());
        }
        Ok(paths)
    }
}

/// The format is described in `qemu-plugin/paths.c`; also whether a call was under way at the end.
fn parse(bytes: &[u8]) -> Result<(Paths, bool), String> {
    let mut words = bytes
        .chunks_exact(4)
        .map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]]));
    let mut next = || words.next().ok_or("the recording ends early; run it again");
    let mut paths = Paths::new();
    loop {
        let (entry, calls) = (next()?, next()?);
        if entry == 0 {
            return Ok((paths, calls > 0));
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
