//! On macOS the interpreter's symbols are found when the module is loaded, which `cargo build` has to be told; maturin does it by itself.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
