//! The smallest controller with friction compensation: a quadrature counter in, a friction model, a PWM duty out, at 20 kHz.
//!
//! Copy this first. It runs on an STM32F405 or F446 as it is (encoder on PA0 and PA1, PWM on PB6 and PB7 for the two half bridges), and any
//! other chip with an encoder timer needs other register names. What a machine needs beside it, faults, limits, a bridge that
//! opens, a command link, is in `firmware/`. The axis moves as soon as this starts: mind the motor.
//!
//! `cargo run --release --example rtic --features example --target thumbv7em-none-eabihf` runs it in QEMU, whose TIM2 counts time
//! instead of edges: there is no axis, and only the model's force means something there.
#![no_std]
#![no_main]

use panic_halt as _;

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use preslide::{Block, Friction, Gms, Motion, Sliding, Units};
    use stm32f4::stm32f405::{TIM2, TIM3, TIM4};

    /// Ticks per second, and clocks of the timers per tick at 84 MHz.
    const RATE: f32 = 20_000.0;
    const CLOCKS: u32 = 4200;
    /// One encoder count (m).
    const COUNT: f32 = 25e-9;
    /// The feedback: stiffness (N/m) and damping (N·s/m). The motor: duty per newton at the stage, and how much of it is allowed.
    const STIFFNESS: f32 = 1e5;
    const DAMPING: f32 = 600.0;
    const DUTY_PER_NEWTON: f32 = 0.0275;
    const LARGEST_DUTY: f32 = 0.38;
    /// To and fro at this speed (m/s) for so many ticks each way.
    const SPEED: f32 = 0.5e-3;
    const STROKE: u32 = 4000;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        encoder: TIM2,
        tick: TIM3,
        pwm: TIM4,
        axis: Axis,
    }

    /// What is remembered from tick to tick.
    pub struct Axis {
        friction: Gms<4>,
        state: <Gms<4> as Friction>::State,
        last: u32,
        ticks: u32,
        /// Reference less position, and the reference (m).
        error: f32,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        p.RCC
            .ahb1enr()
            .modify(|_, w| w.gpioaen().set_bit().gpioben().set_bit());
        p.RCC
            .apb1enr()
            .modify(|_, w| w.tim2en().set_bit().tim3en().set_bit().tim4en().set_bit());
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

        // Table 3 of the paper, four blocks; a tenth less force while it slides.
        let blocks = [
            (313_728.0, 0.339),
            (43_670.0, 0.236),
            (10_545.0, 0.171),
            (5_858.0, 0.254),
        ]
        .map(|(stiffness, weight)| Block { stiffness, weight });
        let sliding = Sliding {
            coulomb: 0.81,
            stribeck_velocity: 1e-3,
            stribeck_exponent: 2.0,
            attraction: 20.0,
        };
        let Ok(friction) = Gms::try_new(&blocks, 0.9, sliding, f64::from(1.0 / RATE), Units::SI)
        else {
            // A number above is wrong: nothing drives yet, and nothing will.
            loop {
                cortex_m::asm::wfi();
            }
        };
        let axis = Axis {
            state: friction.at_rest(),
            friction,
            last: p.TIM2.cnt().read().bits(),
            ticks: 0,
            error: 0.0,
        };
        let local = Local {
            encoder: p.TIM2,
            tick: p.TIM3,
            pwm: p.TIM4,
            axis,
        };
        (Shared {}, local)
    }

    /// Counter in, PWM out.
    #[task(binds = TIM3, priority = 1, local = [encoder, tick, pwm, axis])]
    fn control(cx: control::Context) {
        cx.local.tick.sr().modify(|_, w| w.uif().clear_bit());
        let axis = cx.local.axis;
        let count = cx.local.encoder.cnt().read().bits();
        let moved = count.wrapping_sub(axis.last).cast_signed() as f32 * COUNT;
        axis.last = count;

        let forward = axis.ticks / STROKE % 2 == 0;
        let velocity = if forward { SPEED } else { -SPEED };
        let wanted = Motion {
            displacement: velocity / RATE,
            velocity,
        };
        axis.ticks = axis.ticks.wrapping_add(1);
        axis.error += wanted.displacement - moved;
        let friction = axis.friction.step(&mut axis.state, wanted);
        let feedback = STIFFNESS * axis.error + DAMPING * (velocity - moved * RATE);

        let duty = ((friction + feedback) * DUTY_PER_NEWTON).clamp(-LARGEST_DUTY, LARGEST_DUTY);
        let code = (duty * CLOCKS as f32) as i32;
        let (ahead, back) = (code.max(0) as u16, (-code).max(0) as u16);
        cx.local.pwm.ccr1().write(|w| w.ccr().set(ahead));
        cx.local.pwm.ccr2().write(|w| w.ccr().set(back));
        #[cfg(feature = "example-semihosting")]
        tell(axis.ticks, friction, code);
    }

    /// For QEMU: the force at the end of both strokes.
    #[cfg(feature = "example-semihosting")]
    fn tell(ticks: u32, friction: f32, code: i32) {
        use cortex_m_semihosting::{debug, hprintln};
        if ticks % STROKE == 0 {
            hprintln!(
                "tick {}: friction {} mN, duty code {}",
                ticks,
                (friction * 1e3) as i32,
                code
            );
        }
        if ticks == 2 * STROKE {
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
}
