//! Fourier transforms of `f64`.
//!
//! realfft's planners are generic: each crate that names one compiles all transforms again, an eighth of what the host's library comes to.
//! Behind functions that are not generic they are compiled once.

use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::num_complex::Complex64;
pub use realfft::{ComplexToReal, RealToComplex};

/// Transforms of real samples by length; what those of one planner have in common is kept once.
#[derive(Default)]
pub struct Planner(RealFftPlanner<f64>);

impl Planner {
    /// A planner without plans.
    pub fn new() -> Self {
        Self::default()
    }

    /// From `length` samples to their spectrum.
    pub fn forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// From a spectrum to `length` samples, `length` times as large.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.0.plan_fft_inverse(length)
    }
}
