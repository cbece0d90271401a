//! Runs programs in QEMU under the path recorder and reads what it recorded.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};
use fs_err as fs;
use preslide_tools::process::{command, root, run, run_for};

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
    pub fn build(folder: PathBuf) -> Result<Self> {
        fs::create_dir_all(&folder)?;
        let mut cc = command(
            "cc -std=c11 -D_POSIX_C_SOURCE=200809L -O2 -Wall -Wextra -Werror -shared -fPIC -fvisibility=hidden -o",
        );
        cc.arg(folder.join(PLUGIN));
        run(cc.arg(root().join("cycles/qemu-plugin/paths.c")))?;
        Ok(Self { folder })
    }

    /// Records a program that needs nothing but a console; what it printed, beside the paths.
    pub fn record(&self, program: &Path, watched: &Watched) -> Result<(Paths, String)> {
        let printed = self.folder.join("printed");
        let mut qemu = qemu("mps2-an386", program, &printed)?;
        let recorded = self.watch(qemu.arg("-plugin").arg(self.plugin(watched)), watched);
        let printed = fs::read_to_string(&printed)?;
        let paths = recorded.with_context(|| format!("it printed:\n{printed}"))?;
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
    pub fn watch(&self, command: &mut Command, watched: &Watched) -> Result<Paths> {
        for (name, addresses) in [("entries", watched.entries), ("skipped", watched.skipped)] {
            let list: String = addresses.iter().map(|at| format!("{at:x}\n")).collect();
            fs::write(self.folder.join(name), list)?;
        }
        let file = self.folder.join(RECORDED);
        // What an earlier run left must not pass for this one's.
        let _ = fs::remove_file(&file);
        run_for(command.current_dir(&self.folder), QEMU_LIMIT)
            .context("the recorder needs a QEMU with TCG plugins, as Debian's is")?;
        let (paths, ended_inside) = parse(&fs::read(&file)?)?;
        ensure!(
            watched.ends_inside || !ended_inside,
            "a recorded call had not returned at the end"
        );
        Ok(paths)
    }
}

/// Runs a program on an emulated machine that needs nothing but a console, which goes to a file: QEMU spins when its standard output closes
/// early.
pub fn qemu(machine: &str, program: &Path, printed: &Path) -> Result<Command> {
    let mut qemu = command(&format!(
        "qemu-system-arm -machine {machine} -display none -monitor none -serial none \
         -semihosting-config enable=on,target=native -icount shift=5,sleep=off -kernel"
    ));
    let printed = fs::File::create(printed)?;
    qemu.arg(program).stdout(printed.into_file());
    Ok(qemu)
}

/// The format is described in `qemu-plugin/paths.c`; also whether a call was under way at the end.
fn parse(bytes: &[u8]) -> Result<(Paths, bool)> {
    let mut words = bytes
        .chunks_exact(4)
        .map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]]));
    let mut next = || {
        words
            .next()
            .context("the recording ends early; run it again")
    };
    let mut paths = Paths::new();
    loop {
        let (entry, calls) = (next()?, next()?);
        if entry == 0 {
            return Ok((paths, calls > 0));
        }
        let count = next()?;
        let stretches = (0..count)
            .map(|_| Ok((next()?, next()?)))
            .collect::<Result<_>>()?;
        paths
            .entry(entry)
            .or_default()
            .push(TakenPath { calls, stretches });
    }
}
