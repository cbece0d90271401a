//! A force ramp as an argument: `0,0.9,0,0.6,-0.9@0.01`.

/// Most samples of a ramp, the same as of a recording.
const MOST_SAMPLES: f64 = 1e7;

/// Forces to go to one after the other, at a constant rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Forces (N or N·m) at which the ramp turns; the first is 0, where the body was never moved.
    pub corners: Vec<f64>,
    /// Force per time (N/s or N·m/s).
    pub rate: f64,
}

/// Reads `CORNER,CORNER,…@RATE`.
///
/// # Errors
/// A message for the user: what is no ramp and how one is written.
pub fn parse_ramp(text: &str) -> Result<Ramp, String> {
    const EXAMPLE: &str =
        "write the forces in N and the rate in N/s, such as 0,0.9,0,0.6,-0.9@0.01";
    let (corners, rate) = text
        .split_once('@')
        .ok_or_else(|| format!("`{text}` has no rate; {EXAMPLE}"))?;
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{part}` is not a number; {EXAMPLE}")),
    };
    let corners = corners
        .split(',')
        .map(number)
        .collect::<Result<Vec<_>, _>>()?;
    let rate = number(rate)?;
    if rate <= 0.0 {
        return Err(format!("the rate {rate} is not above zero; {EXAMPLE}"));
    }
    if corners.len() < 2 || corners[0] != 0.0 {
        return Err(format!(
            "a ramp starts at 0 and goes to at least one other force; {EXAMPLE}"
        ));
    }
    Ok(Ramp { corners, rate })
}

impl Ramp {
    /// Times \[s\] and forces, `samples_per_second` \[Hz\] apart. Each leg takes a whole number of samples, so that every
    /// corner is one; the rate is lower by up to one sample a leg.
    ///
    /// # Errors
    /// A message for the user where the sample rate is no rate or gives too many samples.
    pub fn samples(&self, samples_per_second: f64) -> Result<(Vec<f64>, Vec<f64>), String> {
        if !(samples_per_second.is_finite() && samples_per_second > 0.0) {
            return Err(format!("--rate {samples_per_second}: must be above zero"));
        }
        let legs: Vec<(f64, f64, f64)> = self
            .corners
            .windows(2)
            .map(|pair| {
                let samples = (pair[1] - pair[0]).abs() / self.rate * samples_per_second;
                // A hair for rounding: 0.9/0.01·10 must not become 901.
                (pair[0], pair[1], (samples - 1e-6).ceil().max(1.0))
            })
            .collect();
        let all: f64 = legs.iter().map(|leg| leg.2).sum();
        if all > MOST_SAMPLES {
            return Err(format!(
                "the ramp takes {all:.2e} samples, more than {MOST_SAMPLES:.0e}; lower --rate or raise the force's rate"
            ));
        }
        let mut force = vec![0.0];
        for (from, to, samples) in legs {
            let count = samples as usize;
            force.extend((1..=count).map(|i| {
                if i == count {
                    to
                } else {
                    from + (to - from) * i as f64 / samples
                }
            }));
        }
        let t_s = (0..force.len())
            .map(|i| i as f64 / samples_per_second)
            .collect();
        Ok((t_s, force))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_samples_and_time_is_even() {
        let ramp = parse_ramp("0, 0.9,0,-0.35@0.01").expect("valid");
        let (t_s, force) = ramp.samples(10.0).expect("valid");
        assert_eq!(force.len(), 1 + 900 + 900 + 350);
        assert_eq!((force[900], force[1800], force[2150]), (0.9, 0.0, -0.35));
        assert!((t_s[900] - 90.0).abs() < 1e-9);
        assert!(
            force
                .windows(2)
                .all(|p| (p[1] - p[0]).abs() < 0.001 + 1e-12)
        );
    }

    #[test]
    fn what_is_no_ramp_is_refused_with_an_example() {
        for text in [
            "0,1", "0@1", "0.5,1@1", "0,x@1", "0,inf@1", "0,1@0", "0,1@-1", "0,1@nan", "",
        ] {
            let error = parse_ramp(text).expect_err(text);
            assert!(error.contains("0,0.9,0,0.6,-0.9@0.01"), "{error}");
        }
        let ramp = parse_ramp("0,1@1").expect("valid");
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(ramp.samples(rate).is_err(), "{rate}");
        }
    }
}
