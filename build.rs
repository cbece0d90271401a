//! Says what no stable `cfg` does: whether a core has the DSP instructions that `src/kernels/dsp.rs` uses, whether it gives the upper word
//! of a product (`src/kernels/product.rs`), and whether the compiler takes the hint of `src/hint.rs`.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(dsp_instructions, short_products, cold_path)");
    // Every ARMv7E-M core (Cortex-M4, M7) has them; on ARMv8-M they are optional and the name does not tell.
    let target = std::env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv7em-") {
        println!("cargo:rustc-cfg=dsp_instructions");
    }
    if target.starts_with("thumbv6m-") {
        println!("cargo:rustc-cfg=short_products");
    }
    if compiler() >= Some(95) {
        println!("cargo:rustc-cfg=cold_path");
    }
}

/// The compiler's minor version: 95 of `rustc 1.95.0 (…)`.
fn compiler() -> Option<u32> {
    let rustc = std::env::var_os("RUSTC")?;
    let said = std::process::Command::new(rustc).arg("--version").output();
    let said = String::from_utf8(said.ok()?.stdout).ok()?;
    said.split('.').nth(1)?.parse().ok()
}
