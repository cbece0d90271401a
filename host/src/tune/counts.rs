//! What an encoder's counts alone take from a model.

use preslide_fit::friction::{FrictionModel, Path};
use preslide_fit::report::figures::{quantity, three};
use preslide_fit::statistics::nmse;

/// From here on (NMSE, %) what counts take from a model is said.
const COARSE: f64 = 1.0;

/// No model is worth its cycles of which counts take so much (NMSE, %). Counts as long as the shortest yield, the longest of which
/// `identify` still finds a block, take up to 44 %; where they show nothing it is all.
pub const TOO_COARSE: f64 = 50.0;

/// What an encoder's counts (m or rad) alone take from a Maxwell-slip model, whatever the arithmetic: its force along counts beside that
/// along the motion itself (NMSE, %). The motion is strokes that shrink from four times the longest yield displacement to half of
/// the shortest, so that every block sticks and slips on it; 0 for another law.
pub fn counting(friction: &FrictionModel, count: f64) -> f64 {
    /// Samples of a stroke, and each stroke of the one before.
    const SAMPLES: usize = 200;
    const SHRINK: f64 = 0.8;
    let FrictionModel::Gms {
        breakaway, blocks, ..
    } = friction
    else {
        return 0.0;
    };
    let yields = || blocks.iter().map(|b| b.yield_displacement(*breakaway));
    let (longest, shortest) = (
        yields().fold(0.0, f64::max),
        yields().fold(f64::INFINITY, f64::min),
    );
    let (mut position, mut at, mut stroke, mut forward) = (Vec::new(), 0.0, 4.0 * longest, 1.0);
    while stroke >= 0.5 * shortest {
        let step = forward * stroke / SAMPLES as f64;
        position.extend((1..=SAMPLES).map(|i| at + step * i as f64));
        at += forward * stroke;
        (stroke, forward) = (SHRINK * stroke, -forward);
    }
    // At rest the level is the breakaway force: the curve of sliding is no question of counts.
    let law = FrictionModel::Gms {
        breakaway: *breakaway,
        blocks: blocks.clone(),
        sliding: None,
    };
    let velocity = vec![0.0; position.len()];
    let along = |position: &[f64]| {
        law.force(Path {
            position,
            velocity: &velocity,
            pieces: std::slice::from_ref(&(0..position.len())),
            sample_time: 1.0,
        })
    };
    let counted: Vec<f64> = position
        .iter()
        .map(|x| (x / count).round() * count)
        .collect();
    let (Ok(exact), Ok(counted)) = (along(&position), along(&counted)) else {
        return 0.0;
    };
    let rows: Vec<usize> = (0..exact.len()).collect();
    nmse(&exact, &counted, &rows)
}

/// What is said of counts that take a part of the model.
pub fn counting_note(counting: f64, count: f64, unit: &str) -> Option<String> {
    (counting > COARSE).then(|| {
        format!(
            "encoder counts of {} alone put the model off by an NMSE of {} % (on strokes that show every block), whatever the arithmetic",
            quantity(count, unit),
            three(counting)
        )
    })
}

/// Why nothing is recommended for such counts.
pub fn too_coarse(counting: f64, count: f64, unit: &str) -> String {
    format!(
        "--count {}: so coarse that counts alone put the model off by an NMSE of {} % (on strokes that show every block), whatever the arithmetic; check the length of a count, or identify with fewer blocks, which yield later",
        quantity(count, unit),
        three(counting)
    )
}
