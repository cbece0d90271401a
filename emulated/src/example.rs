//! The example to copy first, in QEMU: what it computes, and how it sets the clock, which QEMU lacks.

use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use preslide_tools::process::{command, output_for, root, run, target_of};
use preslide_tools::thumb::{TARGET, Toolchain};

/// What `examples/rtic` prints in QEMU. Its clock registers read as zero there, which is the chip's 16 MHz undivided: 16 MHz / 4200.
/// Sliding takes 0.9 N: at 115 codes a newton and 7 of back-EMF 111, which the feedback's answer to whole counts moves by 3.
const PRINTED: [&str; 3] = [
    "TIM3 ticks at 3809 Hz, not at 20000: off",
    "tick 4000: at 3917 counts, duty code 114",
    "tick 8000: at 183 counts, duty code -108",
];

/// Timers' clocks per tick, which the first of these lines gives, and what they are to be with the clock set.
const CLOCKS: u32 = 4200;
const RATE: u32 = 20_000;

/// Builds the example for the target, runs it, and compares what it prints and what it writes to the clock's registers.
pub fn run_in_qemu() -> Result<()> {
    let folder = root().join("examples");
    let line = "build --release --locked --package rtic-f405 --features semihosting";
    run(&mut Toolchain::ensure()?.cargo(&folder, line))?;
    let image = target_of(&folder).join(TARGET).join("release/rtic-f405");
    let mut qemu = command(
        "qemu-system-arm -M netduinoplus2 -nographic -icount shift=3 -semihosting-config enable=on,target=native \
         -d unimp -kernel",
    );
    let (printed, log) = output_for(
        qemu.arg(image).stdin(Stdio::null()),
        Duration::from_secs(60),
    )?;
    let told = || format!("examples/rtic:\n{printed}{log}");
    for line in PRINTED {
        let is_there = printed.contains(line) || log.contains(line);
        ensure!(is_there, "{}did not print `{line}`", told());
    }
    let rate = tick_rate(&writes(&log)).with_context(told)?;
    ensure!(
        rate == RATE,
        "{}sets the clock for {rate} Hz, not for {RATE}",
        told()
    );
    println!(
        "examples/rtic: sets the clock for {RATE} Hz; {}",
        printed.trim().replace('\n', "; ")
    );
    Ok(())
}

/// The examples that no emulator of Debian's runs, and what each is built for.
const OTHERS: [(&str, &str); 2] = [("embassy-g4", TARGET), ("rp2040", "thumbv6m-none-eabi")];

/// Builds them as a user would.
pub fn link_others() -> Result<()> {
    OTHERS.iter().try_for_each(|(name, target)| {
        let line = format!("build --release --locked --package {name}");
        match Toolchain::or_skipped(target, name) {
            Some(own) => run(&mut own.cargo_for(target, &root().join("examples"), &line)),
            None => Ok(()),
        }
    })
}

/// A write to a device that QEMU has not.
struct Write<'a> {
    device: &'a str,
    offset: u32,
    value: u32,
}

/// `RCC: unimplemented device write (size 4, offset 0x030, value 0x00000003)`, in their order.
fn writes(log: &str) -> Vec<Write<'_>> {
    let hexadecimal = |line: &str, key: &str| {
        let digits = line.split(key).nth(1)?.split([',', ')']).next()?;
        u32::from_str_radix(digits, 16).ok()
    };
    let parse = |line| {
        let (device, rest) = str::split_once(line, ": unimplemented device write")?;
        Some(Write {
            device,
            offset: hexadecimal(rest, "offset 0x")?,
            value: hexadecimal(rest, "value 0x")?,
        })
    };
    log.lines().filter_map(parse).collect()
}

/// What the chip makes of these writes (RM0090, chapters 3 and 7), and why it would not run.
fn tick_rate(writes: &[Write]) -> Result<u32> {
    let [mut wait_states, mut pllcfgr, mut cfgr, mut pll_on] = [0, 0x2400_3010, 0, 0];
    for write in writes {
        match (write.device, write.offset) {
            ("Flash Int", 0) => wait_states = write.value & 7,
            ("RCC", 0) => pll_on = write.value >> 24 & 1,
            ("RCC", 4) if pll_on == 1 => bail!("sets a PLL that is on"),
            ("RCC", 4) => pllcfgr = write.value,
            ("RCC", 8) => cfgr = write.value,
            _ => continue,
        }
        if cfgr & 3 == 2 && (wait_states != 5 || pll_on == 0) {
            bail!("goes to the PLL before flash and PLL are ready for it");
        }
    }
    if cfgr & 3 != 2 {
        bail!("leaves the chip on its 16 MHz");
    }
    let divided = |code: u32, none_below: u32| match code.checked_sub(none_below) {
        None => 1,
        Some(power) => 2_u32 << power,
    };
    let [m, n, p] = [
        pllcfgr & 63,
        pllcfgr >> 6 & 511,
        ((pllcfgr >> 16 & 3) + 1) * 2,
    ];
    let oscillator = 16_000_000 / m.max(1);
    let core = oscillator * n / p;
    let bus = divided(cfgr >> 10 & 7, 4);
    let fast = divided(cfgr >> 13 & 7, 4);
    let within = pllcfgr >> 22 & 1 == 0
        && (1_000_000..=2_000_000).contains(&oscillator)
        && (100_000_000..=432_000_000).contains(&(oscillator * n))
        && cfgr >> 4 & 15 == 0
        && core <= 168_000_000
        && core / bus <= 42_000_000
        && core / fast <= 84_000_000;
    ensure!(
        within,
        "sets PLLCFGR {pllcfgr:#x} and CFGR {cfgr:#x}, beyond what the chip bears"
    );
    let timers = core / bus * if bus > 1 { 2 } else { 1 };
    Ok(timers / CLOCKS)
}
