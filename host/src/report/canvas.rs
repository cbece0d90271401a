//! The picture's layout, lines and text.
//!
//! plotters supplies pixels, glyphs and filled shapes. The layout is ours, so that the legend never covers data, and so
//! are the joints of lines, because mitred ones put spikes on reversals.

use std::sync::LazyLock;

use anyhow::bail;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis_ticks::{Span, Tick};
use super::drawing::{Curve, Drawing, Stroke};

/// Drawn this many times larger, then averaged.
pub(super) const OVERSAMPLING: i32 = 2;
/// Pixels of the picture per CSS pixel of the page: what is 420 px high there is about 1000 here.
const DENSITY: f64 = 2.0;

/// Font sizes and distances, in pixels of the oversampled picture.
const TITLE: i32 = 36 * OVERSAMPLING;
const LABEL: i32 = 30 * OVERSAMPLING;
const TICK: i32 = 26 * OVERSAMPLING;
const NOTE: i32 = 22 * OVERSAMPLING;
const PAD: i32 = 14 * OVERSAMPLING;
const EDGE: i32 = 28 * OVERSAMPLING;

const INK: RGBColor = RGBColor(0x1a, 0x1a, 0x1a);
const FRAME: RGBColor = RGBColor(0x44, 0x44, 0x44);
const GRID: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Pixel = (i32, i32);

/// Name under which the font is known to plotters, which finds no fonts of the system in this configuration.
const FONT: &str = "preslide";
static FONT_REGISTERED: LazyLock<bool> = LazyLock::new(|| {
    plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .is_ok()
});

/// Where data are drawn, in pixels.
struct Frame {
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    x: Span,
    y: Span,
}

impl Frame {
    fn x_pixel(&self, value: f64) -> i32 {
        self.left + (self.x.fraction(value) * f64::from(self.right - self.left)).round() as i32
    }

    fn y_pixel(&self, value: f64) -> i32 {
        self.bottom - (self.y.fraction(value) * f64::from(self.bottom - self.top)).round() as i32
    }
}

/// The picture while it is drawn, oversampled.
pub(super) struct Canvas<'a> {
    area: Area<'a>,
}

impl<'a> Canvas<'a> {
    /// Draws on `area`, once the font is there.
    pub fn new(area: Area<'a>) -> anyhow::Result<Self> {
        if !*FONT_REGISTERED {
            bail!(
                "the built-in font is not readable: rebuild with the version of epaint_default_fonts in Cargo.lock"
            );
        }
        Ok(Canvas { area })
    }

    /// Lays out from the edges inwards: title and legend from the top, note and x axis from the bottom, y axis from the
    /// left; the frame takes what remains.
    pub fn figure(
        &self,
        title: &str,
        drawing: &Drawing,
        width: i32,
        height: i32,
    ) -> anyhow::Result<()> {
        let (left, right) = (EDGE, width - EDGE);
        let mut top = EDGE;
        for line in self.wrap(title, TITLE, right - left, 2)? {
            self.text(&line, TITLE, (left, top), (HPos::Left, VPos::Top))?;
            top += TITLE * 5 / 4;
        }
        if drawing.curves.len() > 1 {
            top = self.legend(&drawing.curves, left, right, top)?;
        }
        let mut bottom = height - EDGE;
        for line in self
            .wrap(&drawing.note, NOTE, right - left, 4)?
            .iter()
            .rev()
        {
            bottom -= NOTE * 5 / 4;
            self.text(line, NOTE, (left, bottom), (HPos::Left, VPos::Top))?;
        }
        bottom -= LABEL + PAD;
        let x_title_at = bottom;
        bottom -= TICK + PAD;

        let points = || drawing.curves.iter().flat_map(|c| &c.points);
        let x = Span::over(points().map(|p| p.0), drawing.x.log);
        let y = Span::over(points().map(|p| p.1), drawing.y.log);
        let (x_ticks, y_ticks) = (x.ticks(9), y.ticks(7));
        let mut widest = 0;
        for tick in &y_ticks {
            widest = widest.max(self.width(&tick.text, TICK)?);
        }
        let frame = Frame {
            left: left + LABEL + PAD + widest + PAD,
            right,
            top: top + PAD,
            bottom,
            x,
            y,
        };

        self.axes(&frame, &x_ticks, &y_ticks)?;
        let x_middle = (frame.left + frame.right) / 2;
        self.text(
            &drawing.x.title,
            LABEL,
            (x_middle, x_title_at),
            (HPos::Center, VPos::Top),
        )?;
        self.upwards(
            &drawing.y.title,
            LABEL,
            (left, (frame.top + frame.bottom) / 2),
        )?;
        for curve in &drawing.curves {
            self.curve(curve, &frame)?;
        }
        Ok(())
    }

    fn axes(&self, frame: &Frame, x_ticks: &[Tick], y_ticks: &[Tick]) -> anyhow::Result<()> {
        for tick in x_ticks {
            let x = frame.x_pixel(tick.at);
            self.line((x, frame.top), (x, frame.bottom), GRID, OVERSAMPLING)?;
            self.text(
                &tick.text,
                TICK,
                (x, frame.bottom + PAD / 2),
                (HPos::Center, VPos::Top),
            )?;
        }
        for tick in y_ticks {
            let y = frame.y_pixel(tick.at);
            self.line((frame.left, y), (frame.right, y), GRID, OVERSAMPLING)?;
            self.text(
                &tick.text,
                TICK,
                (frame.left - PAD / 2, y),
                (HPos::Right, VPos::Center),
            )?;
        }
        let corners = [(frame.left, frame.top), (frame.right, frame.bottom)];
        self.area.draw(&Rectangle::new(
            corners,
            FRAME.stroke_width(OVERSAMPLING as u32),
        ))?;
        Ok(())
    }

    /// Draws the legend in rows from `top` down and returns where it ends.
    fn legend(&self, curves: &[Curve], left: i32, right: i32, top: i32) -> anyhow::Result<i32> {
        const ROW: i32 = TICK * 3 / 2;
        const SWATCH: i32 = 3 * TICK;
        const MOST_ROWS: i32 = 6;
        let (mut x, mut row) = (left, 0);
        for (i, curve) in curves.iter().enumerate() {
            let name = self
                .wrap(&curve.name, TICK, (right - left) / 2, 1)?
                .concat();
            let width = SWATCH + PAD + self.width(&name, TICK)? + 2 * PAD;
            if x > left && x + width > right {
                (x, row) = (left, row + 1);
            }
            let middle = top + row * ROW + ROW / 2;
            if row == MOST_ROWS {
                let rest = format!("… and {} more", curves.len() - i);
                self.text(&rest, TICK, (x, middle), (HPos::Left, VPos::Center))?;
                break;
            }
            self.swatch(curve, x, x + SWATCH, middle)?;
            self.text(
                &name,
                TICK,
                (x + SWATCH + PAD, middle),
                (HPos::Left, VPos::Center),
            )?;
            x += width;
        }
        Ok(top + (row + 1) * ROW)
    }

    /// A piece of the curve with at most one mark, for the legend.
    fn swatch(&self, curve: &Curve, left: i32, right: i32, y: i32) -> anyhow::Result<()> {
        self.stroke(curve, &[(left, y), (right, y)])?;
        if curve.marks {
            self.mark(((left + right) / 2, y), curve)
        } else {
            Ok(())
        }
    }

    fn curve(&self, curve: &Curve, frame: &Frame) -> anyhow::Result<()> {
        for run in curve
            .points
            .split(|p| p.0.is_nan() || p.1.is_nan())
            .filter(|run| !run.is_empty())
        {
            let mut pixels: Vec<Pixel> = run
                .iter()
                .map(|p| (frame.x_pixel(p.0), frame.y_pixel(p.1)))
                .collect();
            pixels.dedup();
            self.stroke(curve, &pixels)?;
            if curve.marks {
                pixels.iter().try_for_each(|at| self.mark(*at, curve))?;
            }
        }
        Ok(())
    }

    /// Draws the line through the pixels, if the curve has one; a single pixel becomes a dot, so that it is seen.
    fn stroke(&self, curve: &Curve, pixels: &[Pixel]) -> anyhow::Result<()> {
        let Some(stroke) = curve.stroke else {
            return Ok(());
        };
        let width = (curve.width * DENSITY) as i32 * OVERSAMPLING;
        let (colour, css_pixel) = (colour(curve), DENSITY * f64::from(OVERSAMPLING));
        let pieces = match stroke {
            Stroke::Solid => pixels
                .windows(2)
                .filter_map(|w| Some((*w.first()?, *w.last()?)))
                .collect(),
            Stroke::Dashed => dashes(pixels, 9.0 * css_pixel, 5.0 * css_pixel),
            Stroke::Dotted => dashes(pixels, 2.0 * css_pixel, 4.0 * css_pixel),
        };
        for (from, to) in pieces {
            self.line(from, to, colour, width)?;
            if stroke == Stroke::Solid {
                // Rounds the joint; mitred joints would put spikes on reversals.
                self.area
                    .draw(&Circle::new(to, width / 2, colour.filled()))?;
            }
        }
        if let [at] = pixels {
            self.area.draw(&Circle::new(*at, width, colour.filled()))?;
        }
        Ok(())
    }

    fn mark(&self, at: Pixel, curve: &Curve) -> anyhow::Result<()> {
        let radius = if curve.width > 2.0 { 9 } else { 6 } * OVERSAMPLING;
        Ok(self
            .area
            .draw(&Circle::new(at, radius, colour(curve).filled()))?)
    }

    fn line(&self, from: Pixel, to: Pixel, colour: RGBColor, width: i32) -> anyhow::Result<()> {
        Ok(self.area.draw(&PathElement::new(
            [from, to],
            colour.stroke_width(width as u32),
        ))?)
    }

    fn text(&self, text: &str, size: i32, at: Pixel, (h, v): (HPos, VPos)) -> anyhow::Result<()> {
        // plotters sets ab_glyph's glyphs this much too high.
        let at = (at.0, at.1 + size / 10);
        let style = style(size).pos(Pos::new(h, v));
        Ok(self.area.draw(&Text::new(in_font(text), at, style))?)
    }

    /// Text that runs upwards, centred at the height of `at`, whose abscissa is the text's left edge.
    fn upwards(&self, text: &str, size: i32, at: Pixel) -> anyhow::Result<()> {
        let style = style(size)
            .pos(Pos::new(HPos::Center, VPos::Top))
            .transform(FontTransform::Rotate270);
        Ok(self.area.draw(&Text::new(in_font(text), at, style))?)
    }

    fn width(&self, text: &str, size: i32) -> anyhow::Result<i32> {
        Ok(self
            .area
            .estimate_text_size(&in_font(text), &style(size))?
            .0 as i32)
    }

    /// Breaks `text` between words into at most `most` lines no wider than `width`; what does not fit ends in "…".
    fn wrap(&self, text: &str, size: i32, width: i32, most: usize) -> anyhow::Result<Vec<String>> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            let longer = lines.last().map(|line| format!("{line} {word}"));
            match (longer, lines.last_mut()) {
                (Some(longer), Some(line)) if self.width(&longer, size)? <= width => *line = longer,
                _ => lines.push(word.to_string()),
            }
        }
        let cut = lines.len() > most;
        lines.truncate(most);
        let last = lines.len();
        for (i, line) in lines.iter_mut().enumerate() {
            if (cut && i + 1 == last) || self.width(line, size)? > width {
                line.push('…');
                while self.width(line, size)? > width && line.chars().count() > 1 {
                    line.truncate(line.char_indices().rev().nth(1).map_or(0, |(at, _)| at));
                    line.push('…');
                }
            }
        }
        Ok(lines)
    }
}

/// The few characters of our texts that Ubuntu Light lacks, by ones that look alike.
fn in_font(text: &str) -> String {
    text.replace('⁻', "¯")
        .replace('⋅', "·")
        .replace('→', "–>")
        .replace('′', "'")
}

fn style(size: i32) -> TextStyle<'static> {
    TextStyle::from((FONT, size)).color(&INK)
}

fn colour(curve: &Curve) -> RGBColor {
    let [r, g, b] = curve.rgb;
    RGBColor(r, g, b)
}

/// Cuts the line through `pixels` into dashes of length `on` with gaps of length `off` between them, all in pixels.
fn dashes(pixels: &[Pixel], on: f64, off: f64) -> Vec<(Pixel, Pixel)> {
    let mut pieces = Vec::new();
    let (mut drawn, mut left) = (true, on);
    for (from, to) in pixels.iter().zip(pixels.iter().skip(1)) {
        let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
        let length = dx.hypot(dy);
        let point = |s: f64| {
            let at = |from: i32, d: f64| from + (d * s / length).round() as i32;
            (at(from.0, dx), at(from.1, dy))
        };
        let mut done = 0.0;
        while done < length {
            let step = left.min(length - done);
            if drawn {
                pieces.push((point(done), point(done + step)));
            }
            done += step;
            left -= step;
            if left <= 0.0 {
                drawn = !drawn;
                left = if drawn { on } else { off };
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_character_that_we_write() {
        // What a missing character looks like: the font's substitute glyph.
        let drawn = |c: char| {
            let mut buffer = vec![0; 100 * 100 * 3];
            let area = BitMapBackend::with_buffer(&mut buffer, (100, 100)).into_drawing_area();
            area.fill(&WHITE).unwrap();
            assert!(*FONT_REGISTERED);
            area.draw(&Text::new(c.to_string(), (20, 20), style(60)))
                .unwrap();
            drop(area);
            buffer
        };
        let missing = drawn('\u{10FFFF}');
        let blank = vec![255; 100 * 100 * 3];
        for c in "µσαΣωτθ·²³⁰¹⁴⁵⁶⁷⁸⁹⁻±−–×°√≤≥≈…%₀₁₂äé→⋅′".chars()
        {
            let pixels = in_font(&c.to_string()).chars().map(drawn).next().unwrap();
            assert!(
                pixels != missing && pixels != blank,
                "{c} is not in the font"
            );
        }
    }

    #[test]
    fn dashes_cover_their_share_of_the_line() {
        let pieces = dashes(&[(0, 0), (30, 0), (30, 40), (130, 40)], 10.0, 5.0);
        let drawn: i32 = pieces
            .iter()
            .map(|(a, b)| (b.0 - a.0).abs() + (b.1 - a.1).abs())
            .sum();
        assert!((113 - 5..=113 + 5).contains(&drawn), "{drawn} of 170");
        assert!(dashes(&[(1, 1)], 10.0, 5.0).is_empty());
    }
}
