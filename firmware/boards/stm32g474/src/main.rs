//! The controller on a NUCLEO-G474RE: 170 MHz, 20 kHz. See `README.md` for the pins and how to flash it.

#![no_std]
#![no_main]

mod bridge;
mod ccm;
mod encoder;
mod line;
mod memory;
mod sense;

use core::panic::PanicInfo;
#[cfg(feature = "log")]
use defmt_rtt as _;
use preslide::control::Hardware;
use preslide_app::Board;
use preslide_stm32g4::{clock, tim1};

/// What axis.toml says of the bridge and the converters on this board (build.rs), and what the clock makes of it.
const BOARD: Board = include!(concat!(env!("OUT_DIR"), "/board.rs"));
const HARDWARE: Hardware = clock::hardware(&BOARD);

preslide_app::model!(fixed::types::I16F16);

type Friction = <Model as preslide_app::Model>::Friction;

#[rtic::app(device = embassy_stm32, peripherals = false)]
mod app {
    use super::{Friction, HARDWARE, MODEL, Model};
    use crate::encoder::Encoder;
    use crate::line::{CHUNK, Sender};
    use crate::memory::Pages;
    use crate::sense::Converter;
    use crate::{bridge, memory};
    use embassy_stm32::peripherals::IWDG;
    use embassy_stm32::wdg::IndependentWatchdog;
    use heapless::spsc::{Consumer, Producer, Queue};
    use preslide::control::Axis;
    use preslide_app::{
        Background, CountEncoder, Drive, Parameters, Queues, RECEIVED, SENT, Start,
    };
    use preslide_stm32g4::tim1::{self, HalfBridges};
    use preslide_stm32g4::{cause, clock};
    use preslide_store::{LONGEST, Slots};

    /// Telemetry of every eighth tick, 2500 frames of some 30 bytes a second, is what 921600 baud carry.
    const EVERY: u16 = 8;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        drive: Drive<Friction, Encoder, Converter, HalfBridges>,
        background: Background<Model>,
        watchdog: IndependentWatchdog<'static, IWDG>,
        memory: Option<Slots<Pages>>,
        received: Producer<'static, u8>,
        sender: Sender,
        from_line: Consumer<'static, u8>,
        to_line: Producer<'static, u8>,
    }

    #[init(local = [
        queues: Queues<Friction> = Queues::new(),
        arriving: Queue<u8, RECEIVED> = Queue::new(),
        outgoing: Queue<u8, SENT> = Queue::new(),
        chunk: [u8; CHUNK] = [0; CHUNK],
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        crate::ccm::load();
        let reset = cause();
        let p = embassy_stm32::init(clock::config());
        let mut encoder = Encoder::start(p.TIM2, p.PA0, p.PA1, p.PB10);
        let pins = bridge::Pins {
            a: (p.PA8, p.PB13),
            b: (p.PA9, p.PB14),
            fault: p.PB12,
        };
        // What axis.toml says (build.rs), on this board's clock.
        let axis = Axis {
            hardware: HARDWARE,
            ..include!(concat!(env!("OUT_DIR"), "/axis.rs"))
        };
        let bridge = bridge::start(p.TIM1, pins, axis.sampling_phase());
        let mut memory = memory::slots();
        let mut record = [0; LONGEST];
        let length = memory.as_mut().and_then(|slots| slots.load(&mut record));
        let start = Start {
            axis,
            model: MODEL,
            saved: length.and_then(|length| Parameters::from_bytes(record.get(..length)?)),
            count: encoder.count(),
            every: EVERY,
            reset,
        };
        let tasks = cx.local.queues.tasks(start);
        let (received, from_line) = cx.local.arriving.split();
        let (to_line, sent) = cx.local.outgoing.split();
        let chunk = cx.local.chunk;
        let link = crate::line::start(p.LPUART1, p.PA3, p.PA2, p.DMA1_CH1, chunk, sent);
        let (Ok((control, background)), Some(sender), Some(bridge)) = (tasks, link, bridge) else {
            // Nothing drives yet; the watchdog is not running, so it stays so.
            tim1::off();
            loop {
                cortex_m::asm::wfi();
            }
        };
        // Ten ticks without a sign of life are 500 µs; the slow oscillator is good to a few percent.
        let mut watchdog = IndependentWatchdog::new(p.IWDG, 500);
        watchdog.unleash();
        let sense = Converter::start(p.ADC1, p.PC0, p.PC1);
        let local = Local {
            drive: Drive::new(control, encoder, sense, bridge),
            background,
            watchdog,
            memory,
            received,
            sender,
            from_line,
            to_line,
        };
        (Shared {}, local)
    }

    /// The control task ([`Drive::tick`]). Due when the current of a PWM period has been converted, so it has no timer of its own.
    #[task(binds = ADC1_2, priority = 8, local = [drive, watchdog])]
    fn tick(cx: tick::Context) {
        cx.local.drive.tick();
        cx.local.watchdog.pet();
    }

    /// Bytes that come. It only moves them.
    #[task(binds = LPUART1, priority = 4, local = [received])]
    fn line(cx: line::Context) {
        crate::line::receive(cx.local.received);
    }

    /// Requests and telemetry.
    #[idle(local = [background, memory, sender, from_line, to_line])]
    fn idle(cx: idle::Context) -> ! {
        let local = cx.local;
        loop {
            let done = local
                .background
                .poll(local.from_line, local.to_line, local.memory);
            local.sender.poll();
            if !done {
                cortex_m::asm::wfi();
            }
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    tim1::off();
    // The watchdog resets.
    loop {
        cortex_m::asm::nop();
    }
}
