//! The controller on a NUCLEO-G474RE: 170 MHz, 20 kHz. See `README.md` for the pins and how to flash it.

#![no_std]
#![no_main]

mod bridge;
mod ccm;
mod clock;
mod log;
mod sense;

use core::panic::PanicInfo;

preslide_app::model!(fixed::types::I16F16);

type Friction = <Model as preslide_app::Model>::Friction;

#[rtic::app(device = embassy_stm32, peripherals = false)]
mod app {
    use super::{Friction, MODEL, Model};
    use crate::bridge::{self, Channel};
    use crate::clock;
    use crate::log::Log;
    use crate::sense::Sense;
    use embassy_stm32::mode::Blocking;
    use embassy_stm32::pac;
    use embassy_stm32::peripherals::{IWDG, TIM2, TIM6};
    use embassy_stm32::timer::low_level::{RoundTo, Timer};
    use embassy_stm32::timer::qei::{self, Qei};
    use embassy_stm32::usart::{self, Uart};
    use embassy_stm32::wdg::IndependentWatchdog;
    use embedded_hal_nb::serial::Read;
    use preslide::control::Settings;
    use preslide_app::{Background, Bridge, Control, Inputs, Queues};
    use preslide_link::{LARGEST_FRAME, Report, encode};

    /// Telemetry of every eighth tick, 2500 frames of some 30 bytes a second, is what 921600 baud carry.
    const EVERY: u16 = 8;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control<Friction>,
        background: Background<Model>,
        bridge: Bridge<Channel, Channel>,
        sense: Sense,
        // Kept, so that its pins stay the timer's.
        _encoder: Qei<'static, TIM2>,
        rate: Timer<'static, TIM6>,
        watchdog: IndependentWatchdog<'static, IWDG>,
        link: Uart<'static, Blocking>,
        late: bool,
    }

    #[init(local = [queues: Queues<Friction> = Queues::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        crate::ccm::load();
        let p = embassy_stm32::init(clock::config());
        let settings = Settings::PAPER_AXIS;

        let encoder = Qei::new(p.TIM2, p.PA0, p.PA1, qei::Config::default());
        // The driver counts 16 bits; the timer has 32.
        pac::TIM2.arr().write_value(u32::MAX);
        let sense = Sense::new(p.ADC1, p.PA2, p.PA3);
        let (forward, backward) = bridge::start(p.TIM1, p.PA8, p.PB13, p.PA9, p.PB14);
        let mut serial = usart::Config::default();
        serial.baudrate = 921_600;
        let link = Uart::new_blocking(p.USART3, p.PC11, p.PC10, serial);
        let first = pac::TIM2.cnt().read();
        let tasks = cx.local.queues.tasks(settings, MODEL, first, EVERY);
        let bridge = Bridge::new(forward, backward, clock::STEPS);
        let (Ok((control, background)), Some(bridge), Ok(link)) = (tasks, bridge, link) else {
            // Nothing drives yet; the watchdog is not running, so it stays so.
            bridge::off();
            loop {
                cortex_m::asm::wfi();
            }
        };

        // Ten ticks without a sign of life are 500 µs; the slow oscillator is good to a few percent.
        let mut watchdog = IndependentWatchdog::new(p.IWDG, 500);
        watchdog.unleash();
        let rate = Timer::new(p.TIM6);
        rate.set_frequency(clock::RATE, RoundTo::Slower);
        rate.enable_update_interrupt(true);
        rate.start();
        let local = Local {
            control,
            background,
            bridge,
            sense,
            _encoder: encoder,
            rate,
            watchdog,
            link,
            late: false,
        };
        (Shared {}, local)
    }

    /// The control task; see [`Control`] for its deadline and what happens when it is missed.
    #[task(binds = TIM6_DAC, priority = 8, local = [control, bridge, sense, rate, watchdog, late])]
    fn tick(cx: tick::Context) {
        cx.local.rate.clear_update_interrupt();
        let count = pac::TIM2.cnt().read();
        let (supply, current) = cx.local.sense.read();
        let inputs = Inputs {
            count,
            supply,
            current,
            late: *cx.local.late,
        };
        cx.local.control.tick(inputs, cx.local.bridge);
        *cx.local.late = pac::TIM6.sr().read().uif();
        cx.local.watchdog.pet();
    }

    /// Requests and telemetry.
    #[idle(local = [background, link])]
    fn idle(cx: idle::Context) -> ! {
        let mut log = Log::default();
        loop {
            // A receive error costs a byte; the frame's CRC tells.
            if let Ok(byte) = cx.local.link.read()
                && let Some(report) = cx.local.background.receive(byte)
            {
                log.report(&report);
                send(cx.local.link, &report);
            }
            if let Some(report) = cx.local.background.sample() {
                log.report(&report);
                send(cx.local.link, &report);
            }
        }
    }

    fn send(link: &mut Uart<'static, Blocking>, report: &Report) {
        let mut frame = [0; LARGEST_FRAME];
        // Every report fits a frame (a test of the link crate), and there is no one to tell here.
        let length = encode(report, &mut frame).unwrap_or(0);
        let _ = link.blocking_write(frame.get(..length).unwrap_or_default());
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    bridge::off();
    // The watchdog resets.
    loop {
        cortex_m::asm::nop();
    }
}
