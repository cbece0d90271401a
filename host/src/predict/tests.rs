use super::edmd::Moments;
use super::{AHEAD, Predictor, predict};
use nalgebra::DMatrix;
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, Needs, load_csv};
use preslide_fit::simulate::motion_with_inertia;
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::refusal::refuses;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

/// A linear system with more than one input is found to the last digits from what it does, whatever its columns' units.
#[test]
fn a_linear_system_is_recovered() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let a = DMatrix::from_row_slice(3, 3, &[0.9, 1e-4, 0.0, -50.0, 0.7, 0.1, 0.0, 0.2, 0.5]);
    let b = DMatrix::from_row_slice(3, 2, &[1e-5, 0.0, 0.3, 2.0, 0.0, -1.0]);
    let input = DMatrix::from_fn(2, 400, |_, _| rng.random_range(-1.0..1.0));
    let mut state = DMatrix::zeros(3, 401);
    for k in 0..400 {
        let next = &a * state.column(k) + &b * input.column(k);
        state.set_column(k + 1, &next);
    }
    let (now, next) = (state.columns(0, 400), state.columns(1, 400));
    let map = Moments::of(&now.into_owned(), &input, &next.into_owned())
        .map(0.0)
        .expect("it excites every state");
    let mut apart = Deviation::default();
    for (found, kept) in (map.a.iter().zip(&a)).chain(map.b.iter().zip(&b)) {
        let unit = kept.abs().max(1e-5);
        apart.add(found / unit, kept / unit);
    }
    // Normal equations square the states' condition; the entry of 10⁻⁵ feels it.
    apart.assert_within("entries of the map", 1e-6, 1e-6, 1e-6);
}

/// Two blocks on a mass, driven by sines of the force that break away and turn within their hysteresis.
fn machine() -> String {
    let model = Model::parse(
        r#"
schema = "preslide.model/1"
motion = "linear"
[inertia]
mass_kg = 4.0
[friction]
kind = "gms"
breakaway_N = 1.0
blocks = [ { stiffness_N_per_m = 40000.0, weight = 0.6 }, { stiffness_N_per_m = 5000.0, weight = 0.4 } ]
viscous_N_s_per_m = 60.0
"#,
    )
    .expect("valid");
    let force = |t: f64| 0.9 * (19.0 * t).sin() + 0.7 * (5.3 * t).sin() + 0.3 * (71.0 * t).sin();
    let rows: String = (0..15_000)
        .map(|i| format!("{},{:e}\n", i as f64 * 1e-3, force(i as f64 * 1e-3)))
        .collect();
    let options = LoadOptions {
        needs: Needs::Effort,
        ..LoadOptions::default()
    };
    let text = format!("t_s,force_N\n{rows}");
    let driven = load_csv(text.as_bytes(), "force.csv", &options).expect("valid");
    let moved = motion_with_inertia(&model, &driven, 1).expect("it moves");
    let mut text = "t_s,x_m,force_N\n".to_owned();
    for ((t, x), f) in moved.t_s.iter().zip(&moved.position).zip(&moved.force) {
        let _ = writeln!(text, "{t},{x:e},{f:e}");
    }
    text
}

/// On a machine that is a mass and blocks, the lift with the blocks errs less than the same without in the next sample; no map that is
/// linear knows when they slip, so that from ten samples on the model that is the machine errs less than any.
#[test]
fn blocks_see_the_next_sample_and_the_machine_itself_the_next_second() {
    let recording = load_csv(machine().as_bytes(), "machine.csv", &LoadOptions::default());
    let recording = recording.expect("valid");
    let found = predict(&recording, &Progress::new("test", super::STEPS)).expect("it tells");
    println!(
        "{}{}",
        found.table(&recording).to_text(),
        found.recommendation()
    );
    let of = |name: &str| -> &Predictor {
        let named = found.predictors.iter().find(|p| p.name.starts_with(name));
        named.expect("fitted")
    };
    let (arx, blocks, gms) = (of("ARX"), of("Koopman, blocks"), of("GMS"));
    assert!(blocks.told[0] < 0.5 * arx.told[0], "{blocks:?} {arx:?}");
    for linear in found.predictors.iter().filter(|p| p.lift.is_some()) {
        for (i, ahead) in AHEAD.into_iter().enumerate().skip(1) {
            assert!(gms.told[i] < linear.told[i], "{ahead}: {gms:?} {linear:?}");
        }
    }
    let json = found.to_json(&recording, 0.0);
    assert_eq!(json["predicted"], "position");
    assert_eq!(
        json["predictors"][0]["rms_m"].as_array().map(Vec::len),
        Some(4)
    );
}

#[test]
fn a_recording_that_is_too_short_says_how_long_it_must_be() {
    let text: String = (0..2000)
        .map(|i| {
            format!(
                "{},{},{}\n",
                i as f64 * 1e-3,
                (i as f64 * 0.01).sin(),
                i % 7
            )
        })
        .collect();
    let text = format!("t_s,x_m,force_N\n{text}");
    let recording = load_csv(text.as_bytes(), "short.csv", &LoadOptions::default());
    refuses(
        predict(
            &recording.expect("valid"),
            &Progress::new("test", super::STEPS),
        ),
        &["short.csv", "record at least"],
    );
}
