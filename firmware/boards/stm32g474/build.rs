//! Linker arguments, the axis, the exported model, and whether the pins are what the chip has.

include!("../axis.rs");
include!("../exported_model.rs");
include!("pins.rs");

fn main() {
    println!(
        "cargo:rustc-link-search={}",
        std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()
    );
    // First, so that it takes its sections before link.x takes all.
    println!("cargo:rustc-link-arg=-Tccm.x");
    println!("cargo:rustc-link-arg=-Tlink.x");
    if std::env::var_os("CARGO_FEATURE_LOG").is_some() {
        println!("cargo:rustc-link-arg=-Tdefmt.x");
    }
    for file in ["memory.x", "ccm.x", "build.rs"] {
        println!("cargo:rerun-if-changed={file}");
    }
    axis(Some("stm32g474"));
    exported_model();
    let transmitter = request("LPUART1", "TX").map_or_else(String::new, |n| n.to_string());
    let folder = std::path::PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = std::fs::write(folder.join("lpuart1_tx.rs"), transmitter) {
        println!("cargo::error=lpuart1_tx.rs: {error}");
    }
    let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default();
    for wrong in check_pins(&read("README.md"), &read("src/main.rs")) {
        println!("cargo::error={wrong}");
    }
    for file in ["README.md", "src/main.rs", "pins.rs"] {
        println!("cargo:rerun-if-changed={file}");
    }
}

/// The number by which DMAMUX1 knows a peripheral's request.
fn request(peripheral: &str, signal: &str) -> Option<u32> {
    let peripheral = METADATA.peripherals.iter().find(|p| p.name == peripheral)?;
    let by = |c: &&stm32_metapac::metadata::PeripheralDmaChannel| {
        c.signal == signal && c.dmamux == Some("DMAMUX1")
    };
    peripheral.dma_channels.iter().find(by)?.request
}
