//! A cable that is pulled while `preslide commission` works: once in each way, or in the middle of every stage.

use super::typed::run;
use anyhow::{Context, bail, ensure};
use preslide_link::{Deframer, Numbered, Report, Request, Sample};
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The drive's `silence` here (s), and in its ticks.
const SILENCE: &str = "silence=0.5";
const SILENCE_TICKS: u32 = 10_000;
/// And what it needs to brake: 15 mm/s by 1 m/s², the smoothing, and the telemetry that was on its way.
const BRAKING_TICKS: u32 = 1000;
/// How long it is watched after that (ticks).
const WATCHED_TICKS: u32 = 2000;

/// Counts by which a reference has set out.
const MOVES_COUNTS: i64 = 1000;

/// An emulator may run at a tenth of a drive's speed.
const PATIENCE: Duration = Duration::from_secs(120);

/// A short motion.
const WISH: &str =
    "--travel 0.02mm --speed 4mm/s --acceleration 0.5m/s2 --smallest 1um --repeats 1";

/// What happens to a commissioning, and when.
struct Pull {
    /// What the tool is to call the stage.
    stage: &'static str,
    /// At so many of the requests that are.
    at: usize,
    is: fn(&Request) -> bool,
    /// When so many motions have begun since it was plugged in.
    begun: usize,
    what: What,
}

#[derive(Clone, Copy, PartialEq)]
enum What {
    /// The cable is pulled, and the axis watched.
    Pulled,
    /// The same where only silence stops the axis.
    RunsOn,
    /// It stays and carries nothing more: a broken wire, a converter that hangs.
    Mute,
    /// It is plugged in again at once, with the axis still moving.
    AtOnce,
    /// The cable stays, the user presses Ctrl-C.
    Interrupted,
}

fn is_points(request: &Request) -> bool {
    matches!(request, Request::Points(_))
}

fn is_home(request: &Request) -> bool {
    matches!(request, Request::Home(_))
}

const fn at(
    stage: &'static str,
    begun: usize,
    (at, is): (usize, fn(&Request) -> bool),
    what: What,
) -> Pull {
    Pull {
        stage,
        at,
        is,
        begun,
        what,
    }
}

/// In the middle of a stream of points.
const STREAM: (usize, fn(&Request) -> bool) = (40, is_points);

const PULLS: [Pull; 10] = [
    at(
        "enable, nudge",
        0,
        (1, |request| matches!(request, Request::Move { .. })),
        What::Pulled,
    ),
    at("home", 0, (1, is_home), What::RunsOn),
    at("home", 0, (1, is_home), What::AtOnce),
    at("play careful", 1, (20, is_points), What::Pulled),
    at("play before", 2, STREAM, What::Pulled),
    at("play before", 1, STREAM, What::Mute),
    // The share of the feed-forward is what the stage set; it is to be what it was before the cable was pulled.
    at("play before", 1, STREAM, What::Interrupted),
    at(
        "load",
        1,
        (1, |request| matches!(request, Request::Model(_))),
        What::Pulled,
    ),
    at("play unseen-without", 1, STREAM, What::Pulled),
    at("play unseen-with", 2, STREAM, What::Pulled),
];

/// Those of [`PULLS`] that show each way once.
const SHORT: [usize; 5] = [1, 2, 4, 5, 6];

/// Commissions the drive at the port, the cable pulled and plugged in again; `everywhere` until it is done.
pub fn pulled(tool: &Path, port: u16, everywhere: bool) -> anyhow::Result<()> {
    let folder = tempfile::tempdir()?;
    let direct = format!("tcp:127.0.0.1:{port}");
    run(tool, &direct, &["set", SILENCE])?;
    // Far from the index, so that the way to it takes longer than the drive's timeout.
    run(tool, &direct, &["enable"])?;
    run(tool, &direct, &["move", "--by", "1.8mm"])?;
    run(tool, &direct, &["disable"])?;
    let plug = TcpListener::bind(("127.0.0.1", 0))?;
    let far = format!("tcp:127.0.0.1:{}", plug.local_addr()?.port());
    let commission = |port: &str| {
        let mut command = Command::new(tool);
        command
            .args(["commission", port, "--save", "-o", "out"])
            .args(["--experiments", "0"])
            .args(WISH.split(' '))
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    };
    for (i, pull) in PULLS.iter().enumerate() {
        if !everywhere && !SHORT.contains(&i) {
            continue;
        }
        let begun = commission(&far).spawn()?;
        let mut cable = Cable::plug(&plug, port)?;
        let after = cable.carry(pull, begun.id());
        let ended = begun.wait_with_output()?;
        // The emulator hears one client at a time.
        drop(cable);
        let said = String::from_utf8_lossy(&ended.stderr);
        let stage = format!("in stage `{}`", pull.stage);
        let after = after.with_context(|| format!("{stage}: {said}"))?;
        let (code, reason) = match pull.what {
            What::Interrupted => (3, "stopped"),
            What::Mute => (1, "no answer to"),
            _ => (1, "the line to the controller broke"),
        };
        ensure!(
            ended.status.code() == Some(code)
                && [&stage, reason, "the same command goes on from there"]
                    .iter()
                    .all(|words| said.contains(words)),
            "{stage}, the tool ended with {} and said: {said}",
            ended.status
        );
        match pull.what {
            What::AtOnce => println!("pulled {stage}, and plugged in again at once"),
            What::Interrupted => {
                let share = run(tool, &direct, &["get", "feed_forward.share"])?;
                ensure!(share.contains("1e0"), "interrupted {stage}: {share}");
                println!("interrupted {stage}: disabled, its share of the feed-forward as it was");
            }
            What::Pulled | What::RunsOn | What::Mute => after.judge(pull)?,
        }
    }
    // Interrupted and then commissioned to its end it is by `cargo xtask qemu`, too.
    if everywhere {
        let done = commission(&direct).output()?;
        let said = String::from_utf8_lossy(&done.stdout);
        for name in ["careful", "before", "unseen-without"] {
            ensure!(
                said.contains(&format!("{name}: recorded earlier")),
                "what was recorded was not kept: {said}"
            );
        }
        let page = folder.path().join("out/report.html").exists();
        ensure!(
            done.status.success() && page,
            "plugged in for good, it ended with {}: {}",
            done.status,
            String::from_utf8_lossy(&done.stderr)
        );
        println!("then commissioned to its end");
    }
    let said = run(tool, &direct, &["state"])?;
    ensure!(said.contains("disabled"), "it is left enabled: {said}");
    Ok(())
}

/// What the drive's telemetry showed after the cable was pulled.
#[derive(Debug, Default)]
struct After {
    /// Until the reference moved for the last time, and from then on.
    moved_ticks: u32,
    watched_ticks: u32,
    faults: usize,
}

impl After {
    /// The axis stands, by itself and without a fault.
    fn judge(&self, pull: &Pull) -> anyhow::Result<()> {
        let (stage, moved) = (pull.stage, self.moved_ticks);
        ensure!(
            moved <= SILENCE_TICKS + BRAKING_TICKS
                && self.watched_ticks >= WATCHED_TICKS
                && self.faults == 0,
            "pulled in stage `{stage}`: {self:?}"
        );
        ensure!(
            pull.what != What::RunsOn || moved >= SILENCE_TICKS / 2,
            "pulled in stage `{stage}`, nothing was left to be stopped: {self:?}"
        );
        println!("pulled in stage `{stage}`: the axis stood after {moved} ticks; the tool said so");
        Ok(())
    }
}

/// Between tool and drive.
struct Cable {
    near: TcpStream,
    far: TcpStream,
}

impl Cable {
    fn plug(plug: &TcpListener, port: u16) -> anyhow::Result<Self> {
        let (near, _) = plug.accept()?;
        let far = super::connect(port, &AtomicBool::new(false))?;
        for end in [&near, &far] {
            end.set_nodelay(true)?;
            end.set_read_timeout(Some(Duration::from_millis(2)))?;
        }
        Ok(Self { near, far })
    }

    /// What was sent is lost where the emulator's line is closed before it was read.
    fn wait_until_it_moves(&mut self, told: &mut Deframer) -> anyhow::Result<()> {
        let (start, mut first) = (Instant::now(), None);
        while start.elapsed() < PATIENCE {
            for sample in samples(told, &taken(&mut self.far)?) {
                let from = *first.get_or_insert(sample.reference);
                if (sample.reference - from).abs() > MOVES_COUNTS << 16 {
                    return Ok(());
                }
            }
        }
        bail!("the axis does not move")
    }

    /// Carries until the moment has come, lets go of the tool `id`, and watches the drive.
    fn carry(&mut self, pull: &Pull, id: u32) -> anyhow::Result<After> {
        let (mut asked, mut told) = (Deframer::new(), Deframer::new());
        let (mut seen, mut plays, mut last) = (0, 0, None);
        let start = Instant::now();
        while seen < pull.at {
            ensure!(start.elapsed() < PATIENCE, "the stage was not reached");
            let bytes = taken(&mut self.near)?;
            self.far.write_all(&bytes)?;
            for byte in bytes {
                if let Some(Ok(Numbered { request, .. })) = asked.push(byte) {
                    // Every motion begins with it.
                    plays += usize::from(matches!(request, Request::Telemetry { .. }));
                    seen += usize::from(plays == pull.begun && (pull.is)(&request));
                }
            }
            let bytes = taken(&mut self.far)?;
            self.near.write_all(&bytes)?;
            last = samples(&mut told, &bytes).last().or(last);
        }
        match pull.what {
            What::AtOnce => {
                self.wait_until_it_moves(&mut told)?;
                self.near.shutdown(Shutdown::Both)?;
                return Ok(After::default());
            }
            What::Interrupted => {
                let id = id.to_string();
                Command::new("kill").args(["-INT", &id]).status()?;
                // Until the tool has ended.
                while let Ok(bytes) = taken(&mut self.near) {
                    self.far.write_all(&bytes)?;
                    let answers = taken(&mut self.far)?;
                    if self.near.write_all(&answers).is_err() {
                        break;
                    }
                }
                return Ok(After::default());
            }
            What::Pulled | What::RunsOn => self.near.shutdown(Shutdown::Both)?,
            What::Mute => {}
        }
        let pulled = last.context("no telemetry came")?.tick;
        let (mut before, mut moved, mut after) = (None, pulled, After::default());
        let start = Instant::now();
        loop {
            ensure!(start.elapsed() < PATIENCE, "the telemetry ended");
            for sample in samples(&mut told, &taken(&mut self.far)?) {
                after.faults += usize::from(sample.fault.is_some());
                if before.is_some_and(|before| before != sample.reference) {
                    moved = sample.tick;
                }
                before = Some(sample.reference);
                after.moved_ticks = moved.wrapping_sub(pulled);
                after.watched_ticks = sample.tick.wrapping_sub(moved);
                let watched = sample.tick.wrapping_sub(pulled);
                if watched > SILENCE_TICKS + BRAKING_TICKS + WATCHED_TICKS {
                    return Ok(after);
                }
            }
        }
    }
}

/// What has come.
fn taken(from: &mut TcpStream) -> anyhow::Result<Vec<u8>> {
    let mut buffer = [0; 4096];
    match from.read(&mut buffer) {
        Ok(0) => bail!("an end was closed"),
        Ok(length) => Ok(buffer[..length].to_vec()),
        Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
            Ok(Vec::new())
        }
        Err(error) => Err(error.into()),
    }
}

fn samples<'a>(told: &'a mut Deframer, bytes: &'a [u8]) -> impl Iterator<Item = Sample> + 'a {
    bytes.iter().filter_map(|&byte| match told.push(byte) {
        Some(Ok(Report::Sample(sample))) => Some(sample),
        _ => None,
    })
}
