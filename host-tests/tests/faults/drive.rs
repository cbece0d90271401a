//! The firmware's application on the simulated stage: what a host asks, over the link's frames, tick by tick.

use super::Outcome;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use fixed::types::I16F16;
use heapless::spsc::{Consumer, Producer, Queue};
use preslide::control::Axis;
use preslide_app::{
    Background, Bridge, Control, Inputs, Limits, Model, Parameters, Queues, RECEIVED, SENT, Start,
    Starting,
};
use preslide_link::{
    Deframer, GainSettings, LARGEST_FRAME, Name, Numbered, Reply, Report, Request, ResetCause,
    State, encode,
};
use preslide_sim::stage::{Stage, StageConfig};
use preslide_store::{LONGEST, Slots};

type Firmware = Starting<I16F16>;

const PAGE: usize = 2048;

/// Two pages of flash.
#[derive(Clone)]
pub struct Flash(pub Vec<u8>);

impl Flash {
    pub fn erased() -> Self {
        Self(vec![0xFF; 2 * PAGE])
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        into.copy_from_slice(&self.0[offset as usize..][..into.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.0[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

fn slots(flash: Flash) -> Slots<Flash> {
    let slots = Slots::new(flash, [0, PAGE as u32], PAGE as u32, Parameters::VERSION);
    slots.expect("two pages")
}

/// The last commands to bridge and brake, and their surroundings.
#[derive(Default)]
pub struct BridgeLog {
    pub code: i32,
    pub closed: bool,
    pub released: bool,
    pub limits: Limits,
    pub delays: [u32; 2],
}

impl Bridge for BridgeLog {
    const GUARDED: bool = true;

    fn drive(&mut self, code: i32) {
        self.code = code;
        self.closed = true;
    }

    fn open(&mut self) {
        self.code = 0;
        self.closed = false;
    }

    fn is_broken(&mut self) -> bool {
        false
    }

    fn limits(&mut self) -> Limits {
        self.limits
    }

    fn release_brake(&mut self, released: bool) {
        self.released = released;
    }

    fn brake_delays(&self) -> [u32; 2] {
        self.delays
    }
}

/// A brake that does what it is told some ticks later, and holds like a stiff spring with some damping.
pub struct HoldingBrake {
    delays: [u32; 2],
    released: bool,
    since: u32,
    holds_m: Option<f64>,
    last_m: f64,
}

impl HoldingBrake {
    /// Ticks to be released, and to hold; it holds.
    pub fn new(delays: [u32; 2]) -> Self {
        Self {
            delays,
            released: false,
            since: u32::MAX - 1_000_000,
            holds_m: Some(0.0),
            last_m: 0.0,
        }
    }

    fn force_n(&mut self, released: bool, at_m: f64) -> f64 {
        if released != self.released {
            (self.released, self.since) = (released, 0);
        }
        self.since += 1;
        if self.since > self.delays[usize::from(!released)] {
            self.holds_m = match released {
                true => None,
                false => self.holds_m.or(Some(at_m)),
            };
        }
        let speed = (at_m - self.last_m) * 20e3;
        self.last_m = at_m;
        self.holds_m
            .map_or(0.0, |held| (held - at_m) * 1e6 - speed * 1000.0)
    }
}

/// A drive that is switched on.
pub struct Drive<M: Model = Firmware> {
    control: Control<M::Friction>,
    background: Background<M>,
    memory: Option<Slots<Flash>>,
    pub bridge: BridgeLog,
    pub stage: Stage,
    /// A mechanical stop on the negative side (m), as stiff as the drive is.
    pub stop_m: Option<f64>,
    /// Limit switches (m), the low one first, perhaps at the other's input.
    pub switches_m: Option<(f64, f64)>,
    pub swapped: bool,
    /// What hangs on the axis, and what holds it.
    pub weight_n: f64,
    pub brake: Option<HoldingBrake>,
    /// The farthest the mass came, and the largest code.
    pub lowest_m: f64,
    pub push: i32,
    to_drive: (Producer<'static, u8>, Consumer<'static, u8>),
    from_drive: (Producer<'static, u8>, Consumer<'static, u8>),
    deframer: Deframer,
    next: u16,
}

impl Drive {
    /// With what is in the flash, as a board starts.
    pub fn on(flash: Flash) -> Self {
        Self::of(Firmware::PAPER, flash)
    }
}

impl<M: Model> Drive<M> {
    /// With this model compiled in; the queues live as long as the program.
    pub fn of(model: M, flash: Flash) -> Self {
        let stage = Stage::try_new(StageConfig {
            seed: 7,
            ..StageConfig::default()
        });
        let stage = stage.expect("the default stage");
        let mut memory = slots(flash);
        let mut record = [0; LONGEST];
        let length = memory.load(&mut record);
        let start = Start {
            axis: Axis::PAPER_AXIS,
            model,
            saved: length.and_then(|length| Parameters::from_bytes(&record[..length])),
            count: stage.reading().count.cast_unsigned(),
            every: 0,
            reset: ResetCause::Power,
        };
        let queues: &'static mut Queues<_> = Box::leak(Box::default());
        let (control, background) = queues.tasks(start).expect("the paper's axis");
        let line: &'static mut Queue<u8, RECEIVED> = Box::leak(Box::default());
        let back: &'static mut Queue<u8, SENT> = Box::leak(Box::default());
        Self {
            control,
            background,
            memory: Some(memory),
            bridge: BridgeLog::default(),
            stage,
            stop_m: None,
            switches_m: None,
            swapped: false,
            weight_n: 0.0,
            brake: None,
            lowest_m: 0.0,
            push: 0,
            to_drive: line.split(),
            from_drive: back.split(),
            deframer: Deframer::new(),
            next: 0,
        }
    }

    /// Switches it off; what the flash holds.
    pub fn off(self) -> Flash {
        self.memory.expect("it has one").flash().clone()
    }

    /// One tick of control, and a turn of the background; the answers that came.
    pub fn tick(&mut self) -> Option<Report> {
        let reading = self.stage.reading();
        let inputs = Inputs {
            count: reading.count.cast_unsigned(),
            index: None,
            // Saturating: what an ADC does.
            supply: (reading.supply_v * 1e3).round() as u16,
            current: (reading.current_a * 1e4).round() as i16,
            late: false,
        };
        let at_m = self.stage.truth().position_m;
        if let Some((low_m, high_m)) = self.switches_m {
            let (low, high) = (at_m < low_m, at_m > high_m);
            self.bridge.limits = match self.swapped {
                true => Limits {
                    low: high,
                    high: low,
                },
                false => Limits { low, high },
            };
        }
        self.control.tick(inputs, &mut self.bridge);
        self.lowest_m = self.lowest_m.min(at_m);
        self.push = self.push.max(self.bridge.code.abs());
        let stop = self
            .stop_m
            .map_or(0.0, |stop_m| (stop_m - at_m).max(0.0) * 4e6);
        let held = match &mut self.brake {
            Some(brake) => brake.force_n(self.bridge.released, at_m),
            None => 0.0,
        };
        let force = stop + held - self.weight_n;
        self.stage.set_external_force_n(force).expect("finite");
        let steps = f64::from(Axis::PAPER_AXIS.hardware.steps);
        self.stage.tick(f64::from(self.bridge.code) / steps);
        let (received, out) = (&mut self.to_drive.1, &mut self.from_drive.0);
        self.background.poll(received, out, &mut self.memory);
        while let Some(byte) = self.from_drive.1.dequeue() {
            if let Some(report) = self.deframer.push(byte) {
                return Some(report.expect("a whole frame"));
            }
        }
        None
    }

    /// Asks, and waits for the answer.
    pub fn ask(&mut self, request: Request) -> Reply {
        let id = self.next;
        self.next += 1;
        let mut frame = [0; LARGEST_FRAME];
        let length = encode(&Numbered { id, request }, &mut frame).expect("it fits");
        for byte in &frame[..length] {
            self.to_drive.0.enqueue(*byte).expect("there is room");
        }
        for _ in 0..2000 {
            match self.tick() {
                Some(Report::Answer { id: of, reply }) if of == id => return reply,
                _ => {}
            }
        }
        panic!("{request:?} is not answered");
    }

    pub fn done(&mut self, request: Request) {
        let reply = self.ask(request);
        assert!(
            matches!(reply, Reply::Done { .. }),
            "{request:?}: {reply:?}"
        );
    }

    pub fn state(&mut self) -> State {
        match self.ask(Request::State) {
            Reply::State(state) => state,
            other => panic!("{other:?}"),
        }
    }

    pub fn get(&mut self, name: &str) -> f32 {
        match self.ask(Request::Get(Name::new(name).expect("a name"))) {
            Reply::Parameter(parameter) => parameter.value,
            other => panic!("{other:?}"),
        }
    }
}

/// A drive whose saved parameters are damaged in every way comes up with those compiled in, disabled, and takes requests.
pub fn corrupt_parameters() -> Outcome {
    let mut drive = Drive::on(Flash::erased());
    let compiled_in = drive.get("gains.proportional");
    for proportional in [2e4, 4e4] {
        drive.done(Request::Gains(GainSettings {
            proportional,
            integral: 3e6,
            derivative: 600.0,
        }));
        drive.done(Request::Save);
    }
    let whole = drive.off();
    let proportional = |flash: &Flash| Drive::on(flash.clone()).get("gains.proportional");
    assert_eq!(proportional(&whole), 4e4, "the newest");
    // The newest record is in the second page: the one before it rules where that is damaged.
    let mut one = whole.clone();
    one.0[PAGE + 40] ^= 0x10;
    assert_eq!(proportional(&one), 2e4, "the one before");
    let mut outcome = Outcome::nothing();
    // Flipped bits, a page half erased, and a record that is whole but of no use: its CRC is right, its numbers are not.
    let mut flipped = one.clone();
    flipped.0[60] ^= 0x01;
    let mut half = one.clone();
    half.0[100..PAGE].fill(0xFF);
    let mut absurd = slots(Flash::erased());
    let mut record = [0; LONGEST];
    let length = slots(whole).load(&mut record).expect("it is whole");
    record[4..length].fill(0x7F);
    absurd.save(&record[..length]).expect("it fits");
    for flash in [flipped, half, absurd.flash().clone()] {
        let mut drive = Drive::on(flash);
        assert_eq!(drive.get("gains.proportional"), compiled_in);
        for _ in 0..2000 {
            let _ = drive.tick();
            let moved = drive.stage.truth().position_m.abs();
            outcome.travel_m = outcome.travel_m.max(moved);
        }
        outcome.push = outcome.push.max(drive.push);
        assert_eq!(drive.state().fault, None);
        drive.done(Request::Enable);
    }
    outcome
}
