//! What RTIC and cortex-m-rt need of a device crate, for the few interrupts of the mps2-an386 that are used.

#![allow(unsafe_code)]

use cortex_m::interrupt::InterruptNumber;

/// Bits of priority that the NVIC implements.
pub const NVIC_PRIO_BITS: u8 = 3;

/// The interrupts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
#[allow(non_camel_case_types)]
pub enum Interrupt {
    /// UART0 has received.
    UARTRX0 = 0,
    /// UART0 has sent.
    UARTTX0 = 1,
    /// CMSDK Timer0.
    TIMER0 = 8,
    /// CMSDK Timer1, which does not run: pended to start the outer task.
    TIMER1 = 9,
}

pub use Interrupt as interrupt;

// Safety: the number is the interrupt's place in the vector table below.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// No typed peripherals: `registers` holds the addresses.
pub struct Peripherals;

impl Peripherals {
    /// RTIC asks for it.
    ///
    /// # Safety
    /// None needed: the type is empty.
    pub unsafe fn steal() -> Self {
        Self
    }
}

unsafe extern "C" {
    fn UARTRX0();
    fn UARTTX0();
    fn TIMER0();
    fn TIMER1();
    fn DefaultHandler();
}

/// The external interrupts of the vector table, which end at Timer1.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [unsafe extern "C" fn(); 10] = [
    UARTRX0,
    UARTTX0,
    DefaultHandler,
    DefaultHandler,
    DefaultHandler,
    DefaultHandler,
    DefaultHandler,
    DefaultHandler,
    TIMER0,
    TIMER1,
];
