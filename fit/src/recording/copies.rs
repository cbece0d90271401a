//! Pieces that are given twice: a copy proves nothing, and would be fitted and held out at once.

use super::Recording;
use crate::statistics::bounds;
use std::ops::Range;

/// Code of the warning that names copies.
pub const COPIES: &str = "copies";

/// Share of a column's range by which a copy may differ: what resampling to even times later by the clock makes of it. No motion repeats
/// itself so closely that every sample of position and effort is the same.
const ROUNDED: f64 = 1e-6;

impl Recording {
    /// Without the pieces whose position, effort and further columns are those of an earlier piece, which a warning names.
    pub(super) fn without_copies(self) -> Recording {
        let further = self.extra.iter().map(|extra| &extra.values);
        let columns = [&self.position, &self.effort].into_iter().chain(further);
        let columns: Vec<(&Vec<f64>, f64)> = columns
            .map(|column| {
                let (low, high) = bounds(column);
                (column, ROUNDED * (high - low))
            })
            .collect();
        let same = |a: &Range<usize>, b: &Range<usize>| {
            a.len() == b.len()
                && columns.iter().all(|(values, rounded)| {
                    let mut pairs = values[a.clone()].iter().zip(&values[b.clone()]);
                    pairs.all(|(a, b)| (a - b).abs() <= *rounded)
                })
        };
        let mut inside = vec![true; self.len()];
        for (i, piece) in self.pieces.iter().enumerate() {
            if self.pieces[..i].iter().any(|earlier| same(earlier, piece)) {
                inside[piece.clone()].fill(false);
            }
        }
        let copies = inside.iter().filter(|i| !**i).count();
        if copies == 0 {
            return self;
        }
        let mut once = self.masked(&inside);
        once.warnings.push(warning!(
            COPIES,
            "{copies} of {} samples are copies of others: left out, as they add nothing",
            self.len()
        ));
        once
    }
}

#[cfg(test)]
mod tests {
    use super::super::Recording;
    use super::super::tests::{read, said};

    fn swing(seed: f64) -> Recording {
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..3000 {
            let t = f64::from(i) * 1e-3;
            let (sin, cos) = (7.0 * t).sin_cos();
            let noise = (seed + 1e4 * sin).sin();
            text += &format!("{t:.3},{:.7},{:.5}\n", 0.01 * sin, cos + 0.01 * noise);
        }
        read(&text)
    }

    #[test]
    fn a_copy_is_left_out_and_a_repetition_is_not() {
        let once = swing(1.0);
        // With what resampling makes of a copy.
        let mut copy = once.clone();
        copy.effort.iter_mut().for_each(|f| *f *= 1.0 + 1e-9);
        let whole = Recording::join(vec![once.clone(), swing(2.0), copy]).expect("joined");
        assert_eq!(whole.len(), 2 * once.len());
        assert_eq!((whole.pieces.len(), whole.joined.len()), (2, 3));
        assert!(whole.joined[2].is_empty());
        assert!(said(&whole, super::COPIES).contains("3000 of 9000"));
        let apart = Recording::join(vec![swing(1.0), swing(2.0)]).expect("joined");
        assert_eq!(apart.len(), 6000);
    }
}
