//! The outer task.

use super::{
    Ahead, Desk, ErrorLift, ErrorLiftState, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState,
};
use crate::control::{Axis, Move, Pace, Reference};
use crate::param::{Bound, ParamError, nearest};

/// What an outer task is built of: what a host learnt of the loop below (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterSettings<const STATES: usize, const BLOCKS: usize, const MOVES: usize> {
    /// Ticks of a sample.
    pub ticks: u32,
    /// Yield displacements of the lift's blocks (m or rad).
    pub yields: [f64; BLOCKS],
    /// The loop below compensates the blocks along the reference.
    pub compensated: bool,
    /// Part of the error that the map did not foresee which is believed (-).
    pub gain: f64,
    /// The loop's map.
    pub model: KoopmanModel<STATES>,
    /// What is made small.
    pub cost: KoopmanSettings<MOVES>,
}

/// Lift, look ahead and predictive controller, as a board's outer task runs them.
///
/// ```text
/// started: if desk(|d| outer.take(d)) { let force = outer.solve(); desk(|d| d.order(outer.sample(), force)) }
/// ```
/// The reference is known ahead as far as the running move and the one behind it reach. Behind them it stands; a stream of points goes on
/// at its last speed.
#[derive(Clone, Debug)]
pub struct Outer<const STATES: usize, const BLOCKS: usize, const DELAYS: usize, const MOVES: usize>
{
    lift: ErrorLift<STATES, BLOCKS, DELAYS>,
    mpc: KoopmanMpc<STATES, MOVES>,
    /// Ticks of each move, and one over its samples.
    ticks: [u32; MOVES],
    shares: [f32; MOVES],
    /// 2⁻³² counts (m or rad).
    unit: f32,
    lifted: ErrorLiftState<STATES, BLOCKS>,
    state: [f32; STATES],
    plan: KoopmanState<MOVES>,
    /// A copy that goes ahead.
    scout: Reference,
    next: Option<Move>,
    pace: Pace,
    sample: u32,
}

impl<const STATES: usize, const BLOCKS: usize, const DELAYS: usize, const MOVES: usize>
    Outer<STATES, BLOCKS, DELAYS, MOVES>
{
    /// For an axis, whose control task shares the `desk`.
    ///
    /// # Errors
    /// [`ParamError`] where a setting is not finite or out of range.
    pub fn try_new(
        settings: &OuterSettings<STATES, BLOCKS, MOVES>,
        axis: &Axis,
        desk: &Desk,
    ) -> Result<Self, ParamError> {
        let OuterSettings { model, cost, .. } = settings;
        let mpc = KoopmanMpc::try_new(model, cost)?;
        let lift =
            ErrorLift::try_new(&settings.yields, settings.compensated, model, settings.gain)?;
        let longest = cost
            .lengths
            .iter()
            .fold(0, |most, &length| length.max(most));
        // So that the look ahead ends.
        if settings.ticks.saturating_mul(longest) > 100_000 {
            return Err(ParamError::new(
                "ticks of a move",
                settings.ticks.into(),
                Bound::AtMost(100_000.0),
            ));
        }
        let (scout, next, pace) = desk.reference();
        Ok(Self {
            lifted: lift.at_rest(),
            lift,
            mpc,
            ticks: cost.lengths.map(|length| length * settings.ticks),
            shares: cost.lengths.map(|length| 1.0 / length as f32),
            unit: nearest("length of a count", axis.encoder.count / 4_294_967_296.0)?,
            state: [0.0; STATES],
            plan: KoopmanState::new(),
            scout: scout.clone(),
            next,
            pace: pace.clone(),
            sample: 0,
        })
    }

    /// Takes the samples that wait on the desk; whether there were any, and an order is to be found.
    pub fn take(&mut self, desk: &mut Desk) -> bool {
        let mut any = false;
        while let Some(told) = desk.take() {
            if told.first {
                self.lifted = self.lift.at_rest();
                self.plan = KoopmanState::new();
            }
            let error = told.error as f32 * (65_536.0 * self.unit);
            let [travelled, reference] = told.travelled;
            self.state =
                *(self.lift).take(&mut self.lifted, error, travelled, reference, told.force);
            any = true;
        }
        if any {
            let (reference, next, pace) = desk.reference();
            self.scout.become_as(reference);
            self.next = next;
            self.pace.clone_from(pace);
            self.sample = desk.sample();
        }
        any
    }

    /// The sample that was taken last.
    pub fn sample(&self) -> u32 {
        self.sample
    }

    /// The force (N or N·m) for the sample behind it. This takes the time.
    pub fn solve(&mut self) -> f32 {
        let ahead = self.look_ahead();
        self.mpc.solve(&mut self.plan, &self.state, &ahead)
    }

    fn look_ahead(&mut self) -> Ahead<MOVES> {
        let mut ahead = Ahead {
            displacement: [0.0; MOVES],
            below: [f32::INFINITY; MOVES],
            above: [f32::INFINITY; MOVES],
        };
        let mut at = self.scout.position();
        for (j, ticks) in self.ticks.into_iter().enumerate() {
            let end = self.go_ahead(at, ticks);
            ahead.displacement[j] = end.wrapping_sub(at) as f32 * self.unit * self.shares[j];
            if let Some((low, high)) = self.scout.ends(&self.pace) {
                ahead.below[j] = end.wrapping_sub(low) as f32 * self.unit;
                ahead.above[j] = high.wrapping_sub(end) as f32 * self.unit;
            }
            at = end;
        }
        ahead
    }

    /// Where the reference will be so many ticks behind the place `at` (2⁻³² counts).
    fn go_ahead(&mut self, mut at: i64, ticks: u32) -> i64 {
        for left in (1..=i64::from(ticks)).rev() {
            if self.scout.is_idle() {
                match self.next.take() {
                    // One that is refused will not be made.
                    Some(next) => {
                        let _ = self.scout.start(next, &self.pace);
                    }
                    None if self.scout.is_open() => {
                        let speed = self.scout.speed();
                        return at.wrapping_add(speed.wrapping_mul(left));
                    }
                    None if self.scout.is_standing() => return at,
                    None => (),
                }
            }
            at = self.scout.step(&self.pace).position;
        }
        at
    }
}
