//! Says whether the core has the DSP instructions that `src/kernels/dsp.rs` uses: no stable `cfg` does. Has the examples for a
//! microcontroller linked by cortex-m-rt's script, with `memory.x` from the root.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(dsp_instructions)");
    // Every ARMv7E-M core (Cortex-M4, M7) has them; on ARMv8-M they are optional and the name does not tell.
    let target = std::env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv7em-") {
        println!("cargo:rustc-cfg=dsp_instructions");
    }
    if target.ends_with("-none-eabihf") && std::env::var_os("CARGO_FEATURE_EXAMPLE").is_some() {
        println!("cargo:rustc-link-arg-examples=-Tlink.x");
        println!("cargo:rerun-if-changed=memory.x");
    }
}
