//! Velocity weakening `s(v)`, tabulated: no exponential and no division in the control tick.

use crate::Scalar;
use crate::param::{
    ParamError, Units, at_least, at_most, fits, not_negative, positive, to_positive, to_scalar,
};

/// Sliding behaviour above breakaway: the Stribeck curve and the frictional lag.
///
/// `s(v) = F_c + (F_s − F_c)·exp(−(|v|/v_s)^δ)` (N), the usual form of the paper's `s(v)` "bounded on the
/// lower end by Coulomb friction" (text before eq. 7; the paper prints no formula).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sliding {
    /// Coulomb force `F_c` (N or N·m), at most the breakaway force `F_s`.
    pub coulomb: f64,
    /// Stribeck velocity `v_s` (m/s or rad/s).
    pub stribeck_velocity: f64,
    /// Stribeck exponent `δ` (-), 1…4; 2 is a Gaussian.
    pub stribeck_exponent: f64,
    /// Attraction parameter `C` (N/s or N·m/s) of eq. (11); `f64::INFINITY` for no frictional lag.
    pub attraction: f64,
}

impl Sliding {
    /// `F_s = F_c` and no lag: the quasi-static law.
    pub fn none(breakaway: f64) -> Self {
        Self {
            coulomb: breakaway,
            stribeck_velocity: 1.0,
            stribeck_exponent: 2.0,
            attraction: f64::INFINITY,
        }
    }

    /// `s(v)/F_s` (-) at the speed `speed ≥ 0` (m/s).
    pub(crate) fn weakening(&self, breakaway: f64, speed: f64) -> f64 {
        let share = self.coulomb / breakaway;
        let decay = libm::pow(speed / self.stribeck_velocity, self.stribeck_exponent);
        share + (1.0 - share) * libm::exp(-decay)
    }

    /// The speed (m/s) at which the exponential has fallen to 1e-4.
    pub(crate) fn levelled(&self) -> f64 {
        const DECAYED: f64 = 9.210_340_371_976_184; // ln 1e4
        self.stribeck_velocity * libm::pow(DECAYED, 1.0 / self.stribeck_exponent)
    }

    pub(crate) fn check(&self, breakaway: f64) -> Result<(), ParamError> {
        positive("Coulomb force", self.coulomb)?;
        at_most("Coulomb force", self.coulomb, breakaway)?;
        positive("Stribeck velocity", self.stribeck_velocity)?;
        at_least("Stribeck exponent", self.stribeck_exponent, 1.0)?;
        at_most("Stribeck exponent", self.stribeck_exponent, 4.0)?;
        if self.attraction != f64::INFINITY {
            not_negative("attraction parameter", self.attraction)?;
        }
        Ok(())
    }
}

/// Intervals of the table.
const INTERVALS: usize = 64;

/// Two functions of speed on one uniform table with linear interpolation.
///
/// It reaches up to the speed where the exponential has fallen to 1e-4 and is flat beyond. Its error in
/// `s(v)/F_s` is at most `4e-3·(1 − F_c/F_s)`, largest at `δ = 1.3`, and `6e-4·(1 − F_c/F_s)` at `δ ≥ 2`
/// (`host-tests` assert it); a cusp sharper than `δ = 1` would need finer nodes near standstill and is refused.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SpeedTable<S> {
    nodes: [[S; 2]; INTERVALS + 1],
    per_velocity: S,
}

impl<S: Scalar> SpeedTable<S> {
    /// `σ(v)` and `λ(v)` of the full law at a fixed sample time (s).
    pub(crate) fn of_law(
        sliding: &Sliding,
        breakaway: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        sliding.check(breakaway)?;
        positive("sample time", sample_time)?;
        at_most("sample time", sample_time, 1.0)?;
        let relaxation = sliding.attraction * sample_time / breakaway;
        Self::try_new(
            sliding,
            breakaway,
            units.velocity,
            ["s(v)/F_s", "lag per tick"],
            |weakening| [weakening, -libm::expm1(-relaxation / weakening)],
        )
    }

    /// Tabulates `functions(s(v)/F_s)` for the sliding law, velocities given in `velocity_unit` (m/s).
    pub(crate) fn try_new(
        sliding: &Sliding,
        breakaway: f64,
        velocity_unit: f64,
        names: [&'static str; 2],
        functions: impl Fn(f64) -> [f64; 2],
    ) -> Result<Self, ParamError> {
        // A place in the table is computed in `S`: a type that cannot count the intervals would never reach
        // its end, and slide with too much friction.
        fits::<S>("number of Stribeck table intervals", INTERVALS as f64)?;
        let end = sliding.levelled();
        let mut nodes = [[S::ZERO; 2]; INTERVALS + 1];
        for (j, node) in nodes.iter_mut().enumerate() {
            let speed = end * j as f64 / INTERVALS as f64;
            let weakening = if j < INTERVALS {
                sliding.weakening(breakaway, speed)
            } else {
                sliding.coulomb / breakaway
            };
            let values = functions(weakening);
            *node = [
                to_positive(names[0], values[0])?,
                to_scalar(names[1], values[1])?,
            ];
        }
        Ok(Self {
            nodes,
            per_velocity: to_positive(
                "Stribeck table nodes per velocity unit",
                INTERVALS as f64 / end * velocity_unit,
            )?,
        })
    }

    /// Both functions at the velocity `v` (its sign does not matter; NaN counts as fast).
    #[inline]
    pub(crate) fn at(&self, v: S) -> [S; 2] {
        let place = v.magnitude().mul_input(self.per_velocity);
        let flat = || self.nodes[INTERVALS];
        let Some(whole) = place.whole_below(INTERVALS) else {
            return flat();
        };
        // The remainder changes nothing; the compiler drops its checks for it.
        let j = whole % INTERVALS;
        let (Some(low), Some(high)) = (self.nodes.get(j), self.nodes.get(j + 1)) else {
            return flat();
        };
        let part = place - S::from_int(whole as i32);
        [
            low[0] + part * (high[0] - low[0]),
            low[1] + part * (high[1] - low[1]),
        ]
    }
}
