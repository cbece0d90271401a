//! What a figure is: axes, series, and how each series is to look.

/// A picture of one or more series over common axes.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// Title; on the page, the caption after the figure's number.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The series, drawn in order, so that the last lies on top.
    pub series: Vec<Series>,
    /// What to see in the figure and where the data come from. What drawing had to leave out is appended to it.
    pub note: String,
}

/// An axis, drawn as "label \[unit\]".
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// The quantity, such as "displacement".
    pub label: String,
    /// The unit that the data are in, such as "m", "N·m" or "%"; empty means dimensionless and is drawn as \[–\].
    /// A unit known to [`display_unit`](super::display_unit) is shown with the prefix that suits the data.
    pub unit: String,
    /// Logarithmic; points at or below zero are left out, and the note says how many.
    pub log: bool,
}

/// One curve or cloud of points.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Abscissae, in the unit of the figure's x axis. NaN breaks the line.
    pub x: Vec<f64>,
    /// Ordinates, in the unit of the figure's y axis; as many as abscissae. NaN breaks the line.
    pub y: Vec<f64>,
    /// Line or points.
    pub style: Style,
    /// How much it stands out.
    pub emphasis: Emphasis,
    /// A colour to keep across figures; `None` takes the next of the palette.
    pub colour: Option<Colour>,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// A mark at every point, no line.
    Points,
    /// A solid line with a mark at every point, for few points.
    LinePoints,
}

/// How much a series stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emphasis {
    /// Thin and pale: background, such as every repeat behind their mean.
    Faint,
    /// The usual weight.
    #[default]
    Normal,
    /// Thick: the series that the figure is about.
    Strong,
}

/// The palette of Okabe and Ito (Color Universal Design, 2008), distinguishable under the common colour-vision
/// deficiencies; ordered so that the colours that read well on white come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// #0072B2
    Blue,
    /// #D55E00
    Vermillion,
    /// #009E73
    Green,
    /// #CC79A7
    Purple,
    /// #E69F00
    Orange,
    /// #56B4E9
    Sky,
    /// #000000, by habit the measurement
    Black,
    /// #F0E442
    Yellow,
}

impl Colour {
    /// All eight, in the order in which series take them.
    pub const PALETTE: [Colour; 8] = [
        Colour::Blue,
        Colour::Vermillion,
        Colour::Green,
        Colour::Purple,
        Colour::Orange,
        Colour::Sky,
        Colour::Black,
        Colour::Yellow,
    ];

    /// Red, green, blue, 0–255.
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Colour::Blue => [0x00, 0x72, 0xB2],
            Colour::Vermillion => [0xD5, 0x5E, 0x00],
            Colour::Green => [0x00, 0x9E, 0x73],
            Colour::Purple => [0xCC, 0x79, 0xA7],
            Colour::Orange => [0xE6, 0x9F, 0x00],
            Colour::Sky => [0x56, 0xB4, 0xE9],
            Colour::Black => [0x00, 0x00, 0x00],
            Colour::Yellow => [0xF0, 0xE4, 0x42],
        }
    }
}

impl Figure {
    /// A figure without series.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Figure {
            title: title.into(),
            x,
            y,
            ..Figure::default()
        }
    }

    /// Adds a series on top of those before it.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Sets the note.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

impl Axis {
    /// A linear axis for data in `unit`.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Axis {
            label: label.into(),
            unit: unit.into(),
            log: false,
        }
    }

    /// The same axis, logarithmic.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.log = true;
        self
    }
}

impl Series {
    /// A solid line through the points.
    pub fn line(name: impl Into<String>, x: Vec<f64>, y: Vec<f64>) -> Self {
        Series {
            name: name.into(),
            x,
            y,
            ..Series::default()
        }
    }

    /// Marks only.
    pub fn points(name: impl Into<String>, x: Vec<f64>, y: Vec<f64>) -> Self {
        Series::line(name, x, y).style(Style::Points)
    }

    /// Sets line or points.
    #[must_use]
    pub fn style(mut self, style: Style) -> Self {
        self.style = style;
        self
    }

    /// Sets how much it stands out.
    #[must_use]
    pub fn emphasis(mut self, emphasis: Emphasis) -> Self {
        self.emphasis = emphasis;
        self
    }

    /// Keeps this colour instead of the palette's next.
    #[must_use]
    pub fn colour(mut self, colour: Colour) -> Self {
        self.colour = Some(colour);
        self
    }
}
