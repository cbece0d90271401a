//! What holds of a firmware's image: its size, a control task that cannot panic, and on one board all of it in fast memory.

use std::collections::BTreeMap;
use std::path::Path;

use crate::call_graph;
use crate::process::{command, output};
use anyhow::{Context as _, Result, bail, ensure};

/// The interrupt of the control task on the STM32G474.
pub const ADC1_2: &str = "ADC1_2";

/// CCM SRAM of the STM32G474.
const CCM: std::ops::Range<u32> = 0x1000_0000..0x1000_8000;
/// Least stack (bytes): the firmware in QEMU uses up to 6936, as `rig wear` prints, and a quarter more.
const LEAST_STACK: u32 = 8670;

/// Prints flash and RAM of an image; its control task, but for what is `beyond`, must not reach a panic.
pub fn image(kind: &str, elf: &Path, task: &str, beyond: &[&str]) -> Result<()> {
    let sizes = output(command("arm-none-eabi-size").arg(elf))?;
    let numbers = sizes.lines().nth(1).unwrap_or_default().split_whitespace();
    let numbers: Vec<u64> = numbers.filter_map(|word| word.parse().ok()).collect();
    let [text, data, bss, ..] = numbers[..] else {
        bail!("arm-none-eabi-size printed something unknown:\n{sizes}");
    };
    let (flash, ram) = (text + data, data + bss);
    println!("{kind}: flash {flash} bytes, static RAM {ram} bytes");
    let reached = reached(elf, task, beyond)?;
    let panics = reached.values().filter(|name| name.contains("panic"));
    let panics: Vec<&String> = panics.collect();
    ensure!(
        panics.is_empty(),
        "{kind}: the interrupt {task} can reach {panics:?}"
    );
    println!(
        "{kind}: {} functions reached from the interrupt {task}, none of them panics",
        reached.len()
    );
    Ok(())
}

/// Whether the control task, all that it calls and the stack are in CCM SRAM. A panic, which ends the task, may be in flash.
pub fn ccm(elf: &Path) -> Result<()> {
    let reached = reached(elf, ADC1_2, &[])?;
    // The linker reaches flash from there through veneers only, which it names.
    let outside = reached.iter().filter(|(at, name)| {
        !name.contains("panic") && (name.contains("Thunk") || !CCM.contains(at))
    });
    let outside: Vec<_> = outside.map(|(_, name)| name).collect();
    ensure!(
        outside.is_empty(),
        "{ADC1_2} runs in CCM SRAM but calls {outside:?} outside; add them to firmware/boards/stm32g474/ccm.x"
    );
    let symbols = output(command("arm-none-eabi-nm").arg(elf))?;
    let address = |name: &str| {
        let line = symbols.lines().find(|line| line.ends_with(name))?;
        u32::from_str_radix(line.split(' ').next()?, 16).ok()
    };
    let stack = [" _stack_end", " _stack_start"].map(address);
    let left = match stack {
        [Some(low), Some(high)] if high == CCM.end => high.saturating_sub(low),
        _ => bail!("the stack {stack:x?} does not begin at the end of CCM SRAM"),
    };
    ensure!(
        left >= LEAST_STACK,
        "{left} bytes of CCM SRAM are left for the stack, fewer than {LEAST_STACK}; take from ccm.x what the interrupt does not reach"
    );
    println!(
        "stm32g474: {ADC1_2} and the {} functions that it calls are in CCM SRAM, and so is the stack of {left} bytes (checked by address; \
         it cannot be run here)",
        reached.len() - 1
    );
    Ok(())
}

/// The functions that a task can reach, by address.
fn reached(elf: &Path, task: &str, beyond: &[&str]) -> Result<BTreeMap<u32, String>> {
    let listing = output(command("arm-none-eabi-objdump --disassemble --demangle").arg(elf))?;
    call_graph::reached(&listing, task, beyond).with_context(|| elf.display().to_string())
}
