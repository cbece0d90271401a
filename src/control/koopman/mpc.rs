//! The quadratic problem of a sample, condensed when it is built, and a fixed number of iterations on it.

use super::spectrum::extremes;
use crate::param::{ParamError, at_least, at_most, nearest, not_negative, positive};

/// `ψ⁺ = A·ψ + B·u + C·Δr`, a sample long (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KoopmanModel<const STATES: usize> {
    /// `A`, row by row. The first state is the following error (m or rad), reference less position.
    pub map: [[f64; STATES]; STATES],
    /// `B`: what the decided force adds (per N or N·m).
    pub force: [f64; STATES],
    /// `C`: what the reference's displacement in the sample adds (per m or rad).
    pub reference: [f64; STATES],
}

/// What is made small, within which limits (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KoopmanSettings<const MOVES: usize> {
    /// Samples for which each decided force is held. Short ones first: only the first is ever applied. Their sum is the horizon.
    pub lengths: [u32; MOVES],
    /// Weight of a squared force held for a sample, against a squared error (m²/N² or rad²/(N·m)²).
    pub effort: f64,
    /// Weight of a squared change of the force from one move to the next (m²/N² or rad²/(N·m)²).
    pub change: f64,
    /// Bound on the force (N or N·m).
    pub force: f64,
    /// Bound on the force's change in a sample (N or N·m).
    pub slew: f64,
    /// Weight of a squared excursion beyond the travel at the end of a move, against a squared error (-).
    pub travel: f64,
    /// Iterations of the fast gradient in a sample.
    pub iterations: u32,
}

/// What is known of the moves that are decided on (m or rad).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ahead<const MOVES: usize> {
    /// The reference's mean displacement in a sample of each move.
    pub displacement: [f32; MOVES],
    /// From the low end of travel to the reference at the end of each move; infinite where there is none.
    pub below: [f32; MOVES],
    /// From the reference to the high end.
    pub above: [f32; MOVES],
}

/// ```text
/// min Σ e_k² + effort·Σ u_k² + change·Σ (u_j − u_{j−1})² + travel·Σ max(0, beyond the ends)²
/// |u_j| ≤ force, |u_0 − u_{−1}| ≤ slew, and each later one in reach of u_{−1}
/// ```
/// over `MOVES` held forces; the errors are those that [`KoopmanModel`] predicts. The limits of force and slew are a box and never
/// exceeded by what is applied. The travel's ends are a penalty: a predicted error may not be avoidable, and a problem without a solution
/// is no use in a tick; what stops an axis there is its planner and its controller.
///
/// **Iterations.** Nesterov's projected gradient of constant momentum from the last plan, one sample on (*Introductory Lectures on Convex
/// Optimization*, 2004, section 2.2; for control: Richter, Jones, Morari, IEEE TAC 57(6), 2012): `u⁺ = Π(y − ∇J(y)/L)`,
/// `y⁺ = u⁺ + β·(u⁺ − u)`, every force in units in which the cost bends alike. After `i` of them what the plan costs more than the best
/// one is at most `(1 − √(μ/L))^i` of what the start costs more plus `μ/2·‖u − u*‖²`, which is no more than the start costs more: so
/// twice [`KoopmanMpc::contraction`]. `L` and `μ` are the ends of the spectrum of the problem's matrix, found when it is built.
///
/// ```
/// use preslide::control::koopman::{Ahead, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState};
///
/// // An error that a spring returns to rest, and 1 N moves by 1 µm in a sample.
/// let model = KoopmanModel { map: [[0.9]], force: [-1e-6], reference: [1.0] };
/// let settings = KoopmanSettings {
///     lengths: [1, 1, 2, 4], effort: 1e-14, change: 1e-14, force: 2.0, slew: 0.5, travel: 10.0, iterations: 20,
/// };
/// let mpc = KoopmanMpc::try_new(&model, &settings)?;
/// let ahead = Ahead { displacement: [0.0; 4], below: [f32::INFINITY; 4], above: [f32::INFINITY; 4] };
/// let mut state = KoopmanState::new();
/// assert_eq!(mpc.solve(&mut state, &[5e-6], &ahead), 0.5); // as much as the slew allows
/// assert!(mpc.contraction() < 0.2); // less than two fifths of the start's excess cost are left
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct KoopmanMpc<const STATES: usize, const MOVES: usize> {
    /// Of the cost, each row over `L` and the move's own curvature: its matrix, and what lift and reference add to its gradient.
    matrix: [[f32; MOVES]; MOVES],
    by_lift: [[f32; STATES]; MOVES],
    by_reference: [[f32; MOVES]; MOVES],
    /// What the force before adds to the first entry of the gradient.
    by_last: f32,
    /// The error at the end of each move, of lift, reference and forces; and the penalty as the cost's gradient.
    ends: Ends<STATES, MOVES>,
    penalty: [f32; MOVES],
    momentum: f32,
    force: f32,
    /// How far the force gets from what it was until each move.
    reach: [f32; MOVES],
    /// One over each length.
    shares: [f32; MOVES],
    iterations: u32,
    contraction: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct Ends<const STATES: usize, const MOVES: usize> {
    lift: [[f32; STATES]; MOVES],
    reference: [[f32; MOVES]; MOVES],
    force: [[f32; MOVES]; MOVES],
}

/// What a [`KoopmanMpc`] remembers: its plan, and the force that it gave last.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KoopmanState<const MOVES: usize> {
    plan: [f32; MOVES],
    last: f32,
}

impl<const MOVES: usize> KoopmanState<MOVES> {
    /// No force, no plan.
    pub const fn new() -> Self {
        Self {
            plan: [0.0; MOVES],
            last: 0.0,
        }
    }

    /// The forces (N or N·m) that are planned, move by move.
    pub fn plan(&self) -> &[f32; MOVES] {
        &self.plan
    }
}

impl<const MOVES: usize> Default for KoopmanState<MOVES> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const STATES: usize, const MOVES: usize> KoopmanMpc<STATES, MOVES> {
    /// Condenses the problem.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or leaves a gradient that `f32` cannot hold.
    pub fn try_new(
        model: &KoopmanModel<STATES>,
        settings: &KoopmanSettings<MOVES>,
    ) -> Result<Self, ParamError> {
        const { assert!(STATES > 0 && MOVES > 0) };
        for &length in &settings.lengths {
            at_least("length of a move", length.into(), 1.0)?;
            at_most("length of a move", length.into(), 1000.0)?;
        }
        at_least("iterations", settings.iterations.into(), 1.0)?;
        positive("weight of the force", settings.effort)?;
        not_negative("weight of the force's change", settings.change)?;
        let penalty = not_negative("weight of the travel", settings.travel)?;
        let condensed = Condensed::of(model, settings);
        let stiffest = condensed.with_ends(penalty);
        // Each force in units in which the cost bends alike: its limits stay a box, and the spectrum narrows.
        let mut units = [0.0; MOVES];
        for (j, unit) in units.iter_mut().enumerate() {
            *unit = 1.0 / libm::sqrt(positive("curvature of the cost", stiffest[j][j])?);
        }
        let (least, _) = extremes(scaled(&condensed.matrix, &units));
        // Rounding to `f32` must not make it larger than what a step is of.
        let greatest = 1.0001 * extremes(scaled(&stiffest, &units)).1;
        positive("curvature of the cost", greatest)?;
        let ratio = libm::sqrt(least.max(0.0) / greatest);
        let steps = units.map(|unit| unit * unit / greatest);
        let mut start = 0;
        let reach = settings.lengths.map(|length| {
            let before = start;
            start += length;
            f64::from(before + 1) * settings.slew
        });
        positive("slew of the force", settings.slew)?;
        Ok(Self {
            matrix: held(&condensed.matrix, &steps)?,
            by_lift: held(&condensed.by_lift, &steps)?,
            by_reference: held(&condensed.by_reference, &steps)?,
            by_last: nearest("cost's gradient", -settings.change * steps[0])?,
            ends: Ends {
                lift: held(&condensed.ends.lift, &[1.0; MOVES])?,
                reference: held(&condensed.ends.reference, &[1.0; MOVES])?,
                force: held(&condensed.ends.force, &[1.0; MOVES])?,
            },
            penalty: held(&[steps], &[penalty])?[0],
            momentum: nearest("momentum", (1.0 - ratio) / (1.0 + ratio))?,
            force: nearest(
                "bound on the force",
                positive("bound on the force", settings.force)?,
            )?,
            reach: held(&[reach], &[1.0])?[0],
            shares: settings.lengths.map(|length| 1.0 / length as f32),
            iterations: settings.iterations,
            contraction: libm::pow(1.0 - ratio, settings.iterations.into()),
        })
    }

    /// `(1 − √(μ/L))^i` (-): at most twice this part of what the start costs more than the best plan is left.
    pub fn contraction(&self) -> f64 {
        self.contraction
    }

    /// The force (N or N·m) of the next sample, from the lifted state of this one.
    ///
    /// No loop depends on the values; what a limit costs more or less is counted (`firmware/cycles`). A lift that is no number lets the
    /// force go as fast as it may.
    pub fn solve(
        &self,
        state: &mut KoopmanState<MOVES>,
        lifted: &[f32; STATES],
        ahead: &Ahead<MOVES>,
    ) -> f32 {
        let mut linear = [0.0; MOVES];
        for (j, entry) in linear.iter_mut().enumerate() {
            *entry =
                dot(&self.by_lift[j], lifted) + dot(&self.by_reference[j], &ahead.displacement);
        }
        linear[0] += self.by_last * state.last;
        let mut free = [0.0; MOVES];
        for (j, entry) in free.iter_mut().enumerate() {
            *entry =
                dot(&self.ends.lift[j], lifted) + dot(&self.ends.reference[j], &ahead.displacement);
        }
        let boxes = self.boxes(state.last);
        let mut plan = self.one_sample_on(state.plan);
        for (u, (low, high)) in plan.iter_mut().zip(boxes) {
            *u = within(*u, low, high);
        }
        let mut leap = plan;
        for _ in 0..self.iterations {
            let slope = self.slope(&linear, &free, &leap, ahead);
            for j in 0..MOVES {
                let (low, high) = boxes[j];
                let next = within(leap[j] - slope[j], low, high);
                leap[j] = next + self.momentum * (next - plan[j]);
                plan[j] = next;
            }
        }
        state.plan = plan;
        state.last = plan[0];
        plan[0]
    }

    /// The cost's gradient, each entry over `L` and its own curvature.
    #[inline]
    fn slope(
        &self,
        linear: &[f32; MOVES],
        free: &[f32; MOVES],
        at: &[f32; MOVES],
        ahead: &Ahead<MOVES>,
    ) -> [f32; MOVES] {
        let mut slope = *linear;
        for (entry, row) in slope.iter_mut().zip(&self.matrix) {
            *entry += dot(row, at);
        }
        for (j, row) in self.ends.force.iter().enumerate() {
            let error = free[j] + dot(row, at);
            // The position is the reference less the error.
            let beyond = if error > ahead.below[j] {
                error - ahead.below[j]
            } else if error < -ahead.above[j] {
                error + ahead.above[j]
            } else {
                continue;
            };
            for ((entry, part), penalty) in slope.iter_mut().zip(row).zip(&self.penalty) {
                *entry += penalty * beyond * part;
            }
        }
        slope
    }

    fn boxes(&self, last: f32) -> [(f32, f32); MOVES] {
        self.reach.map(|reach| {
            let low = within(last - reach, -self.force, self.force);
            (low, within(last + reach, -self.force, self.force))
        })
    }

    /// The plan's means over the same moves a sample later.
    fn one_sample_on(&self, plan: [f32; MOVES]) -> [f32; MOVES] {
        let mut on = plan;
        for j in 0..MOVES - 1 {
            on[j] += self.shares[j] * (plan[j + 1] - plan[j]);
        }
        on
    }
}

/// What is no number goes to the end that is nearest to no force.
#[inline]
fn within(value: f32, low: f32, high: f32) -> f32 {
    if value > high {
        high
    } else if value >= low {
        value
    } else if value < low || low > 0.0 {
        low
    } else if high < 0.0 {
        high
    } else {
        0.0
    }
}

#[inline]
fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// A matrix in `f32`, each row times its factor.
fn held<const N: usize, const M: usize>(
    matrix: &[[f64; N]; M],
    factors: &[f64; M],
) -> Result<[[f32; N]; M], ParamError> {
    let mut rows = [[0.0; N]; M];
    for ((to, from), factor) in rows.iter_mut().zip(matrix).zip(factors) {
        for (to, from) in to.iter_mut().zip(from) {
            *to = nearest("entry of the condensed problem", from * factor)?;
        }
    }
    Ok(rows)
}

fn scaled<const N: usize>(matrix: &[[f64; N]; N], units: &[f64; N]) -> [[f64; N]; N] {
    let mut scaled = *matrix;
    for (j, row) in scaled.iter_mut().enumerate() {
        for (k, entry) in row.iter_mut().enumerate() {
            *entry *= units[j] * units[k];
        }
    }
    scaled
}

/// The cost as `½·uᵀ·M·u + uᵀ·(lift + reference + last)`.
struct Condensed<const STATES: usize, const MOVES: usize> {
    matrix: [[f64; MOVES]; MOVES],
    by_lift: [[f64; STATES]; MOVES],
    by_reference: [[f64; MOVES]; MOVES],
    ends: ExactEnds<STATES, MOVES>,
}

struct ExactEnds<const STATES: usize, const MOVES: usize> {
    lift: [[f64; STATES]; MOVES],
    reference: [[f64; MOVES]; MOVES],
    force: [[f64; MOVES]; MOVES],
}

/// What the first state is a number of samples on: of the lift now, and of every move's force and reference.
struct Response<const STATES: usize, const MOVES: usize> {
    by_lift: [f64; STATES],
    to_force: [[f64; STATES]; MOVES],
    to_reference: [[f64; STATES]; MOVES],
}

impl<const STATES: usize, const MOVES: usize> Response<STATES, MOVES> {
    /// A sample on, which belongs to `held`.
    fn step(&mut self, model: &KoopmanModel<STATES>, held: usize) {
        let mut row = [0.0; STATES];
        for (weight, from) in self.by_lift.iter().zip(&model.map) {
            for (to, entry) in row.iter_mut().zip(from) {
                *to += weight * entry;
            }
        }
        self.by_lift = row;
        for (responses, by) in [
            (&mut self.to_force, &model.force),
            (&mut self.to_reference, &model.reference),
        ] {
            for (j, response) in responses.iter_mut().enumerate() {
                let before = *response;
                for (i, entry) in response.iter_mut().enumerate() {
                    *entry = if j == held { by[i] } else { 0.0 };
                    for (a, b) in model.map[i].iter().zip(&before) {
                        *entry += a * b;
                    }
                }
            }
        }
    }
}

impl<const STATES: usize, const MOVES: usize> Condensed<STATES, MOVES> {
    fn of(model: &KoopmanModel<STATES>, settings: &KoopmanSettings<MOVES>) -> Self {
        let mut all = Self {
            matrix: [[0.0; MOVES]; MOVES],
            by_lift: [[0.0; STATES]; MOVES],
            by_reference: [[0.0; MOVES]; MOVES],
            ends: ExactEnds {
                lift: [[0.0; STATES]; MOVES],
                reference: [[0.0; MOVES]; MOVES],
                force: [[0.0; MOVES]; MOVES],
            },
        };
        let mut first = [0.0; STATES];
        first[0] = 1.0;
        let mut now = Response {
            by_lift: first,
            to_force: [[0.0; STATES]; MOVES],
            to_reference: [[0.0; STATES]; MOVES],
        };
        for (held, &length) in settings.lengths.iter().enumerate() {
            for _ in 0..length {
                now.step(model, held);
                for j in 0..MOVES {
                    let own = now.to_force[j][0];
                    for k in 0..MOVES {
                        all.matrix[j][k] += own * now.to_force[k][0];
                        all.by_reference[j][k] += own * now.to_reference[k][0];
                    }
                    for (to, from) in all.by_lift[j].iter_mut().zip(&now.by_lift) {
                        *to += own * from;
                    }
                }
            }
            all.ends.lift[held] = now.by_lift;
            all.ends.reference[held] = now.to_reference.map(|response| response[0]);
            all.ends.force[held] = now.to_force.map(|response| response[0]);
            all.matrix[held][held] += settings.effort * f64::from(length) + settings.change;
            if held > 0 {
                all.matrix[held - 1][held - 1] += settings.change;
                all.matrix[held - 1][held] -= settings.change;
                all.matrix[held][held - 1] -= settings.change;
            }
        }
        all
    }

    /// The matrix where the travel's ends press at the end of every move.
    fn with_ends(&self, penalty: f64) -> [[f64; MOVES]; MOVES] {
        let mut matrix = self.matrix;
        for row in &self.ends.force {
            for j in 0..MOVES {
                for k in 0..MOVES {
                    matrix[j][k] += penalty * row[j] * row[k];
                }
            }
        }
        matrix
    }
}
