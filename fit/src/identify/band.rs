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
/// Share of friction's force in an octave that the inertia which is missing there must make: no model of friction is so exact that less of its own
/// could not be what it leaves. Where friction is nearly all, that would be any inertia.
const BESIDE_FRICTION: f64 = 0.1;
/// Octaves that are looked at.
const OCTAVES: u32 = 8;

/// Acceleration, effort beside friction and friction of a fit, or what of them is within a band.
type Signals = [Vec<f64>; 3];

/// Products of acceleration, effort beside friction and friction within a band.
#[derive(Clone, Copy)]
struct Products {
    aa: f64,
    ag: f64,
    gg: f64,
    ff: f64,
}

impl Products {
    fn of([a, g, f]: &Signals, rows: &[usize]) -> Self {
        let sum = |of: &dyn Fn(usize) -> f64| rows.iter().map(|i| of(*i)).sum();
        Self {
            aa: sum(&|i| a[i] * a[i]),
            ag: sum(&|i| a[i] * g[i]),
            gg: sum(&|i| g[i] * g[i]),
            ff: sum(&|i| f[i] * f[i]),
        }
    }

    /// Whether the effort follows the acceleration with nearly this inertia, or what is missing may be friction's.
    fn is_followed(&self, inertia: f64) -> bool {
        let missing = (inertia - self.inertia()).powi(2) * self.aa;
        self.inertia() >= NOT_ALL * inertia || missing < BESIDE_FRICTION.powi(2) * self.ff
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
        let friction: Vec<f64> = (best.fitted.iter().zip(a))
            .map(|(f, a)| f - mass * a)
            .collect();
        let effort = self.effort.iter();
        let beside = effort.zip(&friction).map(|(e, f)| e - f).collect();
        let whole = [a.clone(), beside, friction];
        let cutoff = |octave: u32| kinematics.filter.cutoff_hz() / 2.0_f64.powi(octave as i32);
        let below = (1..=OCTAVES).map(|octave| {
            let filter = ZeroPhase::new(recording, cutoff(octave));
            [0, 1, 2].map(|of: usize| filter.smooth(&whole[of]))
        });
        let bands: Vec<Signals> = std::iter::once(whole.clone()).chain(below).collect();
        let rows = self.split.train();
        let whole = Products::of(&bands[0], &rows);
        let octaves: Vec<Products> = bands
            .windows(2)
            .map(|pair| {
                let alone = [0, 1, 2].map(|of: usize| {
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
        let is_followed = |o: &usize| octaves[*o].is_followed(most);
        let first = *told.iter().find(|o| is_followed(o))?;
        (told[0] != first).then(|| cutoff(first as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, load_csv};
    use preslide_host_tests::made::{Blocks, sines};
    use std::f64::consts::TAU;
    use std::fmt::Write as _;

    /// A clean stage whose blocks are not quite those of the search: what they leave of friction is more than the little inertia in the upper octaves.
    #[test]
    fn inertia_that_friction_hides_narrows_no_band() {
        let mut blocks = Blocks::new(&[(2e5, 1e-5), (8e4, 3.75e-5), (2e4, 1.5e-4)]);
        let waves = [[0.02, 0.5, 0.0], [0.01, 1.1, 1.0], [2e-3, 3.0, 2.0]];
        let waves = waves.map(|[size, hertz, phase]| [size, TAU * hertz, phase]);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            let [x, v, a] = sines(&waves, t);
            let force = 5.0 * a + 30.0 * v + blocks.force(x);
            let _ = writeln!(text, "{t:.3},{x:.10},{force:.6}");
        }
        let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
        let recording = recording.expect("valid");
        let found = identify(&recording, &Options::default(), &Progress::new("test", 0));
        let found = found.expect("a fit");
        let said = found.notes(&recording).join("\n");
        println!("{} Hz: {said}", found.band_hz);
        assert!(found.band_hz > 50.0, "{}", found.band_hz);
        assert!(!said.contains("less inertia"), "{said}");
    }
}
