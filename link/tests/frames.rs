//! Frames survive the line, and nothing on the line survives the parser's checks by accident.

use crc::{CRC_16_IBM_3740, Crc};
use preslide_link::{
    Answered, Deframer, Exchange, FaultCode, FrameError, GainSettings, Homing, Identity,
    LARGEST_FRAME, LONGEST_NAME, Mark, Mode, ModelPart, Name, Numbered, Order, PART, POINTS,
    Parameter, Points, RangeCode, Reading, Refusal, Reply, Report, Request, ResetCause, Sample,
    State, WINDOW, encode,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const REQUEST: Request = Request::Gains(GainSettings {
    proportional: 1e5,
    integral: 3e6,
    derivative: 600.0,
});

fn frame<T: serde::Serialize>(message: &T) -> Vec<u8> {
    let mut out = [0; LARGEST_FRAME];
    let length = encode(message, &mut out).expect("every message fits a frame");
    out[..length].to_vec()
}

fn feed(bytes: &[u8]) -> Vec<Result<Request, FrameError>> {
    let mut deframer = Deframer::new();
    bytes
        .iter()
        .filter_map(|&byte| deframer.push(byte))
        .collect()
}

#[test]
fn messages_survive_the_line() {
    let model = Request::Model(ModelPart {
        layout: u32::MAX,
        first: u8::MAX,
        values: [270_313.0; PART],
    });
    // The largest of each kind, by which each fits a frame.
    let name = Name::new(&"n".repeat(LONGEST_NAME)).expect("as long as a name may be");
    for request in [
        REQUEST,
        model,
        Request::Ping,
        Request::Telemetry { every: u16::MAX },
        Request::Home(Homing {
            mark: Mark::Index,
            speed_m_s: 1.0,
            position_m: 1.0,
            back_off_m: 1.0,
        }),
        Request::Points(Points {
            ticks: u16::MAX,
            first: i64::MIN,
            steps: [i32::MIN; POINTS - 1],
        }),
        Request::Set(name, 1.0),
    ] {
        let numbered = Numbered {
            id: u16::MAX,
            request,
        };
        let mut deframer = Deframer::new();
        let back: Vec<_> = frame(&numbered)
            .iter()
            .filter_map(|&b| deframer.push::<Numbered>(b))
            .collect();
        assert_eq!(back, [Ok(numbered)]);
    }
    let sample = Report::Sample(Sample {
        sequence: u32::MAX,
        dropped: u32::MAX,
        tick: u32::MAX,
        position: i32::MIN,
        reference: i64::MIN,
        code: i16::MIN,
        current: i16::MIN,
        supply: u16::MAX,
        fault: None,
        range: Some(RangeCode::Below),
        level: i16::MIN,
    });
    let state = Reply::State(State {
        mode: Mode::Homing,
        fault: Some(FaultCode::Bridge),
        located: true,
        silent: true,
        reset: ResetCause::Software,
        tick: u32::MAX,
        position: i64::MIN,
        queued: u16::MAX,
        dropped: u16::MAX,
        missed: u16::MAX,
        supply: u16::MAX,
        current: i16::MIN,
    });
    let identity = Reply::Identity(Identity {
        protocol: u16::MAX,
        rate_hz: u32::MAX,
        count: 1.0,
        effort_per_a: 1.0,
        room: u16::MAX,
        saved: true,
        model: u32::MAX,
    });
    let parameter = Reply::Parameter(Parameter {
        name,
        value: 1.0,
        settable: true,
    });
    let answer = |reply| Report::Answer {
        id: u16::MAX,
        reply,
    };
    let damaged = Report::Damaged(Refusal::Checksum);
    for report in [
        sample,
        answer(state),
        answer(identity),
        answer(parameter),
        damaged,
    ] {
        let mut deframer = Deframer::new();
        let back: Vec<_> = frame(&report)
            .iter()
            .filter_map(|&b| deframer.push::<Report>(b))
            .collect();
        assert_eq!(back, [Ok(report)]);
    }
    let order = Order {
        code: -3,
        driven: true,
    };
    assert_eq!(Order::from_bytes(order.to_bytes()), order);
    let reading = Reading {
        count: 7,
        index: Some(u32::MAX),
        supply: 6001,
        current: -3,
        byte: Some(0),
        hang: true,
        ..Reading::default()
    };
    assert_eq!(Reading::from_bytes(reading.to_bytes()), reading);
}

#[test]
fn a_repeated_request_is_answered_from_memory_and_old_numbers_are_forgotten() {
    let mut answered = Answered::new();
    assert_eq!(answered.find(0), None);
    let reply = |id: u16| Reply::Done { room: id };
    for id in 0..100 {
        answered.add(id, reply(id));
        let known: Vec<u16> = (0..200).filter(|n| answered.find(*n).is_some()).collect();
        assert_eq!(known.len(), WINDOW.min(usize::from(id) + 1));
        assert!(known.iter().all(|n| answered.find(*n) == Some(reply(*n))));
        assert!(known.contains(&id));
    }
}

#[test]
fn bad_frames_are_refused_by_kind_and_cost_only_themselves() {
    let good = frame(&REQUEST);
    let after = |bad: &[u8]| {
        let results = feed(&[bad, &good].concat());
        assert_eq!(
            results.last(),
            Some(&Ok(REQUEST)),
            "the good frame behind it"
        );
        assert_eq!(results.len(), 2);
        results[0]
    };
    let mut damaged = good.clone();
    damaged[3] ^= 0x10;
    assert_eq!(after(&damaged), Err(FrameError::Checksum));
    assert_eq!(
        after(&[&good[..5], &[0]].concat()),
        Err(FrameError::Malformed)
    );
    assert_eq!(
        after(&[&[7; 300], &[0][..]].concat()),
        Err(FrameError::Oversized)
    );
    assert_eq!(after(&frame(&200_u8)), Err(FrameError::Unknown));
    assert_eq!(feed(&[0, 0, 0]), []);
}

/// Every flipped bit of a frame is found.
#[test]
fn single_bit_errors_never_pass() {
    let good = frame(&REQUEST);
    for bit in 0..(good.len() - 1) * 8 {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(!feed(&bytes).contains(&Ok(REQUEST)), "bit {bit}");
    }
}

/// Random bytes, mutated frames, and random payloads whose CRC is right: no panic, and what is read can be written again.
fn do_no_harm(inputs: u64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut requests, mut reports) = (Deframer::new(), Deframer::new());
    let [mut frames, mut whole] = [[0_u64; 3]; 2];
    for input in 0..inputs {
        let kind = (input % 3) as usize;
        let mut bytes = [0; LARGEST_FRAME];
        let length = match kind {
            0 => {
                rng.fill_bytes(&mut bytes);
                bytes[LARGEST_FRAME - 1] = 0;
                LARGEST_FRAME
            }
            1 => {
                let length = encode(&REQUEST, &mut bytes).expect("it fits");
                bytes[rng.random_range(0..length)] = rng.random();
                length
            }
            _ => {
                let length = rng.random_range(3..LARGEST_FRAME - 4);
                let mut body = [0; LARGEST_FRAME];
                rng.fill_bytes(&mut body[..length]);
                // The kind of a message: most of all numbers are none.
                body[rng.random_range(0..3)] = rng.random_range(0..24);
                let check = Crc::<u16>::new(&CRC_16_IBM_3740).checksum(&body[..length]);
                body[length..length + 2].copy_from_slice(&check.to_le_bytes());
                cobs::encode(&body[..length + 2], &mut bytes) + 1
            }
        };
        for byte in &bytes[..length] {
            if let Some(read) = requests.push::<Numbered>(*byte) {
                frames[kind] += 1;
                whole[kind] += u64::from(read.is_ok());
                let again = read.map(|numbered| encode(&numbered, &mut [0; LARGEST_FRAME]));
                assert_ne!(again, Ok(None), "{read:?}");
            }
            if let Some(Ok(report)) = reports.push::<Report>(*byte) {
                whole[kind] += 1;
                let again = encode(&report, &mut [0; LARGEST_FRAME]);
                assert!(again.is_some(), "{report:?}");
            }
        }
    }
    println!(
        "{inputs} inputs: {frames:?} frames, {whole:?} messages, of bytes, mutated frames and payloads"
    );
    assert!(frames.iter().all(|frames| *frames >= inputs / 4));
    // A CRC of 16 bits lets 1 in 65536 through.
    assert!(
        whole[0] + whole[1] < inputs / 5000 && whole[2] > inputs / 2000,
        "{whole:?}"
    );
}

#[test]
fn a_million_random_inputs_do_no_harm() {
    do_no_harm(1_000_000, 3);
}

/// As many of another seed with `INPUTS=1000000000 SEED=7`.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_hundred_million_random_inputs_do_no_harm() {
    let told = |name, usual| std::env::var(name).map_or(usual, |n| n.parse().expect("a number"));
    do_no_harm(told("INPUTS", 100_000_000), told("SEED", 3));
}
