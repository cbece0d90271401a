//! The ends of a symmetric matrix's spectrum.

/// Sweeps of rotations. Jacobi's method converges quadratically: 5…6 sweeps do for any size that a controller has.
const SWEEPS: u32 = 12;

/// Smallest and largest eigenvalue of a symmetric matrix by cyclic Jacobi rotations: Golub and Van Loan, *Matrix Computations*
/// (4th ed., 2013), section 8.5.
pub(super) fn extremes<const N: usize>(mut m: [[f64; N]; N]) -> (f64, f64) {
    for _ in 0..SWEEPS {
        for p in 0..N {
            for q in p + 1..N {
                if m[p][q] == 0.0 {
                    continue;
                }
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let tangent =
                    libm::copysign(1.0, theta) / (theta.abs() + libm::sqrt(theta * theta + 1.0));
                let cosine = 1.0 / libm::sqrt(tangent * tangent + 1.0);
                let sine = tangent * cosine;
                for row in &mut m {
                    let (a, b) = (row[p], row[q]);
                    row[p] = cosine * a - sine * b;
                    row[q] = sine * a + cosine * b;
                }
                let (above, below) = m.split_at_mut(q);
                for (at_p, at_q) in above[p].iter_mut().zip(&mut below[0]) {
                    let (a, b) = (*at_p, *at_q);
                    *at_p = cosine * a - sine * b;
                    *at_q = sine * a + cosine * b;
                }
            }
        }
    }
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for (k, row) in m.iter().enumerate() {
        ends = (ends.0.min(row[k]), ends.1.max(row[k]));
    }
    ends
}
