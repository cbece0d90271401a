//! LPUART1: the ST-LINK's serial line. What comes is taken by its interrupt, what goes is fetched by DMA.

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::pac::bdma::vals::Dir;
use embassy_stm32::peripherals::{DMA1_CH1, LPUART1, PA2, PA3};
use embassy_stm32::usart::{Config, Uart};
use heapless::spsc::{Consumer, Producer};

/// Bits per second.
pub const BAUD: u32 = 921_600;

/// Bytes of a transfer: 2.8 ms of the line, so that the 50 µs between two looks of the background cost 2 % of it.
pub const CHUNK: usize = 256;

/// DMA1's first channel, and what DMAMUX1 calls the line's transmitter (build.rs asks the chip's data).
const CHANNEL: usize = 0;
const TRANSMITTER: u8 = include!(concat!(env!("OUT_DIR"), "/lpuart1_tx.rs"));

/// What sends. DMA reads the buffer, which must not be in CCM SRAM.
pub struct Sender {
    buffer: &'static mut [u8; CHUNK],
    sent: Consumer<'static, u8>,
    _channel: Peri<'static, DMA1_CH1>,
}

/// Starts the line; `None` where the clock does not make the speed.
pub fn start(
    uart: Peri<'static, LPUART1>,
    rx: Peri<'static, PA3>,
    tx: Peri<'static, PA2>,
    channel: Peri<'static, DMA1_CH1>,
    buffer: &'static mut [u8; CHUNK],
    sent: Consumer<'static, u8>,
) -> Option<Sender> {
    let mut config = Config::default();
    config.baudrate = BAUD;
    // It runs from here on; dropping the driver would stop it.
    core::mem::forget(Uart::new_blocking(uart, rx, tx, config).ok()?);
    let uart = pac::LPUART1;
    uart.cr1().modify(|w| w.set_rxneie(true));
    uart.cr3().modify(|w| w.set_dmat(true));
    let request = pac::DMAMUX1.ccr(CHANNEL);
    request.write(|w| w.set_dmareq_id(TRANSMITTER));
    let dma = pac::DMA1.ch(CHANNEL);
    dma.par().write_value(uart.tdr().as_ptr() as u32);
    dma.cr().write(|w| {
        w.set_dir(Dir::FROM_MEMORY);
        w.set_minc(true);
    });
    Some(Sender {
        buffer,
        sent,
        _channel: channel,
    })
}

impl Sender {
    /// Starts the next transfer where the last one is over and there is something to send. It waits for nothing and needs no
    /// interrupt: the background looks again after the next tick.
    pub fn poll(&mut self) {
        let dma = pac::DMA1.ch(CHANNEL);
        if dma.cr().read().en() && dma.ndtr().read().ndt() > 0 {
            return;
        }
        let mut length = 0;
        for place in self.buffer.iter_mut() {
            let Some(byte) = self.sent.dequeue() else {
                break;
            };
            *place = byte;
            length += 1;
        }
        if length == 0 {
            return;
        }
        // Its registers can be written while it is off only; what was written to the buffer must be there before it is on.
        dma.cr().modify(|w| w.set_en(false));
        dma.mar().write_value(self.buffer.as_ptr() as u32);
        dma.ndtr().write(|w| w.set_ndt(length));
        cortex_m::asm::dmb();
        dma.cr().modify(|w| w.set_en(true));
    }
}

/// The interrupt: takes what has come. A received byte that finds the ring full, or was damaged, costs its frame; the ring holds all
/// that a host may have on its way.
pub fn receive(received: &mut Producer<'static, u8>) {
    let uart = pac::LPUART1;
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
}
