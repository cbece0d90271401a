//! The quasi-static kernels in every state that they can reach, by every move from there. That is a proof for the blocks below: the force is
//! the law's, no larger than the sum of what the blocks yield at, and, since overflows are checked in tests, nothing wraps.

extern crate std;

use super::{Kernel, PackedSlipReserve, SlipReserve, Whole};
use crate::{Block, Motion, ParamError, Units};
use std::vec;
use std::vec::Vec;

/// Yield displacement and stiffness of a block in whole units.
type Spring = [i64; 2];

fn breakaway(springs: &[Spring]) -> i64 {
    springs
        .iter()
        .map(|[yields, stiffness]| yields * stiffness)
        .sum()
}

fn built<const N: usize, K>(
    springs: &[Spring; N],
    new: impl Fn(&[Block; N], f64, Units) -> Result<K, ParamError>,
) -> K {
    let sum = breakaway(springs) as f64;
    let blocks = springs.map(|[yields, stiffness]| Block {
        stiffness: stiffness as f64,
        weight: (yields * stiffness) as f64 / sum,
    });
    new(&blocks, sum, Units::SI).expect("whole numbers within the range")
}

/// Goes everywhere beside springs that slip, `z ← clamp(z + dx, ±D)`, `F = Σ k·z`; how many states there are.
fn explore<const N: usize, K: Kernel<State: PartialEq>>(
    kernel: &K,
    springs: &[Spring; N],
    moves: &[i32],
) -> usize {
    let limit = breakaway(springs);
    assert_eq!(
        kernel.limit().map(|limit| limit.to_bits().into()),
        Some(limit)
    );
    let mut seen = vec![(kernel.at_rest(), [0; N])];
    let mut next = 0;
    while let Some((state, stretched)) = seen.get(next).cloned() {
        next += 1;
        for &dx in moves {
            let mut state = state.clone();
            let force = kernel.step(&mut state, Motion::quasi_static(Whole::from_bits(dx)));
            let mut stretched = stretched;
            for (z, [yields, _]) in stretched.iter_mut().zip(springs) {
                *z = (*z + i64::from(dx)).clamp(-yields, *yields);
            }
            let exact: i64 = stretched.iter().zip(springs).map(|(z, [_, k])| z * k).sum();
            assert_eq!(
                i64::from(force.to_bits()),
                exact,
                "by {dx} to {stretched:?}"
            );
            assert!(exact.abs() <= limit);
            let reached = (state, stretched);
            if !seen.contains(&reached) {
                seen.push(reached);
            }
        }
    }
    seen.len()
}

/// Up to so many units to and fro, and moves at and beyond what the kernels cut them to, which slip every block.
fn moves(most: i32, unit: i32) -> Vec<i32> {
    let whole = (-most..=most).map(|by| by * unit);
    let ends = [i32::MIN, i32::MIN + 1, -(1 << 30), 1 << 30, i32::MAX];
    whole.chain(ends).collect()
}

#[test]
fn small_blocks_obey_the_law_wherever_they_are() {
    const SMALL: [Spring; 3] = [[1, 7], [2, 3], [5, 1]];
    let one = explore(&built(&SMALL, SlipReserve::try_new), &SMALL, &moves(11, 1));
    let packed = built(&SMALL, PackedSlipReserve::<2>::try_new);
    let two = explore(&packed, &SMALL, &moves(11, 1));
    std::println!("{one} and {two} states");
    assert!(one == two && one > 50, "{one} and {two} states");
}

#[test]
fn blocks_at_the_ends_of_the_range_do_not_overflow() {
    let unit = 1 << 27;
    let large: [Spring; 2] = [[3 << 27, 1], [1 << 27, 4]];
    let states = explore(
        &built(&large, SlipReserve::try_new),
        &large,
        &moves(8, unit),
    );
    assert!(states > 10, "{states} states");
    let large: [Spring; 2] = [[3 << 12, 1 << 14], [1 << 12, 32_767]];
    let packed = built(&large, PackedSlipReserve::<1>::try_new);
    let states = explore(&packed, &large, &moves(8, 1 << 12));
    assert!(states > 10, "{states} states");
}
