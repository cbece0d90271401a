//! From force to motion, from many places of a recording: what a model says of the next second.

use super::forward::{Body, FIRST, applied, end_slope, one_body};
use crate::friction::Visitor;
use crate::model::Model;
use crate::recording::Recording;
use preslide::Friction;

/// Measured samples for the velocity at a start.
const HEAD: usize = 8;

/// Positions (m or rad) 1, 2, … `steps` samples after each of `starts` in the first piece of the recording. Until a start the friction
/// is loaded by the measured motion; after it only the recorded force is looked at.
///
/// # Errors
/// A model without inertia, effects that need a second body, a parameter that the library refuses.
pub fn motion_from_each(
    model: &Model,
    recording: &Recording,
    starts: &[usize],
    steps: usize,
) -> Result<Vec<Vec<f64>>, String> {
    one_body(model)?;
    let piece = recording.pieces[0].clone();
    let sample_time = recording.sample_time_s();
    let run = Runs {
        inertia: model.inertia,
        force: &applied(model, &recording.effort[piece.clone()], sample_time),
        position: &recording.position[piece],
        sample_time,
        starts,
        steps,
    };
    model.forward_law(sample_time / f64::from(FIRST), run)
}

struct Runs<'a> {
    inertia: f64,
    force: &'a [f64],
    position: &'a [f64],
    sample_time: f64,
    starts: &'a [usize],
    steps: usize,
}

impl Visitor for Runs<'_> {
    type Outcome = Vec<Vec<f64>>;

    fn visit<L: Friction<Scalar = f64>>(self, law: L) -> Self::Outcome {
        let dt = self.sample_time / f64::from(FIRST);
        let mut led = Body::at(&law, self.position[0], 0.0);
        let (mut next, mut all) = (1, Vec::new());
        for &start in self.starts {
            for &place in &self.position[next..=start] {
                led.lead(&law, place, FIRST, dt);
            }
            next = start + 1;
            let head = &self.position[(start + 1).saturating_sub(HEAD)..=start];
            let mut body = Body::<L> {
                v: end_slope(head, self.sample_time),
                state: led.state.clone(),
                ..led
            };
            let positions = self.force[start..=start + self.steps]
                .windows(2)
                .map(|pair| {
                    for step in 0..FIRST {
                        let part = (f64::from(step) + 0.5) / f64::from(FIRST);
                        let force = pair[0] + part * (pair[1] - pair[0]);
                        body.advance(&law, self.inertia, force, dt);
                    }
                    body.x
                });
            all.push(positions.collect());
        }
        all
    }
}
