//! The controller on a B-G431B-ESC1: 170 MHz, 20 kHz, a brushed motor between two of the three phases. See `README.md`.

#![no_std]
#![no_main]

mod encoder;
mod line;
mod sense;

use core::panic::PanicInfo;
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
    use crate::sense::{self, Converters};
    use embassy_stm32::gpio::{Level, Output, OutputType, Speed};
    use embassy_stm32::peripherals::IWDG;
    use embassy_stm32::time::Hertz;
    use embassy_stm32::timer::complementary_pwm::{ComplementaryPwm, ComplementaryPwmPin};
    use embassy_stm32::timer::low_level::CountingMode;
    use embassy_stm32::timer::simple_pwm::PwmPin;
    use embassy_stm32::wdg::IndependentWatchdog;
    use heapless::spsc::{Consumer, Producer, Queue};
    use preslide::control::Axis;
    use preslide_app::{Background, CountEncoder, Drive, NoFlash, Queues, RECEIVED, SENT, Start};
    use preslide_stm32g4::tim1::{self, HalfBridges};
    use preslide_stm32g4::{cause, clock};

    /// Telemetry of every eighth tick, 2500 frames of some 30 bytes a second, is what 921600 baud carry.
    const EVERY: u16 = 8;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        drive: Drive<Friction, Encoder, Converters, HalfBridges>,
        background: Background<Model>,
        watchdog: IndependentWatchdog<'static, IWDG>,
        received: Producer<'static, u8>,
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
        let reset = cause();
        let p = embassy_stm32::init(clock::config());
        // The third phase stays open.
        core::mem::forget(Output::new(p.PA10, Level::Low, Speed::Low));
        core::mem::forget(Output::new(p.PB15, Level::Low, Speed::Low));
        let mut encoder = Encoder::start(p.TIM4, p.PB6, p.PB7, p.PB8);
        // What axis.toml says (build.rs), on this board's clock.
        let axis = Axis {
            hardware: HARDWARE,
            ..include!(concat!(env!("OUT_DIR"), "/axis.rs"))
        };
        let pwm = ComplementaryPwm::new(
            p.TIM1,
            Some(PwmPin::new(p.PA8, OutputType::PushPull)),
            Some(ComplementaryPwmPin::new(p.PC13, OutputType::PushPull)),
            Some(PwmPin::new(p.PA9, OutputType::PushPull)),
            Some(ComplementaryPwmPin::new(p.PA12, OutputType::PushPull)),
            None,
            None,
            None,
            None,
            Hertz(HARDWARE.rate_hz),
            CountingMode::CenterAlignedBothInterrupts,
        );
        let bridge = tim1::run(pwm, &HARDWARE, false, axis.sampling_phase());
        let start = Start {
            axis,
            model: MODEL,
            saved: None,
            count: encoder.count(),
            every: EVERY,
            reset,
        };
        let tasks = cx.local.queues.tasks(start);
        let link = crate::line::start(p.USART2, p.PB4, p.PB3);
        let (Ok((control, background)), Some(()), Some(bridge)) = (tasks, link, bridge) else {
            // Nothing drives yet; the watchdog is not running, so it stays so.
            tim1::off();
            loop {
                cortex_m::asm::wfi();
            }
        };
        let (received, from_line) = cx.local.arriving.split();
        let (to_line, sent) = cx.local.outgoing.split();
        // Ten ticks without a sign of life are 500 µs; the slow oscillator is good to a few percent.
        let mut watchdog = IndependentWatchdog::new(p.IWDG, 500);
        watchdog.unleash();
        let pins = sense::Pins {
            u: (p.PA1, p.PA3, p.PA2),
            v: (p.PA7, p.PA5, p.PA6),
            supply: p.PA0,
        };
        let sense = Converters::start((p.ADC1, p.ADC2), (p.OPAMP1, p.OPAMP2), pins);
        let local = Local {
            drive: Drive::new(control, encoder, sense, bridge),
            background,
            watchdog,
            received,
            sent,
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

    /// Bytes in and out. It only moves them.
    #[task(binds = USART2, priority = 4, local = [received, sent])]
    fn line(cx: line::Context) {
        crate::line::serve(cx.local.received, cx.local.sent);
    }

    /// Requests and telemetry.
    #[idle(local = [background, from_line, to_line])]
    fn idle(cx: idle::Context) -> ! {
        let local = cx.local;
        // The chip's one bank of flash cannot be written while code runs from it: nothing is kept.
        let mut memory = NoFlash::SLOTS;
        loop {
            let done = local
                .background
                .poll(local.from_line, local.to_line, &mut memory);
            if done {
                crate::line::kick();
            } else {
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
