//! Says whether the core has the DSP instructions that `src/kernels/dsp.rs` uses: no stable `cfg` does.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(dsp_instructions)");
    // Every ARMv7E-M core (Cortex-M4, M7) has them; on ARMv8-M they are optional and the name does not tell.
    let target = std::env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv7em-") {
        println!("cargo:rustc-cfg=dsp_instructions");
    }
}
