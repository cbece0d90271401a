//! The whole-number kernels: those of one law against each other bit for bit, each law against `f64`.
//!
//! The references are written from the equations and share no code with the kernels.

use preslide::kernels::{ConstantTimeSlipReserve, CountGms, PackedSlipReserve, SlipReserve, Whole};
use preslide::{Block, Friction, Motion, Sliding, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEPS: usize = 1_000_000;
const COUNT: f64 = 25e-9;
const SAMPLE_TIME: f64 = 50e-6;
const BREAKAWAY: f64 = 0.9;
const SLIDING: Sliding = Sliding {
    coulomb: 0.81,
    stribeck_velocity: 1e-3,
    stribeck_exponent: 2.0,
    attraction: 20.0,
};

/// N blocks whose yield displacements spread from 1 µm to 50 µm, as those of Table 3 do.
fn blocks<const N: usize>() -> [Block; N] {
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

fn counts(force: f64) -> Units {
    Units {
        length: COUNT,
        force,
        velocity: 1e-7,
    }
}

fn whole(value: i32) -> Whole {
    Whole::from_bits(value)
}

/// Displacements of every size: none, one count, a stroke's, more than a block takes, and the integers' ends.
fn any_displacement(random: &mut ChaCha8Rng) -> i32 {
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

/// `z ← clamp(z + dx, −D, D)`, `F = Σ k·z` in 64-bit integers, `D` in counts and `k` from `W = k·D`.
struct Clamped(Vec<[i64; 3]>);

impl Clamped {
    fn new(blocks: &[Block], units: Units) -> Self {
        let integers = |block: &Block| {
            let breakaway = block.weight * BREAKAWAY;
            let yields = (breakaway / block.stiffness / units.length).round();
            [
                0,
                yields as i64,
                (breakaway / units.force / yields).round() as i64,
            ]
        };
        Self(blocks.iter().map(integers).collect())
    }

    fn step(&mut self, dx: i32) -> i64 {
        let mut force = 0;
        for [z, yields, stiffness] in &mut self.0 {
            *z = (*z + i64::from(dx)).clamp(-*yields, *yields);
            force += *stiffness * *z;
        }
        force
    }
}

fn slip_reserve_kernels_agree<const N: usize, const PAIRS: usize>() {
    let blocks = blocks::<N>();
    let units = counts(PackedSlipReserve::<PAIRS>::finest_force(
        &blocks, BREAKAWAY, COUNT,
    ));
    let plain = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    let packed = PackedSlipReserve::<PAIRS>::try_new(&blocks, BREAKAWAY, units).unwrap();
    let constant = ConstantTimeSlipReserve::<PAIRS>::try_new(&blocks, BREAKAWAY, units).unwrap();
    let mut reference = Clamped::new(&blocks, units);
    let mut states = (plain.at_rest(), packed.at_rest(), constant.at_rest());
    let mut random = ChaCha8Rng::seed_from_u64(N as u64);
    let limit = i64::from(plain.limit().unwrap().to_bits());
    for step in 0..STEPS {
        let dx = any_displacement(&mut random);
        let motion = Motion::quasi_static(whole(dx));
        let force = reference.step(dx);
        let found = [
            plain.step(&mut states.0, motion),
            packed.step(&mut states.1, motion),
            constant.step(&mut states.2, motion),
        ];
        let found = found.map(|force| i64::from(force.to_bits()));
        assert_eq!(found, [force; 3], "N = {N}, step {step}, dx = {dx}");
        assert!(
            force.abs() <= limit,
            "N = {N}, step {step}: |{force}| > {limit}"
        );
    }
}

#[test]
fn slip_reserve_kernels_agree_bit_for_bit_with_the_clamped_form() {
    slip_reserve_kernels_agree::<1, 1>();
    slip_reserve_kernels_agree::<2, 1>();
    slip_reserve_kernels_agree::<3, 2>();
    slip_reserve_kernels_agree::<4, 2>();
    slip_reserve_kernels_agree::<5, 3>();
    slip_reserve_kernels_agree::<6, 3>();
    slip_reserve_kernels_agree::<7, 4>();
    slip_reserve_kernels_agree::<8, 4>();
    slip_reserve_kernels_agree::<9, 5>();
    slip_reserve_kernels_agree::<10, 5>();
}

/// Strokes of random length at random speed, forth and back, with rests: displacement (counts), speed (counts/tick).
fn strokes(seed: u64) -> impl Iterator<Item = (i32, f64)> {
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

/// The full law by eqs. (10)–(12) as `Gms` reads them, with exponentials, in newtons and metres.
struct Exact {
    /// Deflection, stiffness, weight.
    blocks: Vec<[f64; 3]>,
    slips: Vec<bool>,
    direction: f64,
}

impl Exact {
    fn new(blocks: &[Block]) -> Self {
        Self {
            blocks: blocks
                .iter()
                .map(|b| [0.0, b.stiffness, b.weight])
                .collect(),
            slips: vec![false; blocks.len()],
            direction: 1.0,
        }
    }

    fn step(&mut self, dx: f64, v: f64) -> f64 {
        if dx != 0.0 && dx.signum() != self.direction {
            self.direction = dx.signum();
            self.slips.fill(false);
        }
        let decay = (v.abs() / SLIDING.stribeck_velocity).powf(SLIDING.stribeck_exponent);
        let s = SLIDING.coulomb + (BREAKAWAY - SLIDING.coulomb) * (-decay).exp();
        let stays = (-SLIDING.attraction * SAMPLE_TIME / s).exp();
        if dx != 0.0 || v != 0.0 {
            for ([z, k, weight], slips) in self.blocks.iter_mut().zip(&mut self.slips) {
                let bound = *weight * s / *k;
                let old = *z * self.direction;
                let stuck = old + dx.abs();
                let along = if !*slips && stuck < bound {
                    stuck
                } else if !*slips && old < bound {
                    bound
                } else {
                    bound + (old - bound) * stays
                };
                *slips |= stuck >= bound;
                *z = along * self.direction;
            }
        }
        self.blocks.iter().map(|[z, k, _]| z * k).sum()
    }
}

/// Errors of a kernel against a reference, in % of the breakaway force.
#[derive(Default)]
struct Errors {
    most: f64,
    squares: f64,
    sum: f64,
    steps: f64,
}

impl Errors {
    fn add(&mut self, error: f64) {
        let percent = 100.0 * error / BREAKAWAY;
        self.most = self.most.max(percent.abs());
        self.squares += percent * percent;
        self.sum += percent;
        self.steps += 1.0;
    }

    fn check(&self, name: &str, [most, rms, bias]: [f64; 3]) {
        let found = [
            self.most,
            (self.squares / self.steps).sqrt(),
            self.sum / self.steps,
        ];
        println!(
            "{name}: max {:.4} %, rms {:.4} %, bias {:.5} % of F_s",
            found[0], found[1], found[2]
        );
        assert!(found[0] <= most, "{name}: max {} % > {most} %", found[0]);
        assert!(found[1] <= rms, "{name}: rms {} % > {rms} %", found[1]);
        assert!(
            found[2].abs() <= bias,
            "{name}: bias {} % > {bias} %",
            found[2]
        );
    }
}

/// Runs a kernel and a reference along the strokes; `reference` takes metres and metres per second.
fn errors<K: Friction<Scalar = Whole>>(
    kernel: &K,
    units: Units,
    mut reference: impl FnMut(f64, f64) -> f64,
) -> Errors {
    let mut state = kernel.at_rest();
    let mut errors = Errors::default();
    for (dx, speed) in strokes(1).take(STEPS) {
        let velocity = speed * COUNT / SAMPLE_TIME;
        let motion = Motion {
            displacement: whole(dx),
            velocity: whole((velocity / units.velocity).round() as i32),
        };
        let force = f64::from(kernel.step(&mut state, motion).to_bits()) * units.force;
        errors.add(force - reference(f64::from(dx) * COUNT, velocity));
    }
    errors
}

fn laws_against_f64<const N: usize, const PAIRS: usize>() {
    let blocks = blocks::<N>();
    let quasi_static = || {
        let mut deflection = [0.0; N];
        move |dx: f64, _: f64| {
            let mut force = 0.0;
            for (z, block) in deflection.iter_mut().zip(&blocks) {
                let yields = block.weight * BREAKAWAY / block.stiffness;
                *z = (*z + dx).clamp(-yields, yields);
                force += block.stiffness * *z;
            }
            force
        }
    };

    let units = counts(SlipReserve::<N>::finest_force(&blocks, BREAKAWAY, COUNT));
    let kernel = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    errors(&kernel, units, quasi_static())
        .check(&format!("slip reserve N = {N}"), [0.4, 0.1, 0.003]);

    let units = counts(PackedSlipReserve::<PAIRS>::finest_force(
        &blocks, BREAKAWAY, COUNT,
    ));
    let kernel = PackedSlipReserve::<PAIRS>::try_new(&blocks, BREAKAWAY, units).unwrap();
    errors(&kernel, units, quasi_static()).check(&format!("packed N = {N}"), [0.4, 0.1, 0.003]);

    let units = counts(CountGms::<N>::finest_force(&blocks, BREAKAWAY, COUNT));
    let kernel = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).unwrap();
    let mut exact = Exact::new(&blocks);
    errors(&kernel, units, |dx, v| exact.step(dx, v))
        .check(&format!("gms_i32 N = {N}"), [0.01, 0.004, 0.0002]);
}

#[test]
fn every_law_stays_within_its_bounds_of_the_f64_reference() {
    laws_against_f64::<1, 1>();
    laws_against_f64::<2, 1>();
    laws_against_f64::<3, 2>();
    laws_against_f64::<4, 2>();
    laws_against_f64::<5, 3>();
    laws_against_f64::<6, 3>();
    laws_against_f64::<7, 4>();
    laws_against_f64::<8, 4>();
    laws_against_f64::<9, 5>();
    laws_against_f64::<10, 5>();
}

#[test]
fn no_input_takes_the_exact_kernel_beyond_its_limit() {
    let blocks = blocks::<6>();
    let units = counts(CountGms::<6>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).unwrap();
    let limit = gms.limit().unwrap();
    let mut state = gms.at_rest();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for step in 0..STEPS {
        let displacement = whole(any_displacement(&mut random));
        let velocity = match random.random_range(0..20) {
            0 => whole([i32::MIN, i32::MAX, 0, 1][random.random_range(0..4)]),
            _ => whole(random.random_range(-100_000..=100_000)),
        };
        let force = gms.step(
            &mut state,
            Motion {
                displacement,
                velocity,
            },
        );
        assert!(force.abs() <= limit, "step {step}: {force} beyond {limit}");
    }
}

#[test]
fn a_loop_closes_and_its_inside_is_wiped_out_after_any_number_of_steps() {
    let blocks = blocks::<4>();
    let units = counts(SlipReserve::<4>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    let mut state = gms.at_rest();
    let mut go = |counts: i32| gms.step(&mut state, Motion::quasi_static(whole(counts)));
    go(1_000);
    go(-700);
    let outer = go(300);
    for _ in 0..100_000 {
        go(-150);
        go(50);
        go(-30);
        assert_eq!(go(130), outer);
    }
}

#[test]
fn what_lies_outside_a_kernels_range_is_refused_with_its_name() {
    let soft = [Block {
        stiffness: 10.0,
        weight: 1.0,
    }]; // D = 90 mm
    let message = |error: preslide::ParamError| error.to_string();
    let packed = PackedSlipReserve::<1>::try_new(&soft, BREAKAWAY, counts(1e-6)).unwrap_err();
    assert!(
        message(packed).contains("yield displacement of block 1"),
        "{packed}"
    );
    assert!(SlipReserve::try_new(&soft, BREAKAWAY, counts(1e-9)).is_ok());

    let stiff = [Block {
        stiffness: 1e9,
        weight: 1.0,
    }]; // D = 0.9 nm, less than half a count
    for error in [
        SlipReserve::try_new(&stiff, BREAKAWAY, counts(1e-9)).unwrap_err(),
        ConstantTimeSlipReserve::<1>::try_new(&stiff, BREAKAWAY, counts(1e-9)).unwrap_err(),
    ] {
        assert!(message(error).contains("rounds to zero"), "{error}");
    }

    let fine = SlipReserve::try_new(&blocks::<3>(), BREAKAWAY, counts(1e-12)).unwrap_err();
    assert!(message(fine).contains("stiffness of block 1"), "{fine}");
    let sum = SlipReserve::try_new(&blocks::<3>(), BREAKAWAY, counts(6e-10)).unwrap_err();
    assert!(message(sum).contains("breakaway force"), "{sum}");

    let exact = |blocks: &[Block; 2], units| {
        CountGms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    };
    let apart = [
        Block {
            stiffness: 1e7,
            weight: 0.5,
        },
        Block {
            stiffness: 10.0,
            weight: 0.5,
        },
    ];
    let error = exact(&apart, counts(1e-3)).unwrap_err();
    assert!(message(error).contains("yield displacement"), "{error}");
    let coarse = Units {
        velocity: 1e-3,
        ..counts(1e-6)
    };
    let error = exact(&blocks(), coarse).unwrap_err();
    assert!(message(error).contains("unit of velocity"), "{error}");
    let error = exact(&blocks(), counts(1e-9)).unwrap_err();
    assert!(
        message(error).contains("weight times breakaway force"),
        "{error}"
    );
}
