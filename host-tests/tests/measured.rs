//! What a drive measures in a tick: 6 V, no current, in time, but for one thing.

use preslide::control::Measurement;
use preslide_sim::stage::EncoderReading;

pub fn calm<C>(count: C) -> Measurement<C> {
    Measurement {
        count,
        supply: 6000,
        current: 0,
        late: false,
    }
}

/// At 0 with the supply's code.
pub fn supplied<C: Default>(supply: u16) -> Measurement<C> {
    Measurement {
        supply,
        ..calm(C::default())
    }
}

/// At 0 with the current's code.
pub fn carrying<C: Default>(current: i16) -> Measurement<C> {
    Measurement {
        current,
        ..calm(C::default())
    }
}

/// At 0, not in time.
pub fn delayed<C: Default>() -> Measurement<C> {
    Measurement {
        late: true,
        ..calm(C::default())
    }
}

/// The stage's reading, saturating as an ADC does.
pub fn read(reading: &EncoderReading) -> Measurement<u32> {
    Measurement {
        count: reading.count.cast_unsigned(),
        supply: (reading.supply_v * 1e3).round() as u16,
        current: (reading.current_a * 1e4).round() as i16,
        late: false,
    }
}
