//! Whether the acceleration at the top of the band is the machine's: a periodic error of the encoder moves nothing, and an inertia that is
//! fitted to it comes out too small by the share of its power.

use super::Identification;
use crate::recording::Recording;
use crate::signal::{Kinematics, ZeroPhase};
use crate::statistics::{nmse, quantile};

/// Share of the acceleration's power that must be in an octave to count: less takes less than that off the inertia.
const COUNTS: f64 = 0.01;
/// The inertia that an octave shows, over what most of them show, under which it is not all of the machine's: a load that swings at the top of the
/// band leaves the motor's, a periodic error of the encoder next to none. Octaves of clean machines differ by a tenth.
const NOT_ALL: f64 = 0.8;
/// Least squared correlation of effort and acceleration in a band that shows an inertia.
const SHOWS: f64 = 0.25;
/// Octaves that are looked at.
const OCTAVES: u32 = 8;

/// Products of acceleration and effort within a band.
#[derive(Clone, Copy)]
struct Products {
    aa: f64,
    ag: f64,
    gg: f64,
}

impl Products {
    fn of([a, g]: &[Vec<f64>; 2], rows: &[usize]) -> Self {
        let sum = |of: &dyn Fn(usize) -> f64| rows.iter().map(|i| of(*i)).sum();
        Self {
            aa: sum(&|i| a[i] * a[i]),
            ag: sum(&|i| a[i] * g[i]),
            gg: sum(&|i| g[i] * g[i]),
        }
    }

    fn inertia(&self) -> f64 {
        self.ag / self.aa.max(1e-300)
    }

    /// Squared correlation, where the effort pushes the way that it accelerates.
    fn shown(&self) -> f64 {
        self.ag.max(0.0).powi(2) / (self.aa * self.gg).max(1e-300)
    }
}

impl Identification {
    /// What the fit leaves of what is held out (NMSE, %), as it is seen in a narrower band: what a filter takes off is no better fit.
    pub(super) fn left_within(&self, narrower: &Kinematics) -> f64 {
        let (best, rows) = (self.best(), self.split.train());
        let [effort, fitted] = [&self.effort, &best.fitted];
        let seen = [effort, fitted].map(|values| narrower.filter.smooth(values));
        best.nmse_test * nmse(&seen[0], &seen[1], &rows) / nmse(effort, fitted, &rows).max(1e-300)
    }

    /// The cut-off (Hz) up to which the effort beside friction and plain physics follows the acceleration with the machine's inertia, where that is
    /// below the band's: the inertia that the octaves show in the middle.
    pub(super) fn followed_up_to(
        &self,
        recording: &Recording,
        kinematics: &Kinematics,
    ) -> Option<f64> {
        let a = &kinematics.acceleration;
        let best = self.best();
        let own = |name| best.rigid_body.iter().find(|p| p.0 == name);
        let mass = own("mass").map_or(0.0, |p| p.1.value);
        let fitted = best.fitted.iter().zip(a);
        let beside = fitted.zip(&self.effort).map(|((f, a), e)| e - f + mass * a);
        let whole = [a.clone(), beside.collect()];
        let cutoff = |octave: u32| kinematics.filter.cutoff_hz() / 2.0_f64.powi(octave as i32);
        let below = (1..=OCTAVES).map(|octave| {
            let filter = ZeroPhase::new(recording, cutoff(octave));
            [0, 1].map(|of: usize| filter.smooth(&whole[of]))
        });
        let bands: Vec<[Vec<f64>; 2]> = std::iter::once(whole.clone()).chain(below).collect();
        let rows = self.split.train();
        let whole = Products::of(&bands[0], &rows);
        let octaves: Vec<Products> = bands
            .windows(2)
            .map(|pair| {
                let alone = [0, 1].map(|of: usize| {
                    let both = pair[0][of].iter().zip(&pair[1][of]);
                    both.map(|(upper, lower)| upper - lower).collect()
                });
                Products::of(&alone, &rows)
            })
            .collect();
        let counts = |octave: &Products| octave.aa >= COUNTS * whole.aa;
        let mut shown: Vec<f64> = octaves
            .iter()
            .filter(|octave| counts(octave) && octave.shown() >= SHOWS)
            .map(Products::inertia)
            .collect();
        let most = quantile(&mut shown, 0.5)?;
        let told: Vec<usize> = (0..octaves.len())
            .filter(|o| counts(&octaves[*o]))
            .collect();
        let is_followed = |o: &usize| octaves[*o].inertia() >= NOT_ALL * most;
        let first = *told.iter().find(|o| is_followed(o))?;
        (told[0] != first).then(|| cutoff(first as u32))
    }
}
