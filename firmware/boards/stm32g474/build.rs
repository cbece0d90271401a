//! Linker arguments; the memory map is embassy-stm32's.

fn main() {
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=build.rs");
}
