//! Frames survive the line, and nothing on the line survives the parser's checks by accident.

use preslide_link::{
    Deframer, Exchange, FrameError, GainSettings, LARGEST_FRAME, ModelSettings, RangeCode, Reading,
    Report, Request, Sample, encode,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::{Duration, Instant};

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
    let model = Request::Model(ModelSettings {
        breakaway_n: 0.9,
        blocks: [(270_313.0, 0.292); 4],
    });
    for request in [
        REQUEST,
        model,
        Request::Ping,
        Request::Restart,
        Request::Telemetry { every: u16::MAX },
    ] {
        assert_eq!(feed(&frame(&request)), [Ok(request)]);
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
    let mut deframer = Deframer::new();
    let back: Vec<_> = frame(&sample)
        .iter()
        .filter_map(|&b| deframer.push::<Report>(b))
        .collect();
    assert_eq!(back, [Ok(sample)]);
    let reading = Reading {
        count: 7,
        supply: 6001,
        current: -3,
        byte: Some(0),
        hang: true,
        ..Reading::default()
    };
    assert_eq!(Reading::from_bytes(reading.to_bytes()), reading);
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

/// Random bytes and mutated frames, for two seconds: no panic, and nothing but known kinds of errors.
#[test]
fn random_bytes_do_no_harm() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut deframer = Deframer::new();
    let (mut frames, mut passed) = (0_u64, 0_u64);
    let end = Instant::now() + Duration::from_secs(2);
    while Instant::now() < end {
        let mut bytes = vec![0; rng.random_range(0..200)];
        rng.fill_bytes(&mut bytes);
        if rng.random() {
            let mut valid = frame(&REQUEST);
            let at = rng.random_range(0..valid.len());
            valid[at] = rng.random();
            bytes.extend(valid);
        }
        for byte in bytes {
            if let Some(result) = deframer.push::<Request>(byte) {
                frames += 1;
                passed += u64::from(result.is_ok());
            }
        }
    }
    println!("{frames} frames, {passed} passed the CRC");
    assert!(frames > 10_000);
    // A CRC of 16 bits lets 1 in 65536 through; most mutations leave the frame as it was or break it for good.
    assert!(passed < frames / 50, "{passed} of {frames}");
}
