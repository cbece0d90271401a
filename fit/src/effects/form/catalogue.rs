//! Every effect of a model file, one an entry; a key is that of a linear axis, which a rotary file has in its own units (`force_Nm`, `period_rad`,
//! `stiffness_Nm_per_rad` …). A new effect is an entry, and a line in [`ALL`].

use super::Range::{self, Any, Between, NotNegative, Positive, Within};
use super::{Argument, BARE, CTerm, Column, Form, Memory, built};
use crate::effects::term::{FAR, encoder, term};
use preslide::Units;
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, DwellAging, ExternalVibration, FrictionalLag, Gravity,
    LARGEST_LEVEL, LoadDependentFriction, LocalFrictionSpot, PeriodicForce, PeriodicFriction,
    PositionForce, PositionFriction, PositionSpring, QuadraticDrag, RunIn, Stribeck, ThermalDrift,
    ViscousAsymmetry, WarmUp,
};

/// The forms of the ids of a model file. Two of an id are two sets of keys.
pub static ALL: [&Form; 28] = [
    &CONSTANT_FORCE,
    &COULOMB_ASYMMETRY,
    &VISCOUS_ASYMMETRY,
    &QUADRATIC_DRAG,
    &STRIBECK,
    &FRICTIONAL_LAG,
    &POSITION_SPRING,
    &POSITION_FORCE,
    &POSITION_FRICTION,
    &LOCAL_FRICTION_SPOT,
    &PERIODIC_FORCE,
    &PERIODIC_FRICTION,
    &ENCODER_ERROR,
    &GRAVITY,
    &EXTERNAL_VIBRATION,
    &CHANNEL_DELAY,
    &DRIVE_COMPLIANCE,
    &BACKLASH,
    &THERMAL_DRIFT,
    &WARM_UP,
    &RUN_IN,
    &DWELL_AGING,
    &LOAD_DEPENDENT_FRICTION,
    &TRANSMITTED_FRICTION,
    &TORQUE_RIPPLE,
    &ACTUATOR_DEAD_ZONE,
    &ACTUATOR_SATURATION,
    &CREEP,
];

/// A form whose term is the library's type of that name, built from the values of the keys and what follows them: on the host, and in exported
/// source, in C with this term.
macro_rules! library {
    ($kind:ident($($value:ident),*), [$($more:ident),*], $c:expr) => {
        Form {
            library: |effect, _sample_time| {
                let [$($value),*] = effect.numbers();
                term($kind::try_new($($value,)* $(library!(on the host: $more _sample_time)),*))
            },
            controller: built(stringify!($kind), &[$(Argument::$more),*], $c),
            ..BARE
        }
    };
    (on the host: ForceLimit $time:ident) => { FAR };
    (on the host: LevelLimit $time:ident) => { LARGEST_LEVEL };
    (on the host: SampleTime $time:ident) => { $time };
    (on the host: Units $time:ident) => { Units::SI };
}

/// A change of the friction level.
const LEVEL: Range = Within(LARGEST_LEVEL);

/// Largest share of a ripple: a motor that gives nothing at some place is broken.
const MOST_RIPPLE: f64 = 0.9;

/// Most of what is transmitted that may be lost on the way: a gear that loses all of it drives nothing.
const MOST_LOST: f64 = 0.99;

/// Decades of ageing in a controller: what single precision adds up in ticks of 50 µs, for time constants up to some seconds.
const DECADES: &str = "2.0";
/// The same on the host, in double precision.
const HOST_DECADES: f64 = 6.0;

/// `F0`.
pub static CONSTANT_FORCE: Form = Form {
    id: "constant_force",
    keys: &[("force_N", Any)],
    example: &[0.1],
    ..library!(ConstantForce(force), [Units], CTerm::force("$force_N"))
};

/// `b·v`, which a model file has among the keys of `[friction]`.
pub static VISCOUS: Form = Form {
    id: "viscous",
    keys: &[("viscous_N_s_per_m", Any)],
    example: &[3.0],
    controller: built(
        "Viscous",
        &[Argument::ForceLimit, Argument::Units],
        CTerm::force("limited($viscous_N_s_per_m * v, FORCE_LIMIT)"),
    ),
    ..BARE
};

/// `m = 1 + a·sgn F` (`= sgn v` in sliding).
pub static COULOMB_ASYMMETRY: Form = Form {
    id: "coulomb_asymmetry",
    keys: &[("asymmetry", Within(1.0))],
    example: &[0.1],
    ..library!(
        CoulombAsymmetry(asymmetry),
        [],
        CTerm::level("friction > 0.0f ? $asymmetry : friction < 0.0f ? -$asymmetry : 0.0f")
    )
};

/// `d·abs(v)`: viscous friction is `viscous + d` forwards and `viscous − d` backwards.
pub static VISCOUS_ASYMMETRY: Form = Form {
    id: "viscous_asymmetry",
    keys: &[("half_difference_N_s_per_m", Any)],
    example: &[6.0],
    of_speed: true,
    ..library!(
        ViscousAsymmetry(half_difference),
        [ForceLimit, Units],
        CTerm::force("limited($half_difference_N_s_per_m * fabsf(v), FORCE_LIMIT)")
    )
};

/// `c·v·abs(v)`.
pub static QUADRATIC_DRAG: Form = Form {
    id: "quadratic_drag",
    keys: &[("drag_N_s2_per_m2", Any)],
    example: &[40.0],
    of_speed: true,
    ..library!(
        QuadraticDrag(drag),
        [ForceLimit, Units],
        CTerm::force("limited($drag_N_s2_per_m2 * (v * fabsf(v)), FORCE_LIMIT)")
    )
};

/// `m = 1 + a·exp(−(abs(v)/v_s)^δ)`.
pub static STRIBECK: Form = Form {
    id: "stribeck",
    keys: &[
        ("level", LEVEL),
        ("velocity_m_s", Positive),
        ("exponent", Between(1.0, 4.0)),
    ],
    example: &[0.3, 5e-3, 2.0],
    ..library!(
        Stribeck(level, velocity, exponent),
        [Units],
        CTerm::level("$level * stribeck(v, $velocity_m_s, $exponent)")
    )
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
    example: &[0.2, 5e-3, 1.0, 0.02],
    ..library!(FrictionalLag(level, velocity, exponent, time), [SampleTime, Units], CTerm::level("@").remembers(Memory {
            kind: "float",
            at_rest: "$level",
            next: "@ - expm1f(-SAMPLE_TIME_S / $time_constant_s) * ($level * stribeck(v, $velocity_m_s, $exponent) - @)",
        }))
};

/// `κ·(x − x0)`.
pub static POSITION_SPRING: Form = Form {
    id: "position_spring",
    keys: &[("stiffness_N_per_m", Any), ("centre_m", Any)],
    example: &[12.0, 1.0 / 3.0],
    ..library!(
        PositionSpring(stiffness, centre),
        [ForceLimit, Units],
        CTerm::force("limited($stiffness_N_per_m * (x - $centre_m), FORCE_LIMIT)").placed()
    )
};

/// `Σ c_j·cos(jπu)`, `u = (x − from)/(to − from)` in 0…1.
pub static POSITION_FORCE: Form = Form {
    id: "position_force",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*_N", Any)],
    example: &[-0.01, 0.02, 0.1, 0.0, -0.05],
    library: |effect, _| {
        let [from, to] = effect.numbers();
        term(PositionForce::try_new(
            from,
            to,
            effect.padded_cosines(),
            Units::SI,
        ))
    },
    controller: built(
        "PositionForce",
        &[Argument::Units],
        CTerm::force("cosines((x - $from_m) / ($to_m - $from_m), $cosines)").placed(),
    ),
    ..BARE
};

/// `m = 1 + Σ c_j·cos(jπu)`.
pub static POSITION_FRICTION: Form = Form {
    id: "position_friction",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*", LEVEL)],
    example: &[-0.01, 0.02, 0.1, 0.05],
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
    example: &[0.5, 4e-3, 1e-3],
    ..library!(
        LocalFrictionSpot(level, position, width),
        [Units],
        CTerm::level("$level * spot((x - $position_m) / $width_m)").placed()
    )
};

/// `A·cos(2πx/p + φ)`.
pub static PERIODIC_FORCE: Form = Form {
    id: "periodic_force",
    keys: &[("force_N", Any), ("period_m", Positive), ("phase_rad", Any)],
    example: &[0.05, 1.3e-3, 0.4],
    ..library!(
        PeriodicForce(force, period, phase),
        [Units],
        CTerm::force("$force_N * wave(x, $period_m, $phase_rad)").placed()
    )
};

/// `m = 1 + a·cos(2πx/p + φ)`.
pub static PERIODIC_FRICTION: Form = Form {
    id: "periodic_friction",
    keys: &[("level", LEVEL), ("period_m", Positive), ("phase_rad", Any)],
    example: &[0.1, 2e-3, -1.0],
    ..library!(
        PeriodicFriction(level, period, phase),
        [Units],
        CTerm::level("$level * wave(x, $period_m, $phase_rad)").placed()
    )
};

/// Measured `= x + e·cos(2πx/p + φ)`.
pub static ENCODER_ERROR: Form = Form {
    id: "encoder_error",
    keys: &[("error_m", Any), ("period_m", Positive), ("phase_rad", Any)],
    example: &[2e-6, 1e-4, 0.7],
    library: |effect, _| {
        encoder(effect)?;
        Ok(None)
    },
    controller: built(
        "EncoderError",
        &[Argument::Units],
        CTerm::shift("-$error_m * wave(x, $period_m, $phase_rad)"),
    ),
    ..BARE
};

/// `A·sin(q − q0)`, rotary axes only.
pub static GRAVITY: Form = Form {
    id: "gravity",
    keys: &[("force_N", Any), ("angle_rad", Any)],
    example: &[3.31, 0.2],
    // The same code with other constants.
    cost: Some("periodic_force"),
    ..library!(
        Gravity(force, angle),
        [Units],
        CTerm::force("$force_N * limited(sinf(x - $angle_rad), 1.0f)").placed()
    )
};

/// `A·sin(2πft + φ)`.
pub static EXTERNAL_VIBRATION: Form = Form {
    id: "external_vibration",
    keys: &[
        ("force_N", Any),
        ("frequency_Hz", Positive),
        ("phase_rad", Any),
    ],
    example: &[0.1, 17.0, 0.3],
    library: |effect, sample_time| {
        let [force, frequency, phase] = effect.numbers();
        term(ExternalVibration::try_new(
            force,
            frequency,
            phase,
            sample_time,
            Units::SI,
        ))
    },
    controller: Err(
        "its phase is that of the recording's clock, which the controller does not know",
    ),
    ..BARE
};

/// The force is recorded `τ` after the motion.
pub static CHANNEL_DELAY: Form = Form {
    id: "channel_delay",
    keys: &[("delay_s", Any)],
    example: &[2.5e-3],
    controller: Err("it belongs to the recording: the force was sampled later than the position"),
    ..BARE
};

/// The load on a spring behind the motor with the encoder, `ω = 2πf = √(4k/M)`.
pub static DRIVE_COMPLIANCE: Form = Form {
    id: "drive_compliance",
    keys: &[("frequency_Hz", Positive)],
    example: &[60.0],
    controller: Err("it needs the second derivative of the friction force"),
    ..BARE
};

/// A play of the whole width `gap` between motor and load.
pub static BACKLASH: Form = Form {
    id: "backlash",
    keys: &[("gap_m", NotNegative)],
    example: &[1e-4],
    controller: Err("crossing the gap takes a move of the motor, not a force"),
    ..BARE
};

/// `m = 1 + β·(T − T0)`.
pub static THERMAL_DRIFT: Form = Form {
    id: "thermal_drift",
    keys: &[("level_per_K", Any), ("temperature_C", Any)],
    example: &[-0.02, 20.0],
    needs: Some((
        Column::Temperature,
        "thermal_drift with level and time_constant_s",
    )),
    ..library!(
        ThermalDrift(level, temperature),
        [LevelLimit],
        CTerm::level("slope(temperature, $temperature_C, $level_per_K)")
    )
};

/// `m = 1 + a·exp(−t/τ)`: the other set of keys of `thermal_drift`.
pub static WARM_UP: Form = Form {
    id: "thermal_drift",
    keys: &[("level", LEVEL), ("time_constant_s", Positive)],
    example: &[0.2, 1.5],
    cost: Some("warm_up"),
    ..library!(
        WarmUp(level, time),
        [SampleTime],
        CTerm::level("$level * expf(-(float)@ * (SAMPLE_TIME_S / $time_constant_s))").remembers(
            // Ticks: seconds in single precision stand still.
            Memory {
                kind: "uint32_t",
                at_rest: "0u",
                next: "@ < UINT32_MAX ? @ + 1u : @",
            },
        )
    )
};

/// `m = 1 + a·exp(−s/λ)`.
pub static RUN_IN: Form = Form {
    id: "run_in",
    keys: &[("level", LEVEL), ("path_m", Positive)],
    example: &[0.2, 0.05],
    library: |effect, sample_time| {
        let [level, path] = effect.numbers();
        term(RunIn::try_new(level, path, sample_time, Units::SI))
    },
    controller: Err(
        "it counts from the first sample of the recording and would begin anew whenever the controller starts",
    ),
    ..BARE
};

/// `m = 1 + a·log10(1 + θ/τ)`, `dθ/dt = 1 − abs(v)·θ/λ`.
pub static DWELL_AGING: Form = Form {
    id: "dwell_aging",
    keys: &[
        ("level_per_decade", Within(1.0)),
        ("time_constant_s", Positive),
        ("erasing_path_m", Positive),
    ],
    example: &[0.05, 0.1, 1e-4],
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
    example: &[0.01, 30.0],
    needs: Some((Column::Load, "a constant friction level")),
    ..library!(
        LoadDependentFriction(level, load),
        [LevelLimit, Units],
        CTerm::level("slope(load, $load_N, $level_per_N)")
    )
};

/// `μ·abs(T)` in the direction of friction, `T` what a gear transmits: the other set of keys of `load_dependent_friction`.
pub static TRANSMITTED_FRICTION: Form = Form {
    id: "load_dependent_friction",
    keys: &[
        ("share_of_transmitted", Between(0.0, MOST_LOST)),
        ("motor_mass_kg", NotNegative),
    ],
    example: &[0.3, 0.4],
    controller: Err(
        "the controller's library has no friction of what a gear transmits yet; without it the friction of an unloaded gear is left",
    ),
    ..BARE
};

/// Command `= F/(1 + a·cos(2πx/p + φ))`.
pub static TORQUE_RIPPLE: Form = Form {
    id: "torque_ripple",
    keys: &[
        ("share", Within(MOST_RIPPLE)),
        ("period_m", Positive),
        ("phase_rad", Any),
    ],
    example: &[0.1, 1.7e-3, 0.6],
    controller: Err(
        "it is a property of the drive: divide the command by 1 + share·cos(2π·position/period + phase)",
    ),
    ..BARE
};

/// Command `= F + ½·width·sgn F`.
pub static ACTUATOR_DEAD_ZONE: Form = Form {
    id: "actuator_dead_zone",
    keys: &[("width_N", NotNegative)],
    example: &[0.2],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};

/// `F` held within ± limit.
pub static ACTUATOR_SATURATION: Form = Form {
    id: "actuator_saturation",
    keys: &[("limit_N", Positive)],
    example: &[0.7],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};

/// Displacement less `rate·T_s·sinh(F/(share·F_limit))`.
pub static CREEP: Form = Form {
    id: "creep",
    keys: &[("rate_m_s", NotNegative), ("share_of_breakaway", Positive)],
    example: &[1e-3, 1.0],
    controller: Err("its feed-forward would push a resting axis"),
    ..BARE
};
