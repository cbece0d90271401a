//! Linker arguments, the axis, and the exported model.

include!("../axis.rs");
include!("../exported_model.rs");

fn main() {
    println!(
        "cargo:rustc-link-search={}",
        std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()
    );
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=device.x");
    axis(None);
    exported_model();
}
