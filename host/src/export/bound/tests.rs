use super::*;
use crate::export::{C, c_source, rust_source};
use preslide_fit::friction::FrictionModel;
use preslide_fit::kernel::Kernel;
use preslide_fit::recording::{LoadOptions, Needs, load_csv};
use std::fmt::Write as _;

/// 1 N of friction and one term that has a bound.
fn model(term: &Effect) -> Model {
    let friction = FrictionModel::Gms {
        breakaway: 1.0,
        blocks: vec![preslide::Block {
            stiffness: 1e5,
            weight: 1.0,
        }],
        sliding: None,
    };
    let mut model = Model::of_friction(MotionKind::Linear, friction);
    match term.is(&form::VISCOUS) {
        true => model.viscous = term.get("viscous_N_s_per_m"),
        false => model.effects.push(term.clone()),
    }
    model
}

/// ±10 mm at 1 Hz: 62.8 mm/s; 20 to 50 °C, 0 to 40 N.
fn recording() -> Recording {
    let mut text = "t_s,x_m,temperature_C,load_N\n".to_owned();
    for i in 0..4000 {
        let t = f64::from(i) * 1e-3;
        let x = 0.01 * (std::f64::consts::TAU * t).sin();
        writeln!(text, "{t},{x},{},{}", 20.0 + 7.5 * t, 10.0 * t).expect("a string");
    }
    let options = LoadOptions {
        needs: Needs::Motion,
        ..LoadOptions::default()
    };
    load_csv(text.as_bytes(), "made.csv", &options).expect("a recording")
}

/// Of every form with a bound: values of its keys, its largest on [`recording`], and where the default bound cuts it.
fn table() -> Vec<(Effect, f64, f64)> {
    vec![
        (Effect::of(&form::VISCOUS, &[300.0]), 18.85, 10.0 / 300.0),
        (
            Effect::of(&form::VISCOUS_ASYMMETRY, &[-300.0]),
            18.85,
            10.0 / 300.0,
        ),
        (Effect::of(&form::QUADRATIC_DRAG, &[4000.0]), 15.79, 0.05),
        (
            Effect::of(&form::POSITION_SPRING, &[2000.0, 0.002]),
            24.0,
            0.005,
        ),
        (Effect::of(&form::THERMAL_DRIFT, &[0.02, 20.0]), 0.6, 25.0),
        (
            Effect::of(&form::LOAD_DEPENDENT_FRICTION, &[-0.02, 0.0]),
            0.8,
            25.0,
        ),
    ]
}

fn value_of(model: &Model, options: &Options) -> f64 {
    bounds(model, options).expect("a bound")[0].value
}

#[test]
fn a_bound_holds_what_a_recording_shows_and_says_where_the_default_cuts() {
    let recording = recording();
    let table = table();
    let with_a_bound = form::ALL.iter().copied().chain([&form::VISCOUS]);
    for form in with_a_bound.filter(|form| bounded(&Effect::of(form, form.example)).is_some()) {
        assert!(
            table.iter().any(|row| row.0.is(form)),
            "{form:?} has no row here"
        );
    }
    for (term, largest, cut) in table {
        let (model, id) = (model(&term), term.id());
        let default = bounds(&model, &Options::default())
            .expect("a bound")
            .remove(0);
        let found = default.cuts[0].distance;
        assert!((found / cut - 1.0).abs() < 1e-9, "{id}: cut at {found}");
        let said = default.said_with_remedy();
        assert!(said.contains(id) && said.contains("--recording"), "{said}");
        let seen = reached(&model, &recording).expect("valid");
        // Of the exact derivative; the zero-phase filter's ends may swing.
        let found = seen[0].largest;
        assert!(
            (found / largest - 1.0).abs() < 0.05,
            "{id}: {found} at most"
        );
        let options = Options {
            reached: seen,
            ..Options::default()
        };
        assert_eq!(value_of(&model, &options), 2.0 * found, "{id}");
        let source = rust_source(&model, &options).expect("exportable");
        assert!(source.contains("twice the largest"), "{source}");
    }
}

#[test]
fn a_limit_that_cuts_on_a_recording_is_refused_with_the_one_that_holds() {
    let model = model(&Effect::of(&form::POSITION_SPRING, &[2000.0, 0.002]));
    let reached = reached(&model, &recording()).expect("valid");
    let of = |limit| {
        let reached = reached.clone();
        bounds(
            &model,
            &Options {
                limit: Some(limit),
                reached,
                ..Options::default()
            },
        )
    };
    let refused = of(5.0).expect_err("it cuts");
    for part in ["position_spring", "24.0 N", "--limit 24 holds it"] {
        assert!(refused.contains(part), "{refused}");
    }
    assert_eq!(of(25.0).expect("it holds")[0].value, 25.0);
}

/// The power of ten of forces makes room for a bound far above the breakaway force.
#[test]
fn whole_numbers_hold_what_a_recording_shows() {
    let model = model(&Effect::of(&form::VISCOUS, &[3000.0]));
    let options = Options {
        reached: reached(&model, &recording()).expect("valid"),
        rate: Some(1e4),
        count: Some(1e-7),
        kernel: Some(Kernel::SlipReserve),
        ..Options::default()
    };
    let C { header, .. } = c_source(&model, &options, "stage").expect("it fits");
    assert!(header.contains("#define STAGE_FORCE_N 0.1f"), "{header}");
    assert!(
        header.contains("Force bound 377 N (twice the largest"),
        "{header}"
    );
}
