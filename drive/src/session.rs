//! Requests and their answers.

use crate::{DriveError, Line};
use preslide_link::{
    Deframer, Identity, LARGEST_FRAME, Mode, ModelPart, Name, Numbered, PART, PROTOCOL, Parameter,
    Refusal, Reply, Report, Request, Sample, State, encode,
};
use std::io::ErrorKind;
use std::time::{Duration, Instant, SystemTime};

/// A request that is not answered in this time is sent again, under the same number.
const PATIENCE: Duration = Duration::from_millis(400);
/// How often: 10 s in all, which an emulator on a busy machine may need.
const ATTEMPTS: u32 = 25;
/// Samples kept for the caller to take; older ones are forgotten first.
const KEPT: usize = 200_000;

/// A conversation with a controller.
pub struct Drive {
    line: Box<dyn Line>,
    deframer: Deframer,
    next: u16,
    samples: std::collections::VecDeque<Sample>,
    bytes: u64,
    damaged: u64,
    identity: Identity,
}

impl Drive {
    /// Begins a conversation: asks who is there.
    ///
    /// # Errors
    /// [`DriveError::Silent`], [`DriveError::Protocol`] or [`DriveError::Line`].
    pub fn begin(line: Box<dyn Line>) -> Result<Self, DriveError> {
        // Numbers need not be the same in the next conversation.
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let identity = Identity {
            protocol: 0,
            rate_hz: 0,
            count: 0.0,
            effort_per_a: 0.0,
            room: 0,
            saved: false,
            model: 0,
        };
        let mut drive = Self {
            line,
            deframer: Deframer::new(),
            next: now.map_or(0, |now| now.subsec_nanos() as u16),
            samples: std::collections::VecDeque::new(),
            bytes: 0,
            damaged: 0,
            identity,
        };
        // Ends whatever the last one left half said.
        drive.write(&[0])?;
        match drive.ask(Request::Hello)? {
            Reply::Identity(identity) if identity.protocol == PROTOCOL => drive.identity = identity,
            Reply::Identity(identity) => return Err(DriveError::Protocol(identity.protocol)),
            _ => return Err(DriveError::Answer("hello".to_owned())),
        }
        drive.samples.clear();
        Ok(drive)
    }

    /// Who is there.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The telemetry that came since the last call.
    pub fn take_samples(&mut self) -> Vec<Sample> {
        self.samples.drain(..).collect()
    }

    /// Asks, and waits for the answer; asks again, under the same number, where none comes.
    ///
    /// # Errors
    /// [`DriveError::Refused`], [`DriveError::Silent`] or [`DriveError::Line`].
    pub fn ask(&mut self, request: Request) -> Result<Reply, DriveError> {
        let id = self.send(request)?;
        let before = self.bytes;
        for _ in 0..ATTEMPTS {
            let start = Instant::now();
            while start.elapsed() < PATIENCE {
                match self.pump(id)? {
                    Some(Reply::Refused(refusal)) => {
                        let request = name(&request);
                        return Err(DriveError::Refused { request, refusal });
                    }
                    Some(reply) => return Ok(reply),
                    None => {}
                }
            }
            self.send_as(id, request)?;
        }
        Err(DriveError::Silent {
            request: name(&request),
            bytes: self.bytes - before,
            damaged: self.damaged,
        })
    }

    /// As [`Drive::ask`], but asks again later where the controller is busy.
    ///
    /// # Errors
    /// As [`Drive::ask`].
    pub fn insist(&mut self, request: Request) -> Result<Reply, DriveError> {
        loop {
            match self.ask(request) {
                Err(DriveError::Refused {
                    refusal: Refusal::Busy,
                    ..
                }) => self.listen(Duration::from_millis(5))?,
                answer => return answer,
            }
        }
    }

    /// Sends the parameters of a friction model of this layout; the controller takes them without a bump when the last are there.
    ///
    /// # Errors
    /// As [`Drive::ask`].
    pub fn load(&mut self, layout: u32, parameters: &[f64]) -> Result<(), DriveError> {
        for (part, sent) in parameters.chunks(PART).enumerate() {
            let mut values = [0.0; PART];
            for (value, parameter) in values.iter_mut().zip(sent) {
                *value = *parameter as f32;
            }
            // No model has more than the link takes, which a byte counts.
            let first = (part * PART) as u8;
            self.insist(Request::Model(ModelPart {
                layout,
                first,
                values,
            }))?;
        }
        Ok(())
    }

    /// How the controller is.
    ///
    /// # Errors
    /// As [`Drive::ask`].
    pub fn state(&mut self) -> Result<State, DriveError> {
        match self.ask(Request::State)? {
            Reply::State(state) => Ok(state),
            _ => Err(DriveError::Answer("state".to_owned())),
        }
    }

    /// Stops the axis: the first thing to do.
    ///
    /// # Errors
    /// As [`Drive::ask`].
    pub fn stop(&mut self) -> Result<(), DriveError> {
        self.ask(Request::Stop).map(|_| ())
    }

    /// A parameter by its name; `None` if none has that name.
    ///
    /// # Errors
    /// As [`Drive::ask`], but for [`Refusal::NoParameter`].
    pub fn get(&mut self, text: &str) -> Result<Option<f64>, DriveError> {
        let Some(name) = Name::new(text) else {
            return Ok(None);
        };
        self.parameter(Request::Get(name))
            .map(|found| found.map(|parameter| parameter.value.into()))
    }

    /// All parameters.
    ///
    /// # Errors
    /// As [`Drive::ask`].
    pub fn parameters(&mut self) -> Result<Vec<Parameter>, DriveError> {
        let mut all = Vec::new();
        for number in 0..=u8::MAX {
            match self.parameter(Request::GetAt(number))? {
                Some(parameter) => all.push(parameter),
                None => break,
            }
        }
        Ok(all)
    }

    fn parameter(&mut self, request: Request) -> Result<Option<Parameter>, DriveError> {
        match self.ask(request) {
            Ok(Reply::Parameter(parameter)) => Ok(Some(parameter)),
            Ok(_) => Err(DriveError::Answer(name(&request))),
            Err(DriveError::Refused {
                refusal: Refusal::NoParameter,
                ..
            }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Waits until the axis stands, with the controller hearing that the host is there; stops it when `stop` says so.
    ///
    /// # Errors
    /// [`DriveError::Stopped`], [`DriveError::Fault`], [`DriveError::Disabled`], or as [`Drive::ask`].
    pub fn wait(&mut self, mut stop: impl FnMut() -> bool) -> Result<State, DriveError> {
        let mut stopped = false;
        loop {
            let state = self.state()?;
            match (state.fault, state.mode) {
                (Some(fault), _) => return Err(DriveError::Fault(fault)),
                (None, Mode::Disabled) => return Err(DriveError::Disabled),
                (None, Mode::Standing) if stopped => return Err(DriveError::Stopped),
                (None, Mode::Standing) => return Ok(state),
                _ => {}
            }
            if !stopped && stop() {
                self.stop()?;
                stopped = true;
            }
            self.listen(Duration::from_millis(20))?;
        }
    }

    /// Takes what comes for this long.
    ///
    /// # Errors
    /// [`DriveError::Line`].
    pub fn listen(&mut self, time: Duration) -> Result<(), DriveError> {
        let start = Instant::now();
        while start.elapsed() < time {
            self.pump(self.next.wrapping_sub(1))?;
        }
        Ok(())
    }

    fn send(&mut self, request: Request) -> Result<u16, DriveError> {
        let id = self.next;
        self.next = id.wrapping_add(1);
        self.send_as(id, request)?;
        Ok(id)
    }

    fn send_as(&mut self, id: u16, request: Request) -> Result<(), DriveError> {
        let mut frame = [0; LARGEST_FRAME];
        // Every request fits a frame: a test of the link's.
        let length = encode(&Numbered { id, request }, &mut frame).unwrap_or(0);
        self.write(frame.get(..length).unwrap_or_default())
    }

    fn write(&mut self, mut bytes: &[u8]) -> Result<(), DriveError> {
        while !bytes.is_empty() {
            match self.line.write(bytes) {
                Ok(0) => return Err(DriveError::Line(ErrorKind::WriteZero.into())),
                Ok(length) => bytes = bytes.get(length..).unwrap_or_default(),
                Err(error) if is_timeout(&error) => {}
                Err(error) => return Err(DriveError::Line(error)),
            }
        }
        self.line.flush().map_err(DriveError::Line)
    }

    /// Takes what has come; the answer to the request `id`, if it was among it.
    fn pump(&mut self, id: u16) -> Result<Option<Reply>, DriveError> {
        let mut buffer = [0; 4096];
        let length = match self.line.read(&mut buffer) {
            Ok(0) => return Err(DriveError::Line(ErrorKind::UnexpectedEof.into())),
            Ok(length) => length,
            Err(error) if is_timeout(&error) => 0,
            Err(error) => return Err(DriveError::Line(error)),
        };
        self.bytes += length as u64;
        let mut answer = None;
        for byte in buffer.iter().take(length) {
            match self.deframer.push::<Report>(*byte) {
                Some(Ok(Report::Sample(sample))) => {
                    if self.samples.len() >= KEPT {
                        self.samples.pop_front();
                    }
                    self.samples.push_back(sample);
                }
                Some(Ok(Report::Answer { id: of, reply })) if of == id => answer = Some(reply),
                // The answer to a request that was answered before.
                Some(Ok(Report::Answer { .. })) | None => {}
                Some(Ok(Report::Damaged(_)) | Err(_)) => self.damaged += 1,
            }
        }
        Ok(answer)
    }
}

fn is_timeout(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

/// A request's name, for messages.
fn name(request: &Request) -> String {
    let text = format!("{request:?}");
    let end = text.find([' ', '(', '{']).unwrap_or(text.len());
    text.get(..end).unwrap_or_default().to_lowercase()
}
