//! The card of an effect: what of its entry no recording changes.

use super::Effect;
use super::formula::Stated;
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::normal::Bound;
use crate::diagnose::signals::Signals;

/// What an effect is, in words and kinds.
pub struct Card {
    /// Its id in model files and JSON.
    pub id: &'static str,
    /// Its name for a person: "friction spot".
    pub name: &'static str,
    /// What it is, for a control engineer: "a narrow place of higher or lower friction".
    pub words: &'static str,
    /// What it competes with.
    pub class: Class,
    /// The coordinate over which it acts.
    pub axis: Axis,
    /// The experiment that tells it from its rivals.
    pub experiment: &'static str,
    /// The parts of a motion that show it.
    pub shown_by: &'static [Part],
    /// Key of its coefficient, in the units of a linear axis; of a wave that of its amplitude.
    pub coefficient: &'static str,
    /// Shape parameters: key in the units of a linear axis, and scale.
    pub shape: &'static [(&'static str, Scale)],
    /// The spectrum whose lines give further shapes.
    pub line: Option<Line>,
    /// Whether it may act more than once in one machine.
    pub recurs: bool,
    /// Whether its columns are made of the fitted or measured effort itself (then it is no part of that effort's model).
    pub acts_on_effort: bool,
    /// Whether it acts for a while after a stop or a reversal only.
    pub is_transient: bool,
    /// Whether it is a narrow place, which chance makes as well.
    pub is_spot: bool,
    /// How its coefficients are bound wherever they are fitted.
    pub bound: Bound,
    /// Its force as a formula of what is stated of it; `None` for what is no force of the motion at one instant: the drive, the encoder, the channels, and
    /// what ages.
    pub formula: Option<Formula>,
    /// Effects of the same shape that are tried in its place: next to it they are no simpler, and where they predict better it is they.
    pub in_place: &'static [&'static dyn Effect],
    /// What the recording lacks to show it, if anything.
    pub lacks: fn(&Signals) -> Option<&'static str>,
    /// What the recording lacks to tell it well from hysteresis, though it can be named where the data do.
    pub blurred: fn(&Signals) -> Option<&'static str>,
}

/// A force (N or N·m) from stated parameters; `None` where they are others.
pub type Formula = fn(&Stated) -> Option<Expr>;

/// A card of nothing, for what most leave out: each has id, name, words, class, axis and experiment of its own.
pub const BARE: Card = Card {
    id: "",
    name: "",
    words: "",
    class: Class::Plain,
    axis: Axis::Time,
    experiment: "",
    shown_by: &[Part::Passes, Part::Speeds],
    coefficient: "",
    shape: &[],
    line: None,
    recurs: false,
    acts_on_effort: false,
    is_transient: false,
    is_spot: false,
    bound: Bound::Free,
    formula: None,
    in_place: &[],
    lacks: |_| None,
    blurred: |_| None,
};

/// How much an effect may explain by chance, and what it competes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One coefficient that every machine may have: weight, viscous friction, a spring. Tried before all others.
    Plain,
    /// A change of the friction law over speed, load or direction.
    Law,
    /// A place: friction that wanders may repeat there by chance.
    Place,
    /// Slow change over time, path or temperature: friction that wanders may look like it.
    Drift,
    /// The drive, the encoder or the channels.
    Drive,
}

/// How a shape parameter is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// By its logarithm.
    Logarithmic,
    /// By itself, in shares of the travel.
    Travel,
    /// As a period in position: by phase over the travel.
    Period,
    /// As a frequency in time: by phase over the recording.
    Frequency,
    /// Chosen from the grid only.
    Chosen,
}

/// Where lines of the mismatch's spectrum give further shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A period in position of the force.
    Force,
    /// A period in position of the friction level.
    Level,
    /// A period in position of what the drive gives for its command.
    Effort,
    /// A frequency in time of the force.
    Time,
}

/// A motion that shows an effect, for the experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Triangles inside triangles, for hysteresis, backlash and encoder.
    Nested,
    /// The same stroke at speeds of three decades.
    Speeds,
    /// Slow moves after rests of 0.1, 1 and 10 s.
    Rests,
    /// Slow passes over the whole travel, there and back.
    Passes,
    /// Fast strokes, for inertia, delay and elasticity.
    Fast,
    /// The same fast strokes over and over, a rest, and some more: what runs in stays, warmth goes back.
    Again,
}
