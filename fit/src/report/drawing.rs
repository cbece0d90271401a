//! A figure made ready to draw: display units chosen, points decimated, colours given out. Page and picture share it.

use super::decimate::decimate;
use super::figure::{Axis, Colour, Emphasis, Figure, Series, Style};
use super::scale::{DisplayUnit, display_unit};

/// Points a series at most, in a picture or on a page of few series.
///
/// Four thousand are more than twice the pixels of a wide screen, and 80 kB of page.
pub(super) const POINTS_PER_SERIES: usize = 4000;

/// What both ways of drawing draw.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    pub x: DrawnAxis,
    pub y: DrawnAxis,
    pub curves: Vec<Curve>,
    /// The figure's own note and what was left out.
    pub note: String,
}

#[derive(Clone, Debug)]
pub(super) struct DrawnAxis {
    /// "label \[unit\]"
    pub title: String,
    /// The unit shown, such as "µm".
    pub unit: String,
    pub log: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub name: String,
    /// Opaque; pale when the series is faint.
    pub rgb: [u8; 3],
    pub stroke: Option<Stroke>,
    pub marks: bool,
    /// Line width in CSS pixels.
    pub width: f64,
    /// In display units; both NaN at a gap, finite otherwise.
    pub points: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    Solid,
    Dashed,
    Dotted,
}

impl Drawing {
    /// Prepares `figure` with at most about `most` points a series.
    pub fn new(figure: &Figure, most: usize) -> Self {
        let mut left_out = LeftOut::default();
        let mut raw: Vec<Vec<(f64, f64)>> = figure
            .series
            .iter()
            .map(|series| left_out.drawable(series, &figure.x, &figure.y))
            .collect();
        let largest = |of: fn(&(f64, f64)) -> f64| {
            raw.iter()
                .flatten()
                .map(of)
                .map(f64::abs)
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max)
        };
        let (x, x_factor) = drawn_axis(&figure.x, largest(|p| p.0));
        let (y, y_factor) = drawn_axis(&figure.y, largest(|p| p.1));

        let mut curves = Vec::with_capacity(raw.len());
        for (i, (series, points)) in figure.series.iter().zip(&mut raw).enumerate() {
            let kept = decimate(points, most);
            left_out.decimated(kept.len(), points.len());
            let points = kept
                .into_iter()
                .filter_map(|k| points.get(k))
                .map(|p| (p.0 * x_factor, p.1 * y_factor))
                .collect();
            curves.push(curve(series, i, points));
        }
        if curves.iter().all(|c| c.points.iter().all(|p| p.0.is_nan())) {
            left_out
                .sentences
                .push("There is nothing to draw: no series has a finite point.".into());
        }
        Drawing {
            x,
            y,
            curves,
            note: left_out.note(&figure.note),
        }
    }
}

fn drawn_axis(axis: &Axis, largest: f64) -> (DrawnAxis, f64) {
    let DisplayUnit { unit, factor } = display_unit(&axis.unit, largest);
    let shown = if unit.is_empty() { "–" } else { &unit };
    (
        DrawnAxis {
            title: format!("{} [{shown}]", axis.label),
            unit,
            log: axis.log,
        },
        factor,
    )
}

fn curve(series: &Series, index: usize, points: Vec<(f64, f64)>) -> Curve {
    // Past the eight colours they repeat; dots then tell the second round from the first.
    let first_round = index < Colour::PALETTE.len() || series.colour.is_some();
    let palette = Colour::PALETTE
        .iter()
        .copied()
        .cycle()
        .nth(index % Colour::PALETTE.len());
    let rgb = series.colour.or(palette).unwrap_or(Colour::Black).rgb();
    let stroke = match series.style {
        Style::Points => None,
        Style::Dashed => Some(Stroke::Dashed),
        Style::Line | Style::LinePoints if first_round => Some(Stroke::Solid),
        Style::Line | Style::LinePoints => Some(Stroke::Dotted),
    };
    let (rgb, width) = match series.emphasis {
        // Mixed with white rather than made transparent: overlapping pieces then do not darken.
        Emphasis::Faint => (rgb.map(|c| 255 - (255 - c) / 5 * 2), 1.0),
        Emphasis::Normal => (rgb, 1.5),
        Emphasis::Strong => (rgb, 2.75),
    };
    let marks = matches!(series.style, Style::Points | Style::LinePoints);
    Curve {
        name: series.name.clone(),
        rgb,
        stroke,
        marks,
        width,
        points,
    }
}

/// What cannot be drawn, counted so that the note can say it.
#[derive(Default)]
struct LeftOut {
    not_positive: usize,
    infinite: usize,
    unpaired: usize,
    shown: usize,
    of: usize,
    sentences: Vec<String>,
}

impl LeftOut {
    /// The points of a series with everything that cannot be drawn turned into gaps, and counted.
    fn drawable(&mut self, series: &Series, x_axis: &Axis, y_axis: &Axis) -> Vec<(f64, f64)> {
        self.unpaired += series.x.len().abs_diff(series.y.len());
        let pairs = series.x.iter().zip(&series.y);
        pairs
            .map(|(&x, &y)| {
                if x.is_nan() || y.is_nan() {
                    return (f64::NAN, f64::NAN);
                }
                if x.is_infinite() || y.is_infinite() {
                    self.infinite += 1;
                } else if (x_axis.log && x <= 0.0) || (y_axis.log && y <= 0.0) {
                    self.not_positive += 1;
                } else {
                    return (x, y);
                }
                (f64::NAN, f64::NAN)
            })
            .collect()
    }

    /// Notes the series that lost the most points.
    fn decimated(&mut self, shown: usize, of: usize) {
        if shown < of && of > self.of {
            (self.shown, self.of) = (shown, of);
        }
    }

    fn note(mut self, own: &str) -> String {
        if self.of > 0 {
            self.sentences.push(format!(
                "Drawn with {} of {} points a series; the extremes of every stretch are kept.",
                self.shown, self.of
            ));
        }
        let counted = [
            (
                self.not_positive,
                "at or below zero, which a log axis cannot show",
            ),
            (self.infinite, "with an infinite value"),
            (
                self.unpaired,
                "without a partner (x and y differ in length)",
            ),
        ];
        for (count, what) in counted.into_iter().filter(|(count, _)| *count > 0) {
            let points = if count == 1 { "point" } else { "points" };
            self.sentences
                .push(format!("{count} {points} {what}: left out."));
        }
        self.sentences.insert(0, own.trim().to_string());
        self.sentences.retain(|s| !s.is_empty());
        self.sentences.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(x: Axis, y: Axis, xs: &[f64], ys: &[f64]) -> Figure {
        Figure::new("f", x, y)
            .with(Series::line("a", xs.to_vec(), ys.to_vec()))
            .note("Own note.")
    }

    #[test]
    fn values_and_titles_take_the_display_unit() {
        let f = figure(
            Axis::new("displacement", "m"),
            Axis::new("NMSE", ""),
            &[0.0, 4e-5],
            &[1.0, 2.0],
        );
        let drawing = Drawing::new(&f, 100);
        assert_eq!(drawing.x.title, "displacement [µm]");
        assert_eq!(drawing.y.title, "NMSE [–]");
        assert!((drawing.curves[0].points[1].0 - 40.0).abs() < 1e-12);
        assert_eq!(drawing.note, "Own note.");
    }

    #[test]
    fn what_a_log_axis_cannot_show_is_left_out_and_said() {
        let f = figure(
            Axis::new("N", "").log(),
            Axis::new("NMSE", "%").log(),
            &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            &[1.0, 0.0, -1.0, f64::NAN, f64::INFINITY, 0.1],
        );
        let drawing = Drawing::new(&f, 100);
        let gaps: Vec<bool> = drawing.curves[0]
            .points
            .iter()
            .map(|p| p.1.is_nan())
            .collect();
        assert_eq!(gaps, [false, true, true, true, true, false]);
        assert!(
            drawing.note.contains("2 points at or below zero"),
            "{}",
            drawing.note
        );
        assert!(
            drawing.note.contains("1 point with an infinite value"),
            "{}",
            drawing.note
        );
    }

    #[test]
    fn decimation_keeps_the_peak_and_is_said() {
        let xs: Vec<f64> = (0..50_000).map(f64::from).collect();
        let mut ys = vec![0.0; 50_000];
        ys[25_001] = 3.0;
        let drawing = Drawing::new(
            &figure(Axis::new("t", "s"), Axis::new("F", "N"), &xs, &ys),
            4000,
        );
        assert!(drawing.curves[0].points.contains(&(25_001.0, 3.0)));
        assert!(drawing.note.contains("of 50000 points"), "{}", drawing.note);
    }

    #[test]
    fn unequal_lengths_and_emptiness_are_said() {
        let drawing = Drawing::new(
            &figure(Axis::default(), Axis::default(), &[1.0, 2.0], &[]),
            10,
        );
        assert!(
            drawing.note.contains("2 points without a partner"),
            "{}",
            drawing.note
        );
        assert!(drawing.note.contains("nothing to draw"), "{}", drawing.note);
    }

    #[test]
    fn more_series_than_colours_stay_distinct() {
        let mut f = Figure::default();
        for i in 0..16 {
            f = f.with(Series::line(format!("{i}"), vec![0.0], vec![0.0]));
        }
        let curves = Drawing::new(&f, 10).curves;
        for (i, a) in curves.iter().enumerate() {
            for b in &curves[i + 1..] {
                assert!((a.rgb, a.stroke) != (b.rgb, b.stroke));
            }
        }
    }
}
