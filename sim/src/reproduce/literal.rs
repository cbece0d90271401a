//! Equations (10)–(12) exactly as printed, driven there and back: why the library does not compute them so.

use super::column;
use preslide_fit::report::Table;
use preslide_fit::report::figures::significant;
use preslide_host::paper;
use serde_json::{Value, json};

/// Attraction parameter `C` \[N/s\]; the paper says that it hardly matters.
const ATTRACTION: f64 = 20.0;
/// Speed \[m/s\].
const SPEED: f64 = 20e-6;
/// Time between steps \[s\].
const STEP: f64 = 1e-4;
/// On the way back the force is noted here \[m\], and at the end, [`paper::RANGE`].
const SOON: f64 = 2e-6;
/// Sizes that are shown.
const SHOWN: [usize; 3] = [2, 4, 6];

/// How (11) is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// `dF_i/dt = sgn(v)·C·(α_i − F_i/s(v))`, with `s = F_s`.
    Printed,
    /// `dF_i/dt = C·(sgn(v)·α_i − F_i/s)`: the same for `v > 0`, and odd in `v`.
    Odd,
}

/// One column of Table 3 along 0 → 40 µm → 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Literal {
    /// Number of blocks.
    pub n: usize,
    /// How (11) was read.
    pub reading: Reading,
    /// Force \[N\] where the motion turned, `SOON` later, and back at the start.
    pub force: [f64; 3],
    /// The same where blocks stick again at the reversal: `Σ clamp(k_i·z_i, ±W_i)`.
    pub mended: [f64; 3],
    /// Blocks that stuck at any time on the way back.
    pub stuck_again: usize,
}

/// Every size in `SHOWN`, in both readings.
///
/// # Errors
/// A size that Table 3 does not have.
pub fn literal() -> Result<Vec<Literal>, String> {
    let mut found = Vec::new();
    for n in SHOWN {
        let column = column(n)?;
        for reading in [Reading::Printed, Reading::Odd] {
            found.push(driven(column, reading));
        }
    }
    Ok(found)
}

fn driven(column: &paper::TableColumn, reading: Reading) -> Literal {
    let steps = (paper::RANGE / (SPEED * STEP)).round() as usize;
    let soon = (SOON / (SPEED * STEP)).round() as usize;
    let mut force = vec![0.0_f64; column.size()];
    let mut mended = force.clone();
    let mut stuck = vec![false; column.size()];
    let (mut forces, mut mendeds) = ([0.0; 3], [0.0; 3]);
    for step in 1..=2 * steps {
        let v = if step <= steps { SPEED } else { -SPEED };
        for (i, &(k, weight)) in column.blocks.iter().enumerate() {
            let limit = weight * paper::BREAKAWAY;
            let sticks = force[i].abs() < limit;
            stuck[i] |= sticks && v < 0.0;
            force[i] += STEP
                * match (sticks, reading) {
                    (true, _) => k * v,
                    (false, Reading::Printed) => {
                        v.signum() * ATTRACTION * (weight - force[i] / paper::BREAKAWAY)
                    }
                    (false, Reading::Odd) => {
                        ATTRACTION * (v.signum() * weight - force[i] / paper::BREAKAWAY)
                    }
                };
            mended[i] = (mended[i] + k * v * STEP).clamp(-limit, limit);
        }
        let noted = [steps, steps + soon, 2 * steps];
        if let Some(at) = noted.iter().position(|noted| *noted == step) {
            forces[at] = force.iter().sum();
            mendeds[at] = mended.iter().sum();
        }
    }
    Literal {
        n: column.size(),
        reading,
        force: forces,
        mended: mendeds,
        stuck_again: stuck.iter().filter(|stuck| **stuck).count(),
    }
}

/// For people.
pub fn table(found: &[Literal]) -> Table {
    Table::of(format!(
            "Equations (10)–(12) taken literally, 40 µm there and back at {:.0} µm/s, C = {ATTRACTION:.0} N/s; due: with blocks that stick again when the motion turns",
            1e6 * SPEED
        ), found).column("N", |literal| literal.n.to_string()).column("reading", |literal| match literal.reading {
                Reading::Printed => "as printed".to_owned(),
                Reading::Odd => "(11) made odd in v".to_owned(),
            }).column("at the turn [N]", |literal| significant(literal.force[0])).column("2 µm later [N]", |literal| significant(literal.force[1])).column("due", |literal| significant(literal.mended[1])).column("back at 0 [N]", |literal| match literal.force[2] {
                back if back.abs() < 1e3 => significant(back),
                back => format!("{back:.1e}"),
            }).column("due", |literal| significant(literal.mended[2])).column("stuck again", |literal| {
                literal.stuck_again.to_string()
            }).table()
}

/// What the table says.
pub fn remark(found: &[Literal]) -> String {
    let worst = found
        .iter()
        .filter(|literal| literal.reading == Reading::Printed)
        .map(|literal| literal.force[2])
        .fold(0.0, f64::max);
    format!(
        "Taken literally (10)–(11) wedge at a reversal: a block that slips sits at its limit, |F_i| < |W_i| is never true again, and as printed (11) drives it further out while the body moves back, to {worst:.1e} N in the table. Made odd in v, (11) brings a block back inside by itself, by a slip in time and not in displacement. The library lets a slipping block stick again when the motion turns, as Al-Bender, Lampaert and Swevers (2005) do"
    )
}

/// For machines.
pub fn to_json(found: &[Literal]) -> Value {
    let one = |literal: &Literal| {
        json!({
            "n": literal.n,
            "as_printed": literal.reading == Reading::Printed,
            "force_N": literal.force,
            "force_due_N": literal.mended,
            "blocks_that_stuck_again": literal.stuck_again,
        })
    };
    found.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_equations_wedge_and_odd_in_v_they_do_not() {
        for literal in literal().unwrap() {
            let [turned, soon, back] = literal.mended;
            assert!((literal.force[0] - turned).abs() < 2e-3, "{literal:?}");
            assert!(soon < turned && back < 0.0, "{literal:?}");
            match literal.reading {
                Reading::Printed => {
                    assert_eq!(literal.stuck_again, 0, "{literal:?}");
                    assert!(literal.force[2] >= turned, "{literal:?}");
                }
                Reading::Odd => {
                    assert_eq!(literal.stuck_again, literal.n, "{literal:?}");
                    assert!((literal.force[2] - back).abs() < 2e-3, "{literal:?}");
                    assert!((literal.force[1] - soon).abs() > 1e-3, "{literal:?}");
                }
            }
        }
    }
}
