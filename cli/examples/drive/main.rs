//! An emulated drive: the firmware in QEMU on the simulated stage, its command link on a TCP port.
//!
//! `drive serve ELF PORT` serves it to one client after the other, at the speed of a real one where the machine keeps up.
//! `drive hammer ELF PORT COUNT` sends so many requests, as many at once as the link allows, under telemetry of every tick, and counts
//! the answers. `drive typed ELF PORT TOOL` types at the tool, `drive pulled ELF PORT TOOL` pulls its cable. `cargo xtask stage` and `cargo xtask qemu` call it.

mod pulled;
mod typed;

use anyhow::{Context, bail, ensure};
use preslide_axis::AxisFile;
use preslide_host::drive::starting;
use preslide_link::{
    Deframer, GainSettings, LARGEST_FRAME, ModelPart, Name, Numbered, Refusal, Reply, Report,
    Request, WINDOW, encode,
};
use preslide_sim::rig::{Emulator, Listener, registers};
use preslide_sim::stage::{Stage, StageConfig};
use std::collections::HashMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Counts from one index pulse to the next: a turn of the screw, 2 mm.
const INDEX: i64 = 80_000;

/// The stage runs ahead of the clock by no more than this.
const AHEAD: Duration = Duration::from_millis(2);

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["serve", elf, port] => {
            let port = port.parse().context("the port")?;
            println!("an emulated drive listens: preslide drive tcp:127.0.0.1:{port}");
            serve(Path::new(elf), port, &AtomicBool::new(false))?;
        }
        ["hammer", elf, port, count] => {
            let port = port.parse().context("the port")?;
            let count = count.parse().context("the number of requests")?;
            beside(Path::new(elf), port, |over| hammer(port, count, over))?;
        }
        [
            what @ ("typed" | "pulled" | "pulled-everywhere"),
            elf,
            port,
            tool,
        ] => {
            let port = port.parse().context("the port")?;
            let tool = Path::new(tool)
                .canonicalize()
                .with_context(|| tool.to_owned())?;
            beside(Path::new(elf), port, |_| match what {
                "typed" => typed::typed(&tool, port),
                what => pulled::pulled(&tool, port, what == "pulled-everywhere"),
            })?;
        }
        _ => bail!(
            "usage: drive serve ELF PORT, drive hammer ELF PORT COUNT, drive typed ELF PORT TOOL, or drive pulled|pulled-everywhere ELF PORT TOOL"
        ),
    }
    Ok(())
}

/// Does something while the drive serves; it hears when the drive has ended.
fn beside(
    elf: &Path,
    port: u16,
    act: impl FnOnce(&AtomicBool) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let (enough, ended) = (AtomicBool::new(false), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let serving = scope.spawn(|| {
            let served = serve(elf, port, &enough);
            ended.store(true, Ordering::Relaxed);
            served
        });
        let acted = act(&ended);
        enough.store(true, Ordering::Relaxed);
        let served = serving.join();
        acted?;
        served.map_err(|_| anyhow::anyhow!("the stage panicked"))??;
        Ok(())
    })
}

/// Steps firmware and stage until stopped, or the firmware ends.
fn serve(elf: &Path, port: u16, over: &AtomicBool) -> anyhow::Result<()> {
    // What the firmware was built for, if it was built under the same name.
    let axis = AxisFile::chosen(None)?.axis();
    let config = StageConfig {
        seed: 7,
        ..StageConfig::default()
    };
    let mut stage = Stage::try_new(config.on(&axis))?;
    let mut emulator = Emulator::start(elf, Listener::Served(port), None)?;
    let tick = Duration::from_secs_f64(axis.sample_time());
    let (start, mut now, mut last) = (Instant::now(), Duration::ZERO, 0);
    loop {
        let order = emulator.order()?;
        let code = if order.driven { order.code } else { 0 };
        let reading = stage.tick(f64::from(code) / f64::from(axis.hardware.steps));
        let mut reading = registers(reading, &axis.hardware);
        let count = reading.count.cast_signed();
        reading.index = passed(last, count);
        last = count;
        reading.quit = over.load(Ordering::Relaxed);
        emulator.reading(reading)?;
        if reading.quit {
            return Ok(());
        }
        now += tick;
        if let Some(early) = now
            .checked_sub(start.elapsed())
            .filter(|early| *early > AHEAD)
        {
            std::thread::sleep(early);
        }
    }
}

/// The count of the index pulse between two readings.
fn passed(from: i32, to: i32) -> Option<u32> {
    let (from, to) = (i64::from(from), i64::from(to));
    let turns = from.max(to).div_euclid(INDEX);
    let at = turns * INDEX;
    (from.min(to) < at).then_some(at as u32)
}

/// Sends so many requests, at most [`WINDOW`] of them unanswered, and none twice.
fn hammer(port: u16, requests: u16, over: &AtomicBool) -> anyhow::Result<()> {
    let mut line = connect(port, over)?;
    line.set_nodelay(true)?;
    line.set_read_timeout(Some(Duration::from_secs(20)))?;
    let mut answers: HashMap<u16, Reply> = HashMap::new();
    let (mut sent, mut doubles, mut damaged) = (0, 0, 0);
    let (mut samples, mut missing, mut next_sample) = (0_u64, 0_u64, None);
    let mut deframer = Deframer::new();
    let mut buffer = [0; 65_536];
    let start = Instant::now();
    while answers.len() < usize::from(requests) {
        while sent < requests && usize::from(sent) - answers.len() < WINDOW {
            let mut frame = [0; LARGEST_FRAME];
            let numbered = Numbered {
                id: sent,
                request: request(sent),
            };
            let length = encode(&numbered, &mut frame).context("a frame")?;
            line.write_all(&frame[..length])?;
            sent += 1;
        }
        let length = line.read(&mut buffer).with_context(|| {
            format!(
                "{} of {sent} requests answered, then silence",
                answers.len()
            )
        })?;
        ensure!(length > 0, "the firmware ended");
        for byte in &buffer[..length] {
            match deframer.push::<Report>(*byte) {
                Some(Ok(Report::Answer { id, reply })) => {
                    doubles += u64::from(answers.insert(id, reply).is_some());
                }
                Some(Ok(Report::Sample(sample))) => {
                    samples += 1;
                    missing +=
                        next_sample.map_or(0, |next| u64::from(sample.sequence.wrapping_sub(next)));
                    next_sample = Some(sample.sequence.wrapping_add(1));
                }
                // The line was there before this listener: the first frame may be cut.
                Some(Err(_)) if samples == 0 && answers.is_empty() => {}
                Some(Ok(Report::Damaged(_)) | Err(_)) => damaged += 1,
                None => {}
            }
        }
    }
    let wrong = (0..requests)
        .filter(|id| !is_right(*id, answers.get(id)))
        .count();
    println!(
        "link: {sent} requests sent once, {} answered, {wrong} wrongly, {doubles} twice, {damaged} frames damaged; beside {samples} \
         samples of telemetry, {missing} missing; {:.1} s",
        answers.len(),
        start.elapsed().as_secs_f64()
    );
    ensure!(
        wrong == 0 && doubles == 0 && damaged == 0,
        "requests were lost or answered wrongly"
    );
    ensure!(
        missing == 0,
        "samples were lost that the controller did not count"
    );
    ensure!(
        samples > u64::from(requests),
        "too little telemetry came to show anything"
    );
    Ok(())
}

fn connect(port: u16, over: &AtomicBool) -> anyhow::Result<TcpStream> {
    let start = Instant::now();
    loop {
        match TcpStream::connect(("127.0.0.1", port)) {
            Ok(line) => return Ok(line),
            Err(error)
                if over.load(Ordering::Relaxed) || start.elapsed() > Duration::from_secs(20) =>
            {
                return Err(error).context("connecting to the emulated drive");
            }
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// The request of this number: some that the control task carries out, some that are refused, the longest there are.
fn request(id: u16) -> Request {
    match id % 5 {
        0 => Request::Ping,
        1 => Request::Gains(GainSettings {
            proportional: 1e5,
            integral: 3e6,
            derivative: 600.0,
        }),
        2 => Request::Get(Name::new("gains.proportional").unwrap_or_else(|| unreachable!())),
        3 => Request::Model(ModelPart {
            layout: starting(),
            first: 0,
            values: [
                0.9, 1e5, 0.25, 1e5, 0.25, 1e5, 0.25, 1e5, 0.25, 0.0, 0.0, 0.0,
            ],
        }),
        _ => Request::Gains(GainSettings {
            proportional: f32::NAN,
            integral: 3e6,
            derivative: 600.0,
        }),
    }
}

fn is_right(id: u16, reply: Option<&Reply>) -> bool {
    match (id % 5, reply) {
        (2, Some(Reply::Parameter(parameter))) => parameter.value == 1e5,
        (4, Some(Reply::Refused(refusal))) => *refusal == Refusal::OutOfRange,
        (0 | 1 | 3, Some(Reply::Done { .. })) => true,
        _ => false,
    }
}
