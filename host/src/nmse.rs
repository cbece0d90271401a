//! The paper's measure of fit, eq. (13).

/// Normalised mean square error (%) over `rows`: `100·Σ(F − F̂)² / (N_s·σ²)`, `σ²` being the variance of the
/// measured force about its mean. NaN where the force does not vary.
pub fn nmse(measured: &[f64], modelled: &[f64], rows: &[usize]) -> f64 {
    let mean = rows.iter().map(|&i| measured[i]).sum::<f64>() / rows.len() as f64;
    let (mut error, mut variation) = (0.0, 0.0);
    for &i in rows {
        error += (measured[i] - modelled[i]).powi(2);
        variation += (measured[i] - mean).powi(2);
    }
    100.0 * error / variation
}
