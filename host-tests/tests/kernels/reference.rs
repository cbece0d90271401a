//! What the kernels are run along, and the laws in `f64`.

use preslide::kernels::Whole;
use preslide::{Block, Friction, Motion, Scalar, Sliding, Units};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::reference::{MaxwellSlip, Stribeck};
use preslide_host_tests::table3::falling;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const STEPS: usize = 1_000_000;
pub const COUNT: f64 = 25e-9;
pub const SAMPLE_TIME: f64 = 50e-6;
pub const BREAKAWAY: f64 = 0.9;
pub const SLIDING: Sliding = falling(0.81, 20.0);

/// N blocks whose yield displacements spread from 1 µm to 50 µm, as those of Table 3 do.
pub fn blocks<const N: usize>() -> [Block; N] {
    std::array::from_fn(|i| {
        let place = if N > 1 {
            i as f64 / (N - 1) as f64
        } else {
            0.5
        };
        let yields = 1e-6 * 50_f64.powf(place);
        let weight = 2.0 * (N - i) as f64 / (N * (N + 1)) as f64;
        Block {
            stiffness: weight * BREAKAWAY / yields,
            weight,
        }
    })
}

pub fn counts(force: f64) -> Units {
    Units {
        length: COUNT,
        force,
        velocity: 1e-7,
    }
}

pub fn whole(value: i32) -> Whole {
    Whole::from_bits(value)
}

/// Displacements of every size: none, one count, a stroke's, more than a block takes, and the integers' ends.
pub fn any_displacement(random: &mut ChaCha8Rng) -> i32 {
    match random.random_range(0..100) {
        0..30 => 0,
        30..60 => random.random_range(-1..=1),
        60..95 => random.random_range(-40..=40),
        95..99 => random.random_range(-5_000..=5_000),
        _ => [
            i32::MIN,
            i32::MIN + 1,
            -32_769,
            -32_768,
            32_767,
            32_768,
            i32::MAX,
        ][random.random_range(0..7)],
    }
}

/// Strokes of random length at random speed, forth and back, with rests: displacement (counts), speed (counts/tick).
pub fn strokes(seed: u64) -> impl Iterator<Item = (i32, f64)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut left, mut speed, mut rest) = (0_u32, 0.0_f64, 0.0_f64);
    let mut forward = true;
    std::iter::from_fn(move || {
        if left == 0 {
            forward = !forward;
            let travel = random.random_range(1.0..4_000.0);
            let magnitude = 2_f64.powf(random.random_range(-4.0..5.0));
            left = ((travel / magnitude) as u32).clamp(1, 4_000);
            speed = match (random.random_ratio(1, 8), forward) {
                (true, _) => 0.0,
                (false, true) => magnitude,
                (false, false) => -magnitude,
            };
        }
        left -= 1;
        let travel = rest + speed;
        let dx = travel.floor();
        rest = travel - dx;
        Some((dx as i32, speed))
    })
}

/// The full law by its equations; takes metres and metres per second.
pub fn full(blocks: &[Block]) -> impl FnMut(f64, f64) -> f64 {
    let blocks: Vec<_> = blocks.iter().map(|b| (b.stiffness, b.weight)).collect();
    let stribeck = Stribeck {
        breakaway: BREAKAWAY,
        coulomb: SLIDING.coulomb,
        velocity: SLIDING.stribeck_velocity,
        exponent: SLIDING.stribeck_exponent,
    };
    let mut law = MaxwellSlip::new(&blocks, stribeck, SLIDING.attraction, SAMPLE_TIME);
    move |dx, v| law.advance(dx, v)
}

/// Blocks that stick and slip at once.
pub fn quasi_static<const N: usize>() -> impl FnMut(f64, f64) -> f64 {
    let blocks = blocks::<N>();
    let mut deflection = [0.0; N];
    move |dx, _| {
        let mut force = 0.0;
        for (z, block) in deflection.iter_mut().zip(&blocks) {
            let yields = block.weight * BREAKAWAY / block.stiffness;
            *z = (*z + dx).clamp(-yields, yields);
            force += block.stiffness * *z;
        }
        force
    }
}

/// Prints and asserts errors in % of the breakaway force.
pub fn check(found: &Deviation, name: &str, bounds: [f64; 3]) {
    let percent = BREAKAWAY / 100.0;
    let told = [found.max, found.rms(), found.bias()].map(|error| error / percent);
    println!("{name}: max, RMS, bias {told:.5?} % of F_s");
    let [max, rms, bias] = bounds.map(|bound| bound * percent);
    found.assert_within(name, max, rms, bias);
}

/// Runs a kernel and a reference along the strokes; `reference` takes metres and metres per second.
pub fn errors<K: Friction>(
    kernel: &K,
    units: Units,
    mut reference: impl FnMut(f64, f64) -> f64,
) -> Deviation {
    let mut state = kernel.at_rest();
    let mut errors = Deviation::default();
    for (dx, speed) in strokes(1).take(STEPS) {
        let velocity = speed * COUNT / SAMPLE_TIME;
        let force = kernel
            .step(&mut state, motion(dx, velocity, units))
            .to_f64()
            * units.force;
        errors.add(force, reference(f64::from(dx) * COUNT, velocity));
    }
    errors
}

/// A motion by `dx` counts at a velocity (m/s).
pub fn motion<S: Scalar>(dx: i32, velocity: f64, units: Units) -> Motion<S> {
    let scalar = |value: f64| S::try_from_f64(value).expect("a motion that fits");
    Motion {
        displacement: scalar(f64::from(dx) * COUNT / units.length),
        velocity: scalar(velocity / units.velocity),
    }
}
