//! Linker arguments, the axis, the exported model, the DMA's request, and whether the pins are what the chip has.

use stm32_metapac::metadata::METADATA;

fn main() {
    // `ccm.x` first, so that it takes its sections before link.x takes all.
    preslide_build::link(&["ccm.x", "link.x"]);
    println!("cargo:rerun-if-changed=ccm.x");
    preslide_build::axis(Some("stm32g474"));
    preslide_build::exported_model();
    let transmitter = request("LPUART1", "TX").map_or_else(String::new, |n| n.to_string());
    let folder = std::path::PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = std::fs::write(folder.join("lpuart1_tx.rs"), transmitter) {
        println!("cargo::error=lpuart1_tx.rs: {error}");
    }
    preslide_build::pins(|peripheral, signal, pin| {
        let known = METADATA.peripherals.iter().find(|p| p.name == peripheral);
        known.is_some_and(|p| p.pins.iter().any(|c| c.pin == pin && c.signal == signal))
    });
}

/// The number by which DMAMUX1 knows a peripheral's request.
fn request(peripheral: &str, signal: &str) -> Option<u32> {
    let peripheral = METADATA.peripherals.iter().find(|p| p.name == peripheral)?;
    let by = |c: &&stm32_metapac::metadata::PeripheralDmaChannel| {
        c.signal == signal && c.dmamux == Some("DMAMUX1")
    };
    peripheral.dma_channels.iter().find(by)?.request
}
