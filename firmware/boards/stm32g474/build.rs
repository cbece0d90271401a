//! Linker arguments, and the exported model.

include!("../exported_model.rs");

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
    exported_model();
}
