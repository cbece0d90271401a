//! Linker arguments, the axis, the exported model, and what the outer task was told.

fn main() {
    println!("cargo:rerun-if-changed=device.x");
    preslide_build::link(&["link.x"]);
    preslide_build::axis(None);
    preslide_build::exported_model();
    preslide_build::outer_task();
}
