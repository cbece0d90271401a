//! `m = 1 + a·log10(1 + θ/τ)`, `dθ/dt = 1 − abs(v)·θ/λ`.

use super::Range::{Positive, Within};
use super::{Argument, BARE, CTerm, Constructor, Form, Memory, term};
use preslide::Units;
use preslide::effects::DwellAging;

/// Decades of ageing in a controller: what single precision adds up in ticks of 50 µs, for time constants up to some seconds.
const DECADES: &str = "2.0";
/// The same on the host, in double precision.
const HOST_DECADES: f64 = 6.0;

/// `dwell_aging`.
pub(crate) static DWELL_AGING: Form = Form {
    id: "dwell_aging",
    keys: &[
        ("level_per_decade", Within(1.0)),
        ("time_constant_s", Positive),
        ("erasing_path_m", Positive),
    ],
    library: |effect, sample_time| {
        Ok(term(DwellAging::try_new(
            effect.get("level_per_decade"),
            effect.get("time_constant_s"),
            effect.get("erasing_path_m"),
            HOST_DECADES,
            sample_time,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "DwellAging",
        more: &[
            Argument::Number(DECADES),
            Argument::SampleTime,
            Argument::Units,
        ],
        c: CTerm::level("$level_per_decade * log10f(1.0f + @)").remembers(Memory {
            kind: "float",
            at_rest: "0.0f",
            next: "limited(@ - @ * limited(SAMPLE_TIME_S / $erasing_path_m * fabsf(v), 1.0f) + SAMPLE_TIME_S / $time_constant_s, 99.0f)",
        }),
    }),
    ..BARE
};
