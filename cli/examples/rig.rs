//! Runs a firmware ELF in QEMU: `rig fixed|float|packed-fixed|packed-float ELF` compares its commands with the host's simulation,
//! `rig faults ELF FOLDER [--bless]` injects the faults and compares with the golden files. `rig serve ELF PORT TRUTH` moves
//! the stage through nested strokes, hands its telemetry to `preslide capture tcp:127.0.0.1:PORT` and writes what the
//! stage's friction was; `rig judge REC.csv TRUTH` compares with it what `identify` finds in the capture. `rig record ELF
//! PLUGIN [NAME=VALUE]...` has a QEMU plugin watch the motion of an axis with these parameters. `rig wear ELF` lets the stage wear from half way on and asks
//! whether the firmware notices. `rig winding ELF` lets it follow a winding 30 K warm. `rig guided ELF` has a predictive controller guide the firmware as an outer task, in time and late. `rig logged ELF FILE` writes the frames of defmt that a firmware logs. `cargo xtask qemu`, `stage` and `cycles` call it.

use anyhow::{Context, bail, ensure};
use fixed::types::I16F16;
use preslide::control::learning::{Adaptation, MismatchWatch};
use preslide::control::{Learning, LearningSettings};
use preslide::{Block, QuasiStaticGms, Units};
use preslide_fit::identify::{Options, STEPS, identify};
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions};
use preslide_link::{RangeCode, Request};
use preslide_sim::rig::{
    Followed, Guidance, Listener, Notice, Script, TrueCurve, Wear, agreement, followed, guidance,
    injections, logged, motion, notice, presliding, requests, run,
};
use preslide_sim::tracking::FIXED_UNITS;
use std::cell::RefCell;
use std::path::Path;
use std::process::ExitCode;

/// What `preslide export --kernel` wrote, which is compiled into the firmware as well.
mod packed_f32 {
    include!("../tests/exported/packed_f32.rs");
}
#[allow(dead_code)]
mod koopman {
    include!("../tests/exported/koopman.rs");
}
mod packed_i16f16 {
    include!("../tests/exported/packed_i16f16.rs");
}

/// What the firmware starts with: the paper's Table 3, four blocks.
fn blocks() -> ([Block; 4], f64) {
    let blocks = [
        (313_728.0, 0.339),
        (43_670.0, 0.236),
        (10_545.0, 0.171),
        (5_858.0, 0.253),
    ];
    let blocks = blocks.map(|(stiffness, weight)| Block { stiffness, weight });
    (blocks, 0.9)
}

/// Codes by which a command in `f32` may differ: one, by rounding. In fixed point none may differ.
const FLOAT_BOUND: u32 = 1;

/// Ticks in which the next run of the outer task is made late.
const LATE: [u64; 4] = [3000, 4507, 6011, 8019];
/// From here on all are.
const LATE_FROM: u64 = 3000;

/// Ticks that the motion takes, but for the rest at its end.
const MOVING: u64 = 10_000;

/// The reason stands last, where CI's tail shows it: no backtrace behind it.
fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let Err(error) = asked(&words) else {
        return ExitCode::SUCCESS;
    };
    eprintln!("{error:#}");
    ExitCode::FAILURE
}

fn asked(words: &[&str]) -> anyhow::Result<()> {
    let (blocks, breakaway) = blocks();
    match *words {
        [
            kind @ ("fixed" | "float" | "packed-fixed" | "packed-float"),
            elf,
        ] => {
            let elf = Path::new(elf);
            let (agreement, record) = match kind {
                "fixed" => {
                    let model =
                        QuasiStaticGms::<4, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
                    agreement(elf, model, FIXED_UNITS)?
                }
                "float" => {
                    let model = QuasiStaticGms::<4, f32>::try_new(&blocks, breakaway, Units::SI)?;
                    agreement(elf, model, Units::SI)?
                }
                "packed-fixed" => {
                    let model: packed_i16f16::Model = packed_i16f16::model(50e-6, FIXED_UNITS)?;
                    agreement(elf, model, FIXED_UNITS)?
                }
                _ => {
                    let model: packed_f32::Model = packed_f32::model(50e-6, Units::SI)?;
                    agreement(elf, model, Units::SI)?
                }
            };
            println!(
                "{kind}: {agreement:?}, {} reports",
                record.remains.reports.len()
            );
            print!("{}", record.remains.log());
            let bound = if kind.ends_with("fixed") {
                0
            } else {
                FLOAT_BOUND
            };
            if agreement.largest > bound || agreement.reach < 100 {
                bail!(
                    "QEMU and the host differ by {} codes; the bound is {bound}",
                    agreement.largest
                );
            }
        }
        ["wear", elf] => {
            type Both = (MismatchWatch<I16F16>, Adaptation<I16F16>);
            let model = QuasiStaticGms::<4, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
            let settings = LearningSettings::PAPER_AXIS;
            let model = Learning::<_, Both>::try_new(model, &settings, FIXED_UNITS)?;
            wear(&notice(Path::new(elf), model, FIXED_UNITS, &WEAR)?)?;
        }
        ["logged", elf, file] => {
            let record = run(Path::new(elf), &logged(), Listener::File)?;
            ensure!(!record.broke_off, "the firmware ended early");
            std::fs::write(file, record.remains.log_bytes).context(file.to_owned())?;
        }
        ["guided", elf] => guided(Path::new(elf))?,
        ["serve", elf, port, truth] => {
            serve(
                Path::new(elf),
                port.parse().context("the port")?,
                Path::new(truth),
            )?;
        }
        ["judge", recording, truth] => judge(Path::new(recording), Path::new(truth))?,
        ["winding", elf] => {
            let model = QuasiStaticGms::<4, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS)?;
            winding(&followed(Path::new(elf), model, FIXED_UNITS)?)?;
        }
        ["record", elf, plugin, ref settings @ ..] => {
            let told: Option<Vec<(&str, f64)>> = settings
                .iter()
                .map(|setting| {
                    let (name, value) = setting.split_once('=')?;
                    Some((name, value.parse().ok()?))
                })
                .collect();
            let told = told.context("settings are NAME=VALUE")?;
            let mut script = Script::told(1, &told).send(20, &requests(&motion()));
            script.ticks = MOVING;
            script.plugin = Some(plugin.to_owned());
            let record = run(Path::new(elf), &script, Listener::File)?;
            if record.broke_off {
                bail!("the firmware ended early: {}", record.remains.log());
            }
        }
        ["faults", elf, folder] => faults(Path::new(elf), Path::new(folder), false)?,
        ["faults", elf, folder, "--bless"] => faults(Path::new(elf), Path::new(folder), true)?,
        _ => bail!(
            "usage: rig fixed|float|packed-fixed|packed-float ELF, rig faults ELF FOLDER [--bless], rig serve ELF PORT TRUTH, rig judge REC.csv TRUTH, rig wear ELF, rig winding ELF, rig guided ELF, or rig record ELF PLUGIN [NAME=VALUE]..."
        ),
    }
    Ok(())
}

/// A stage that becomes 1 % harder to move with every stroke, from half way on.
const WEAR: Wear = Wear {
    strokes: 60,
    per_stroke: 0.01,
};

/// Tells what the firmware noticed, and whether that is right.
fn wear(notice: &Notice) -> anyhow::Result<()> {
    let Notice {
        agreement,
        learned: [learned, host_learned],
        worn_from,
        raised: [raised, host_raised],
        level,
        adapted,
        faults,
        log,
    } = notice;
    println!("wear: {agreement:?}");
    println!(
        "normal range learned by tick {learned:?} (host {host_learned:?}), wear from {worn_from}, flag {raised:?} (host \
         {host_raised:?}) at friction level {level:.3}, adapted level at the end {adapted:.3}, samples in the safe state {faults}"
    );
    print!("{log}");
    let (Some(learned), Some(host_learned)) = (learned, host_learned) else {
        bail!("the normal range was never learned");
    };
    let (Some((raised, RangeCode::Above)), Some((host_raised, RangeCode::Above))) =
        (raised, host_raised)
    else {
        bail!("no flag for more friction was raised");
    };
    // Telemetry comes every 20th tick.
    let same = |emulator: &u64, host: &u64| (*host..host + 20).contains(emulator);
    if learned >= worn_from || raised <= worn_from {
        bail!("the flag was raised before the stage began to wear, or the range learned after");
    }
    if agreement.different > 0 || !same(learned, host_learned) || !same(raised, host_raised) {
        bail!("the emulator and the host differ");
    }
    if *faults > 0 {
        bail!("the axis stopped; a status must not stop it");
    }
    Ok(())
}

fn faults(elf: &Path, folder: &Path, bless: bool) -> anyhow::Result<()> {
    let undisturbed = run(
        elf,
        &Script::quiet(14_000).send(20, &requests(&motion())),
        Listener::File,
    )?;
    let mut different = Vec::new();
    for injection in injections() {
        let text = injection.tell(elf, &undisturbed)?;
        println!("== {}\n{text}", injection.name);
        let golden = folder.join(format!("{}.txt", injection.name));
        if bless {
            std::fs::write(&golden, text).with_context(|| golden.display().to_string())?;
        } else {
            let expected = std::fs::read_to_string(&golden).unwrap_or_default();
            if expected != text {
                different.push(difference(injection.name, &expected, &text));
            }
        }
    }
    if !different.is_empty() {
        bail!(
            "unlike the golden files (- expected, + got):\n{}`cargo xtask qemu --bless` if what was got is right",
            different.concat()
        );
    }
    Ok(())
}

/// The lines that one of two texts has and the other has not.
fn difference(name: &str, expected: &str, got: &str) -> String {
    let only = |of: &str, not: &str, sign: char| -> String {
        let alone = of.lines().filter(|line| not.lines().all(|l| l != *line));
        alone.map(|line| format!("{sign} {line}\n")).collect()
    };
    format!(
        "{name}:\n{}{}",
        only(expected, got, '-'),
        only(got, expected, '+')
    )
}

/// Between two looks at the stage's friction: its gains wander over 100 µm of path, a second of this motion.
const LOOK_TICKS: u64 = 2000;

/// Moves through nested strokes and hands out telemetry; what the friction was goes to the file `truth`.
fn serve(elf: &Path, port: u16, truth: &Path) -> anyhow::Result<()> {
    println!("waiting for `preslide capture tcp:127.0.0.1:{port} -o REC.csv`");
    let curve = RefCell::new(TrueCurve::default());
    let mut script = Script::quiet(0);
    // Every tick's telemetry would cost more than the rest of the emulation: QEMU sends it byte by byte.
    // The exchange of the initialisation, tick 0, carries no byte.
    script = script.send(1, &[Request::Telemetry { every: 5 }]);
    script = script.follow(40, &presliding())?;
    script.disturb = Box::new(|tick, stage| {
        if tick.is_multiple_of(LOOK_TICKS) {
            let speed = stage.truth().velocity_m_s;
            curve.borrow_mut().look(stage, speed);
        }
    });
    let record = run(elf, &script, Listener::Tcp(port))?;
    print!("{}", record.remains.log());
    drop(script);
    let text = serde_json::to_string(&curve.into_inner())?;
    std::fs::write(truth, text).with_context(|| truth.display().to_string())
}

/// Wide intervals contain anything: the curve must also be right to 3 %, where the stage's friction varies by ±15 %.
const LARGEST_DEVIATION: f64 = 0.03;

/// Identifies a capture and compares with what the stage's friction was.
fn judge(recording: &Path, truth: &Path) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(truth).with_context(|| truth.display().to_string())?;
    let truth: TrueCurve = serde_json::from_str(&text)?;
    let recording = recording::load(recording, &LoadOptions::default())?;
    let progress = Progress::new("identify", STEPS);
    let found = identify(&recording, &Options::default(), &progress).map_err(anyhow::Error::msg)?;
    progress.finish();
    let best = found.best();
    let comparison = truth.compare(best);
    println!("{}", found.recommendation);
    println!(
        "{:>10} {:>10} {:>10} {:>22}",
        "x (µm)", "true (N)", "found (N)", "95 % (N)"
    );
    for (x, truth, found) in &comparison.points {
        let [low, high] = found.ci95.unwrap_or([f64::NAN; 2]);
        println!(
            "{:>10.3} {truth:>10.4} {:>10.4} {low:>11.4} …{high:>9.4}",
            x * 1e6,
            found.value
        );
    }
    for (name, value) in &best.rigid_body {
        let [low, high] = value.ci95.unwrap_or([f64::NAN; 2]);
        println!("{name}: {:.4}, 95 % {low:.4} … {high:.4}", value.value);
    }
    let (inside, points) = (comparison.inside(), comparison.points.len());
    let (whole, deviation) = (comparison.breakaway_inside(), comparison.relative_rms());
    println!(
        "virgin curve: {inside} of {points} points inside the 95 % interval, RMS deviation {:.2} %; breakaway force: {}",
        100.0 * deviation,
        if whole { "inside" } else { "outside" }
    );
    // The points of one block's stretch move together. Of as many 95 % intervals as there are blocks (4 to 10) two outside are no surprise
    // (1 to 9 %), three are one (0.05 to 1 %).
    let outside = (points - inside) * best.size();
    if !whole || outside > 2 * points || deviation > LARGEST_DEVIATION {
        bail!("the identified model does not match the stage's friction");
    }
    Ok(())
}

/// On the electrical stage what is found is a fifth more than the change (`host-tests/tests/winding.rs` says why).
fn winding(followed: &Followed) -> anyhow::Result<()> {
    let Followed {
        agreement,
        share: [share, found],
    } = followed;
    println!("winding: {agreement:?}; {found:.3} of the resistance told found, it has {share:.3}");
    ensure!(
        agreement.different == 0 && agreement.reach >= 100,
        "the emulator and the host differ"
    );
    ensure!(
        (found - share).abs() < 0.04,
        "the winding's resistance was not found"
    );
    Ok(())
}

/// The outer task in time, late now and then, late from a moment on, and late from the start.
fn guided(elf: &Path) -> anyhow::Result<()> {
    let settings = &koopman::SETTINGS;
    let run = |name: &str, guidance: Guidance| {
        let [rms, mean, largest] = guidance.errors_m.map(|error| error * 1e9);
        let Guidance {
            agreement,
            missed,
            faults,
            ..
        } = &guidance;
        println!(
            "koopman, {name}: RMS {rms:.0} nm, mean {mean:+.1} nm, largest {largest:.0} nm; {} orders missed; {} commands, {} unlike the host's, \
             by {} at most, reach {}",
            missed[0], agreement.ticks, agreement.different, agreement.largest, agreement.reach
        );
        ensure!(
            agreement.largest <= FLOAT_BOUND && agreement.reach >= 100,
            "{name}: QEMU and the host differ by {} codes; the bound is {FLOAT_BOUND}",
            agreement.largest
        );
        ensure!(
            missed[0] == missed[1] && *faults == 0,
            "{name}: orders missed in QEMU and on the host {missed:?}, {faults} faults"
        );
        Ok((rms, missed[0]))
    };
    let now_and_then = |tick: u64| LATE.contains(&tick);
    let (in_time, none) = run("in time", guidance(elf, settings, |_| false)?)?;
    let (_, some) = run("late now and then", guidance(elf, settings, now_and_then)?)?;
    let (_, all) = run(
        "late from a moment on",
        guidance(elf, settings, |tick| tick >= LATE_FROM)?,
    )?;
    let (never, unguided) = run("late from the start", guidance(elf, settings, |_| true)?)?;
    ensure!(
        (none, some, unguided) == (0, LATE.len() as u32, 0),
        "orders missed: {none}, {some} of {}, {unguided}",
        LATE.len()
    );
    ensure!(all > 400, "orders missed for ever: {all}");
    ensure!(
        in_time < 0.3 * never,
        "the outer task is to take most of the feedback's error: {in_time} of {never} nm"
    );
    Ok(())
}
