//! Linker arguments, the axis, the exported model, and whether the pins are what the chip has.

use stm32_metapac::metadata::METADATA;

fn main() {
    preslide_build::link(&["link.x"]);
    preslide_build::axis(Some("b_g431b_esc1"));
    preslide_build::exported_model();
    preslide_build::pins(|peripheral, signal, pin| {
        let known = METADATA.peripherals.iter().find(|p| p.name == peripheral);
        known.is_some_and(|p| p.pins.iter().any(|c| c.pin == pin && c.signal == signal))
    });
}
