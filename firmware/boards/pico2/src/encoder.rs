//! The encoder: a state machine of PIO0 counts quadrature edges, since the chip has no counter for them.

#![allow(unsafe_code)]

use preslide_app::CountEncoder;
use rp235x_hal::gpio::bank0::{Gpio2, Gpio3};
use rp235x_hal::gpio::{FunctionPio0, Pin, PullUp};
use rp235x_hal::pac::{PIO0, RESETS};
use rp235x_hal::pio::{
    Buffers, InstallError, PIOBuilder, PIOExt, Running, SM0, ShiftDirection, StateMachine,
};

/// The encoder on GPIO 2 and 3.
pub struct Encoder {
    // Kept, so that they go on.
    _machine: StateMachine<(PIO0, SM0), Running>,
    _pins: Pins,
}

/// A on GPIO 2, B on GPIO 3.
pub type Pins = (
    Pin<Gpio2, FunctionPio0, PullUp>,
    Pin<Gpio3, FunctionPio0, PullUp>,
);

impl Encoder {
    /// Counts edges of both phases.
    pub fn start(pio: PIO0, pins: Pins, resets: &mut RESETS) -> Result<Self, InstallError> {
        // The two pins before and after make four bits, which are where the program goes on. The count is in `y`, which can only be counted
        // down: up is down of its complement. After each look the count is put where the processor reads it whenever it likes (datasheet,
        // "FJOIN_RX_PUT"). The longest way is 10 clocks: 15 million counts a second.
        let program = pio::pio_asm!(
            ".origin 0",
            "jmp tell", // 00 → 00
            "jmp up",   // 00 → 01
            "jmp down", // 00 → 10
            "jmp tell",
            "jmp down", // 01 → 00
            "jmp tell",
            "jmp tell",
            "jmp up", // 01 → 11
            "jmp up", // 10 → 00
            "jmp tell",
            "jmp tell",
            "jmp down", // 10 → 11
            "jmp tell",
            "jmp down", // 11 → 01
            "jmp up",   // 11 → 10
            "jmp tell",
            "down:",
            "jmp y--, tell",
            ".wrap_target",
            "tell:",
            "mov isr, y",
            "mov rxfifo[0], isr",
            "out isr, 2",
            "in pins, 2",
            "mov osr, isr",
            "mov pc, isr",
            "up:",
            "mov y, ~y",
            "jmp y--, counted",
            "counted:",
            "mov y, ~y",
            ".wrap",
        );
        let (mut block, machine, ..) = pio.split(resets);
        let installed = block.install(&program.program)?;
        let (machine, ..) = PIOBuilder::from_installed_program(installed)
            .buffers(Buffers::RxPut)
            .in_pin_base(2)
            .in_count(2)
            .in_shift_direction(ShiftDirection::Left)
            .out_shift_direction(ShiftDirection::Right)
            .build(machine);
        Ok(Self {
            _machine: machine.start(),
            _pins: pins,
        })
    }
}

impl CountEncoder for Encoder {
    /// The state machine has no room for it.
    #[inline]
    fn index(&mut self) -> Option<u32> {
        None
    }

    #[inline]
    fn count(&mut self) -> u32 {
        // Safety: a register of the state machine that this owns, which reading changes nothing of.
        unsafe { &*PIO0::ptr() }.rxf0_putget(0).read().bits()
    }
}
