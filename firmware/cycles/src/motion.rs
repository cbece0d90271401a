//! The random motion that every kernel sees: strokes of random length and speed, each in the other direction.

use preslide::{Motion, Scalar, Units};

/// Printed with the results, so that they can be repeated.
pub const SEED: u32 = 0x1727_2018;

/// Encoder resolution \[m\], that of the paper's stage (Table 1).
pub const COUNT: f64 = 25e-9;

/// Control period \[s\].
pub const SAMPLE_TIME: f64 = 50e-6;

/// Enough for the worst paths to appear; more changes no figure by 1 %. Cores without a float unit take minutes for a tenth of it.
pub const TICKS: usize = if cfg!(any(target_arch = "riscv32", target_abi = "eabi")) {
    1_000
} else {
    10_000
};

/// Turn back within this range \[counts\]: 60 µm, half as much again as the largest yield displacement of Table 3.
const RANGE: i32 = 2_400;

/// No stroke lasts longer \[ticks\], or a few slow ones would be the whole motion.
const LONGEST: u32 = 512;

/// One tick of the motion.
pub struct Tick {
    /// Displacement \[counts\].
    pub counts: i32,
    /// Where it ends \[counts\].
    pub position: i32,
    /// Velocity \[counts per tick\].
    pub velocity: f32,
}

impl Tick {
    /// The same in the units of a model.
    pub fn motion<S: Scalar>(&self, units: Units) -> Motion<S> {
        let scalar = |value: f64| S::try_from_f64(value).unwrap_or(S::ZERO);
        Motion {
            displacement: scalar(f64::from(self.counts) * COUNT / units.length),
            velocity: scalar(f64::from(self.velocity) * COUNT / SAMPLE_TIME / units.velocity),
        }
    }

    /// Where the axis is, in the units of a model.
    pub fn place<S: Scalar>(&self, units: Units) -> S {
        S::try_from_f64(f64::from(self.position) * COUNT / units.length).unwrap_or(S::ZERO)
    }
}

/// An endless motion: strokes at 1/16 to 32 counts per tick (0.03 to 16 mm/s), one in four followed by a rest.
pub struct Strokes {
    random: u32,
    position: i32,
    /// Sixteenths of a count per tick, and what is left of a count.
    speed: i32,
    remainder: i32,
    stroke_ticks: u32,
    rest_ticks: u32,
}

impl Strokes {
    pub fn new() -> Self {
        Self {
            random: SEED,
            position: 0,
            speed: 1,
            remainder: 0,
            stroke_ticks: 0,
            rest_ticks: 0,
        }
    }

    /// Marsaglia's xorshift32.
    fn random(&mut self) -> u32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 17;
        self.random ^= self.random << 5;
        self.random
    }

    fn new_stroke(&mut self) {
        // Log-uniform: slow approaches and fast traverses are equally frequent.
        let magnitude = 1 << (self.random() % 10);
        let outside = self.position.abs() > RANGE;
        let forward = if outside {
            self.position < 0
        } else {
            self.speed < 0
        };
        self.speed = if forward { magnitude } else { -magnitude };
        self.stroke_ticks = 1 + self.random() % LONGEST.min((2 * RANGE * 16 / magnitude) as u32);
        if self.random().is_multiple_of(4) {
            self.rest_ticks = self.random() % 64;
        }
    }
}

impl Iterator for Strokes {
    type Item = Tick;

    // Once in the image and not once a kernel, which would fill a board's flash.
    #[inline(never)]
    fn next(&mut self) -> Option<Tick> {
        if self.stroke_ticks == 0 {
            if self.rest_ticks > 0 {
                self.rest_ticks -= 1;
                return Some(Tick {
                    counts: 0,
                    position: self.position,
                    velocity: 0.0,
                });
            }
            self.new_stroke();
        }
        self.stroke_ticks -= 1;
        let sixteenths = self.remainder + self.speed;
        let counts = sixteenths.div_euclid(16);
        self.remainder = sixteenths.rem_euclid(16);
        self.position += counts;
        Some(Tick {
            counts,
            position: self.position,
            velocity: self.speed as f32 / 16.0,
        })
    }
}

/// Displacements \[counts\] and velocities of every size, no motion and the integers' ends among them: nothing that a stage
/// does, but what a kernel must take.
pub struct Jumps(u32);

impl Jumps {
    pub fn new() -> Self {
        Self(SEED)
    }
}

impl Iterator for Jumps {
    type Item = (i32, i32);

    fn next(&mut self) -> Option<(i32, i32)> {
        let mut any = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            // From all 32 bits down to none: most are small, as a stage's are.
            let bits = 31 - (self.0 & 31).min((self.0 >> 5) & 31);
            self.0.cast_signed() >> bits
        };
        Some((any(), any()))
    }
}
