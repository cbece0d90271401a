//! What a control tick takes at least, by argument: the operations that this formulation needs, counted one by one.
//!
//! Every load, store, operation and branch is one cycle: loads stand in rows (the first of a row would take two), no branch is taken, no result
//! is waited for and nothing is spilled. Where the compiler's tick is dearer, that is what it pays. Products of fixed point saturate to
//! the bit: multiply, two shifts joined, two to see whether it fits, two to choose. A tick of fewer cycles needs other arithmetic.

/// Exception entry and return, float registers, registers that a function saves, and RTIC's priority.
pub const FRAME: &str = "interrupt, saved registers";
/// Timer, sensors, watchdog and bridge: another board, other cycles.
pub const BOARD: &str = "timer, sensors, bridge";

/// Stage, what for, and cycles in fixed point and in `f32`.
type Need = (&'static str, &'static str, f64, f64);

#[rustfmt::skip]
const NEEDS: &[Need] = &[
    (FRAME, "exception entry and return (the manual's 12 + 12)", 24.0, 24.0),
    (FRAME, "room for float registers and their lazy stacking (17 + 17)", 0.0, 34.0),
    (FRAME, "nine registers saved and restored, 10 + 12", 22.0, 22.0),
    (FRAME, "RTIC: BASEPRI read, written, barrier", 6.0, 6.0),
    (BOARD, "timer: its address 2, flag, constant, store; due again: flag, mask", 7.0, 7.0),
    (BOARD, "reading: call, address, four words; late: address 2, load, store", 10.0, 10.0),
    (BOARD, "watchdog: address 2, constant, store; bridge: address 2, constant, two stores", 9.0, 9.0),
    (BOARD, "does the emulator dawdle: load, compare, branch", 3.0, 3.0),
    ("orders, moves", "address of the task 2, two flags and a pointer, two compares, two branches", 9.0, 9.0),
    ("sensing, scaling", "counts: last and sign, difference, product, store", 5.0, 5.0),
    ("sensing, scaling", "position: two words loaded, added, stored", 6.0, 6.0),
    ("sensing, scaling", "endless axis? driven and steady? load, compare, branch of both", 6.0, 6.0),
    ("sensing, scaling", "the host's silence: load, compare, branch, subtract, store", 5.0, 5.0),
    ("sensing, scaling", "error: difference, three to shift two words, four to saturate", 8.0, 8.0),
    ("sensing, scaling", "error, displacement, acceleration: a factor, and convert 2, multiply; or saturating product", 23.0, 11.0),
    ("sensing, scaling", "velocity: factor, product; velocity error", 9.0, 3.0),
    ("sensing, scaling", "sum of forces; code: sign, product, store; reference to tell: four for two words", 8.0, 8.0),
    ("velocity tracker", "every tick: time loaded, added, stored; compare and branch", 5.0, 5.0),
    ("velocity tracker", "58 % without an edge: direction 3, age and timeout 5, would it fall 10", 10.4, 10.4),
    ("velocity tracker", "41 % with one: count and time 4, sign 6, age of the newest 8", 7.4, 7.4),
    ("velocity tracker", "31 % with an estimate: window 18, division 21 to 23, remember 8", 14.6, 15.2),
    ("monitors", "jump: limit, size 2, compare, branch", 5.0, 5.0),
    ("monitors", "supply: two limits, difference, compare, branch", 5.0, 5.0),
    ("monitors", "current: offset and limit, extract, subtract, size 2, compare, branch; late: compare, branch", 10.0, 10.0),
    ("monitors", "following error: limit, size, compare (2 for floats), branch", 5.0, 5.0),
    ("reference", "even ticks: load, compare, branch, subtract, store", 5.0, 5.0),
    ("reference", "speed and gain: four words loaded, two added, two stored", 8.0, 8.0),
    ("reference", "ring: place and mask, next 2, store, address; oldest 2, newest stored 2, change 2", 12.0, 12.0),
    ("reference", "sum 6, rest 5, whole 3", 14.0, 14.0),
    ("reference", "position 6, displacement 5, change let down 3", 14.0, 14.0),
    ("PID", "three gains, three products, three sums", 27.0, 9.0),
    ("PID", "deadband: load, compare (2 for floats), branch", 3.0, 4.0),
    ("PID", "integral: load, store; limit: load, 5 (7 on a float's bits)", 8.0, 10.0),
    ("feed-forward", "which motion: load, compare, branch", 3.0, 3.0),
    ("feed-forward", "limit: load, negate, compared twice 4 (6 for floats)", 6.0, 8.0),
    ("feed-forward", "share and mass: two factors, two products, a sum", 17.0, 5.0),
    ("friction", "four blocks: z, D, k loaded; sum; limit 5 (7 on a float's bits); store; product 3 (1), sum", 56.0, 56.0),
    ("motor map", "supply: field, two factors, conversions or checks 3, product, division of 12 or 14", 19.0, 21.0),
    ("motor map", "force, velocity, supply: two factors, three products, a sum", 24.0, 6.0),
    ("motor map", "dead time? load, compare, branch; a number? compare 2, branch", 3.0, 6.0),
    ("motor map", "rounding: rest loaded, added, stored; nearest 6 or 7; back 5 or 1; less; limit 5 or 7", 20.0, 19.0),
    ("limiter", "load, one comparison for both signs 2, branch", 4.0, 4.0),
    ("telemetry", "tick: load, add, store; a status? 2; a sample? load, compare, branch, reload 2", 10.0, 10.0),
    ("telemetry", "ring: pointer, written, read, full? 3; slot 3; written 2", 11.0, 11.0),
    ("telemetry", "dropped; current: offset, difference, packed; level; zero; nine stores", 15.0, 15.0),
];

/// The floor of a stage: fixed point, `f32`.
pub fn of(stage: &str) -> [f64; 2] {
    let needs = NEEDS.iter().filter(|(of, ..)| *of == stage);
    needs.fold([0.0, 0.0], |[fixed, float], need| {
        [fixed + need.2, float + need.3]
    })
}

/// What the floors are made of.
pub fn print() {
    println!("\nthe floor by argument, cycles in fixed point and in f32");
    for (stage, what, fixed, float) in NEEDS {
        println!("{stage}: {what}: {fixed}, {float}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::stages::STAGES;

    #[test]
    fn every_need_is_of_a_stage() {
        for (of, what, ..) in super::NEEDS {
            assert!(STAGES.iter().any(|(name, _)| name == of), "{of}: {what}");
        }
    }
}
