//! USART2: the ST-LINK's serial line. Its interrupt moves bytes between the line and two queues.

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{PB3, PB4, USART2};
use embassy_stm32::usart::{Config, Uart};
use heapless::spsc::{Consumer, Producer};

/// Bits per second.
pub const BAUD: u32 = 921_600;

/// Starts it; `None` where the clock does not make the speed.
pub fn start(
    uart: Peri<'static, USART2>,
    rx: Peri<'static, PB4>,
    tx: Peri<'static, PB3>,
) -> Option<()> {
    let mut config = Config::default();
    config.baudrate = BAUD;
    // It runs from here on; dropping the driver would stop it.
    core::mem::forget(Uart::new_blocking(uart, rx, tx, config).ok()?);
    pac::USART2.cr1().modify(|w| w.set_rxneie(true));
    Some(())
}

/// There are bytes to send.
pub fn kick() {
    pac::USART2.cr1().modify(|w| w.set_txeie(true));
}

/// The interrupt: takes what has come and gives what goes. A received byte that finds the ring full, or was damaged, costs its frame.
pub fn serve(received: &mut Producer<'static, u8>, sent: &mut Consumer<'static, u8>) {
    let uart = pac::USART2;
    // Overrun, noise, framing and parity: the frame's CRC tells.
    uart.icr().write(|w| {
        w.set_ore(true);
        w.set_ne(true);
        w.set_fe(true);
        w.set_pe(true);
    });
    while uart.isr().read().rxne() {
        let _ = received.enqueue(uart.rdr().read().dr() as u8);
    }
    while uart.isr().read().txe() {
        match sent.dequeue() {
            Some(byte) => uart.tdr().write(|w| w.set_dr(byte.into())),
            None => {
                uart.cr1().modify(|w| w.set_txeie(false));
                return;
            }
        }
    }
}
