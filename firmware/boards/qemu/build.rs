//! Linker arguments, the axis, and the exported model.

fn main() {
    println!("cargo:rerun-if-changed=device.x");
    preslide_build::link(&["link.x"]);
    preslide_build::axis(None);
    preslide_build::exported_model();
}
