//! The picture: a figure as a PNG of 1600 × 1000 pixels, for a README, a slide or a paper.
//!
//! Everything is drawn at twice the size and averaged down, because plotters smooths only lines of one pixel.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::{Context, bail};
use plotters::prelude::*;

use super::canvas::{Canvas, OVERSAMPLING};
use super::drawing::{Drawing, POINTS_PER_SERIES};
use super::figure::Figure;
use super::unwritable;

/// Pixels of the picture.
const SIZE: (i32, i32) = (1600, 1000);

impl Figure {
    /// Writes the figure as a PNG of 1600 × 1000 pixels, with the same colours, units and note as on a page.
    ///
    /// # Errors
    /// When the file name does not end in `.png` or the file cannot be written; the message names it and says what to do.
    pub fn write_png(&self, path: &Path) -> anyhow::Result<()> {
        if !path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        {
            bail!(
                "cannot write a picture to {}: only PNG is made; let the file name end in .png",
                path.display()
            );
        }
        let pixels =
            pixels(self).with_context(|| format!("cannot draw the figure \"{}\"", self.title))?;
        written(&pixels, path).with_context(|| unwritable(path))
    }
}

/// By the `png` crate alone: plotters' own encoder brings one for every format there is along, which takes longer to build than
/// plotters itself.
fn written(pixels: &[[u8; 3]], path: &Path) -> anyhow::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, SIZE.0 as u32, SIZE.1 as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::FilterType::Sub);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    Ok(writer.finish()?)
}

/// The pixels of the picture, row by row.
fn pixels(figure: &Figure) -> anyhow::Result<Vec<[u8; 3]>> {
    let (width, height) = (SIZE.0 * OVERSAMPLING, SIZE.1 * OVERSAMPLING);
    let mut buffer = vec![0; (width * height * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut buffer, (width as u32, height as u32))
            .into_drawing_area();
        area.fill(&WHITE)?;
        let canvas = Canvas::new(area)?;
        canvas.figure(
            &figure.title,
            &Drawing::new(figure, POINTS_PER_SERIES),
            width,
            height,
        )?;
    }
    Ok(average(&buffer, width as usize, OVERSAMPLING as usize))
}

/// Averages blocks of `n` × `n` pixels of an RGB buffer whose rows are `width` pixels long.
fn average(buffer: &[u8], width: usize, n: usize) -> Vec<[u8; 3]> {
    let mut averaged = Vec::with_capacity(buffer.len() / (3 * n * n));
    for rows in buffer.chunks_exact(3 * width * n) {
        for x in 0..width / n {
            let mut sum = [0; 3];
            for row in rows.chunks_exact(3 * width) {
                for pixel in row.chunks_exact(3).skip(x * n).take(n) {
                    sum.iter_mut()
                        .zip(pixel)
                        .for_each(|(sum, &c)| *sum += usize::from(c));
                }
            }
            averaged.push(sum.map(|c| (c / (n * n)) as u8));
        }
    }
    averaged
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Emphasis, Series, Style};
    use super::*;

    fn loops() -> Figure {
        let phase: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.02).collect();
        let x: Vec<f64> = phase.iter().map(|p| 3e-5 * p.sin()).collect();
        let y: Vec<f64> = phase.iter().map(|p| 0.9 * (p - 0.4).sin()).collect();
        Figure::new(
            "Force–displacement",
            Axis::new("displacement", "m"),
            Axis::new("friction", "N"),
        )
        .with(Series::line("measured", x.clone(), y.clone()))
        .with(Series::line("model", x, y.iter().map(|y| y * 0.8).collect()).style(Style::Dashed))
    }

    fn share_of(pixels: &[[u8; 3]], colour: [u8; 3]) -> f64 {
        pixels.iter().filter(|p| **p == colour).count() as f64 / pixels.len() as f64
    }

    #[test]
    fn every_series_shows_in_its_colour() {
        let drawn = pixels(&loops()).unwrap();
        assert_eq!(drawn.len(), (SIZE.0 * SIZE.1) as usize);
        for colour in [[0x00, 0x72, 0xB2], [0xD5, 0x5E, 0x00]] {
            let share = share_of(&drawn, colour);
            assert!((1e-3..0.1).contains(&share), "{colour:?} covers {share}");
        }
        assert!(share_of(&drawn, [255; 3]) > 0.5);
    }

    #[test]
    fn a_gap_breaks_the_line() {
        let x: Vec<f64> = (0..=100).map(f64::from).collect();
        let blue =
            |y: Vec<f64>| {
                let f = Figure::new("", Axis::new("t", "s"), Axis::new("F", "N"))
                    .with(Series::line("a", x.clone(), y));
                share_of(&pixels(&f).unwrap(), [0x00, 0x72, 0xB2])
            };
        let whole = blue(vec![1.0; 101]);
        let half = blue(
            (0..=100)
                .map(|i| if (20..70).contains(&i) { f64::NAN } else { 1.0 })
                .collect(),
        );
        assert!((0.45..0.55).contains(&(half / whole)), "{half} of {whole}");
    }

    #[test]
    fn the_file_is_a_sound_png_of_the_stated_size() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("loops.png");
        loops().write_png(&path).unwrap();
        let file = std::fs::read(&path).unwrap();
        let (signature, mut rest) = file.split_at(8);
        assert_eq!(signature, b"\x89PNG\r\n\x1a\n");
        // Every chunk: length, type, data, CRC-32 of type and data.
        let word = |bytes: &[u8]| u32::from_be_bytes(bytes[..4].try_into().unwrap());
        let mut types = Vec::new();
        while !rest.is_empty() {
            let length = word(rest) as usize;
            let chunk = &rest[4..8 + length];
            let crc = !chunk.iter().fold(!0u32, |crc, &byte| {
                (0..8).fold(crc ^ u32::from(byte), |c, _| {
                    if c & 1 == 1 {
                        0xEDB8_8320 ^ (c >> 1)
                    } else {
                        c >> 1
                    }
                })
            });
            assert_eq!(crc, word(&rest[8 + length..]));
            if chunk.starts_with(b"IHDR") {
                assert_eq!(
                    (word(&chunk[4..]), word(&chunk[8..])),
                    (SIZE.0 as u32, SIZE.1 as u32)
                );
            }
            types.push(String::from_utf8_lossy(&chunk[..4]).into_owned());
            rest = &rest[12 + length..];
        }
        assert_eq!(types.first().map(String::as_str), Some("IHDR"));
        assert_eq!(types.last().map(String::as_str), Some("IEND"));
        assert!(types.iter().any(|t| t == "IDAT"));
    }

    #[test]
    fn nothing_or_nonsense_to_draw_does_not_panic() {
        let axis = || Axis::new("", "").log();
        let empty = Figure::new("", axis(), axis());
        let long = "word ".repeat(400);
        let mut crowded =
            Figure::new(long.clone(), Axis::new(long.clone(), "m"), axis()).note(long.clone());
        for i in 0..60 {
            let y = vec![1e-300, f64::NAN, 1e300, -1.0, f64::INFINITY];
            let series =
                Series::points(format!("{i} {long}"), vec![-1e308, 0.0, 1e308, 5.0, 6.0], y);
            crowded = crowded.with(series.emphasis(Emphasis::Strong));
        }
        let one_point = Figure::default().with(Series::line("", vec![0.0], vec![0.0]));
        for figure in [empty, crowded, one_point] {
            pixels(&figure).unwrap();
        }
    }

    #[test]
    fn another_extension_or_a_missing_folder_is_an_error_that_names_the_file() {
        let error = format!("{:#}", loops().write_png("loops.jpg".as_ref()).unwrap_err());
        assert!(
            error.contains("loops.jpg") && error.contains("end in .png"),
            "{error}"
        );
        let folder = tempfile::tempdir().unwrap();
        let error = format!(
            "{:#}",
            loops()
                .write_png(&folder.path().join("absent/a.png"))
                .unwrap_err()
        );
        assert!(
            error.contains("a.png") && error.contains("folder that exists"),
            "{error}"
        );
    }
}
