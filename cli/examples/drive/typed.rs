//! A script that types: the tool's commands on a pseudo terminal in place of a serial line, and its terminal with keys.

use anyhow::{Context, bail, ensure};
use portable_pty::{CommandBuilder, PtySize, native_pty_system};
use serialport::{SerialPort, TTYPort};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The emulated drive runs at a third of a real one's speed on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Types at the tool until all is seen that should be. The drive serves at the port.
pub fn typed(tool: &Path, port: u16) -> anyhow::Result<()> {
    on_a_pseudo_terminal(tool, port)?;
    let address = format!("tcp:127.0.0.1:{port}");
    let mut screen = Screen::open(tool, &address)?;
    screen.wait_for("disabled, the bridge is open")?;
    screen.wait_for("power came on")?;
    screen.key("e")?;
    screen.wait_for("enabled, holds its position")?;
    screen.key("t1mm\r")?;
    screen.wait_for("1mm: done")?;
    screen.wait_for("state     moves")?;
    // The space bar in the middle of the move, and in the middle of a question.
    screen.key("b")?;
    screen.wait_for("move by")?;
    screen.key("3 ")?;
    screen.wait_for("stop: done")?;
    screen.wait_for("enabled, holds its position")?;
    screen.key("sgains.derivative=550\r")?;
    screen.wait_for("gains.derivative=550: done")?;
    screen.key("sno.such=1\r")?;
    screen.wait_for("there is no such parameter")?;
    screen.key("q")?;
    screen.ended()?;
    let said = run(tool, &address, &["state"])?;
    ensure!(
        said.contains("disabled"),
        "quitting left the axis enabled: {said}"
    );
    let position = position(&said)?;
    ensure!(
        position > 1e-6 && position < 0.999e-3,
        "the space bar did not stop the move to 1 mm: {position} m"
    );
    let said = run(tool, &address, &["get", "gains.derivative"])?;
    ensure!(said.contains("5.5e2"), "the gain that was typed: {said}");
    // Ctrl-C stops the axis first.
    run(tool, &address, &["enable"])?;
    let mut screen = Screen::open(tool, &address)?;
    screen.wait_for("enabled, holds its position")?;
    screen.key("\u{1b}[C")?;
    screen.wait_for("jog forward: done")?;
    screen.wait_for("state     moves")?;
    screen.key("\u{3}")?;
    screen.ended()?;
    let said = run(tool, &address, &["stop"])?;
    ensure!(said.contains("stands"), "Ctrl-C: {said}");
    stops_commissioning(tool, &address)?;
    println!(
        "typed: enable, move, space bar in a move and in a question, set, quit, jog, Ctrl-C, space bar in a commissioning: as they should"
    );
    Ok(())
}

/// The space bar while `preslide commission` moves the axis.
fn stops_commissioning(tool: &Path, address: &str) -> anyhow::Result<()> {
    let folder = tempfile::tempdir()?;
    let output = folder.path().join("commission");
    let output = output.to_string_lossy();
    let travel = ["--travel", "0.1mm", "--smallest", "4um"];
    let words = [&["commission", address, "-o", &output][..], &travel].concat();
    let mut screen = Screen::of(tool, &words)?;
    screen.wait_for("homed: positions count")?;
    screen.key(" ")?;
    // In two lines.
    screen.wait_for("the same command goes")?;
    screen.wait_for("on from there")?;
    screen.ended_with(3)?;
    let said = run(tool, address, &["state"])?;
    ensure!(
        said.contains("disabled"),
        "the space bar left it enabled: {said}"
    );
    Ok(())
}

/// The plain commands through a pseudo terminal that stands for the serial line.
fn on_a_pseudo_terminal(tool: &Path, port: u16) -> anyhow::Result<()> {
    let (mut near, far) = TTYPort::pair().context("a pseudo terminal")?;
    let path = far.name().context("its name")?;
    let mut line = super::connect(port, &AtomicBool::new(false))?;
    line.set_read_timeout(Some(Duration::from_millis(2)))?;
    near.set_timeout(Duration::from_millis(2))?;
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let carrying = scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                carry(&mut near, &mut line)?;
                carry(&mut line, &mut near)?;
            }
            std::io::Result::Ok(())
        });
        let told = (|| {
            let said = run(tool, &path, &["state"])?;
            ensure!(said.contains("disabled, the bridge is open"), "{said}");
            let refused = run(tool, &path, &["move", "--by", "1mm"]);
            let refused = refused
                .err()
                .context("a move while disabled must be refused")?;
            ensure!(refused.to_string().contains("`enable` first"), "{refused}");
            run(tool, &path, &["set", "silence=1.5"])?;
            let said = run(tool, &path, &["get"])?;
            ensure!(
                said.lines().count() > 20 && said.contains("1.5e0"),
                "{said}"
            );
            anyhow::Ok(())
        })();
        over.store(true, Ordering::Relaxed);
        carrying
            .join()
            .map_err(|_| anyhow::anyhow!("the line panicked"))??;
        told
    })?;
    println!("typed: state, move, set and get over {path}: as they should");
    Ok(())
}

/// Carries what has come; what finds nobody is lost, as on a line.
fn carry(from: &mut impl Read, to: &mut impl Write) -> std::io::Result<()> {
    let mut buffer = [0; 4096];
    let carried = from
        .read(&mut buffer)
        .and_then(|length| to.write_all(&buffer[..length]));
    match carried {
        Err(error) if !matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
            Err(error)
        }
        _ => Ok(()),
    }
}

/// The position (m) that `state` printed with a prefix.
fn position(state: &str) -> anyhow::Result<f64> {
    let line = state.lines().find_map(|line| line.strip_prefix("position"));
    let mut words = line.context("a position")?.split_whitespace();
    let value: f64 = words.next().context("a position")?.parse()?;
    let scale = match words.next() {
        Some("m") => 1.0,
        Some("mm") => 1e-3,
        Some("µm") => 1e-6,
        Some("nm") => 1e-9,
        unit => anyhow::bail!("a position in {unit:?}"),
    };
    Ok(scale * value)
}

/// Runs a plain command; what it printed.
pub fn run(tool: &Path, port: &str, words: &[&str]) -> anyhow::Result<String> {
    let mut command = Command::new(tool);
    let output = command
        .args(["drive", port, "--wait", "20"])
        .args(words)
        .output()?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        bail!("{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(said)
}

/// The tool's terminal.
struct Screen {
    child: Box<dyn portable_pty::Child + Send + Sync>,
    keys: Box<dyn Write + Send>,
    output: Receiver<Vec<u8>>,
    shown: vt100::Parser,
}

impl Screen {
    fn open(tool: &Path, port: &str) -> anyhow::Result<Self> {
        Self::of(tool, &["drive", port, "--wait", "20"])
    }

    fn of(tool: &Path, words: &[&str]) -> anyhow::Result<Self> {
        let (rows, cols) = (40, 160);
        let size = PtySize {
            rows,
            cols,
            pixel_width: 0,
            pixel_height: 0,
        };
        let pair = native_pty_system().openpty(size)?;
        let mut command = CommandBuilder::new(tool);
        command.args(words);
        command.env("TERM", "xterm-256color");
        let child = pair.slave.spawn_command(command)?;
        let mut reader = pair.master.try_clone_reader()?;
        let keys = pair.master.take_writer()?;
        let (send, output) = channel();
        std::thread::spawn(move || {
            // The master lives as long as something may be read.
            let _master = pair.master;
            let mut buffer = [0; 4096];
            while let Ok(length) = reader.read(&mut buffer) {
                if length == 0 || send.send(buffer[..length].to_vec()).is_err() {
                    break;
                }
            }
        });
        Ok(Self {
            child,
            keys,
            output,
            shown: vt100::Parser::new(rows, cols, 0),
        })
    }

    fn key(&mut self, keys: &str) -> anyhow::Result<()> {
        self.keys.write_all(keys.as_bytes())?;
        Ok(self.keys.flush()?)
    }

    fn wait_for(&mut self, text: &str) -> anyhow::Result<()> {
        let start = Instant::now();
        loop {
            let shown = self.shown.screen().contents();
            if shown.contains(text) {
                return Ok(());
            }
            if start.elapsed() > PATIENCE {
                let _ = self.child.kill();
                bail!("`{text}` did not come up on the screen:\n{shown}");
            }
            if let Ok(bytes) = self.output.recv_timeout(Duration::from_millis(20)) {
                self.shown.process(&bytes);
            }
        }
    }

    /// Waits for the program's end, a good one.
    fn ended(&mut self) -> anyhow::Result<()> {
        self.ended_with(0)
    }

    fn ended_with(&mut self, code: u32) -> anyhow::Result<()> {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait()? {
                ensure!(
                    status.exit_code() == code,
                    "the terminal ended with {status:?}"
                );
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        bail!("the terminal did not end")
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.child.kill();
    }
}
