//! The task below the interrupt: requests in, reports out.

use crate::{Change, Model};
use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use heapless::spsc::{Consumer, Producer};
use preslide::control::{Coefficients, Move, Settings};
use preslide_link::{Deframer, GainSettings, Refusal, Report, Request, Sample};

/// Reads requests, validates and plans what they ask for, and hands on telemetry.
pub struct Background<M: Model> {
    deframer: Deframer,
    settings: Settings,
    model: M,
    moves: Producer<'static, Move>,
    changes: Producer<'static, Change<M::Friction>>,
    samples: Consumer<'static, Sample>,
    stopped: &'static AtomicBool,
    heard: &'static AtomicBool,
    every: &'static AtomicU16,
}

impl<M: Model> Background<M> {
    pub(crate) fn new(
        settings: Settings,
        model: M,
        moves: Producer<'static, Move>,
        changes: Producer<'static, Change<M::Friction>>,
        samples: Consumer<'static, Sample>,
        stopped: &'static AtomicBool,
        heard: &'static AtomicBool,
        every: &'static AtomicU16,
    ) -> Self {
        Self {
            deframer: Deframer::new(),
            settings,
            model,
            moves,
            changes,
            samples,
            stopped,
            heard,
            every,
        }
    }

    /// Takes a byte of the command link; the answer, when it ended a frame.
    pub fn receive(&mut self, byte: u8) -> Option<Report> {
        let request = self.deframer.push(byte)?;
        self.heard.store(true, Ordering::Relaxed);
        let result = request
            .map_err(Refusal::from)
            .and_then(|r| self.carry_out(r));
        Some(match result {
            Ok(()) => Report::Done,
            Err(refusal) => Report::Refused(refusal),
        })
    }

    /// The next sample of telemetry.
    pub fn sample(&mut self) -> Option<Report> {
        self.samples.dequeue().map(Report::Sample)
    }

    fn carry_out(&mut self, request: Request) -> Result<(), Refusal> {
        match request {
            Request::Ping => Ok(()),
            Request::Move {
                distance_m,
                speed_m_s,
                ramp_s,
            } => {
                let (speed, ramp) = (f64::from(speed_m_s), f64::from(ramp_s));
                let planned = Move::plan(
                    distance_m.into(),
                    speed,
                    speed / ramp,
                    self.settings.grid(),
                );
                self.queue(planned.map_err(|_| Refusal::OutOfRange)?)
            }
            Request::Dwell { time_s } => {
                let planned = Move::dwell(time_s.into(), self.settings.sample_time());
                self.queue(planned.map_err(|_| Refusal::OutOfRange)?)
            }
            Request::Gains(gains) => {
                let settings = with_gains(&self.settings, &gains);
                self.swap(settings, self.model.clone())
            }
            Request::Model(settings) => self.swap(self.settings, self.model.set(&settings)?),
            Request::Restart => self
                .changes
                .enqueue(Change::Restart)
                .map_err(|_| Refusal::Busy),
            Request::Telemetry { every: 0 } => Err(Refusal::OutOfRange),
            Request::Telemetry { every } => {
                self.every.store(every, Ordering::Relaxed);
                Ok(())
            }
        }
    }

    fn queue(&mut self, next: Move) -> Result<(), Refusal> {
        if self.stopped.load(Ordering::Relaxed) {
            return Err(Refusal::Stopped);
        }
        self.moves.enqueue(next).map_err(|_| Refusal::Busy)
    }

    /// Nothing is taken unless everything is valid and the swap is on its way.
    fn swap(&mut self, settings: Settings, model: M) -> Result<(), Refusal> {
        let coefficients = model
            .build(settings.sample_time())
            .and_then(|friction| Coefficients::try_new(&settings, friction, M::UNITS))
            .map_err(|_| Refusal::OutOfRange)?;
        self.changes
            .enqueue(Change::Swap(coefficients))
            .map_err(|_| Refusal::Busy)?;
        self.settings = settings;
        self.model = model;
        Ok(())
    }
}

fn with_gains(settings: &Settings, gains: &GainSettings) -> Settings {
    let mut settings = *settings;
    settings.gains.proportional = gains.proportional.into();
    settings.gains.integral = gains.integral.into();
    settings.gains.derivative = gains.derivative.into();
    settings
}
