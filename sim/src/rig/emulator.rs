//! QEMU with the firmware in it: the lock step with the stage on its standard input and output, and the telemetry.

use preslide_link::{Deframer, Exchange, Order, Reading, Report};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// QEMU ends within this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// The telemetry's file in the run's folder.
const TELEMETRY: &str = "telemetry";

/// Why a run on the emulator failed.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// QEMU could not be started.
    #[error("qemu-system-arm did not start: {0}; on Debian: apt-get install qemu-system-arm")]
    Start(std::io::Error),
    /// The lock step broke off.
    #[error("the lock step broke off at exchange {exchange}: {error}")]
    LockStep {
        /// Exchanges done before.
        exchange: u64,
        /// What the socket said.
        error: std::io::Error,
    },
    /// A file could not be made.
    #[error("{0}: {1}")]
    File(PathBuf, std::io::Error),
    /// The firmware answered otherwise than it should.
    #[error("the firmware {0}")]
    Answer(&'static str),
    /// The stage or the host's controller could not be built.
    #[error(transparent)]
    Tracking(#[from] crate::tracking::TrackingError),
}

/// Where the telemetry goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listener {
    /// Into a file, read at the end. A file takes every byte at once, so the run depends on nothing outside.
    File,
    /// To the first client of this TCP port on this machine; QEMU waits for it.
    Tcp(u16),
    /// To and from one client of this TCP port after the other, from the start on, whether there is one or not.
    Served(u16),
}

/// A running emulator.
pub struct Emulator {
    child: Child,
    orders: ChildStdout,
    readings: ChildStdin,
    exchanges: u64,
    folder: TempDir,
}

/// What is left of a run.
pub struct Remains {
    /// Everything that came up the telemetry line, frames that could not be read left out.
    pub reports: Vec<Report>,
    /// What the firmware logged: text, or frames of defmt where it was built with the feature `log`.
    pub log_bytes: Vec<u8>,
}

impl Remains {
    /// What the firmware logged, as text.
    pub fn log(&self) -> String {
        String::from_utf8_lossy(&self.log_bytes).into_owned()
    }
}

impl Emulator {
    /// Starts QEMU with the firmware `elf`, and with the TCG plugin whose file and arguments `plugin` holds.
    ///
    /// # Errors
    /// [`RigError`] where QEMU does not start or does not connect.
    pub fn start(elf: &Path, listener: Listener, plugin: Option<&str>) -> Result<Self, RigError> {
        let folder = tempfile::Builder::new().prefix("preslide-rig-").tempdir();
        let folder = folder.map_err(|error| RigError::File(std::env::temp_dir(), error))?;
        let telemetry = match listener {
            Listener::File => format!(
                "file,id=link,path={}",
                folder.path().join(TELEMETRY).display()
            ),
            Listener::Tcp(port) => {
                format!("socket,id=link,host=127.0.0.1,port={port},server=on,wait=on")
            }
            Listener::Served(port) => {
                format!("socket,id=link,host=127.0.0.1,port={port},server=on,wait=off,nodelay=on")
            }
        };
        let mut qemu = Command::new("qemu-system-arm");
        if let Some(plugin) = plugin {
            qemu.args(["-plugin", plugin]);
        }
        let mut child = qemu
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"])
            // 8 ns an instruction: about what a Cortex-M4 at 170 MHz makes of this code.
            .args(["-icount", "shift=3,sleep=off"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-chardev", &telemetry, "-serial", "chardev:link"])
            .arg("-kernel")
            .arg(elf)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(RigError::Start)?;
        let (Some(orders), Some(readings)) = (child.stdout.take(), child.stdin.take()) else {
            return Err(RigError::Start(std::io::Error::other("no pipes to it")));
        };
        Ok(Self {
            child,
            orders,
            readings,
            exchanges: 0,
            folder,
        })
    }

    /// Waits for what the bridge got.
    ///
    /// # Errors
    /// [`RigError::LockStep`] where the firmware does not answer.
    pub fn order(&mut self) -> Result<Order, RigError> {
        let mut bytes = [0; 3];
        let result = self.orders.read_exact(&mut bytes);
        self.step(result)?;
        Ok(Order::from_bytes(bytes))
    }

    /// Shows the registers of the next tick.
    ///
    /// # Errors
    /// [`RigError::LockStep`] where the firmware is gone.
    pub fn reading(&mut self, reading: Reading) -> Result<(), RigError> {
        let result = self.readings.write_all(&reading.to_bytes());
        self.step(result)?;
        self.exchanges += 1;
        Ok(())
    }

    /// Waits for QEMU's end and collects what is left.
    pub fn finish(mut self) -> Remains {
        let start = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) {
            if start.elapsed() > PATIENCE {
                let _ = self.child.kill();
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let log_bytes = output(&mut self.child);
        // Where the telemetry went elsewhere, there is no file.
        let file = std::fs::File::open(self.folder.path().join(TELEMETRY));
        let reports = file.map_or(Vec::new(), heard);
        Remains { reports, log_bytes }
    }

    fn step(&self, result: std::io::Result<()>) -> Result<(), RigError> {
        result.map_err(|error| RigError::LockStep {
            exchange: self.exchanges,
            error,
        })
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It has ended already unless a run broke off.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn output(child: &mut Child) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(mut log) = child.stderr.take() {
        // What cannot be read is not there.
        let _ = log.read_to_end(&mut bytes);
    }
    bytes
}

/// What a telemetry file holds; what cannot be read ends it.
fn heard(mut file: std::fs::File) -> Vec<Report> {
    let mut bytes = Vec::new();
    let _ = file.read_to_end(&mut bytes);
    let mut deframer = Deframer::new();
    let reports = bytes.into_iter();
    reports
        .filter_map(|byte| deframer.push::<Report>(byte)?.ok())
        .collect()
}
