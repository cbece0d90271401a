//! The coordinates that can organise a mismatch.

use super::signals::Signals;

/// A coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Position (m or rad).
    Position,
    /// Velocity (m/s or rad/s).
    Velocity,
    /// Speed (m/s or rad/s).
    Speed,
    /// Displacement since the last reversal (m or rad).
    SinceReversal,
    /// Acceleration (m/s² or rad/s²).
    Acceleration,
    /// Time (s).
    Time,
    /// Travelled path (m or rad).
    Path,
    /// Temperature (°C).
    Temperature,
    /// Load (N).
    Load,
    /// A further column of the recording, by its number, in its own unit.
    Column(usize),
    /// The velocity of a further column, such as another axis's position.
    ColumnVelocity(usize),
}

impl Axis {
    /// Those over which this recording can have a curve.
    pub fn of(s: &Signals) -> Vec<Axis> {
        let own = [
            Axis::Position,
            Axis::Velocity,
            Axis::Speed,
            Axis::SinceReversal,
            Axis::Acceleration,
            Axis::Time,
            Axis::Path,
            Axis::Temperature,
            Axis::Load,
        ];
        let further = (0..s.extra.len()).flat_map(|i| [Axis::Column(i), Axis::ColumnVelocity(i)]);
        own.into_iter().chain(further).collect()
    }

    /// Whether what follows one of the two coordinates looks alike over the other.
    pub fn is_akin(self, other: Axis) -> bool {
        let family = |axis| match axis {
            Axis::Velocity | Axis::Speed | Axis::Acceleration => 0,
            Axis::Time | Axis::Path | Axis::Temperature => 1,
            Axis::Position => 2,
            _ => 3,
        };
        self == other || family(self) == family(other)
    }

    /// Its name in JSON and tables.
    pub fn name(self, s: &Signals) -> String {
        let column = |i: usize| s.extra.get(i).map_or("further column", |e| &e.0);
        match self {
            Axis::Position => "position",
            Axis::Velocity => "velocity",
            Axis::Speed => "speed",
            Axis::SinceReversal => "displacement since reversal",
            Axis::Acceleration => "acceleration",
            Axis::Time => "time",
            Axis::Path => "path",
            Axis::Temperature => "temperature",
            // Where none was recorded, what the drive passes on besides friction stands for it.
            Axis::Load if s.load.is_none() => "transmitted load",
            Axis::Load => "load",
            Axis::Column(i) => column(i),
            Axis::ColumnVelocity(i) => return format!("velocity of {}", column(i)),
        }
        .to_owned()
    }

    /// Its unit on an axis whose position has the unit `position`.
    pub fn unit(self, position: &str) -> String {
        match self {
            Axis::Position | Axis::SinceReversal | Axis::Path => position.to_owned(),
            Axis::Velocity | Axis::Speed => format!("{position}/s"),
            Axis::Acceleration => format!("{position}/s²"),
            Axis::Time => "s".to_owned(),
            Axis::Temperature => "°C".to_owned(),
            Axis::Load => "N".to_owned(),
            Axis::Column(_) => "as written".to_owned(),
            Axis::ColumnVelocity(_) => "per s".to_owned(),
        }
    }

    /// Its value at every sample, where the recording has it.
    pub fn values(self, s: &Signals) -> Option<Vec<f64>> {
        match self {
            Axis::Position => Some(s.x.clone()),
            Axis::Velocity => Some(s.v.clone()),
            Axis::Speed => Some(s.v.iter().map(|v| v.abs()).collect()),
            Axis::SinceReversal => Some(s.since_reversal.clone()),
            Axis::Acceleration => Some(s.a.clone()),
            Axis::Time => Some(s.t.clone()),
            Axis::Path => Some(s.path.clone()),
            Axis::Temperature => s.temperature.clone(),
            Axis::Load => s.load.clone(),
            Axis::Column(i) => s.extra.get(i).map(|e| e.1.clone()),
            Axis::ColumnVelocity(i) => s.extra.get(i).map(|e| s.smooth_slope(&e.1)),
        }
    }
}
