//! The outer task.

use super::{
    Ahead, Desk, ErrorLift, ErrorLiftState, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState,
};
use crate::control::{Axis, Move, Pace, Reference};
use crate::param::{ParamError, at_most, nearest};

/// Most samples that it looks ahead.
const AHEAD: usize = 32;

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
/// at its last speed. A copy of the reference goes ahead of it by the horizon, a sample at a time, and begins anew where the two part.
#[derive(Clone, Debug)]
pub struct Outer<const STATES: usize, const BLOCKS: usize, const DELAYS: usize, const MOVES: usize>
{
    lift: ErrorLift<STATES, BLOCKS, DELAYS>,
    mpc: KoopmanMpc<STATES, MOVES>,
    ticks: u32,
    /// Samples to the end of each move, and one over those that it has.
    ends: [usize; MOVES],
    shares: [f32; MOVES],
    /// 2⁻³² counts (m or rad).
    unit: f32,
    lifted: ErrorLiftState<STATES, BLOCKS>,
    state: [f32; STATES],
    plan: KoopmanState<MOVES>,
    /// The copy, what it is to follow next, and whether it has asked for that in vain.
    scout: Reference,
    next: Option<Move>,
    is_dry: bool,
    pace: Pace,
    /// Where the reference is (2⁻³² counts), and will be at the end of each sample ahead; and whether that only goes on by one.
    places: [i64; AHEAD + 1],
    goes_on: bool,
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
        at_most("ticks of an outer sample", settings.ticks.into(), 10_000.0)?;
        let mut ends = [0; MOVES];
        let mut samples = 0.0;
        for (end, length) in ends.iter_mut().zip(cost.lengths) {
            samples += f64::from(length);
            at_most("samples ahead", samples, AHEAD as f64)?;
            *end = samples as usize;
        }
        let (scout, next, pace) = desk.reference();
        Ok(Self {
            lifted: lift.at_rest(),
            lift,
            mpc,
            ticks: settings.ticks,
            ends,
            shares: cost.lengths.map(|length| 1.0 / length as f32),
            unit: nearest("length of a count", axis.encoder.count / 4_294_967_296.0)?,
            state: [0.0; STATES],
            plan: KoopmanState::new(),
            scout: scout.clone(),
            next,
            is_dry: false,
            pace: *pace,
            places: [0; AHEAD + 1],
            goes_on: false,
            sample: 0,
        })
    }

    /// Takes the samples that wait on the desk; whether there were any, and an order is to be found.
    pub fn take(&mut self, desk: &mut Desk) -> bool {
        let mut samples = 0;
        while let Some(told) = desk.take() {
            if told.first {
                self.lifted = self.lift.at_rest();
                self.plan = KoopmanState::new();
            }
            let error = told.error as f32 * (65_536.0 * self.unit);
            let [travelled, reference] = told.travelled;
            self.state =
                *(self.lift).take(&mut self.lifted, error, travelled, reference, told.force);
            samples += 1;
        }
        if samples > 0 {
            let (reference, next, pace) = desk.reference();
            self.goes_on = samples == 1 && self.foresaw(reference, next, pace);
            if !self.goes_on {
                self.scout.become_as(reference);
                self.pace.clone_from(pace);
                self.is_dry = false;
            }
            // The copy may have taken it already.
            self.next = next.filter(|_| self.scout.plan() == reference.plan());
            self.sample = desk.sample();
        }
        samples > 0
    }

    /// The copy is where the reference will be, as far as anybody knows.
    fn foresaw(&self, reference: &Reference, next: Option<Move>, pace: &Pace) -> bool {
        let is_known = if self.scout.plan() == reference.plan() {
            !(self.is_dry && next.is_some())
        } else {
            next.as_ref() == Some(self.scout.plan())
        };
        let is_there = self.places[1] == reference.position();
        let has_ends = self.scout.ends(&self.pace) == reference.ends(pace);
        is_known && is_there && has_ends && self.pace == *pace
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
        let samples = self.ends[MOVES - 1];
        if self.goes_on {
            self.places.copy_within(1..=samples, 0);
            self.places[samples] = self.go_ahead(self.places[samples - 1]);
        } else {
            self.places[0] = self.scout.position();
            for sample in 1..=samples {
                self.places[sample] = self.go_ahead(self.places[sample - 1]);
            }
        }
        let mut ahead = Ahead {
            displacement: [0.0; MOVES],
            below: [f32::INFINITY; MOVES],
            above: [f32::INFINITY; MOVES],
        };
        let mut from = self.places[0];
        for (j, end) in self.ends.into_iter().enumerate() {
            let to = self.places[end];
            ahead.displacement[j] = to.wrapping_sub(from) as f32 * self.unit * self.shares[j];
            if let Some((low, high)) = self.scout.ends(&self.pace) {
                ahead.below[j] = to.wrapping_sub(low) as f32 * self.unit;
                ahead.above[j] = high.wrapping_sub(to) as f32 * self.unit;
            }
            from = to;
        }
        ahead
    }

    /// Where the copy is a sample behind the place `at`.
    fn go_ahead(&mut self, mut at: i64) -> i64 {
        for left in (1..=i64::from(self.ticks)).rev() {
            if self.scout.is_idle() {
                match self.next.take() {
                    Some(next) => {
                        // One that is refused will not be made.
                        let _ = self.scout.start(next, &self.pace);
                    }
                    None => {
                        self.is_dry = true;
                        if self.scout.is_open() {
                            return at.wrapping_add(self.scout.speed().wrapping_mul(left));
                        }
                        if self.scout.is_standing() {
                            return at;
                        }
                    }
                }
            }
            at = self.scout.step(&self.pace).position;
        }
        at
    }
}
