//! Says what a core multiplies, which no stable `cfg` does: whether it has the DSP instructions that `src/kernels/dsp.rs` uses, and
//! whether it gives the upper word of a product (`src/kernels/product.rs`). Has the examples for a
//! microcontroller linked by cortex-m-rt's script, with `memory.x` from the root.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(dsp_instructions, short_products)");
    // Every ARMv7E-M core (Cortex-M4, M7) has them; on ARMv8-M they are optional and the name does not tell.
    let target = std::env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv7em-") {
        println!("cargo:rustc-cfg=dsp_instructions");
    }
    if target.starts_with("thumbv6m-") {
        println!("cargo:rustc-cfg=short_products");
    }
    if target.ends_with("-none-eabihf") && std::env::var_os("CARGO_FEATURE_EXAMPLE").is_some() {
        println!("cargo:rustc-link-arg-examples=-Tlink.x");
        println!("cargo:rerun-if-changed=memory.x");
    }
}
