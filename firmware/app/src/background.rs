//! The task below the interrupt: requests in, reports out.

use crate::control::refusal;
use crate::log::Log;
use crate::parameters::{Entry, When, place_value};
use crate::queues::{Act, Order, Planned, Seek, Shared, Stall, Status};
use crate::{Model, Parameters, ROOM, telemetry};
use core::sync::atomic::Ordering;
use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};
use preslide::control::{Axis, Coefficients, Move, Planner, Refused};
use preslide_link::{
    Answered, Deframer, GainSettings, Homing, Identity, LARGEST_FRAME, Mode, ModelPart, Numbered,
    PART, POINTS, PROTOCOL, Points, Refusal, Reply, Report, Request, ResetCause, State, encode,
};
use preslide_store::Slots;

/// What comes of a request.
enum Outcome {
    /// This, at once.
    Now(Reply),
    /// What the control task says of the order.
    Ordered,
}

type Carried = Result<Outcome, Refusal>;

/// Reads requests, validates and plans what they ask for, and hands on telemetry.
pub struct Background<M: Model> {
    pub(crate) log: Log,
    pub(crate) deframer: Deframer,
    pub(crate) answered: Answered,
    pub(crate) axis: Axis,
    pub(crate) model: M,
    /// A model of which parts are still to come, and how many parameters have come.
    pub(crate) staged: Option<(usize, M)>,
    pub(crate) planner: Planner,
    pub(crate) reset: ResetCause,
    /// It runs with what was saved.
    pub(crate) saved: bool,
    /// The epoch that the planner plans in; the control task has gone on to another where a motion was broken off.
    pub(crate) epoch: u8,
    /// What was planned last is a stream.
    pub(crate) streaming: bool,
    pub(crate) moves_sent: u16,
    pub(crate) orders_sent: u16,
    /// The request whose order is not carried out yet. None is read before it is.
    pub(crate) pending: Option<u16>,
    pub(crate) status: Status,
    pub(crate) moves: Producer<'static, Planned>,
    pub(crate) orders: Producer<'static, Order<M::Friction>>,
    pub(crate) statuses: Consumer<'static, Status>,
    pub(crate) shared: &'static Shared,
}

impl<M: Model> Background<M> {
    /// Does one thing: answers a request out of the bytes `received`, or hands on a sample; whether there was something to do.
    ///
    /// Neither waits for the line. A request is read when its answer has room in `out`; a sample is handed on when an answer would
    /// still have room behind it, and waits in the queue otherwise, where the control task counts what finds no place.
    pub fn poll<F: NorFlash>(
        &mut self,
        received: &mut Consumer<'_, u8>,
        out: &mut Producer<'_, u8>,
        memory: &mut Option<Slots<F>>,
    ) -> bool {
        while let Some(status) = self.statuses.dequeue() {
            self.status = status;
        }
        self.log.fault(self.status.fault);
        let room = out.capacity() - out.len();
        if room >= LARGEST_FRAME {
            let report = match self.pending {
                Some(id) => self.ordered(id),
                None => self.receive(received, memory),
            };
            if let Some(report) = report {
                send(&report, out);
                return true;
            }
        }
        if room >= 2 * LARGEST_FRAME
            && let Some(sample) = telemetry::take(&self.shared.samples)
        {
            send(&Report::Sample(sample), out);
            return true;
        }
        false
    }

    /// The answer to the request that waits for its order.
    fn ordered(&mut self, id: u16) -> Option<Report> {
        if self.status.orders != self.orders_sent {
            return None;
        }
        self.pending = None;
        let outcome = self.status.outcome.map(|()| self.done());
        Some(self.answer(id, outcome))
    }

    fn receive<F: NorFlash>(
        &mut self,
        received: &mut Consumer<'_, u8>,
        memory: &mut Option<Slots<F>>,
    ) -> Option<Report> {
        loop {
            let byte = received.dequeue()?;
            let Numbered { id, request } = match self.deframer.push(byte) {
                None => continue,
                Some(Ok(request)) => request,
                Some(Err(error)) => return Some(Report::Damaged(error.into())),
            };
            self.shared.heard.store(true, Ordering::Relaxed);
            self.shared.call();
            if matches!(request, Request::Hello) {
                self.answered = Answered::new();
            } else if let Some(reply) = self.answered.find(id) {
                return Some(Report::Answer { id, reply });
            }
            match self.carry_out(request, memory) {
                Ok(Outcome::Ordered) => {
                    self.pending = Some(id);
                    return None;
                }
                Ok(Outcome::Now(reply)) => return Some(self.answer(id, Ok(reply))),
                Err(refusal) => return Some(self.answer(id, Err(refusal))),
            }
        }
    }

    fn answer(&mut self, id: u16, outcome: Result<Reply, Refusal>) -> Report {
        let reply = outcome.unwrap_or_else(|refusal| {
            self.log.refused(id, refusal);
            Reply::Refused(refusal)
        });
        self.answered.add(id, reply);
        Report::Answer { id, reply }
    }

    fn done(&self) -> Reply {
        Reply::Done {
            room: ROOM.saturating_sub(self.moves.len() as u16),
        }
    }

    fn carry_out<F: NorFlash>(
        &mut self,
        request: Request,
        memory: &mut Option<Slots<F>>,
    ) -> Carried {
        let reply = match request {
            Request::Ping => self.done(),
            Request::Hello => Reply::Identity(self.identity()),
            Request::State => Reply::State(self.state()),
            Request::Telemetry { every } => {
                self.shared.every.store(every, Ordering::Relaxed);
                self.shared.call();
                self.done()
            }
            Request::Enable if self.status.fault.is_some() => return Err(Refusal::Faulted),
            Request::Enable => return self.act(Act::Enable),
            Request::Disable => return self.act(Act::Disable),
            Request::Stop => return self.act(Act::Stop),
            Request::Acknowledge => return self.act(Act::Acknowledge),
            Request::Home(homing) => return self.home(homing),
            Request::Zero { position_m } => return self.zero(position_m),
            Request::Jog { speed_m_s } => {
                self.may_move()?;
                let jog = self.planner.jog(speed_m_s.into());
                return self.act(Act::Jog(jog.map_err(|_| Refusal::TooFast)?));
            }
            Request::Move { .. } | Request::MoveTo { .. } | Request::Dwell { .. } => {
                self.plan_move(request)?
            }
            Request::Points(points) => self.plan_points(&points)?,
            Request::Gains(gains) => {
                let axis = with_gains(&self.axis, &gains);
                return self.swap(axis, self.model.clone());
            }
            Request::Model(part) => return self.take_part(&part),
            Request::Get(name) => {
                let entry = Entry::find(&name).ok_or(Refusal::NoParameter)?;
                self.parameter(entry)?
            }
            Request::GetAt(number) => {
                let entry = crate::parameters::TABLE.get(usize::from(number));
                self.parameter(entry.ok_or(Refusal::NoParameter)?)?
            }
            Request::Set(name, value) => {
                let entry = Entry::find(&name).ok_or(Refusal::NoParameter)?;
                return self.set(entry, value);
            }
            Request::Save => self.keep(memory, Slots::save)?,
            Request::Forget => self.keep(memory, |slots, _| slots.forget())?,
        };
        Ok(Outcome::Now(reply))
    }

    fn act(&mut self, act: Act) -> Carried {
        self.order(Order::Act(act))
    }

    fn order(&mut self, order: Order<M::Friction>) -> Carried {
        self.orders.enqueue(order).map_err(|_| Refusal::Busy)?;
        self.shared.call();
        self.orders_sent = self.orders_sent.wrapping_add(1);
        Ok(Outcome::Ordered)
    }

    fn may_move(&self) -> Result<(), Refusal> {
        if self.status.fault.is_some() {
            Err(Refusal::Faulted)
        } else if self.status.mode == Mode::Disabled {
            Err(Refusal::NotEnabled)
        } else {
            Ok(())
        }
    }

    /// Has the planner know where the axis stands. Behind what was planned before it knows already.
    fn locate(&mut self, streams: bool) -> Result<(), Refusal> {
        self.may_move()?;
        let stands = self.status.mode == Mode::Standing;
        let done = stands && self.status.taken == self.moves_sent;
        let broken_off = self.status.epoch != self.epoch;
        if broken_off && !stands {
            return Err(Refusal::NotStanding);
        }
        if broken_off || (self.streaming && done) {
            self.epoch = self.status.epoch;
            let (count, located) = (self.status.reference, self.status.located);
            self.planner.stands(count, located);
        } else if self.streaming && !streams {
            return Err(Refusal::NotStanding);
        }
        self.streaming = streams;
        Ok(())
    }

    fn plan_move(&mut self, request: Request) -> Result<Reply, Refusal> {
        self.locate(false)?;
        if !self.moves.ready() {
            return Err(Refusal::Busy);
        }
        let acceleration = |speed: f32, ramp: f32| f64::from(speed) / f64::from(ramp);
        let planned = match request {
            Request::Move {
                distance_m,
                speed_m_s,
                ramp_s,
            } => self.planner.by(
                distance_m.into(),
                speed_m_s.into(),
                acceleration(speed_m_s, ramp_s),
            ),
            Request::MoveTo {
                position_m,
                speed_m_s,
                ramp_s,
            } => self.planner.to(
                position_m.into(),
                speed_m_s.into(),
                acceleration(speed_m_s, ramp_s),
            ),
            Request::Dwell { time_s } => self.planner.dwell(time_s.into()),
            _ => return Err(Refusal::Unknown),
        };
        let planned = planned.map_err(|error| exceeded(error.parameter))?;
        self.queue(planned)?;
        Ok(self.done())
    }

    /// All points or none.
    fn plan_points(&mut self, points: &Points) -> Result<Reply, Refusal> {
        self.locate(true)?;
        if self.moves.capacity() - self.moves.len() < POINTS {
            return Err(Refusal::Busy);
        }
        let count = self.axis.encoder.count / 65_536.0;
        let mut planner = self.planner.clone();
        let mut at = points.first;
        let mut planned = [None; POINTS];
        let steps = core::iter::once(0).chain(points.steps);
        for (place, step) in planned.iter_mut().zip(steps) {
            at = at.wrapping_add(step.into());
            let point = planner.point(at as f64 * count, points.ticks.into());
            *place = Some(point.map_err(|error| exceeded(error.parameter))?);
        }
        self.planner = planner;
        for point in planned.into_iter().flatten() {
            self.queue(point)?;
        }
        Ok(self.done())
    }

    fn queue(&mut self, next: Move) -> Result<(), Refusal> {
        let planned = (self.epoch, next);
        self.moves.enqueue(planned).map_err(|_| Refusal::Busy)?;
        self.shared.call();
        self.moves_sent = self.moves_sent.wrapping_add(1);
        Ok(())
    }

    fn home(&mut self, homing: Homing) -> Carried {
        self.may_move()?;
        if self.status.mode != Mode::Standing {
            return Err(Refusal::NotStanding);
        }
        let Axis {
            watch,
            motor,
            hardware,
            limits,
            ..
        } = &self.axis;
        let jog = self.planner.jog(homing.speed_m_s.into());
        let (speed, back) = (f64::from(homing.speed_m_s), f64::from(homing.back_off_m));
        let back = match back {
            0.0 => None,
            back if back > 0.0 => {
                let (distance, steep) = (-back.copysign(speed), limits.acceleration);
                let planned = Move::plan(distance, speed.abs(), steep, self.axis.grid());
                Some(planned.map_err(|_| Refusal::OutOfRange)?)
            }
            _ => return Err(Refusal::OutOfRange),
        };
        // Half of what would be a fault.
        let lag = 0.5 * watch.following_error / self.axis.encoder.count;
        let timeout = 0.5 * watch.frozen_time / self.axis.sample_time();
        let push = watch.frozen_duty * motor.supply / motor.resistance;
        let seek = Seek {
            mark: homing.mark,
            jog: jog.map_err(|_| Refusal::TooFast)?,
            to: self.counts(homing.position_m)?,
            lag: (lag as i64).max(1),
            // Below what a current and a count of ticks end at.
            push: ((push / hardware.current_code) as u16).clamp(1, i16::MAX as u16),
            timeout: (timeout as u16).min(u16::MAX - 1),
            stall: Stall::default(),
            back,
        };
        self.act(Act::Seek(seek))
    }

    fn zero(&mut self, position_m: f32) -> Carried {
        if !matches!(self.status.mode, Mode::Standing | Mode::Disabled) {
            return Err(Refusal::NotStanding);
        }
        let to = self.counts(position_m)?;
        self.act(Act::Place(to))
    }

    /// A position (m) in counts.
    fn counts(&self, position_m: f32) -> Result<i64, Refusal> {
        let counts = f64::from(position_m) / self.axis.encoder.count;
        // Comparisons that a NaN fails.
        if !(-1e9..=1e9).contains(&counts) {
            return Err(Refusal::OutOfRange);
        }
        Ok((counts + 0.5_f64.copysign(counts)) as i64)
    }

    fn parameter(&self, entry: &Entry) -> Result<Reply, Refusal> {
        let parameter = entry.read(&self.axis);
        Ok(Reply::Parameter(parameter.ok_or(Refusal::NoParameter)?))
    }

    fn set(&mut self, entry: &Entry, value: f32) -> Carried {
        let disabled = self.status.mode == Mode::Disabled;
        if entry.when == When::Disabled && !disabled {
            return Err(Refusal::Enabled);
        }
        let mut axis = self.axis;
        *(entry.of)(&mut axis).ok_or(Refusal::NoParameter)? = value.into();
        if entry.when == When::Disabled {
            // Enabling tells the new planner where the axis stands.
            self.planner = Planner::try_new(&axis).map_err(|_| Refusal::OutOfRange)?;
        }
        self.swap(axis, self.model.clone())
    }

    /// The model is swapped when its last parameter is there.
    fn take_part(&mut self, part: &ModelPart) -> Carried {
        let first = usize::from(part.first);
        let mut model = match &self.staged {
            _ if first == 0 => self.model.clone(),
            Some((came, model)) if *came == first => model.clone(),
            _ => return Err(Refusal::OutOfRange),
        };
        let table = model.table();
        if table.layout != part.layout {
            return Err(Refusal::OtherModel);
        }
        for (place, value) in table.values.iter_mut().skip(first).zip(part.values) {
            if value.is_nan() {
                return Err(Refusal::OutOfRange);
            }
            place_value(place, value);
        }
        let came = first + PART;
        if came < table.values.len() {
            self.staged = Some((came, model));
            return Ok(Outcome::Now(self.done()));
        }
        let ordered = self.swap(self.axis, model)?;
        // Not where it was refused: the last part may come again once there is room in the queue.
        self.staged = None;
        Ok(ordered)
    }

    /// Nothing is taken unless everything is valid and the swap is on its way.
    fn swap(&mut self, axis: Axis, model: M) -> Carried {
        let coefficients = model
            .build(axis.sample_time())
            .and_then(|friction| Coefficients::try_new(&axis, friction, M::UNITS))
            .map_err(|_| Refusal::OutOfRange)?;
        let ordered = self.order(Order::Swap(coefficients))?;
        self.axis = axis;
        self.model = model;
        Ok(ordered)
    }

    /// Flash stops the processor while it is written: only while the axis is disabled.
    fn keep<F: NorFlash, E>(
        &self,
        memory: &mut Option<Slots<F>>,
        act: impl FnOnce(&mut Slots<F>, &[u8]) -> Result<(), E>,
    ) -> Result<Reply, Refusal> {
        if self.status.mode != Mode::Disabled {
            return Err(Refusal::Enabled);
        }
        let slots = memory.as_mut().ok_or(Refusal::Storage)?;
        let record = Parameters::of(&self.axis, &self.model).to_bytes();
        act(slots, &record).map_err(|_| Refusal::Storage)?;
        Ok(self.done())
    }

    fn identity(&mut self) -> Identity {
        let model = self.model.table().layout;
        let motor = &self.axis.motor;
        Identity {
            protocol: PROTOCOL,
            rate_hz: self.axis.hardware.rate_hz,
            count: self.axis.encoder.count,
            effort_per_a: (motor.torque_constant * motor.transmission()) as f32,
            room: ROOM,
            saved: self.saved,
            model,
        }
    }

    fn state(&self) -> State {
        let status = &self.status;
        State {
            mode: match status.mode {
                // Taken by the time that the host looks again.
                Mode::Standing if status.taken != self.moves_sent => Mode::Moving,
                mode => mode,
            },
            fault: status.fault,
            located: status.located,
            silent: status.silent,
            reset: self.reset,
            tick: status.tick,
            position: status.position,
            queued: self.moves.len() as u16,
            dropped: status.dropped,
            missed: status.missed,
            supply: status.supply,
            current: status.current,
        }
    }
}

/// What a plan exceeded, by the name that the planner gives it.
fn exceeded(parameter: &str) -> Refusal {
    let limits = [
        ("speed", Refused::TooFast),
        ("acceleration", Refused::TooSteep),
        ("end", Refused::BeyondTravel),
        ("point", Refused::BeyondTravel),
    ];
    let limit = limits
        .iter()
        .find(|(begin, _)| parameter.starts_with(begin));
    limit.map_or(Refusal::OutOfRange, |(_, refused)| refusal(*refused))
}

fn with_gains(axis: &Axis, gains: &GainSettings) -> Axis {
    let mut axis = *axis;
    axis.gains.proportional = gains.proportional.into();
    axis.gains.integral = gains.integral.into();
    axis.gains.derivative = gains.derivative.into();
    axis
}

/// Writes a frame to the line's queue, which has room for it.
fn send(report: &Report, out: &mut Producer<'_, u8>) {
    let mut frame = [0; LARGEST_FRAME];
    // Every report fits a frame (a test of the link crate).
    let length = encode(report, &mut frame).unwrap_or(0);
    for &byte in frame.iter().take(length) {
        let _ = out.enqueue(byte);
    }
}
