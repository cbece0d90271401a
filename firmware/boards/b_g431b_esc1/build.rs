//! Linker arguments, the axis, the exported model, and whether the pins are what the chip has.

include!("../axis.rs");
include!("../exported_model.rs");
include!("../stm32g474/pins.rs");

fn main() {
    println!(
        "cargo:rustc-link-search={}",
        std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()
    );
    println!("cargo:rustc-link-arg=-Tlink.x");
    axis(Some("b_g431b_esc1"));
    exported_model();
    let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default();
    for wrong in check_pins(&read("README.md"), &read("src/main.rs")) {
        println!("cargo::error={wrong}");
    }
    for file in [
        "memory.x",
        "build.rs",
        "README.md",
        "src/main.rs",
        "../stm32g474/pins.rs",
    ] {
        println!("cargo:rerun-if-changed={file}");
    }
}
