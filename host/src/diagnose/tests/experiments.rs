//! Motions that a diagnosis asks for.

use super::*;
use crate::diagnose::experiment::Experiment;

/// Each doubt gets one experiment, with motions that the recorded machine can follow.
#[test]
fn plans_one_experiment_a_doubt_that_the_axis_can_follow() {
    let recording = made(|_, x, v| 8.0 * v + 0.5 * (x / 8e-4).sin());
    let found = diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
    let s = &found.null.rows.s;
    let (low, high) = preslide_fit::statistics::bounds(&s.x);
    let steepest = s.a.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
    let stated: Vec<&str> = found.confident().map(|e| e.id()).collect();
    let mut asked: Vec<String> = Vec::new();
    while let Some(next) = Experiment::next(&found, &asked) {
        println!("{}", next.words());
        assert!(!next.about.is_empty() && next.seconds() > 1.0 && next.seconds() < 600.0);
        for id in &next.about {
            assert!(!stated.contains(id), "{id} is known");
            assert!(!asked.iter().any(|a| a == id), "{id} was asked");
        }
        let within = next.x.iter().all(|x| (low..=high).contains(x));
        assert!(within, "it leaves the travel");
        let speeds: Vec<f64> = next.x.windows(2).map(|p| (p[1] - p[0]) / 1e-3).collect();
        let fastest = speeds.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!(fastest <= 1.01 * s.top_speed(), "{fastest}");
        let steep = speeds.windows(2).map(|p| (p[1] - p[0]).abs() / 1e-3);
        let steep = steep.fold(0.0, f64::max);
        // A move is a whole number of milliseconds, and ends at rest.
        assert!(steep <= 1.2 * steepest, "{steep} for {steepest}");
        asked.extend(next.about.iter().map(|id| (*id).to_owned()));
        assert!(asked.len() < 40, "it asks for ever");
    }
}
