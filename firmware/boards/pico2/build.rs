//! Linker arguments, the axis and the exported model. What pins can do, the HAL says by their types.

fn main() {
    preslide_build::link(&["link.x"]);
    preslide_build::axis(Some("pico2"));
    preslide_build::exported_model();
}
