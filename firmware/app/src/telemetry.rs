//! Samples on their way from the control task to the background.
//!
//! A ring as the queues are, but of words and with a length that is a power of two: a tick writes nine words and masks an index, where
//! a queue of any length divides.

use core::sync::atomic::{AtomicU32, Ordering, compiler_fence};
use preslide_link::{FaultCode, RangeCode, Sample};

/// 3 ms at 20 kHz.
const ROOM: usize = 64;

type Words = [u32; 9];

/// Written by the control task, read by the background. Both run on one core, so that the order of stores in the program is the order
/// in which the other sees them; the compiler alone must keep it.
pub(crate) struct Samples {
    /// Samples written and read since the start.
    written: AtomicU32,
    read: AtomicU32,
    slots: [[AtomicU32; 9]; ROOM],
}

impl Samples {
    pub(crate) const fn new() -> Self {
        Self {
            written: AtomicU32::new(0),
            read: AtomicU32::new(0),
            slots: [const { [const { AtomicU32::new(0) }; 9] }; ROOM],
        }
    }
}

/// Puts one in, if there is room, under the number of samples put in before it.
#[inline]
pub(crate) fn put(samples: &Samples, sample: impl FnOnce(u32) -> Sample) -> bool {
    let written = samples.written.load(Ordering::Relaxed);
    if written.wrapping_sub(samples.read.load(Ordering::Relaxed)) >= ROOM as u32 {
        return false;
    }
    compiler_fence(Ordering::Acquire);
    let slot = &samples.slots[written as usize % ROOM];
    for (place, word) in slot.iter().zip(words(&sample(written))) {
        place.store(word, Ordering::Relaxed);
    }
    compiler_fence(Ordering::Release);
    samples
        .written
        .store(written.wrapping_add(1), Ordering::Relaxed);
    true
}

/// The oldest.
pub(crate) fn take(samples: &Samples) -> Option<Sample> {
    let read = samples.read.load(Ordering::Relaxed);
    if read == samples.written.load(Ordering::Relaxed) {
        return None;
    }
    compiler_fence(Ordering::Acquire);
    let slot = &samples.slots[read as usize % ROOM];
    let words = slot.each_ref().map(|word| word.load(Ordering::Relaxed));
    compiler_fence(Ordering::Release);
    samples.read.store(read.wrapping_add(1), Ordering::Relaxed);
    Some(sample(words))
}

const FAULTS: [FaultCode; 12] = [
    FaultCode::EncoderJump,
    FaultCode::EncoderFrozen,
    FaultCode::FollowingError,
    FaultCode::SupplyOutOfRange,
    FaultCode::Overrun,
    FaultCode::NotANumber,
    FaultCode::OverCurrent,
    FaultCode::Overload,
    FaultCode::CurrentOffset,
    FaultCode::Bridge,
    FaultCode::LimitLow,
    FaultCode::LimitHigh,
];

const RANGES: [RangeCode; 4] = [
    RangeCode::Learning,
    RangeCode::Inside,
    RangeCode::Above,
    RangeCode::Below,
];

/// Two 16-bit numbers in a word.
#[inline]
fn pair(low: i16, high: i16) -> u32 {
    u32::from(low.cast_unsigned()) | u32::from(high.cast_unsigned()) << 16
}

#[inline]
fn words(sample: &Sample) -> Words {
    // In the order of the tables; 0 is none.
    let fault = sample.fault.map_or(0, |fault| 1 + fault as u32);
    let range = sample.range.map_or(0, |range| 1 + range as u32);
    [
        sample.sequence,
        sample.dropped,
        sample.tick,
        sample.position.cast_unsigned(),
        sample.reference as u32,
        (sample.reference >> 32) as u32,
        pair(sample.code, sample.current),
        pair(sample.supply.cast_signed(), sample.level),
        fault | range << 8,
    ]
}

fn sample(words: Words) -> Sample {
    let [
        sequence,
        dropped,
        tick,
        position,
        low,
        high,
        code,
        supply,
        codes,
    ] = words;
    let halves = |word: u32| [word as i16, (word >> 16) as i16];
    let ([code, current], [supply, level]) = (halves(code), halves(supply));
    let nth = |word: u32| (word as usize & 0xff).checked_sub(1);
    Sample {
        sequence,
        dropped,
        tick,
        position: position.cast_signed(),
        reference: i64::from(low) | i64::from(high) << 32,
        code,
        current,
        supply: supply.cast_unsigned(),
        fault: nth(codes).and_then(|place| FAULTS.get(place).copied()),
        range: nth(codes >> 8).and_then(|place| RANGES.get(place).copied()),
        level,
    }
}
