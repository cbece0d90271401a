//! How far a model is from its reference.

/// Largest, root-mean-square and mean difference, in the unit of what was compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// Largest absolute difference.
    pub max: f64,
    sum: f64,
    squares: f64,
    samples: f64,
    threshold: f64,
    above: f64,
}

impl Deviation {
    /// Counts the samples that differ by more than `threshold`.
    pub fn counting_above(threshold: f64) -> Self {
        Self {
            threshold,
            ..Self::default()
        }
    }

    /// Share of the samples above the threshold.
    pub fn share_above(&self) -> f64 {
        self.above / self.samples
    }

    /// Takes in one pair. A NaN difference counts as infinite.
    pub fn add(&mut self, model: f64, reference: f64) {
        let difference = model - reference;
        let size = if difference.is_nan() {
            f64::INFINITY
        } else {
            difference.abs()
        };
        self.max = self.max.max(size);
        self.sum += difference;
        self.squares += difference * difference;
        self.samples += 1.0;
        if size > self.threshold {
            self.above += 1.0;
        }
    }

    /// Root mean square difference.
    pub fn rms(&self) -> f64 {
        (self.squares / self.samples).sqrt()
    }

    /// Mean difference, model minus reference.
    pub fn bias(&self) -> f64 {
        self.sum / self.samples
    }

    /// Asserts all three (the bias by its magnitude), naming `what` was compared.
    pub fn assert_within(&self, what: &str, max: f64, rms: f64, bias: f64) {
        assert!(
            self.max <= max,
            "{what}: largest deviation {:e} exceeds {max:e}",
            self.max
        );
        assert!(
            self.rms() <= rms,
            "{what}: RMS deviation {:e} exceeds {rms:e}",
            self.rms()
        );
        assert!(
            self.bias().abs() <= bias,
            "{what}: bias {:e} exceeds {bias:e}",
            self.bias()
        );
    }
}
