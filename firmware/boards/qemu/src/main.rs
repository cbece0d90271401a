//! The controller on QEMU's mps2-an386, in lock step with a simulated stage. `cargo xtask qemu` runs it.

#![no_std]
#![no_main]

mod device;
#[cfg(feature = "log")]
mod logger;
mod memory;
mod registers;
mod stage;

use core::panic::PanicInfo;
use cortex_m_rt::exception;
use cortex_m_semihosting::{debug, heprintln};
use heapless::spsc::Producer;
#[cfg(feature = "adaptation")]
use preslide::control::learning::Adaptation;
#[cfg(feature = "watch")]
use preslide::control::learning::MismatchWatch;
#[cfg(feature = "watch")]
use preslide_app::Learner;
use preslide_link::Reading;

// An outer task is over single precision alone: over what was exported, or over the feedback.
#[cfg(any(feature = "float", all(outer_task, exported_model)))]
preslide_app::model!(f32);
#[cfg(not(any(feature = "float", outer_task)))]
preslide_app::model!(fixed::types::I16F16);

preslide_app::outer_task!();

#[cfg(feature = "watch")]
type Number = <<Model as preslide_app::Model>::Friction as preslide::Friction>::Scalar;

#[cfg(not(any(feature = "watch", feature = "observer", outer_task)))]
type Source = Model;
#[cfg(all(feature = "observer", not(feature = "watch")))]
type Source = preslide_app::Observing<Model>;
#[cfg(all(feature = "watch", not(feature = "adaptation")))]
type Source = Learner<Model, MismatchWatch<Number>>;
#[cfg(feature = "adaptation")]
type Source = Learner<Model, (MismatchWatch<Number>, Adaptation<Number>)>;

#[cfg(not(any(feature = "watch", feature = "observer", outer_task)))]
const SOURCE: Source = MODEL;
#[cfg(all(feature = "observer", not(feature = "watch")))]
const SOURCE: Source =
    preslide_app::Observing::new(MODEL, preslide::control::ObserverSettings::PAPER_AXIS);
#[cfg(feature = "watch")]
const SOURCE: Source = Learner::new(MODEL);

type Friction = <Source as preslide_app::Model>::Friction;

#[rtic::app(device = crate::device)]
mod app {
    use super::{Friction, SOURCE, Source};
    use crate::device::Interrupt;
    use crate::memory::{self, Pages};
    #[cfg(outer_task)]
    use crate::outer_task::{Outer, SETTINGS};
    use crate::registers::{CLOCK_HZ, Timer, Uart, Watchdog};
    use crate::stage::{self, StageBridge};
    use cortex_m_semihosting::{debug, heprintln};
    use heapless::spsc::{Consumer, Producer, Queue};
    use preslide::control::Axis;
    #[cfg(outer_task)]
    use preslide::control::koopman::Desk;
    use preslide_app::{Background, Control, Inputs, Parameters, Queues, RECEIVED, SENT, Start};
    use preslide_link::ResetCause;
    use preslide_store::{LONGEST, Slots};

    /// Nothing lies between the control task and one that there is not.
    #[cfg(not(outer_task))]
    pub struct Desk;
    /// And it remembers nothing.
    #[cfg(not(outer_task))]
    pub struct Outer;

    #[shared]
    struct Shared {
        desk: Desk,
    }

    #[local]
    struct Local {
        control: Control<Friction>,
        background: Background<Source>,
        memory: Option<Slots<&'static mut Pages>>,
        from_script: Consumer<'static, u8>,
        to_script: Producer<'static, u8>,
        from_line: Consumer<'static, u8>,
        to_line: Producer<'static, u8>,
        received: Producer<'static, u8>,
        sent: Consumer<'static, u8>,
        late: bool,
        outer: Outer,
    }

    #[init(local = [
        queues: Queues<Friction> = Queues::new(),
        pages: Pages = Pages::new(),
        script: Queue<u8, 65> = Queue::new(),
        arriving: Queue<u8, RECEIVED> = Queue::new(),
        outgoing: Queue<u8, SENT> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        Uart::start();
        // What axis.toml says (build.rs).
        let axis: Axis = include!(concat!(env!("OUT_DIR"), "/axis.rs"));
        let mut memory = memory::slots(cx.local.pages);
        let mut record = [0; LONGEST];
        let length = memory.as_mut().and_then(|slots| slots.load(&mut record));
        let start = Start {
            axis,
            model: SOURCE,
            saved: length.and_then(|length| Parameters::from_bytes(record.get(..length)?)),
            count: stage::exchange().count,
            every: 1,
            reset: ResetCause::Power,
        };
        let Ok((control, background)) = cx.local.queues.tasks(start) else {
            unusable();
        };
        #[cfg(outer_task)]
        let desk = control.desk();
        #[cfg(outer_task)]
        let Ok(outer) = Outer::try_new(&SETTINGS, &axis, &desk) else {
            unusable();
        };
        #[cfg(not(outer_task))]
        let (desk, outer) = (Desk, Outer);
        let (to_script, from_script) = cx.local.script.split();
        let (received, from_line) = cx.local.arriving.split();
        let (to_line, sent) = cx.local.outgoing.split();
        let cycles = CLOCK_HZ / axis.hardware.rate_hz;
        // Ten ticks without a sign of life.
        Watchdog::start(10 * cycles);
        Timer::start(cycles);
        let local = Local {
            control,
            background,
            memory,
            from_script,
            to_script,
            from_line,
            to_line,
            received,
            sent,
            late: false,
            outer,
        };
        (Shared { desk }, local)
    }

    fn unusable() -> ! {
        heprintln!("the built-in settings are not usable");
        loop {
            debug::exit(debug::EXIT_FAILURE);
        }
    }

    /// The control task; see [`Control`] for its deadline and what happens when it is missed.
    #[task(binds = TIMER0, priority = 3, shared = [desk], local = [control, to_script, late])]
    fn tick(cx: tick::Context) {
        Timer::acknowledge();
        let reading = crate::reading(cx.local.to_script);
        let inputs = Inputs {
            count: reading.count,
            index: reading.index,
            supply: reading.supply,
            current: reading.current,
            late: *cx.local.late,
        };
        cx.local.control.tick(inputs, &mut StageBridge);
        #[cfg(outer_task)]
        {
            let (mut desk, control) = (cx.shared.desk, cx.local.control);
            if desk.lock(|desk| control.attend(desk)) {
                rtic::pend(Interrupt::TIMER1);
            }
        }
        if reading.dawdle {
            while !Timer::is_due() {}
        }
        *cx.local.late = Timer::is_due();
        Watchdog::feed();
    }

    /// The outer task, once a sample: below the control task and the line, above the background. One that is late is not waited for.
    #[cfg(outer_task)]
    #[task(binds = TIMER1, priority = 1, shared = [desk], local = [outer])]
    fn outer(cx: outer::Context) {
        let (mut desk, outer) = (cx.shared.desk, cx.local.outer);
        if desk.lock(|desk| outer.take(desk)) {
            let outlasts = stage::outlasts();
            let force = outer.solve();
            while outlasts && desk.lock(|desk| desk.sample() == outer.sample()) {}
            desk.lock(|desk| desk.order(outer.sample(), force));
        }
    }

    /// Bytes from the host. Its ring holds all that a host may have on its way, so none finds it full.
    #[task(binds = UARTRX0, priority = 2, local = [received])]
    fn receive(cx: receive::Context) {
        while let Some(byte) = Uart::receive() {
            let _ = cx.local.received.enqueue(byte);
        }
    }

    /// Bytes to the host; pended when there are new ones, and by the UART when it takes another.
    #[task(binds = UARTTX0, priority = 2, local = [sent])]
    fn send(cx: send::Context) {
        while Uart::can_send()
            && let Some(byte) = cx.local.sent.dequeue()
        {
            Uart::send(byte);
        }
    }

    /// Requests and telemetry, from the line and, so that a run depends on nothing but ticks, from the lock step.
    #[idle(local = [background, memory, from_script, from_line, to_line])]
    fn idle(cx: idle::Context) -> ! {
        let local = cx.local;
        loop {
            let script = local
                .background
                .poll(local.from_script, local.to_line, local.memory);
            let line = local
                .background
                .poll(local.from_line, local.to_line, local.memory);
            if script || line {
                rtic::pend(Interrupt::UARTTX0);
            } else {
                cortex_m::asm::wfi();
            }
        }
    }
}

/// What the registers show, which on a board is a few loads; what only an emulator is told, it does. Not part of the tick's figures.
#[inline(never)]
fn reading(to_script: &mut Producer<'static, u8>) -> Reading {
    let reading = stage::exchange();
    if reading.quit {
        quit();
    }
    if let Some(byte) = reading.byte {
        // The background reads faster than one byte a tick; should it not, the frame's CRC tells.
        let _ = to_script.enqueue(byte);
    }
    if registers::Uart::hold(reading.unread) {
        // What has waited goes on, as when a transmitter has room again.
        rtic::pend(device::Interrupt::UARTTX0);
    }
    #[cfg(outer_task)]
    stage::outlast(reading.outlast);
    if reading.hang {
        loop {
            cortex_m::asm::nop();
        }
    }
    reading
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
