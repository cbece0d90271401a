//! How far the loop with the observer is from ringing.

use super::gains::{Belief, Gains};
use super::machine::{Machine, STATES};
use nalgebra::{Complex, DMatrix, DVector, Vector3};
use preslide::control::PidGains;
use std::f64::consts::TAU;

/// The feedback: PID on what the observer sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// The PID's gains.
    pub pid: PidGains,
    /// What the observer believes.
    pub belief: Belief,
    /// The observer's gains.
    pub gains: Gains,
}

/// Distances of the loop from instability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Magnitude of the closed loop's slowest or least damped pole (-): stable below 1.
    pub radius: f64,
    /// By what factor the loop's gain may grow (-).
    pub gain: f64,
    /// By what factor it may shrink (-).
    pub reduction: f64,
    /// Phase margin (degrees), the least of all crossovers.
    pub phase_deg: f64,
    /// Highest crossover (Hz).
    pub crossover_hz: f64,
    /// Smallest distance of the loop's gain from −1 (-): the sensitivity's peak is its reciprocal.
    pub distance: f64,
    /// The loop's largest gain within a tenth of the drive's mode (-).
    pub at_mode: f64,
}

/// Frequencies that are looked at: so many, from so low to half the sample rate, evenly in the logarithm.
const LOOKS: usize = 2000;
const LOWEST_HZ: f64 = 1.0;

/// Observer's estimates, the last command, the integral, and the commands under way.
const OWN: usize = 5;

impl Feedback {
    /// The margins on a machine.
    pub fn margins(&self, machine: &Machine) -> Margins {
        let (a, b, c) = self.open_loop(machine);
        let closed = &a + &b * c.transpose();
        let radius = (closed.complex_eigenvalues().iter())
            .map(|pole| pole.norm())
            .fold(0.0, f64::max);
        let t = self.belief.sample_time;
        let highest = 0.5 / t;
        let hz =
            |look: usize| LOWEST_HZ * (highest / LOWEST_HZ).powf(look as f64 / (LOOKS - 1) as f64);
        let response: Vec<(f64, Complex<f64>)> = (0..LOOKS)
            .map(|look| (hz(look), gain_at(&a, &b, &c, TAU * hz(look) * t)))
            .collect();
        let mut margins = Margins {
            radius,
            gain: f64::INFINITY,
            reduction: f64::INFINITY,
            phase_deg: 180.0,
            crossover_hz: 0.0,
            distance: f64::INFINITY,
            at_mode: 0.0,
        };
        for &(hz, gain) in &response {
            margins.distance = margins.distance.min((gain + 1.0).norm());
            if (hz / machine.mode_hz - 1.0).abs() < 0.1 {
                margins.at_mode = margins.at_mode.max(gain.norm());
            }
        }
        for pair in response.windows(2) {
            let [(_, before), (hz, after)] = [pair[0], pair[1]];
            if (before.norm() - 1.0) * (after.norm() - 1.0) <= 0.0 {
                margins.phase_deg = margins.phase_deg.min((-after).arg().abs().to_degrees());
                margins.crossover_hz = margins.crossover_hz.max(hz);
            }
            if before.im * after.im <= 0.0 && after.re < 0.0 {
                let size = after.norm();
                if size < 1.0 {
                    margins.gain = margins.gain.min(1.0 / size);
                } else {
                    margins.reduction = margins.reduction.min(size);
                }
            }
        }
        margins
    }

    /// The loop, cut where the force acts: `s ← A·s + B·F`, command `C·s`. One tick of the whole loop is written once, and its
    /// matrices are what it makes of unit vectors.
    fn open_loop(&self, machine: &Machine) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let size = STATES + OWN + machine.delay as usize;
        let held = machine.held(self.belief.sample_time);
        let unit = |place: usize| {
            let mut state = vec![0.0; size];
            state[place] = 1.0;
            state
        };
        let columns: Vec<_> = (0..size)
            .map(|place| self.tick(&held, &unit(place), 0.0))
            .collect();
        let a = DMatrix::from_fn(size, size, |row, column| columns[column].0[row]);
        let c = DVector::from_fn(size, |row, _| columns[row].1);
        let b = DVector::from_vec(self.tick(&held, &vec![0.0; size], 1.0).0);
        (a, b, c)
    }

    /// The state after a tick in which `force` was put out, and the command.
    fn tick(
        &self,
        (a, b): &(
            nalgebra::SMatrix<f64, STATES, STATES>,
            nalgebra::SMatrix<f64, STATES, 1>,
        ),
        state: &[f64],
        force: f64,
    ) -> (Vec<f64>, f64) {
        let machine = nalgebra::SVector::<f64, STATES>::from_column_slice(&state[..STATES]);
        let estimate = Vector3::from_column_slice(&state[STATES..STATES + 3]);
        let [last, integral] = [state[STATES + 3], state[STATES + 4]];
        let under_way = &state[STATES + OWN..];

        let (belief, gains, pid) = (&self.belief, &self.gains, &self.pid);
        let read = machine[2];
        let per_force = belief.sample_time / belief.mass;
        let pushed = Vector3::new(belief.sample_time * per_force / 2.0, per_force, 0.0);
        let predicted = belief.transition() * estimate + pushed * last;
        let innovation = read - predicted[0];
        let gain = Vector3::new(gains.position, gains.velocity, -gains.disturbance);
        let estimate = predicted + gain * innovation;
        // Without one it is no state that stays where it is, which would count as a pole.
        let integral = if pid.integral > 0.0 {
            integral + pid.integral * belief.sample_time * read
        } else {
            0.0
        };
        let command =
            estimate[2] - pid.proportional * read - pid.derivative * estimate[1] - integral;

        let acts = under_way.first().copied().unwrap_or(force);
        let machine = a * machine + b * acts;
        let mut next: Vec<f64> = machine.iter().chain(&estimate).copied().collect();
        next.extend([command, integral]);
        if !under_way.is_empty() {
            next.extend(&under_way[1..]);
            next.push(force);
        }
        (next, command)
    }
}

/// `−C·(e^{jΩ} − A)⁻¹·B`; infinite at a pole.
fn gain_at(a: &DMatrix<f64>, b: &DVector<f64>, c: &DVector<f64>, angle: f64) -> Complex<f64> {
    let complex = |x: f64| Complex::new(x, 0.0);
    let z = Complex::from_polar(1.0, angle);
    let mut system = a.map(|x| complex(-x));
    for place in 0..a.nrows() {
        system[(place, place)] += z;
    }
    match system.lu().solve(&b.map(complex)) {
        Some(state) => -(c.map(complex).dot(&state)),
        None => Complex::new(f64::INFINITY, 0.0),
    }
}
