//! What only the host can do: delay, compliance, backlash and creep.

use super::*;

/// What only the host can do.
#[test]
fn mechanics_and_channels() {
    let [t, x, v, a] = sine();
    let rest = |i: usize| 2.0 * a[i] + 3.0 * v[i] + 0.05;
    let w = TAU * 0.9;
    // A spring instead of friction: everything is smooth and linear.
    let spring = FrictionModel::maxwell_slip(&[100.0], &[1.0]);
    let force = |t: f64, x0: f64| {
        let (sin, cos) = (w * t).sin_cos();
        100.0 * (0.005 + 0.01 * sin - x0) - 0.02 * w * w * sin + 0.03 * w * cos + 0.05
    };
    // The second piece goes on from the deflection of the first: its displacement starts anew.
    let origin = |i: usize| {
        if i < 2000 {
            x[0]
        } else {
            x[0] + x[2000] - x[1999]
        }
    };
    let plain = along(vec![], spring.clone());
    let off = difference(&plain, 0, |i| force(t[i], origin(i)));
    assert!(off < 1e-9, "{off:e}");

    let ripple = example(&form::TORQUE_RIPPLE);
    let rippled = along(vec![ripple], spring.clone());
    let given = |i: usize| 1.0 + 0.1 * (TAU * x[i] / 1.7e-3 + 0.6).cos();
    let off = difference(&rippled, 0, |i| force(t[i], origin(i)) / given(i));
    assert!(off < 1e-9, "ripple {off:e}");

    let late = along(vec![example(&form::CHANNEL_DELAY)], spring.clone());
    let off = difference(&late, 4, |i| force(t[i] - 2.5e-3, origin(i)));
    assert!(off < 1e-4, "delay {off:e}");
    assert!(difference(&late, 4, |i| force(t[i], origin(i))) > 3e-3);

    // Behind a spring k = ω²·M/4 the load is at x − F_t/k, F_t = M/2·a + F; in a sine that scales the motion of load and
    // spring: F falls by 100 N/m·(F_t − F_t(0))/k, and −F_t''·(M/2)/k = 2·(w/ω)²·(F_t − mean) is added.
    let soft = along(vec![example(&form::DRIVE_COMPLIANCE)], spring);
    let omega = TAU * 60.0;
    let k = omega * omega * 0.5;
    let off = difference(&soft, 7, |i| {
        let transmitted = |i: usize| a[i] + 100.0 * (x[i] - origin(i));
        let mean = 100.0 * (0.005 - origin(i));
        let start = if i < 2000 {
            0.0
        } else {
            transmitted(1999) - transmitted(2000)
        };
        let first = a[0];
        let sprung = 2.0 * (w / omega).powi(2) * (transmitted(i) - mean);
        force(t[i], origin(i)) - 100.0 * (transmitted(i) + start - first) / k + sprung
    });
    assert!(off < 1e-4, "compliance {off:e}");

    // A play of 0.1 mm: after each turn friction is used up at once, and nothing is transmitted for that distance.
    let stop = FrictionModel::maxwell_slip(&[1e6], &[8e-7]);
    let play = along(vec![example(&form::BACKLASH)], stop.clone());
    let mut crossed = Vec::new();
    for i in 1..4000 {
        if i % 2000 != 0 && v[i].signum() != v[i - 1].signum() {
            let idle: Vec<usize> = (i..i + 200)
                .filter(|&n| n / 2000 == i / 2000 && (play[n] - rest(n)).abs() < 1e-3)
                .collect();
            if let (Some(from), Some(to)) = (idle.first(), idle.last()) {
                crossed.push((x[*from] - x[*to]).abs());
            }
        }
    }
    assert!(crossed.len() >= 5, "{crossed:?}");
    for gap in crossed {
        assert!((0.7e-4..1.02e-4).contains(&gap), "{gap:e}");
    }
    // Without friction left over: the same force as without a play, away from the turns.
    let bare = along(vec![], stop);
    assert!(difference(&play, 100, |i| bare[i]) < 1e-9);

    // Held under load, a block of stiffness k relaxes by dF/dt = −k·rate·sinh(F/F_limit):
    // tanh(F/(2·F_limit)) falls exponentially with F_limit/(k·rate) = 0.8 s.
    let model = Model {
        inertia: 0.0,
        viscous: 0.0,
        constant_force: 0.0,
        ..model(vec![example(&form::CREEP)])
    };
    let model = Model {
        friction: FrictionModel::maxwell_slip(&[1e3], &[8e-4]),
        ..model
    };
    let position: Vec<f64> = (0..2000).map(|i| if i == 0 { 0.0 } else { 4e-4 }).collect();
    let path = Path {
        position: &position,
        velocity: &vec![0.0; 2000],
        pieces: std::slice::from_ref(&(0..2000)),
        sample_time: STEP,
    };
    let force = model.resistance(path).expect("bounded");
    for (i, f) in force.iter().enumerate().skip(1) {
        let share = (0.25_f64).tanh() * (-(i as f64 - 1.0) * STEP / 0.8).exp();
        let wanted = 2.0 * 0.8 * share.atanh();
        assert!((f - wanted).abs() < 1e-3, "{i}: {f} {wanted}");
    }
    let lugre = FrictionModel::LuGre {
        stiffness: 1e5,
        damping: 300.0,
        breakaway: 0.9,
        sliding: preslide::Sliding::none(0.9),
    };
    let error = Model {
        friction: lugre,
        ..model
    }
    .resistance(path)
    .expect_err("unbounded");
    assert!(error.contains("creep"), "{error}");
}
