//! What is smooth over the travel, in columns.

/// Degree of the curve: a slow variation over the travel.
pub const DEGREE: usize = 8;

/// Legendre polynomials of degree 1 to [`DEGREE`].
pub fn legendre(u: f64) -> [f64; DEGREE] {
    let mut p = [u; DEGREE];
    let mut before = 1.0;
    for d in 1..DEGREE {
        let n = d as f64;
        p[d] = ((2.0 * n + 1.0) * u * p[d - 1] - n * before) / (n + 1.0);
        before = p[d - 1];
    }
    p
}
