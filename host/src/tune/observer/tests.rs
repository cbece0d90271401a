use super::{DEMANDS, Known, cases, propose, take_mass};
use crate::paper;
use preslide::control::{Axis, ObserverSettings};
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;

/// The paper's axis on the simulated stage: ten blocks of Table 3, a mode of 368 Hz damped by 5 %.
fn known() -> Known {
    Known {
        motion: MotionKind::Linear,
        noise: 0.0,
        breakaway: 0.9,
        contact: (paper::REFERENCE.blocks.iter()).map(|block| block.0).sum(),
        mode_hz: 368.0,
        mode_damping: 0.05,
    }
}

/// Every case is borne: sliding and sticking contacts, as given and 15 % off, each with 1 kg more, with a tick of delay, with both.
#[test]
fn the_paper_axis_has_its_proposal_and_margins() {
    let proposal = propose(&Axis::PAPER_AXIS, &known(), &DEMANDS).expect("it has one");
    assert_eq!(proposal.cases.len(), 16);
    for (case, margins) in &proposal.cases {
        assert!(margins.reach(&DEMANDS), "{}: {margins:?}", case.name);
    }
    let (found, kept) = (proposal.settings, ObserverSettings::PAPER_AXIS);
    // A small joint's gains keep their digits, too.
    let mut small = proposal.clone();
    (small.settings.disturbance, small.settings.braking) = (2.6249, 2.5e-5);
    let words = small.recommendation();
    assert!(
        words.contains("disturbance: 2.6249") && words.contains("braking: 2.5e-5"),
        "{words}"
    );
    for (name, found, kept) in [
        ("position", found.position, kept.position),
        ("velocity", found.velocity, kept.velocity),
        ("disturbance", found.disturbance, kept.disturbance),
        ("mass", found.mass, kept.mass),
        ("braking", found.braking, kept.braking),
        ("limit", found.limit, kept.limit),
        ("top speed", found.top_speed, kept.top_speed),
    ] {
        // Five digits are kept.
        assert!((found / kept - 1.0).abs() < 1e-4, "{name}: {found} {kept}");
    }
}

/// The gain margin by the closed loop's poles: a machine of a gain just below it is stable, one just above is not. A machine whose
/// mass, braking and stiffness are divided by a factor has its gain multiplied by it.
#[test]
fn gain_margins_are_where_the_poles_leave_the_unit_circle() {
    let proposal = propose(&Axis::PAPER_AXIS, &known(), &DEMANDS).expect("it has one");
    let feedback = proposal.feedback();
    for (case, margins) in &proposal.cases {
        let stable = |factor: f64| {
            let mut machine = case.machine;
            machine.mass /= factor;
            machine.braking /= factor;
            machine.contact /= factor;
            feedback.margins(&machine).radius < 1.0
        };
        let name = &case.name;
        // Between two of the frequencies looked at, gains differ by up to 2 %.
        assert!(stable(0.97 * margins.gain), "{name}: {margins:?}");
        assert!(!stable(1.03 * margins.gain), "{name}: {margins:?}");
        if margins.reduction.is_finite() {
            assert!(stable(1.03 / margins.reduction), "{name}: {margins:?}");
            assert!(!stable(0.97 / margins.reduction), "{name}: {margins:?}");
        }
    }
}

/// A mode that is lower or less damped leaves room for a slower filter only; where none is left, it says so.
#[test]
fn the_mode_decides_how_fast_it_may_be() {
    let walk = |mode_hz, mode_damping| {
        let known = Known {
            mode_hz,
            mode_damping,
            contact: 0.0,
            ..known()
        };
        propose(&Axis::PAPER_AXIS, &known, &DEMANDS).map(|proposal| proposal.belief.walk)
    };
    let as_it_is = walk(368.0, 0.05).expect("it has one");
    assert!(walk(368.0, 0.03).expect("it has one") < as_it_is);
    assert!(walk(300.0, 0.05).expect("it has one") < as_it_is);
    assert!(walk(600.0, 0.05).expect("it has one") > as_it_is);
    let error = walk(60.0, 0.02).expect_err("a mode at the crossover");
    assert!(error.contains("60 Hz"), "{error}");
}

/// The mass is the model's, where it has one; what is not of the model's kind of axis or no force is refused.
#[test]
fn the_mass_is_the_models_and_the_axis_of_its_kind() {
    let of = |motion, inertia, effort_unit, screw_lead| {
        let model = Model {
            inertia,
            effort_unit,
            ..Model::of_friction(motion, FrictionModel::Coulomb { coulomb: 1.0 })
        };
        let mut axis = Axis::PAPER_AXIS;
        axis.motor.screw_lead = screw_lead;
        take_mass(&mut axis, &model, "my.toml").map(|said| (axis.feed_forward.mass, said))
    };
    let (linear, turns) = (MotionKind::Linear, std::f64::consts::TAU);
    for (inertia, mass, part) in [
        (
            12.5,
            12.5,
            "12.5 kg (feed_forward.mass of my.toml is 4.05 kg: correct it)",
        ),
        (4.2, 4.2, "4.20 kg; gains"),
        (0.0, 4.05, "no inertia"),
    ] {
        let found = of(linear, inertia, None, 2e-3).expect("usable");
        assert!(found.0 == mass && found.1.contains(part), "{found:?}");
    }
    let rotary = of(MotionKind::Rotary, 3e-4, None, turns).expect("usable");
    assert!(rotary.1.contains("0.000300 kg·m²"), "{rotary:?}");
    for (refused, part) in [
        (of(MotionKind::Rotary, 3e-4, None, 2e-3), "is rotary"),
        (of(linear, 3.0, None, turns), "is linear"),
        (of(linear, 3.0, Some("A"), 2e-3), "forces are in A"),
    ] {
        let reason = refused.expect_err("not usable");
        assert!(reason.contains(part), "{reason}");
    }
    // A kilogram is no payload of what turns.
    let known = Known {
        motion: MotionKind::Rotary,
        ..known()
    };
    let heaviest = cases(&Axis::PAPER_AXIS, &known)
        .into_iter()
        .map(|case| case.machine.mass);
    let heaviest = heaviest.fold(0.0, f64::max);
    assert!((heaviest / 4.05 - 1.25).abs() < 1e-12, "{heaviest}");
}
