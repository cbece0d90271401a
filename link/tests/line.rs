//! The line at 921600 baud, byte by byte, as the NUCLEO's firmware used it before and uses it now. A model: no UART is here.
//!
//! Before: received bytes were polled between telemetry frames, each of which was written waiting. Now an interrupt moves received bytes
//! into a ring and another one sends what is queued.

use preslide_link::{
    Deframer, GainSettings, LARGEST_FRAME, ModelPart, Numbered, PART, Request, WINDOW, encode,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Bytes that a UART of the STM32G4 holds on either side.
const FIFO: usize = 8;
/// A byte on the line (µs).
const BYTE_US: f64 = 10.0 / 0.921_6;
/// The board's telemetry: a frame of every eighth tick.
const TELEMETRY_US: f64 = 400.0;
const TELEMETRY_BYTES: usize = 31;
/// Share of a tick (50 µs) that the control task takes: nothing else runs then.
const CONTROL_US: f64 = 30.0;
const TICK_US: f64 = 50.0;

/// Something that takes a byte of the line in every byte's time, and gives what it read.
trait Firmware {
    fn byte_time(&mut self, now_us: f64, arrived: Option<u8>, read: &mut Vec<u8>);
}

#[derive(Default)]
struct Polled {
    fifo: VecDeque<u8>,
    sending: VecDeque<()>,
    unsent: usize,
    next_sample_us: f64,
}

impl Firmware for Polled {
    fn byte_time(&mut self, now_us: f64, arrived: Option<u8>, read: &mut Vec<u8>) {
        if let Some(byte) = arrived
            && self.fifo.len() < FIFO
        {
            self.fifo.push_back(byte);
        }
        self.sending.pop_front();
        // Writing waits for room; nothing is read meanwhile.
        while self.unsent > 0 && self.sending.len() < FIFO {
            self.sending.push_back(());
            self.unsent -= 1;
        }
        if self.unsent > 0 {
            return;
        }
        read.extend(self.fifo.drain(..));
        if now_us >= self.next_sample_us {
            self.next_sample_us += TELEMETRY_US;
            self.unsent = TELEMETRY_BYTES;
        }
    }
}

/// The background does not look for as long as 3 ms at a time, as while it builds a friction model.
const PAUSE_US: f64 = 3000.0;

#[derive(Default)]
struct Interrupted {
    fifo: VecDeque<u8>,
    ring: VecDeque<u8>,
    busy_until_us: f64,
}

impl Firmware for Interrupted {
    fn byte_time(&mut self, now_us: f64, arrived: Option<u8>, read: &mut Vec<u8>) {
        if let Some(byte) = arrived
            && self.fifo.len() < FIFO
        {
            self.fifo.push_back(byte);
        }
        if now_us % TICK_US < CONTROL_US {
            return;
        }
        for byte in self.fifo.drain(..) {
            if self.ring.len() < WINDOW * LARGEST_FRAME {
                self.ring.push_back(byte);
            }
        }
        if now_us < self.busy_until_us {
            return;
        }
        while let Some(byte) = self.ring.pop_front() {
            read.push(byte);
            if byte == 0 {
                // It works on that frame.
                self.busy_until_us = now_us + PAUSE_US;
                return;
            }
        }
    }
}

/// Sends frames at random times, at most [`WINDOW`] unanswered; how many were not read.
fn lost(firmware: &mut impl Firmware, request: Request, frames: u16, rng: &mut ChaCha8Rng) -> u16 {
    let mut line = VecDeque::new();
    let (mut sent, mut silent_us, mut good) = (0, 0.0, 0);
    let mut deframer = Deframer::new();
    let mut step = 0_u32;
    let mut read = Vec::new();
    while sent < frames || silent_us < 50_000.0 {
        step += 1;
        if line.is_empty() {
            let open = sent - good;
            if sent < frames
                && rng.random_bool(0.02)
                && (open < WINDOW as u16 || silent_us > 20_000.0)
            {
                let mut frame = [0; LARGEST_FRAME];
                let request = Numbered { id: sent, request };
                let length = encode(&request, &mut frame).expect("it fits");
                line.extend(&frame[..length]);
                sent += 1;
                silent_us = 0.0;
            }
            silent_us += BYTE_US;
        }
        firmware.byte_time(f64::from(step) * BYTE_US, line.pop_front(), &mut read);
        for byte in read.drain(..) {
            good += u16::from(matches!(deframer.push::<Numbered>(byte), Some(Ok(_))));
        }
    }
    sent - good
}

#[test]
fn requests_are_read_while_telemetry_is_sent() {
    const SEED: u64 = 15;
    const FRAMES: u16 = 10_000;
    println!(
        "seed {SEED}, {FRAMES} frames of each kind, one at a time and in bursts of up to {WINDOW}"
    );
    let requests = [
        (
            "move",
            Request::Move {
                distance_m: 1e-3,
                speed_m_s: 1e-3,
                ramp_s: 0.01,
            },
        ),
        (
            "gains",
            Request::Gains(GainSettings {
                proportional: 1e5,
                integral: 3e6,
                derivative: 600.0,
            }),
        ),
        (
            "model",
            Request::Model(ModelPart {
                layout: 1,
                first: 0,
                values: [1e5; PART],
            }),
        ),
    ];
    for (name, request) in requests {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let polled = lost(&mut Polled::default(), request, FRAMES, &mut rng);
        let interrupted = lost(&mut Interrupted::default(), request, FRAMES, &mut rng);
        println!("{name}: polled {polled} of {FRAMES} lost, by interrupt {interrupted}");
        assert!(
            polled > FRAMES / 10,
            "the model must show the fault that was there"
        );
        assert_eq!(interrupted, 0);
    }
}
