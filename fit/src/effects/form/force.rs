//! What pushes: forces of speed, place and time.

use super::Range::{Any, Positive};
use super::{Argument, BARE, CTerm, FAR, Form, built, term};
use preslide::Units;
use preslide::effects::{
    ConstantForce, ExternalVibration, Gravity, PeriodicForce, PositionForce, PositionSpring,
    QuadraticDrag, ViscousAsymmetry,
};

/// `F0`.
pub static CONSTANT_FORCE: Form = Form {
    id: "constant_force",
    keys: &[("force_N", Any)],
    library: |effect, _| term(ConstantForce::try_new(effect.get("force_N"), Units::SI)),
    controller: built(
        "ConstantForce",
        &[Argument::Units],
        CTerm::force("$force_N"),
    ),
    ..BARE
};

/// `b·v`, which a model file has among the keys of `[friction]`.
pub static VISCOUS: Form = Form {
    id: "viscous",
    keys: &[("viscous_N_s_per_m", Any)],
    controller: built(
        "Viscous",
        &[Argument::ForceLimit, Argument::Units],
        CTerm::force("limited($viscous_N_s_per_m * v, FORCE_LIMIT)"),
    ),
    ..BARE
};

/// `d·abs(v)`: viscous friction is `viscous + d` forwards and `viscous − d` backwards.
pub static VISCOUS_ASYMMETRY: Form = Form {
    id: "viscous_asymmetry",
    keys: &[("half_difference_N_s_per_m", Any)],
    library: |effect, _| {
        term(ViscousAsymmetry::try_new(
            effect.get("half_difference_N_s_per_m"),
            FAR,
            Units::SI,
        ))
    },
    controller: built(
        "ViscousAsymmetry",
        &[Argument::ForceLimit, Argument::Units],
        CTerm::force("limited($half_difference_N_s_per_m * fabsf(v), FORCE_LIMIT)"),
    ),
    ..BARE
};

/// `c·v·abs(v)`.
pub static QUADRATIC_DRAG: Form = Form {
    id: "quadratic_drag",
    keys: &[("drag_N_s2_per_m2", Any)],
    library: |effect, _| {
        term(QuadraticDrag::try_new(
            effect.get("drag_N_s2_per_m2"),
            FAR,
            Units::SI,
        ))
    },
    controller: built(
        "QuadraticDrag",
        &[Argument::ForceLimit, Argument::Units],
        CTerm::force("limited($drag_N_s2_per_m2 * (v * fabsf(v)), FORCE_LIMIT)"),
    ),
    ..BARE
};

/// `κ·(x − x0)`.
pub static POSITION_SPRING: Form = Form {
    id: "position_spring",
    keys: &[("stiffness_N_per_m", Any), ("centre_m", Any)],
    library: |effect, _| {
        let [stiffness, centre] = effect.numbers();
        term(PositionSpring::try_new(stiffness, centre, FAR, Units::SI))
    },
    controller: built(
        "PositionSpring",
        &[Argument::ForceLimit, Argument::Units],
        CTerm::force("limited($stiffness_N_per_m * (x - $centre_m), FORCE_LIMIT)").placed(),
    ),
    ..BARE
};

/// `Σ c_j·cos(jπu)`, `u = (x − from)/(to − from)` in 0…1.
pub static POSITION_FORCE: Form = Form {
    id: "position_force",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*_N", Any)],
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

/// `A·cos(2πx/p + φ)`.
pub static PERIODIC_FORCE: Form = Form {
    id: "periodic_force",
    keys: &[("force_N", Any), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        let [force, period, phase] = effect.numbers();
        term(PeriodicForce::try_new(force, period, phase, Units::SI))
    },
    controller: built(
        "PeriodicForce",
        &[Argument::Units],
        CTerm::force("$force_N * wave(x, $period_m, $phase_rad)").placed(),
    ),
    ..BARE
};

/// `A·sin(q − q0)`, rotary axes only.
pub static GRAVITY: Form = Form {
    id: "gravity",
    keys: &[("force_N", Any), ("angle_rad", Any)],
    library: |effect, _| {
        let [force, angle] = effect.numbers();
        term(Gravity::try_new(force, angle, Units::SI))
    },
    controller: built(
        "Gravity",
        &[Argument::Units],
        CTerm::force("$force_N * limited(sinf(x - $angle_rad), 1.0f)").placed(),
    ),
    // The same code with other constants.
    cost: Some("periodic_force"),
    ..BARE
};

/// `A·sin(2πft + φ)`.
pub static EXTERNAL_VIBRATION: Form = Form {
    id: "external_vibration",
    keys: &[
        ("force_N", Any),
        ("frequency_Hz", Positive),
        ("phase_rad", Any),
    ],
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
