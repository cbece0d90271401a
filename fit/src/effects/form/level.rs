//! What changes the level of friction.

use super::Range::{Any, Between, NotNegative, Positive, Within};
use super::{Argument, BARE, CTerm, Column, Form, LEVEL, Memory, built, term};
use preslide::Units;
use preslide::effects::{
    CoulombAsymmetry, DwellAging, FrictionalLag, LARGEST_LEVEL, LoadDependentFriction,
    LocalFrictionSpot, PeriodicFriction, PositionFriction, RunIn, Stribeck, ThermalDrift, WarmUp,
};

/// `m = 1 + a·sgn F` (`= sgn v` in sliding).
pub static COULOMB_ASYMMETRY: Form = Form {
    id: "coulomb_asymmetry",
    keys: &[("asymmetry", Within(1.0))],
    library: |effect, _| term(CoulombAsymmetry::try_new(effect.get("asymmetry"))),
    controller: built(
        "CoulombAsymmetry",
        &[],
        CTerm::level("friction > 0.0f ? $asymmetry : friction < 0.0f ? -$asymmetry : 0.0f"),
    ),
    ..BARE
};

/// `m = 1 + a·exp(−(abs(v)/v_s)^δ)`.
pub static STRIBECK: Form = Form {
    id: "stribeck",
    keys: &[
        ("level", LEVEL),
        ("velocity_m_s", Positive),
        ("exponent", Between(1.0, 4.0)),
    ],
    library: |effect, _| {
        let [level, velocity, exponent] = effect.numbers();
        term(Stribeck::try_new(level, velocity, exponent, Units::SI))
    },
    controller: built(
        "Stribeck",
        &[Argument::Units],
        CTerm::level("$level * stribeck(v, $velocity_m_s, $exponent)"),
    ),
    ..BARE
};

/// Stribeck's curve, following with `τ`.
pub static FRICTIONAL_LAG: Form = Form {
    id: "frictional_lag",
    keys: &[
        ("level", LEVEL),
        ("velocity_m_s", Positive),
        ("exponent", Between(1.0, 4.0)),
        ("time_constant_s", Positive),
    ],
    library: |effect, sample_time| {
        let [level, velocity, exponent, time] = effect.numbers();
        term(FrictionalLag::try_new(
            level,
            velocity,
            exponent,
            time,
            sample_time,
            Units::SI,
        ))
    },
    controller: built("FrictionalLag", &[Argument::SampleTime, Argument::Units], CTerm::level("@").remembers(Memory {
            kind: "float",
            at_rest: "$level",
            next: "@ - expm1f(-SAMPLE_TIME_S / $time_constant_s) * ($level * stribeck(v, $velocity_m_s, $exponent) - @)",
        })),
    ..BARE
};

/// `m = 1 + Σ c_j·cos(jπu)`.
pub static POSITION_FRICTION: Form = Form {
    id: "position_friction",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*", LEVEL)],
    library: |effect, _| {
        let [from, to] = effect.numbers();
        term(PositionFriction::try_new(
            from,
            to,
            effect.padded_cosines(),
            Units::SI,
        ))
    },
    controller: built(
        "PositionFriction",
        &[Argument::Units],
        CTerm::level("cosines((x - $from_m) / ($to_m - $from_m), $cosines)").placed(),
    ),
    ..BARE
};

/// `m = 1 + a·exp(−((x − x_s)/w)²)`.
pub static LOCAL_FRICTION_SPOT: Form = Form {
    id: "local_friction_spot",
    keys: &[("level", LEVEL), ("position_m", Any), ("width_m", Positive)],
    library: |effect, _| {
        let [level, position, width] = effect.numbers();
        term(LocalFrictionSpot::try_new(
            level,
            position,
            width,
            Units::SI,
        ))
    },
    controller: built(
        "LocalFrictionSpot",
        &[Argument::Units],
        CTerm::level("$level * spot((x - $position_m) / $width_m)").placed(),
    ),
    ..BARE
};

/// `m = 1 + a·cos(2πx/p + φ)`.
pub static PERIODIC_FRICTION: Form = Form {
    id: "periodic_friction",
    keys: &[("level", LEVEL), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        let [level, period, phase] = effect.numbers();
        term(PeriodicFriction::try_new(level, period, phase, Units::SI))
    },
    controller: built(
        "PeriodicFriction",
        &[Argument::Units],
        CTerm::level("$level * wave(x, $period_m, $phase_rad)").placed(),
    ),
    ..BARE
};

/// `m = 1 + β·(T − T0)`.
pub static THERMAL_DRIFT: Form = Form {
    id: "thermal_drift",
    keys: &[("level_per_K", Any), ("temperature_C", Any)],
    library: |effect, _| {
        let [level, temperature] = effect.numbers();
        term(ThermalDrift::try_new(level, temperature, LARGEST_LEVEL))
    },
    controller: built(
        "ThermalDrift",
        &[Argument::LevelLimit],
        CTerm::level("slope(temperature, $temperature_C, $level_per_K)"),
    ),
    needs: Some((
        Column::Temperature,
        "thermal_drift with level and time_constant_s",
    )),
    ..BARE
};

/// `m = 1 + a·exp(−t/τ)`: the other set of keys of `thermal_drift`.
pub static WARM_UP: Form = Form {
    id: "thermal_drift",
    keys: &[("level", LEVEL), ("time_constant_s", Positive)],
    library: |effect, sample_time| {
        let [level, time] = effect.numbers();
        term(WarmUp::try_new(level, time, sample_time))
    },
    controller: built(
        "WarmUp",
        &[Argument::SampleTime],
        CTerm::level("$level * expf(-(float)@ * (SAMPLE_TIME_S / $time_constant_s))").remembers(
            // Ticks: seconds in single precision stand still.
            Memory {
                kind: "uint32_t",
                at_rest: "0u",
                next: "@ < UINT32_MAX ? @ + 1u : @",
            },
        ),
    ),
    cost: Some("warm_up"),
    ..BARE
};

/// `m = 1 + a·exp(−s/λ)`.
pub static RUN_IN: Form = Form {
    id: "run_in",
    keys: &[("level", LEVEL), ("path_m", Positive)],
    library: |effect, sample_time| {
        let [level, path] = effect.numbers();
        term(RunIn::try_new(level, path, sample_time, Units::SI))
    },
    controller: Err(
        "it counts from the first sample of the recording and would begin anew whenever the controller starts",
    ),
    ..BARE
};

/// Decades of ageing in a controller: what single precision adds up in ticks of 50 µs, for time constants up to some seconds.
const DECADES: &str = "2.0";
/// The same on the host, in double precision.
const HOST_DECADES: f64 = 6.0;

/// `m = 1 + a·log10(1 + θ/τ)`, `dθ/dt = 1 − abs(v)·θ/λ`.
pub static DWELL_AGING: Form = Form {
    id: "dwell_aging",
    keys: &[
        ("level_per_decade", Within(1.0)),
        ("time_constant_s", Positive),
        ("erasing_path_m", Positive),
    ],
    library: |effect, sample_time| {
        let [level, time, erasing] = effect.numbers();
        term(DwellAging::try_new(
            level,
            time,
            erasing,
            HOST_DECADES,
            sample_time,
            Units::SI,
        ))
    },
    controller: built("DwellAging", &[
            Argument::Number(DECADES),
            Argument::SampleTime,
            Argument::Units,
        ], CTerm::level("$level_per_decade * log10f(1.0f + @)").remembers(Memory {
            kind: "float",
            at_rest: "0.0f",
            next: "limited(@ - @ * limited(SAMPLE_TIME_S / $erasing_path_m * fabsf(v), 1.0f) + SAMPLE_TIME_S / $time_constant_s, 99.0f)",
        })),
    ..BARE
};

/// `m = 1 + c·(load − load0)`.
pub static LOAD_DEPENDENT_FRICTION: Form = Form {
    id: "load_dependent_friction",
    keys: &[("level_per_N", Any), ("load_N", Any)],
    library: |effect, _| {
        let [level, load] = effect.numbers();
        term(LoadDependentFriction::try_new(
            level,
            load,
            LARGEST_LEVEL,
            Units::SI,
        ))
    },
    controller: built(
        "LoadDependentFriction",
        &[Argument::LevelLimit, Argument::Units],
        CTerm::level("slope(load, $load_N, $level_per_N)"),
    ),
    needs: Some((Column::Load, "a constant friction level")),
    ..BARE
};

/// Most of what is transmitted that may be lost on the way: a gear that loses all of it drives nothing.
const MOST: f64 = 0.99;

/// `μ·abs(T)` in the direction of friction, `T` what a gear transmits: the other set of keys of `load_dependent_friction`.
pub static TRANSMITTED_FRICTION: Form = Form {
    id: "load_dependent_friction",
    keys: &[
        ("share_of_transmitted", Between(0.0, MOST)),
        ("motor_mass_kg", NotNegative),
    ],
    controller: Err(
        "the controller's library has no friction of what a gear transmits yet; without it the friction of an unloaded gear is left",
    ),
    ..BARE
};
