//! What happens at some time and not otherwise.

use super::*;

/// Share and deviations of the events beside the core.
fn found_in(recording: &Recording) -> Option<(f64, f64)> {
    let null = null(recording);
    let alone = null.fit(&[]).expect("a fit");
    let rows = &null.rows;
    let friction = rows.weak.at_centres(&null.baseline.friction);
    event::event(rows, &friction, &alone.held_out_residual(rows)).map(|e| (e.share, e.z))
}

#[test]
fn events_are_reported_with_times_and_without_names() {
    let times = [[6.1, 6.9], [14.2, 15.0], [23.4, 24.1]];
    let within = |t: f64| times.iter().any(|[from, to]| (*from..*to).contains(&t));
    // Half as much friction again while something lies in the guideway.
    let recording = made(|t, _, v| if within(t) { 1.5 * v.signum() } else { 0.0 });
    let found = diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
    assert_eq!(found.verdict, Verdict::UnknownPhysics);
    let unknown = found.unknown().expect("an event");
    let said = &unknown.happened.as_ref().expect("times").times;
    println!("{said:?} {} {}", unknown.size, unknown.evidence.z);
    assert!(unknown.odd && unknown.size > 0.8, "{}", unknown.size);
    assert_eq!(said.len(), times.len(), "{said:?}");
    for (said, is) in said.iter().zip(&times) {
        let off = (said[0] - is[0]).abs().max((said[1] - is[1]).abs());
        assert!(off < 0.2, "{said:?} {is:?}");
    }
}

#[test]
fn neither_recurring_forces_nor_noise_are_events() {
    assert_eq!(found_in(&made(|_, _, _| 0.0)), None);
    let spot = |x: f64| (-((x - 0.01) / 0.004).powi(2)).exp();
    assert_eq!(found_in(&made(|_, x, v| 1.5 * v.signum() * spot(x))), None);
    let is_told = |from: f64| {
        let once = made(|t, _, _| {
            if (0.0..0.6).contains(&(t - from)) {
                1.0
            } else {
                0.0
            }
        });
        found_in(&once).is_some()
    };
    // No event is reported where the axis moves as nowhere else.
    let told = (1..10).filter(|k| is_told(3.0 * f64::from(*k))).count();
    assert!(told >= 6, "{told} of 9");
}

#[test]
fn events_do_not_bias_permanent_effects() {
    let drag = |v: f64| 20.0 * v;
    let within = |t: f64| {
        [6.1, 14.2, 23.4]
            .iter()
            .any(|from| (0.0..0.8).contains(&(t - from)))
    };
    let chip = move |t: f64, v: f64| if within(t) { 1.5 * v.signum() } else { 0.0 };
    let value = |recording: &Recording| {
        let found = diagnose(recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
        let viscous = found.confident().find(|e| e.id() == "viscous");
        viscous.expect("viscous friction").parameters[0].1.value
    };
    let (alone, beside) = (
        value(&made(|_, _, v| drag(v))),
        value(&made(|t, _, v| drag(v) + chip(t, v))),
    );
    println!("{alone} {beside} N·s/m");
    assert!((alone / 20.0 - 1.0).abs() < 0.05, "{alone}");
    assert!((beside / alone - 1.0).abs() < 0.02, "{beside} {alone}");
}

/// To and fro within 30 s, once, at speeds that vary, with 3 N that turn round and a knock of 1 N that begins at a time.
fn to_and_fro(knock_s: f64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut text, mut x) = ("t_s,x_m,force_N\n".to_owned(), 0.0);
    for i in 0..15_000 {
        let t = f64::from(i) * STEP_S;
        let v = (0.02 + 0.01 * (2.0 * t).sin()) * (20.0 * (15.0 - t)).tanh();
        x += v * STEP_S;
        let knock = if (0.0..0.6).contains(&(t - knock_s)) {
            1.0
        } else {
            0.0
        };
        let noise = 0.02 * (uniform(&mut rng) - 0.5);
        let force = 3.0 * (20.0 * (15.0 - t)).tanh() + knock + noise;
        writeln!(text, "{t:.3},{x:.8},{force:.5}").expect("memory");
    }
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_only_reversal_causes_no_event() {
    // Nothing else moved like that, whatever it is.
    assert_eq!(found_in(&to_and_fro(15.3)), None);
    assert!(found_in(&to_and_fro(23.0)).is_some());
}
