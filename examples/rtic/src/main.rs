//! A controller with friction compensation: a quadrature counter in, a PWM duty out, at 20 kHz, to and fro.
//!
//! Copy this first. It runs on an STM32F405 or F446 as it is (encoder on PA0 and PA1, PWM on PB6 and PB7 for the two half bridges), and any
//! other chip with an encoder timer needs other register names. What a machine needs beside it, current and supply measured, a bridge that
//! opens, a command link, is in `firmware/`. The axis moves as soon as this starts: mind the motor.
//!
//! The clock is set as the reference manual RM0090 says, and read back before anything drives: what ticks at another rate than the
//! controller is built for stays as after reset. No board was here to try it on: what is checked is what is written to the registers.
//!
//! `rustup target add thumbv7em-none-eabihf`, then, in `examples`,
//! `cargo run --release -p rtic-f405 --features semihosting --target thumbv7em-none-eabihf` runs it in QEMU, which has no
//! clock tree, and whose TIM2 counts time instead of edges: an axis that is always where it should be takes its place.
//! On a board leave the feature out, and have your probe be the runner in `.cargo/config.toml`.
#![no_std]
#![no_main]

use panic_halt as _;

// What `preslide export model.toml -o stage_model.rs` wrote; yours stands beside this file.
#[rustfmt::skip]
#[path = "../../../cli/tests/exported/packed_f32.rs"]
mod stage_model;

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use preslide::Units;
    use preslide::control::{Axis, Basics, Coefficients, Controller, Hardware, Measurement, Move};
    use stm32f4::stm32f405::{FLASH, RCC, TIM2, TIM3, TIM4};

    use crate::stage_model::{Model, model};

    /// The chip's own oscillator (Hz), within 1 % at 25 °C and 4 % from −10 to 85 °C, and the damping with it: a crystal is better.
    const HSI: u32 = 16_000_000;
    /// How often a clock that does not start is asked for: a PLL takes 0.2 ms.
    const PATIENCE: u32 = 10_000;
    /// Your axis: all else follows from this, and may be changed in what [`controller`] makes of it.
    const AXIS: Basics = Basics {
        hardware: Hardware::edge_aligned(84_000_000, 20_000),
        count: 25e-9,
        mass: 4.05,
        force_per_ampere: 20.7,
        resistance: 3.41,
        supply: 6.0,
        current: 0.68,
        speed: 15e-3,
        travel: None,
    };
    /// Clocks of the timers per tick.
    const CLOCKS: u32 = AXIS.hardware.steps as u32;
    /// To and fro by this length (m) at this speed (m/s) and acceleration (m/s²).
    const STROKE: f64 = 0.1e-3;
    const SPEED: f64 = 0.5e-3;
    const ACCELERATION: f64 = 0.1;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        encoder: TIM2,
        tick: TIM3,
        pwm: TIM4,
        controller: Controller<Model, u32>,
        moves: [Move; 2],
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        start_clock(&p.RCC, &p.FLASH);
        p.RCC
            .ahb1enr()
            .modify(|_, w| w.gpioaen().set_bit().gpioben().set_bit());
        p.RCC
            .apb1enr()
            .modify(|_, w| w.tim2en().set_bit().tim3en().set_bit().tim4en().set_bit());
        if !ticks_as_built(&p.RCC) {
            stay_off();
        }
        // PA0, PA1: TIM2. PB6, PB7: TIM4.
        p.GPIOA
            .moder()
            .modify(|_, w| w.moder0().alternate().moder1().alternate());
        p.GPIOA.afrl().modify(|_, w| w.afrl0().af1().afrl1().af1());
        p.GPIOB
            .moder()
            .modify(|_, w| w.moder6().alternate().moder7().alternate());
        p.GPIOB.afrl().modify(|_, w| w.afrl6().af2().afrl7().af2());
        // Both phases count, filtered over eight clocks.
        p.TIM2
            .ccmr1_input()
            .write(|w| w.cc1s().ti1().cc2s().ti2().ic1f().fck_int_n8());
        p.TIM2.smcr().write(|w| w.sms().encoder_mode_3());
        p.TIM2.arr().write(|w| w.arr().set(u32::MAX));
        p.TIM2.cr1().write(|w| w.cen().set_bit());
        // PWM on two channels: one drives forward, the other backward.
        p.TIM4
            .ccmr1_output()
            .write(|w| w.oc1m().pwm_mode1().oc2m().pwm_mode1());
        p.TIM4.ccer().write(|w| w.cc1e().set_bit().cc2e().set_bit());
        p.TIM4.arr().write(|w| w.arr().set(CLOCKS as u16 - 1));
        p.TIM4.cr1().write(|w| w.cen().set_bit());
        p.TIM3.arr().write(|w| w.arr().set(CLOCKS as u16 - 1));
        p.TIM3.dier().write(|w| w.uie().set_bit());
        p.TIM3.cr1().write(|w| w.cen().set_bit());

        let Some((controller, moves)) = controller(reading(&p.TIM2, 0)) else {
            // A number above or below is wrong.
            stay_off();
        };
        let local = Local {
            encoder: p.TIM2,
            tick: p.TIM3,
            pwm: p.TIM4,
            controller,
            moves,
        };
        (Shared {}, local)
    }

    /// The controller, enabled, and both moves.
    fn controller(count: u32) -> Option<(Controller<Model, u32>, [Move; 2])> {
        // No host is there to be silent.
        let axis = Axis {
            silence: 0.0,
            ..AXIS.axis().ok()?
        };
        let friction = model(axis.sample_time(), Units::SI).ok()?;
        let coefficients = Coefficients::try_new(&axis, friction, Units::SI).ok()?;
        let mut controller = Controller::new(coefficients, count);
        controller.enable().ok()?;
        let by = |distance| Move::plan(distance, SPEED, ACCELERATION, axis.grid()).ok();
        Some((controller, [by(STROKE)?, by(-STROKE)?]))
    }

    /// 168 MHz from the chip's own oscillator by the PLL: 16 MHz / 8 · 168 / 2 (RM0090, 7.3.2 and 7.3.3). Five wait states come first
    /// (3.5.1, from 2.7 V); the buses stay within their 42 and 84 MHz.
    fn start_clock(rcc: &RCC, flash: &FLASH) {
        flash.acr().write(|w| {
            w.latency()
                .ws5()
                .prften()
                .enabled()
                .icen()
                .enabled()
                .dcen()
                .enabled()
        });
        // SAFETY: 2 MHz and 336 MHz are within what the PLL takes and gives.
        #[allow(unsafe_code)]
        rcc.pllcfgr().modify(|_, w| unsafe {
            w.pllsrc()
                .hsi()
                .pllm()
                .bits(8)
                .plln()
                .bits(168)
                .pllp()
                .div2()
        });
        rcc.cr().modify(|_, w| w.pllon().on());
        rcc.cfgr().write(|w| w.ppre1().div4().ppre2().div2());
        let _ = (0..PATIENCE).find(|_| rcc.cr().read().pllrdy().is_ready());
        // Before the PLL is ready this waits in the chip.
        rcc.cfgr()
            .write(|w| w.ppre1().div4().ppre2().div2().sw().pll());
        let _ = (0..PATIENCE).find(|_| rcc.cfgr().read().sws().is_pll());
    }

    /// Whether [`CLOCKS`] of TIM3 are a tick of [`AXIS`], by what the clock's registers read back.
    fn ticks_as_built(rcc: &RCC) -> bool {
        let control = rcc.cr().read().bits();
        let clock = timer_clock(rcc.cfgr().read().bits(), rcc.pllcfgr().read().bits());
        let wanted = AXIS.hardware.rate_hz;
        let is_right = clock == wanted * CLOCKS;
        #[cfg(feature = "semihosting")]
        if !is_right {
            let rate = clock / CLOCKS;
            cortex_m_semihosting::hprintln!("TIM3 ticks at {} Hz, not at {}: off", rate, wanted);
        }
        // An oscillator is on in every chip that runs: this is QEMU.
        is_right || cfg!(feature = "semihosting") && control == 0
    }

    /// Clock of the timers on APB1 (Hz) for registers CFGR and PLLCFGR: the bus's, twice where the bus is divided (RM0090, 7.2). 0 for a
    /// crystal, whose frequency only its board knows.
    const fn timer_clock(cfgr: u32, pllcfgr: u32) -> u32 {
        let (m, n) = (pllcfgr & 0x3f, pllcfgr >> 6 & 0x1ff);
        let system = match cfgr >> 2 & 3 {
            0 => HSI,
            2 if pllcfgr >> 22 & 1 == 0 && m != 0 => HSI / m * n / (2 * (pllcfgr >> 16 & 3) + 2),
            _ => 0,
        };
        let core = match cfgr >> 4 & 0xf {
            0..8 => system,
            by @ 8..12 => system >> (by - 7),
            by => system >> (by - 6),
        };
        match cfgr >> 10 & 7 {
            0..4 => core,
            by => 2 * (core >> (by - 3)),
        }
    }

    // As after reset, and as set above.
    const _: () = assert!(timer_clock(0, 0x2400_3010) == 16_000_000);
    const _: () = assert!(timer_clock(0x940a, 0x2400_2a08) == 84_000_000);

    /// Pins and timers stay as after reset: no PWM. A bridge needs pull-downs at its inputs, as it does during reset.
    fn stay_off() -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Counter in, PWM out. A fault opens the loop: `controller.fault()` says which.
    #[task(binds = TIM3, priority = 1, local = [encoder, tick, pwm, controller, moves])]
    fn control(cx: control::Context) {
        cx.local.tick.sr().modify(|_, w| w.uif().clear_bit());
        let (controller, moves) = (cx.local.controller, cx.local.moves);
        if controller.is_idle() && controller.start(moves[0]).is_ok() {
            moves.swap(0, 1);
        }
        let count = reading(cx.local.encoder, controller.reference());
        let command = controller.tick(Measurement {
            count,
            // Neither is measured: as if the supply were what it should be.
            supply: (AXIS.supply / AXIS.hardware.supply_code) as u16,
            current: 0,
            late: false,
        });
        let code = command.code;
        let (ahead, back) = (code.max(0) as u16, (-code).max(0) as u16);
        cx.local.pwm.ccr1().write(|w| w.ccr().set(ahead));
        cx.local.pwm.ccr2().write(|w| w.ccr().set(back));
        #[cfg(feature = "semihosting")]
        tell(command.position, code);
    }

    /// The counter; in QEMU the count that is asked for (2⁻¹⁶ counts).
    fn reading(encoder: &TIM2, reference: i64) -> u32 {
        if cfg!(feature = "semihosting") {
            (reference >> 16) as u32
        } else {
            encoder.cnt().read().bits()
        }
    }

    /// For QEMU: the duty near the end of both strokes, and the end of the run.
    #[cfg(feature = "semihosting")]
    fn tell(position: i64, code: i32) {
        use core::sync::atomic::{AtomicU32, Ordering};
        use cortex_m_semihosting::{debug, hprintln};
        static TICKS: AtomicU32 = AtomicU32::new(0);
        let tick = TICKS.load(Ordering::Relaxed) + 1;
        TICKS.store(tick, Ordering::Relaxed);
        if tick.is_multiple_of(4000) {
            hprintln!("tick {}: at {} counts, duty code {}", tick, position, code);
        }
        if tick == 8000 {
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
}
