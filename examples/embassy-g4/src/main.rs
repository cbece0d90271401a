//! Friction compensation beside a drive's own loop, in embassy on a NUCLEO-G474RE: encoder on PA6 and PA7 in, PWM on PA8 out, 2000 times a
//! second. The PWM, filtered, is the torque offset that many servo amplifiers take: half of it is none.
//!
//! The friction of the *measured* motion adds stiffness to the drive's loop, so it is given three quarters of its strength. Built in CI, run
//! on no board. `cargo build --release -p embassy-g4 --target thumbv7em-none-eabihf`
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::gpio::OutputType;
use embassy_stm32::time::khz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_time::{Duration, Ticker};
use panic_halt as _;
use preslide::{CountTracker, EncoderScale, Friction, Units};

// What `preslide export model.toml -o stage_model.rs` wrote; yours stands beside this file.
#[rustfmt::skip]
#[path = "../../../cli/tests/exported/packed_f32.rs"]
mod stage_model;

const SAMPLE_TIME_US: u64 = 500;
/// One count of the encoder (m).
const COUNT: f64 = 25e-9;
/// What the amplifier makes of the whole PWM, from end to end (N at the stage), and how much of the friction is compensated (-).
const FORCE_SPAN: f32 = 10.0;
const SHARE: f32 = 0.75;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(Default::default());
    let encoder = Qei::new(p.TIM3, p.PA6, p.PA7, Config::default());
    let pin = PwmPin::new(p.PA8, OutputType::PushPull);
    let up = CountingMode::EdgeAlignedUp;
    let mut pwm = SimplePwm::new(p.TIM1, Some(pin), None, None, None, khz(16), up);
    let mut offset = pwm.ch1();
    offset.set_duty_cycle_fraction(1, 2);
    offset.enable();

    let sample_time = SAMPLE_TIME_US as f64 * 1e-6;
    let model: Result<stage_model::Model, _> = stage_model::model(sample_time, Units::SI);
    // Velocity over 5 ms, and standstill after half a second without an edge.
    let scale = EncoderScale::try_new(COUNT, sample_time, 5e-3, 0.5, Units::SI);
    let (Ok(model), Ok(scale)) = (model, scale) else {
        // A number of the model or above is wrong: no offset.
        return;
    };
    let mut counter = CountTracker::new(encoder.count());
    let (mut timing, mut friction) = (scale.at_rest(), model.at_rest());
    let mut ticker = Ticker::every(Duration::from_micros(SAMPLE_TIME_US));
    let full = offset.max_duty_cycle() as f32;
    loop {
        ticker.next().await;
        let motion = scale.step(&mut timing, counter.update(encoder.count()));
        let force = SHARE * model.step(&mut friction, motion);
        let part = (0.5 + force / FORCE_SPAN).clamp(0.0, 1.0);
        offset.set_duty_cycle((part * full) as u32);
    }
}
