//! The controller on QEMU's mps2-an386, in lock step with a simulated stage. `cargo xtask qemu` runs it.

#![no_std]
#![no_main]

mod device;
mod registers;
mod stage;

use core::panic::PanicInfo;
use cortex_m_rt::exception;
use cortex_m_semihosting::{debug, heprintln};
#[cfg(feature = "adaptation")]
use preslide::control::learning::Adaptation;
#[cfg(feature = "watch")]
use preslide::control::learning::MismatchWatch;
#[cfg(feature = "watch")]
use preslide_app::Learner;

#[cfg(feature = "float")]
preslide_app::model!(f32);
#[cfg(not(feature = "float"))]
preslide_app::model!(fixed::types::I16F16);

#[cfg(feature = "watch")]
type Number = <<Model as preslide_app::Model>::Friction as preslide::Friction>::Scalar;

#[cfg(not(feature = "watch"))]
type Source = Model;
#[cfg(all(feature = "watch", not(feature = "adaptation")))]
type Source = Learner<Model, MismatchWatch<Number>>;
#[cfg(feature = "adaptation")]
type Source = Learner<Model, (MismatchWatch<Number>, Adaptation<Number>)>;

#[cfg(not(feature = "watch"))]
const SOURCE: Source = MODEL;
#[cfg(feature = "watch")]
const SOURCE: Source = Learner::new(MODEL);

type Friction = <Source as preslide_app::Model>::Friction;

/// As on the board: 170 MHz at 20 kHz.
const STEPS: u16 = 8500;

#[rtic::app(device = crate::device)]
mod app {
    use super::{Friction, SOURCE, STEPS, Source};
    use crate::registers::{CLOCK_HZ, Timer, Uart, Watchdog};
    use crate::stage::{self, Channel};
    use cortex_m_semihosting::{debug, heprintln};
    use heapless::spsc::{Consumer, Producer, Queue};
    use preslide::control::Settings;
    use preslide_app::{Background, Bridge, Control, Inputs, Queues};
    use preslide_link::{LARGEST_FRAME, Report, encode};

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control<Friction>,
        bridge: Bridge<Channel, Channel>,
        background: Background<Source>,
        received: Consumer<'static, u8>,
        arrived: Producer<'static, u8>,
        late: bool,
    }

    #[init(local = [queues: Queues<Friction> = Queues::new(), bytes: Queue<u8, 65> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        Uart::LINK.start();
        let settings = Settings::PAPER_AXIS;
        let first = stage::exchange().count;
        let (forward, backward) = Channel::pair(STEPS);
        let tasks = cx.local.queues.tasks(settings, SOURCE, first, 1);
        let (Ok((control, background)), Some(bridge)) =
            (tasks, Bridge::new(forward, backward, STEPS))
        else {
            heprintln!("the built-in settings are not usable");
            loop {
                debug::exit(debug::EXIT_FAILURE);
            }
        };
        let (arrived, received) = cx.local.bytes.split();
        let cycles = CLOCK_HZ / settings.hardware.rate_hz;
        // Ten ticks without a sign of life.
        Watchdog::start(10 * cycles);
        Timer::start(cycles);
        let local = Local {
            control,
            bridge,
            background,
            received,
            arrived,
            late: false,
        };
        (Shared {}, local)
    }

    /// The control task; see [`Control`] for its deadline and what happens when it is missed.
    #[task(binds = TIMER0, priority = 1, local = [control, bridge, arrived, late])]
    fn tick(cx: tick::Context) {
        Timer::acknowledge();
        let reading = stage::exchange();
        if reading.quit {
            crate::quit();
        }
        if let Some(byte) = reading.byte {
            // The background reads faster than one byte a tick; should it not, the frame's CRC tells.
            let _ = cx.local.arrived.enqueue(byte);
        }
        if reading.hang {
            loop {
                cortex_m::asm::nop();
            }
        }
        let inputs = Inputs {
            count: reading.count,
            supply: reading.supply,
            current: reading.current,
            late: *cx.local.late,
        };
        cx.local.control.tick(inputs, cx.local.bridge);
        if reading.dawdle {
            while !Timer::is_due() {}
        }
        *cx.local.late = Timer::is_due();
        Watchdog::feed();
    }

    /// Requests and telemetry. Here, and only here, a slow listener makes the controller wait.
    #[idle(local = [background, received])]
    fn idle(cx: idle::Context) -> ! {
        loop {
            while let Some(byte) = cx.local.received.dequeue() {
                if let Some(report) = cx.local.background.receive(byte) {
                    send(&report);
                }
            }
            match cx.local.background.sample() {
                Some(report) => send(&report),
                None => cortex_m::asm::wfi(),
            }
        }
    }

    fn send(report: &Report) {
        let mut frame = [0; LARGEST_FRAME];
        // Every report fits a frame (a test of the link crate), and there is no one to tell here.
        let length = encode(report, &mut frame).unwrap_or(0);
        for &byte in frame.iter().take(length) {
            Uart::LINK.send(byte);
        }
    }
}

/// The run is over. A function of its own, which `cargo xtask qemu` leaves out where it looks for panics: no controller
/// on a board formats text in its interrupt.
#[inline(never)]
fn quit() {
    registers::Watchdog::stop();
    heprintln!(
        "stack high-water mark: {} bytes",
        registers::stack_high_water()
    );
    debug::exit(debug::EXIT_SUCCESS);
}

/// The watchdog's first expiry: the control task hangs. PWM off, and the stage learns of it.
// Unsafe because it may interrupt anything: it takes no lock and shares only atomics.
#[allow(unsafe_code)]
#[exception]
unsafe fn NonMaskableInt() -> ! {
    registers::Watchdog::stop();
    registers::Timer::run(false);
    stage::off();
    heprintln!("watchdog: the control task did not answer; PWM off");
    stage::exchange();
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    stage::off();
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
