//! The motions of the comparison.

use super::Step;

/// Amplitudes of the nested triangles (m).
pub const TRIANGLES_M: [f64; 4] = [50e-6, 20e-6, 5e-6, 1e-6];

/// Time from zero to the speed of a triangle (s): the corner's half.
const CORNER_S: f64 = 0.02;

/// Triangles at 1 Hz of 50, 20, 5 and 1 µm: each nested into the loop that the one before left open.
///
/// The amplitude shrinks on the way down from a peak, so every smaller triangle reverses inside the larger one's
/// hysteresis loop. The first stroke comes from rest.
pub fn nested_triangles() -> Vec<Step> {
    let mut steps = Vec::new();
    let mut position = 0.0;
    let mut go = |to: f64, amplitude: f64| {
        // 1 Hz: four amplitudes a second.
        let speed_m_s = 4.0 * amplitude;
        steps.push(Step::Move {
            distance_m: to - position,
            speed_m_s,
            ramp_s: CORNER_S,
        });
        position = to;
    };
    for amplitude in TRIANGLES_M {
        for _ in 0..2 {
            go(amplitude, amplitude);
            go(-amplitude, amplitude);
        }
    }
    go(0.0, TRIANGLES_M[3]);
    steps
}

/// Ten steps of 100 nm up and ten down, each with 0.4 s to settle.
pub fn steps() -> Vec<Step> {
    (0..20)
        .flat_map(|i| {
            [
                Step::Move {
                    distance_m: if i < 10 { 100e-9 } else { -100e-9 },
                    speed_m_s: 20e-6,
                    ramp_s: 0.5e-3,
                },
                Step::Dwell(0.4),
            ]
        })
        .collect()
}

/// A slide of 0.5 mm at 1 mm/s there and back, twice.
pub fn slide() -> Vec<Step> {
    [1.0, -1.0, 1.0, -1.0]
        .map(|sign| Step::Move {
            distance_m: sign * 0.5e-3,
            speed_m_s: 1e-3,
            ramp_s: 0.02,
        })
        .to_vec()
}

/// A move of 10 µm, then 60 s at rest.
pub fn rest() -> Vec<Step> {
    vec![
        Step::Move {
            distance_m: 10e-6,
            speed_m_s: 50e-6,
            ramp_s: 0.02,
        },
        Step::Dwell(60.0),
    ]
}

/// What the parameters are identified from: slow triangles, nested, and a slide for the Stribeck branch.
pub fn identification() -> Vec<Step> {
    let mut steps = Vec::new();
    let mut position = 0.0;
    for (to, speed_m_s) in [
        (80e-6, 80e-6),
        (-80e-6, 80e-6),
        (80e-6, 80e-6),
        (40e-6, 40e-6),
        (70e-6, 40e-6),
        (60e-6, 20e-6),
        (65e-6, 10e-6),
        (63e-6, 5e-6),
        (64e-6, 5e-6),
        (-80e-6, 80e-6),
        (-40e-6, 40e-6),
        (-60e-6, 20e-6),
        (0.0, 80e-6),
        (0.5e-3, 1e-3),
        (-0.5e-3, 0.5e-3),
        (0.0, 0.3e-3),
    ] {
        steps.push(Step::Move {
            distance_m: to - position,
            speed_m_s,
            ramp_s: 0.05,
        });
        position = to;
    }
    steps
}
