//! The controller on a Raspberry Pi Pico 2: RP2350, 150 MHz, 20 kHz. See `README.md` for the pins and how to flash it.

#![no_std]
#![no_main]

mod encoder;
mod sense;

use core::panic::PanicInfo;
#[cfg(feature = "log")]
use defmt_rtt as _;
use preslide::control::Hardware;
use preslide_app::Board;
use rp235x_hal::block::ImageDef;

/// The core's clock and that of the timers (Hz), from the board's crystal.
const CLOCK_HZ: u32 = 150_000_000;
const CRYSTAL_HZ: u32 = 12_000_000;

/// What axis.toml says of the bridge and the converters on this board (build.rs).
const BOARD: Board = include!(concat!(env!("OUT_DIR"), "/board.rs"));
const HARDWARE: Hardware =
    Hardware::centre_aligned(CLOCK_HZ, 20_000).with_dead_time(BOARD.dead_time, BOARD.diode_drop);

/// Tells the chip's ROM that this is a program.
#[unsafe(link_section = ".start_block")]
#[used]
#[allow(unsafe_code)]
static IMAGE_DEF: ImageDef = ImageDef::secure_exe();

preslide_app::model!(f32);

type Friction = <Model as preslide_app::Model>::Friction;

#[rtic::app(device = rp235x_hal::pac)]
mod app {
    use super::{CLOCK_HZ, CRYSTAL_HZ, Friction, HARDWARE, MODEL, Model};
    use crate::encoder::Encoder;
    use crate::sense::{self, Converter};
    use heapless::spsc::{Consumer, Producer, Queue};
    use preslide::control::Axis;
    use preslide_app::{
        Background, CountEncoder, Drive, HalfBridges, NoFlash, Queues, RECEIVED, SENT, Start, wake,
    };
    use preslide_link::ResetCause;
    use rp235x_hal::adc::AdcPin;
    use rp235x_hal::fugit::{MicrosDurationU32, RateExtU32};
    use rp235x_hal::gpio::bank0::{Gpio0, Gpio1, Gpio18, Gpio20};
    use rp235x_hal::gpio::{
        FunctionSioInput, FunctionSioOutput, FunctionUart, Pin, PullDown, PullUp,
    };
    use rp235x_hal::pac::UART0;
    use rp235x_hal::pwm::{self, FreeRunning, Pwm0, Slice, Slices};
    use rp235x_hal::uart::{Reader, UartConfig, UartPeripheral, Writer};
    use rp235x_hal::{Adc, Clock, Sio, Timer, Watchdog, clocks};

    /// Bits per second, and ticks from one sample of telemetry to the next that they carry.
    const BAUD: u32 = 921_600;
    const EVERY: u16 = 8;

    /// What a gate driver takes to wake (µs): 1 ms for most.
    const WAKING_US: u32 = 2000;

    type Bridge = HalfBridges<
        pwm::Channel<Slice<Pwm0, FreeRunning>, pwm::A>,
        pwm::Channel<Slice<Pwm0, FreeRunning>, pwm::B>,
        Pin<Gpio18, FunctionSioOutput, PullDown>,
        Pin<Gpio20, FunctionSioInput, PullUp>,
    >;
    type Pins = (
        Pin<Gpio0, FunctionUart, PullDown>,
        Pin<Gpio1, FunctionUart, PullDown>,
    );

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        drive: Drive<Friction, Encoder, Converter, Bridge>,
        background: Background<Model>,
        watchdog: Watchdog,
        received: Producer<'static, u8>,
        reader: Reader<UART0, Pins>,
        writer: Writer<UART0, Pins>,
        sent: Consumer<'static, u8>,
        from_line: Consumer<'static, u8>,
        to_line: Producer<'static, u8>,
    }

    #[init(local = [
        queues: Queues<Friction> = Queues::new(),
        arriving: Queue<u8, RECEIVED> = Queue::new(),
        outgoing: Queue<u8, SENT> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut p = cx.device;
        let reset = match p.WATCHDOG.reason().read().bits() {
            0 => ResetCause::Power,
            _ => ResetCause::Watchdog,
        };
        let mut watchdog = Watchdog::new(p.WATCHDOG);
        let clocks = clocks::init_clocks_and_plls(
            CRYSTAL_HZ,
            p.XOSC,
            p.CLOCKS,
            p.PLL_SYS,
            p.PLL_USB,
            &mut p.RESETS,
            &mut watchdog,
        );
        let Ok(clocks) = clocks else {
            super::stay_off()
        };
        let sio = Sio::new(p.SIO);
        let pins =
            rp235x_hal::gpio::Pins::new(p.IO_BANK0, p.PADS_BANK0, sio.gpio_bank0, &mut p.RESETS);
        // What axis.toml says (build.rs), on this board's clock.
        let axis = Axis {
            hardware: HARDWARE,
            ..include!(concat!(env!("OUT_DIR"), "/axis.rs"))
        };

        let mut slices = Slices::new(p.PWM, &mut p.RESETS);
        slices.pwm0.set_ph_correct();
        slices.pwm0.set_top(HARDWARE.steps - 1);
        slices.pwm0.channel_a.output_to(pins.gpio16);
        slices.pwm0.channel_b.output_to(pins.gpio17);
        sense::schedule(&mut slices.pwm1, axis.sampling_phase());
        slices.enable_simultaneous(0b11);
        let mut timer = Timer::new_timer0(p.TIMER0, &mut p.RESETS, &clocks);
        let woke = wake(
            &mut pins.gpio19.into_push_pull_output(),
            &mut timer,
            WAKING_US,
        );
        let adc = Adc::new(p.ADC, &mut p.RESETS);
        let inputs = (
            AdcPin::new(pins.gpio26.into_floating_disabled()),
            AdcPin::new(pins.gpio27.into_floating_disabled()),
        );
        let line = UartPeripheral::new(
            p.UART0,
            (pins.gpio0.into_function(), pins.gpio1.into_function()),
            &mut p.RESETS,
        );
        let mut config = UartConfig::default();
        config.baudrate = BAUD.Hz();
        let line = line.enable(config, clocks.peripheral_clock.freq());
        let phases = (
            pins.gpio2.into_pull_type().into_function(),
            pins.gpio3.into_pull_type().into_function(),
        );
        let encoder = Encoder::start(p.PIO0, phases, &mut p.RESETS);
        let (Ok(mut encoder), Ok(mut line), (Ok(supply), Ok(current))) = (encoder, line, inputs)
        else {
            super::stay_off();
        };
        let start = Start {
            axis,
            model: MODEL,
            saved: None,
            count: encoder.count(),
            every: EVERY,
            reset,
        };
        let tasks = cx.local.queues.tasks(start);
        let bridge = HalfBridges::start(
            slices.pwm0.channel_a,
            slices.pwm0.channel_b,
            pins.gpio18.into_push_pull_output(),
            pins.gpio20.into_pull_up_input(),
            HARDWARE.steps,
        );
        let (Ok((control, background)), Some(bridge), true) = (
            tasks,
            bridge,
            woke && clocks.system_clock.freq() == CLOCK_HZ.Hz::<1, 1>(),
        ) else {
            super::stay_off();
        };
        let sense = Converter {
            adc,
            supply,
            current,
            timer: slices.pwm1,
        };
        line.enable_rx_interrupt();
        let (reader, writer) = line.split();
        let (received, from_line) = cx.local.arriving.split();
        let (to_line, sent) = cx.local.outgoing.split();
        // Ten ticks without a sign of life.
        watchdog.start(MicrosDurationU32::micros(500));
        let local = Local {
            drive: Drive::new(control, encoder, sense, bridge),
            background,
            watchdog,
            received,
            reader,
            writer,
            sent,
            from_line,
            to_line,
        };
        (Shared {}, local)
    }

    /// The control task ([`Drive::tick`]). Due when the current of a PWM period is to be converted.
    #[task(binds = PWM_IRQ_WRAP_0, priority = 3, local = [drive, watchdog])]
    fn tick(cx: tick::Context) {
        cx.local.drive.tick();
        cx.local.watchdog.feed();
    }

    /// Bytes that come. It only moves them.
    #[task(binds = UART0_IRQ, priority = 2, local = [reader, received])]
    fn line(cx: line::Context) {
        let mut bytes = [0; 32];
        while let Ok(count) = cx.local.reader.read_raw(&mut bytes) {
            for &byte in bytes.iter().take(count) {
                // One that finds no room costs its frame, as one that was damaged: the frame's CRC tells.
                let _ = cx.local.received.enqueue(byte);
            }
        }
    }

    /// Requests and telemetry.
    #[idle(local = [background, writer, sent, from_line, to_line])]
    fn idle(cx: idle::Context) -> ! {
        let local = cx.local;
        // Code runs from the flash, which cannot be written meanwhile: nothing is kept.
        let mut memory = NoFlash::SLOTS;
        loop {
            let done = local
                .background
                .poll(local.from_line, local.to_line, &mut memory);
            // The line's own queue holds 32 bytes, 7 ticks' worth; the next tick wakes this again.
            while let Some(&byte) = local.sent.peek()
                && local.writer.write_raw(&[byte]).is_ok()
            {
                let _ = local.sent.dequeue();
            }
            if !done {
                cortex_m::asm::wfi();
            }
        }
    }
}

/// Nothing drives yet, and the watchdog is not running.
fn stay_off() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

/// Opens the bridge by its pin alone, from wherever.
#[allow(unsafe_code)]
fn off() {
    // Safety: a register whose ones drive pins low and whose zeros do nothing.
    unsafe {
        let sio = &*rp235x_hal::pac::SIO::ptr();
        sio.gpio_out_clr().write(|w| w.bits(1 << 18));
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    off();
    // The watchdog resets, and with it pins are pulled low.
    loop {
        cortex_m::asm::nop();
    }
}
