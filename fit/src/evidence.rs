//! How sure it is that a candidate explains something, and how much: a paired statistic of blocks.
//!
//! `f` is the candidate's force at the rows with coefficients and shapes from other folds, `e` the residual that other folds
//! predict without it. With `γ = Σfe/Σf²` the scores `u_b = Σ_b f·(e − γf)` of the *unrestricted* residual tell how much
//! `Σfe` varies over blocks (Liang and Zeger 1986; the sign flips of Hemerik, Goeman and Finos 2020 have the same variance), however strong the effect
//! itself is. Where few blocks hold most of `f²` there are as few degrees of freedom (Bell and McCaffrey 2002).

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use std::ops::Range;

/// Share of the mismatch from which an effect is named.
pub const NAMED: f64 = 0.03;
/// Blocks below which a force proves nothing, however well it fits them.
const FEWEST: f64 = 2.0;

/// What a candidate is worth.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence {
    /// Squares taken off on folds held out, over those there were: the share of the mismatch.
    pub share: f64,
    /// Standard deviations of a normal variable that are as unlikely as this by chance, for one candidate that was not chosen.
    pub z: f64,
    /// Blocks that it is seen in.
    pub blocks: f64,
    /// Coefficient of its force held out on what is there: 1 where it predicts what it promises.
    pub slope: f64,
}

/// Judges a force against a residual, both whitened and held out.
pub fn evidence(force: &[f64], residual: &[f64], blocks: &[Range<usize>]) -> Evidence {
    let square: f64 = force.iter().map(|f| f * f).sum();
    let product: f64 = force.iter().zip(residual).map(|(f, e)| f * e).sum();
    let loss: f64 = residual.iter().map(|e| e * e).sum();
    if square <= 0.0 || loss <= 0.0 {
        return Evidence::default();
    }
    let slope = product / square;
    let (mut variance, mut fourth) = (0.0, 0.0);
    for rows in blocks {
        let (mut score, mut own) = (0.0, 0.0);
        for i in rows.clone() {
            score += force[i] * (residual[i] - slope * force[i]);
            own += force[i] * force[i];
        }
        variance += score * score;
        fourth += own * own;
    }
    let count = square * square / fourth.max(1e-300);
    let n = blocks.len() as f64;
    let t = product / (variance * n / (n - 1.0).max(1.0)).sqrt().max(1e-300);
    Evidence {
        share: (2.0 * product - square) / loss,
        z: if count < FEWEST {
            0.0
        } else {
            as_normal(t, count - 1.0)
        },
        blocks: count,
        slope,
    }
}

/// Share of a force's squares that its largest values hold, over which [`at_its_largest`] looks.
const LARGEST: f64 = 0.2;

/// The coefficient of a force held out on what is there, where the force is largest. In a closed loop whatever pushes the carriage moves it,
/// and the effort that answers is taken for a term by as much as the two go together (Söderström and Stoica 1989, chapter 10): while
/// little else moves, so that the coefficient falls where the motion asked for makes the force large. What is there keeps it.
pub fn at_its_largest(force: &[f64], residual: &[f64]) -> f64 {
    let square: f64 = force.iter().map(|f| f * f).sum();
    let mut rows: Vec<usize> = (0..force.len()).collect();
    rows.sort_by(|&a, &b| force[b].abs().total_cmp(&force[a].abs()));
    let (mut product, mut own) = (0.0, 0.0);
    for i in rows {
        if own >= LARGEST * square {
            break;
        }
        product += force[i] * residual[i];
        own += force[i] * force[i];
    }
    if own > 0.0 { product / own } else { 0.0 }
}

/// The normal deviate that is as rare as Student's `t` with so many degrees of freedom.
fn as_normal(t: f64, freedom: f64) -> f64 {
    /// Beyond it double precision no longer separates the distributions' tails.
    const RAREST: f64 = 1e-280;
    let tail = StudentsT::new(0.0, 1.0, freedom)
        .map_or(0.5, |d| d.sf(t.abs()))
        .max(RAREST);
    let z = Normal::standard().inverse_cdf(tail).abs();
    z.min(t.abs()).copysign(t)
}

/// The chance that the best of `tries` independent candidates reaches `z` without any effect.
pub fn chance(z: f64, tries: f64) -> f64 {
    let one = Normal::standard().sf(z);
    (-(-one).ln_1p() * tries).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Scores that are alike within a block are counted once a block.
    #[test]
    fn a_force_that_is_not_there_is_found_as_often_as_chance_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let blocks: Vec<Range<usize>> = (0..24).map(|b| b * 40..(b + 1) * 40).collect();
        let runs = 4000;
        let (mut beyond, mut beyond_more) = (0, 0);
        for _ in 0..runs {
            let (mut force, mut residual) = (Vec::new(), Vec::new());
            for _ in &blocks {
                let (a, b) = (uniform(&mut rng), uniform(&mut rng));
                force.extend((0..40).map(|_| a));
                residual.extend((0..40).map(|_| b));
            }
            let z = evidence(&force, &residual, &blocks).z;
            beyond += usize::from(z > 1.645);
            beyond_more += usize::from(z > 2.576);
        }
        // 5 % and 0.5 %: a binomial's deviation is 0.34 % and 0.11 %.
        let share = |n: usize| n as f64 / f64::from(runs);
        assert!((share(beyond) - 0.05).abs() < 0.015, "{}", share(beyond));
        assert!(share(beyond_more) < 0.01, "{}", share(beyond_more));
    }

    #[test]
    fn a_coefficient_that_falls_with_the_force_is_seen() {
        let force: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.1).sin()).collect();
        let bounded: Vec<f64> = force.iter().map(|f| f.clamp(-0.3, 0.3)).collect();
        assert!((at_its_largest(&force, &force) - 1.0).abs() < 1e-12);
        assert!(at_its_largest(&force, &bounded) < 0.35);
        assert_eq!(at_its_largest(&[0.0; 4], &[1.0; 4]), 0.0);
    }

    #[test]
    fn a_force_in_a_single_block_proves_nothing() {
        let blocks = [0..10, 10..20, 20..30, 30..40, 40..50, 50..60, 60..70];
        let force: Vec<f64> = (0..70).map(|i| if i < 10 { 1.0 } else { 0.0 }).collect();
        let found = evidence(&force, &force, &blocks);
        assert!(found.z < 2.0 && found.share > 0.99, "{found:?}");
    }
}
