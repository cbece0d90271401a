//! Does a model stick and slip? A mass drawn over the friction by a spring whose far end moves steadily.

use preslide::{Friction, Motion};
use preslide_fit::friction::Visitor;

/// Mass \[kg\]: the paper's axis carries 30 N.
const MASS: f64 = 3.0;
/// Stiffness of the spring \[N/m\]: the pull takes 3.6 s to rise from `F_c` to `F_s`, the mass 0.5 s to swing.
const SPRING: f64 = 100.0;
/// Speed of the spring's far end \[m/s\], half of the Stribeck velocity, where the Stribeck curve falls steeply.
const DRAWN: f64 = 5e-4;
/// Viscous coefficient \[N·s/m\], a tenth of the slope `(F_s − F_c)/v_s` with which the Stribeck curve falls there.
const VISCOUS: f64 = 15.0;
/// Step \[s\]: a 170th of the fastest period, mass on pre-sliding stiffness.
const STEP: f64 = 1e-4;
/// Steps before the motion is judged, and steps in which it is: 15 s each, several periods.
const SETTLE: usize = 150_000;
/// See [`SETTLE`].
const JUDGED: usize = 150_000;

/// Speed over the drawn speed, lowest of the window's means and highest.
#[derive(Clone, Copy, Debug)]
pub struct Motions {
    /// Lowest mean over a tenth of a second.
    pub slowest: f64,
    /// Highest mean over a tenth of a second.
    pub fastest: f64,
}

impl Motions {
    /// Nearly at rest for a while and several times as fast as drawn for another.
    pub fn sticks_and_slips(&self) -> bool {
        self.slowest < 0.1 && self.fastest > 2.0
    }
}

/// Runs the motion with a model for ticks of [`Drawn::SAMPLE_TIME`].
pub struct Drawn;

impl Drawn {
    /// Time of a tick \[s\].
    pub const SAMPLE_TIME: f64 = STEP;
}

impl Visitor for Drawn {
    type Outcome = Motions;

    fn visit<M: Friction<Scalar = f64>>(self, model: M) -> Motions {
        const WINDOW: usize = 1000;
        let mut state = model.at_rest();
        let (mut x, mut v, mut friction) = (0.0, 0.0, 0.0);
        let mut found = Motions {
            slowest: f64::INFINITY,
            fastest: 0.0,
        };
        let mut at_window = 0.0;
        for i in 0..SETTLE + JUDGED {
            let pull = SPRING * (DRAWN * STEP * i as f64 - x);
            v += (pull - friction - VISCOUS * v) / MASS * STEP;
            let displacement = v * STEP;
            x += displacement;
            friction = model.step(
                &mut state,
                Motion {
                    displacement,
                    velocity: v,
                },
            );
            if i % WINDOW == 0 {
                let mean = (x - at_window) / (WINDOW as f64 * STEP) / DRAWN;
                at_window = x;
                if i > SETTLE {
                    found.slowest = found.slowest.min(mean);
                    found.fastest = found.fastest.max(mean);
                }
            }
        }
        found
    }
}
