//! Links by cortex-m-rt's script; the memory is that of the chip's crate.

fn main() {
    println!("cargo:rustc-link-arg=-Tlink.x");
}
