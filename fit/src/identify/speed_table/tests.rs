//! Tables that are made, and a shared one.

use super::*;
use crate::recording::{EffortRole, LoadOptions, MotionKind, load_speeds};
use preslide_host_tests::shared;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

/// Thirty speeds each way, from 0.01 to 2 rad/s, with noise of that deviation.
fn speeds(seed: u64, noise: f64, effort: impl Fn(f64) -> f64) -> Speeds {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let one = (0..30).map(|i| 0.01 * 200f64.powf(f64::from(i) / 29.0));
    let velocity: Vec<f64> = one.flat_map(|v| [v, -v]).collect();
    // The sum of twelve uniform deviates has a variance of one.
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    Speeds {
        name: "table.csv".to_owned(),
        kind: MotionKind::Rotary,
        role: EffortRole::Torque,
        effort: velocity
            .iter()
            .map(|v| effort(*v) + noise * normal())
            .collect(),
        velocity,
        warnings: Vec::new(),
    }
}

fn plain(v: f64) -> f64 {
    0.572 * v.signum() + 0.522 * v + 0.012
}

fn stribeck(v: f64) -> f64 {
    plain(v) + 0.2 * v.signum() * (-(v / 0.08).powi(2)).exp()
}

/// Lubricants have exponents of one as well, whose curve reaches to where an exponent of two leaves viscous friction alone.
fn stribeck_of_one(v: f64) -> f64 {
    plain(v) + 0.4 * v.signum() * (-(v / 0.1).abs()).exp()
}

fn names(found: &SpeedTable) -> Vec<&str> {
    found.parameters.iter().map(|p| p.0).collect()
}

#[test]
fn intervals_hold_the_truth_and_no_curve_is_seen_where_there_is_none() {
    type Case = (fn(f64) -> f64, &'static [(&'static str, f64)]);
    let cases: [Case; 4] = [
        (
            plain,
            &[("coulomb", 0.572), ("viscous", 0.522), ("offset", 0.012)],
        ),
        (
            stribeck,
            &[
                ("coulomb", 0.572),
                ("viscous", 0.522),
                ("offset", 0.012),
                ("static", 0.772),
                ("stribeck_velocity", 0.08),
                ("stribeck_exponent", 2.0),
            ],
        ),
        (
            stribeck_of_one,
            &[
                ("coulomb", 0.572),
                ("viscous", 0.522),
                ("offset", 0.012),
                ("static", 0.972),
                ("stribeck_velocity", 0.1),
                ("stribeck_exponent", 1.0),
            ],
        ),
        (
            |v| plain(v) + 0.1 * v.abs(),
            &[
                ("coulomb", 0.572),
                ("viscous_forward", 0.622),
                ("viscous_backward", 0.422),
                ("offset", 0.012),
            ],
        ),
    ];
    for (law, truth) in cases {
        let expected: Vec<&str> = truth.iter().map(|t| t.0).collect();
        let (mut held, mut other) = (vec![0; truth.len()], 0);
        for seed in 0..200 {
            let found = fit(speeds(seed, 0.02, law), true).expect("a table");
            if names(&found) != expected {
                other += 1;
                continue;
            }
            for (held, ((_, e), (_, true_value))) in
                held.iter_mut().zip(found.parameters.iter().zip(truth))
            {
                let [low, high] = e.ci95.expect("an interval");
                *held += usize::from(low <= *true_value && *true_value <= high);
            }
        }
        println!(
            "{expected:?}: {held:?} of {} held, {other} others",
            200 - other
        );
        assert!(other <= 2, "{other} of another law");
        assert!(
            held.iter().all(|h| *h * 100 >= 91 * (200 - other)),
            "{held:?}"
        );
    }
}

#[test]
fn reports_one_direction_an_opposed_sign_and_rests() {
    let mut one = speeds(1, 1e-3, plain);
    let forward: Vec<bool> = one.velocity.iter().map(|v| *v > 0.0).collect();
    let mut flags = forward.iter().cycle();
    one.velocity.retain(|_| flags.next() == Some(&true));
    let mut flags = forward.iter().cycle();
    one.effort.retain(|_| flags.next() == Some(&true));
    let found = fit(one, true).expect("one way");
    assert_eq!(names(&found), ["coulomb_and_offset", "viscous"]);
    assert!((found.get("coulomb_and_offset").expect("a sum") - 0.584).abs() < 1e-3);
    assert!(found.notes().join(" ").contains("one direction"));

    let opposed = speeds(2, 1e-3, |v| -plain(v));
    let found = fit(opposed.clone(), true).expect("turned");
    assert!((found.get("coulomb").expect("a level") - 0.572).abs() < 1e-3);
    assert!(found.notes().join(" ").contains("--sign -1"));
    let model = found.model().expect("a model");
    assert!((model.viscous - 0.522).abs() < 1e-3 && model.inertia == 0.0);
    assert!(fit(opposed, false).expect("as it is").model().is_err());

    let mut rests = speeds(3, 1e-3, plain);
    rests.velocity.extend([0.0; 5]);
    rests.effort.extend([0.3; 5]);
    let found = fit(rests, true).expect("with rests");
    assert_eq!(found.fitted.len(), 60);
    assert!(found.notes().join(" ").contains("5 rows at zero speed"));
}

#[test]
fn uninformative_tables_say_why() {
    let with = |velocity: &[f64], effort: &[f64]| {
        let table = Speeds {
            velocity: velocity.to_vec(),
            effort: effort.to_vec(),
            ..speeds(0, 0.0, plain)
        };
        fit(table, true).map(|_| ()).expect_err("no table")
    };
    let eight = [1.0, 2.0, 3.0, 4.0, -1.0, -2.0, -3.0, -4.0];
    for (error, part) in [
        (with(&[0.0; 8], &eight), "no row has a speed"),
        (with(&[1.0; 8], &eight), "three speeds"),
        (with(&eight[..4], &eight[..4]), "4 rows"),
        (with(&eight, &[2.0; 8]), "the same in all rows"),
    ] {
        assert!(
            error.contains(part) && error.contains("table.csv"),
            "{error}"
        );
    }
    let noise = fit(speeds(4, 1.0, |_| 0.0), true).map(|_| ());
    assert!(
        noise
            .expect_err("noise")
            .contains("not a table of friction")
    );
}

#[test]
fn the_shared_table_of_a_joint_has_its_friction() {
    let Some(root) = shared("cases") else { return };
    let path = root.join("speed_torque_table.csv");
    let table = load_speeds(&path, &LoadOptions::default()).expect("readable");
    let found = fit(table.expect("a table"), true).expect("a fit");
    let truth = [("coulomb", 0.572), ("viscous", 0.522), ("offset", 0.012)];
    for ((name, e), (expected, right)) in found.parameters.iter().zip(truth) {
        let [low, high] = e.ci95.expect("an interval");
        assert_eq!(*name, expected);
        assert!(
            low <= right && right <= high && high - low < 0.05,
            "{name}: {e:?}"
        );
    }
    let json = found.to_json(0.0);
    let fit = &json["fit"];
    assert_eq!(
        (&fit["rows"], &fit["parameters"]),
        (&json!(50), &json["parameters"])
    );
    assert!(fit["parameters"]["viscous_Nm_s_per_rad"]["ci95"][0].is_number());
}
