//! Fewer points for the same picture.

/// Indices, in order, of the points to keep so that at most `most` remain.
///
/// The series is cut into buckets of equal count. Of each bucket the first and last point, the extremes of x and of y,
/// and the first gap (a point with NaN) stay, so that peaks, the outline of a loop and breaks in the line survive.
/// At most `most` points are kept, or seven where `most` is less.
pub(super) fn decimate(points: &[(f64, f64)], most: usize) -> Vec<usize> {
    if points.len() <= most {
        return (0..points.len()).collect();
    }
    // With x in order, its extremes are the ends of the bucket.
    let ascending = points
        .iter()
        .filter(|p| !is_gap(p))
        .is_sorted_by_key(|p| p.0);
    let has_gaps = points.iter().any(is_gap);
    let per_bucket = if ascending { 4 } else { 6 } + usize::from(has_gaps);
    let buckets = (most / per_bucket).max(1);
    let kept = extremes(points, buckets);
    // One point is often several of the extremes; what that saves goes into finer buckets.
    let finer = extremes(points, buckets * most / kept.len().max(1));
    if finer.len() <= most { finer } else { kept }
}

fn is_gap(p: &(f64, f64)) -> bool {
    p.0.is_nan() || p.1.is_nan()
}

/// Indices of first, last, extremes and first gap of each of about `buckets` stretches.
fn extremes(points: &[(f64, f64)], buckets: usize) -> Vec<usize> {
    let size = points.len().div_ceil(buckets.max(1)).max(1);
    let mut kept = Vec::new();
    for (bucket, chunk) in points.chunks(size).enumerate() {
        let finite = || chunk.iter().enumerate().filter(|(_, p)| !is_gap(p));
        type Point<'a> = (usize, &'a (f64, f64));
        let by_x = |a: &Point, b: &Point| a.1.0.total_cmp(&b.1.0);
        let by_y = |a: &Point, b: &Point| a.1.1.total_cmp(&b.1.1);
        let mut of_bucket: Vec<usize> = [
            finite().next(),
            finite().next_back(),
            finite().min_by(by_x),
            finite().max_by(by_x),
            finite().min_by(by_y),
            finite().max_by(by_y),
        ]
        .into_iter()
        .flatten()
        .map(|(i, _)| i)
        .chain(chunk.iter().position(is_gap))
        .map(|i| bucket * size + i)
        .collect();
        of_bucket.sort_unstable();
        of_bucket.dedup();
        kept.extend(of_bucket);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_series_stays_whole() {
        let points: Vec<_> = (0..10).map(|i| (f64::from(i), 0.0)).collect();
        assert_eq!(decimate(&points, 10), (0..10).collect::<Vec<_>>());
        assert_eq!(decimate(&[], 10), Vec::<usize>::new());
    }

    #[test]
    fn single_sample_peaks_survive_and_the_count_holds() {
        let mut points: Vec<_> = (0..100_000)
            .map(|i| (f64::from(i), (f64::from(i) * 0.01).sin()))
            .collect();
        points[33_333].1 = 7.0;
        points[77_777].1 = -9.0;
        let kept = decimate(&points, 4000);
        assert!(kept.len() <= 4000 && kept.len() > 2500, "{}", kept.len());
        assert!(kept.is_sorted_by(|a, b| a < b));
        for i in [0, 33_333, 77_777, 99_999] {
            assert!(kept.contains(&i), "{i} lost");
        }
    }

    #[test]
    fn a_loop_keeps_its_extremes_in_x_and_y() {
        // Lissajous figure with one spike in x: only the extremes of x can keep it.
        let mut points: Vec<_> = (0..50_000)
            .map(|i| f64::from(i) * 1e-3)
            .map(|t| (t.sin(), (2.0 * t).cos()))
            .collect();
        points[12_345].0 = 3.0;
        let kept = decimate(&points, 1000);
        assert!(kept.len() <= 1000 && kept.contains(&12_345));
    }

    #[test]
    fn a_gap_survives() {
        let mut points: Vec<_> = (0..20_000).map(|i| (f64::from(i), 1.0)).collect();
        points[9_999].1 = f64::NAN;
        assert!(decimate(&points, 500).contains(&9_999));
    }
}
