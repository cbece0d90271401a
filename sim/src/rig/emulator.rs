//! QEMU with the firmware in it: the lock step with the stage on its standard input and output, and the telemetry.

use preslide_link::{Deframer, Exchange, Order, Reading, Report};
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// QEMU connects and ends within this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// The telemetry's file in the run's folder.
const TELEMETRY: &str = "telemetry";

/// Why a run on the emulator failed.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// QEMU could not be started.
    #[error("qemu-system-arm did not start: {0}; on Debian: apt-get install qemu-system-arm")]
    Start(std::io::Error),
    /// QEMU did not open its sockets.
    #[error("QEMU did not connect within 20 s; its output: {0}")]
    Connect(String),
    /// The lock step broke off.
    #[error("the lock step broke off at exchange {exchange}: {error}")]
    LockStep {
        /// Exchanges done before.
        exchange: u64,
        /// What the socket said.
        error: std::io::Error,
    },
    /// A file or socket could not be made.
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
    /// Into a socket that holds a few samples, read by a thread that can pause.
    Line,
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
    listener: Option<JoinHandle<Vec<Report>>>,
    paused: Arc<AtomicBool>,
    heard: Arc<AtomicU32>,
    folder: TempDir,
}

/// What is left of a run.
pub struct Remains {
    /// Everything that came up the telemetry line, frames that could not be read left out.
    pub reports: Vec<Report>,
    /// What the firmware logged.
    pub log: String,
}

impl Emulator {
    /// Starts QEMU with the firmware `elf`, and with the TCG plugin whose file and arguments `plugin` holds.
    ///
    /// # Errors
    /// [`RigError`] where QEMU does not start or does not connect.
    pub fn start(elf: &Path, listener: Listener, plugin: Option<&str>) -> Result<Self, RigError> {
        let folder = tempfile::Builder::new().prefix("preslide-rig-").tempdir();
        let folder = folder.map_err(|error| RigError::File(std::env::temp_dir(), error))?;
        let link_path = folder.path().join("link");
        let link = UnixListener::bind(&link_path)
            .map_err(|error| RigError::File(link_path.clone(), error))?;
        let telemetry = match listener {
            Listener::File => format!(
                "file,id=link,path={}",
                folder.path().join(TELEMETRY).display()
            ),
            Listener::Line => format!("socket,id=link,path={}", link_path.display()),
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
        let link = match listener {
            Listener::Line => accept(&link).map(Some),
            Listener::File | Listener::Tcp(_) | Listener::Served(_) => Some(None),
        };
        let (Some(link), Some(orders), Some(readings)) =
            (link, child.stdout.take(), child.stdin.take())
        else {
            // Either way it is gone after the wait.
            let _ = child.kill();
            let log = output(&mut child);
            return Err(RigError::Connect(log));
        };
        let paused = Arc::new(AtomicBool::new(false));
        let heard = Arc::new(AtomicU32::new(0));
        let listener = link.map(|link| {
            let (paused, heard) = (Arc::clone(&paused), Arc::clone(&heard));
            std::thread::spawn(move || listen(link, &paused, &heard))
        });
        Ok(Self {
            child,
            orders,
            readings,
            exchanges: 0,
            listener,
            paused,
            heard,
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

    /// Stops or goes on listening to the telemetry.
    pub fn pause_listening(&self, paused: bool) {
        self.paused.store(paused, Ordering::Relaxed);
    }

    /// The tick of the newest sample that [`Listener::Line`] has brought.
    pub fn heard(&self) -> u64 {
        self.heard.load(Ordering::Relaxed).into()
    }

    /// Waits for QEMU's end and collects what is left.
    pub fn finish(mut self) -> Remains {
        self.pause_listening(false);
        let start = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) {
            if start.elapsed() > PATIENCE {
                let _ = self.child.kill();
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let log = output(&mut self.child);
        let reports = match self.listener.take() {
            Some(thread) => thread.join().unwrap_or_default(),
            None => {
                let file = std::fs::File::open(self.folder.path().join(TELEMETRY));
                file.map_or(Vec::new(), |file| listen(file, &self.paused, &self.heard))
            }
        };
        Remains { reports, log }
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

fn accept(listener: &UnixListener) -> Option<UnixStream> {
    listener.set_nonblocking(true).ok()?;
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Ok((stream, _)) = listener.accept() {
            stream.set_nonblocking(false).ok()?;
            stream.set_read_timeout(Some(PATIENCE)).ok()?;
            stream.set_write_timeout(Some(PATIENCE)).ok()?;
            return Some(stream);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    None
}

fn output(child: &mut Child) -> String {
    let mut text = String::new();
    if let Some(mut log) = child.stderr.take() {
        // What cannot be read is not there.
        let _ = log.read_to_string(&mut text);
    }
    text
}

fn listen(mut link: impl Read, paused: &AtomicBool, heard: &AtomicU32) -> Vec<Report> {
    let mut deframer = Deframer::new();
    let mut reports = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        if paused.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
            continue;
        }
        match link.read(&mut buffer) {
            Ok(0) | Err(_) => return reports,
            Ok(length) => {
                let bytes = buffer.iter().take(length);
                reports.extend(bytes.filter_map(|&byte| deframer.push::<Report>(byte)?.ok()));
                if let Some(Report::Sample(sample)) = reports.last() {
                    heard.store(sample.tick, Ordering::Relaxed);
                }
            }
        }
    }
}
