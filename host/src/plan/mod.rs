//! Motions that show friction: nested reversals begun at different places, and passes at different speeds.
//!
//! Friction below a few micrometres shows itself only at reversals, so each repeat has nested ones, of strokes that shrink, at stations
//! over the travel: what belongs to a place then differs from what belongs to a stroke. Passes over the travel at speeds apart by
//! equal factors show what depends on speed and on position.

mod present;
#[cfg(test)]
mod tests;

use preslide_fit::report::figures::duration;
use std::fmt::Write as _;

/// What a motion should show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Pre-sliding: nested reversals.
    Presliding,
    /// Sliding: speed and position.
    Sliding,
    /// Both.
    All,
}

/// The requested motion (m or rad, and s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// The motion stays within ± half of this around where it begins.
    pub travel: f64,
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Smallest stroke between reversals.
    pub smallest: f64,
    /// What it should show.
    pub show: Show,
    /// How often it is repeated, as folds of cross-validation.
    pub repeats: u32,
    /// Rows per second (Hz).
    pub rate: f64,
}

/// Stations over the travel, as shares of its half; nested strokes begin there. No two are alike in distance, so that none
/// falls on the same phase of something periodic.
const STATIONS: [f64; 3] = [-0.61, 0.07, 0.53];
/// The largest nested stroke, as a share of the travel.
const LARGEST: f64 = 0.1;
/// From one nested stroke to the next inside it.
const SHRINK: f64 = 0.55;
/// Speeds of passes and strokes, from the largest down.
const SPEEDS: [f64; 4] = [1.0, 0.35, 0.12, 0.04];
/// A stroke slower than this (s) is left out: it would only cost time.
const SLOWEST: f64 = 4.0;
/// Rest after a group (s): long enough to see that nothing creeps.
const REST: f64 = 0.1;

/// The longest plan (s) and the most rows: beyond that an option was mistaken.
const LONGEST: f64 = 3600.0;
const MOST: f64 = 2e6;

/// A planned motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Rows per second (Hz).
    pub rate: f64,
    /// Position (m or rad) and repeat (from 1) of each row.
    pub rows: Vec<(f64, u32)>,
    /// Changes of direction.
    pub reversals: u32,
    /// Smallest and largest stroke between them.
    pub strokes: (f64, f64),
}

/// Plans it.
///
/// # Errors
/// Everything that is wrong with the wish.
pub fn plan(wish: &Wish) -> Result<Plan, String> {
    check(wish)?;
    let mut path = Path {
        wish,
        at: 0.0,
        repeat: 1,
        pieces: Vec::new(),
    };
    for repeat in 1..=wish.repeats {
        path.repeat = repeat;
        path.rest(REST);
        if wish.show != Show::Sliding {
            for (i, station) in STATIONS.into_iter().enumerate() {
                path.go(0.5 * wish.travel * station, wish.speed);
                path.nested(SPEEDS[i % 3 + 1] * wish.speed);
            }
        }
        if wish.show != Show::Presliding {
            path.passes();
        }
        path.go(0.0, wish.speed);
        path.rest(REST);
    }
    path.check()?;
    let strokes = path.pieces.iter().map(|piece| piece.to - piece.from);
    let strokes: Vec<f64> = strokes.filter(|stroke| *stroke != 0.0).collect();
    let reversals = strokes.windows(2).filter(|pair| pair[0] * pair[1] < 0.0);
    let sizes = strokes.iter().map(|stroke| stroke.abs());
    let bounds = sizes.fold((f64::MAX, 0.0_f64), |(low, high), s| {
        (low.min(s), high.max(s))
    });
    Ok(Plan {
        rate: wish.rate,
        reversals: reversals.count() as u32,
        strokes: bounds,
        rows: path.rows(),
    })
}

fn check(wish: &Wish) -> Result<(), String> {
    let mut wrong = String::new();
    let values = [
        ("--travel", wish.travel),
        ("--speed", wish.speed),
        ("--acceleration", wish.acceleration),
        ("--smallest", wish.smallest),
        ("--rate", wish.rate),
    ];
    for (name, value) in values {
        if !(value.is_finite() && value > 0.0) {
            let _ = write!(wrong, "{name} must be above zero; ");
        }
    }
    if wish.smallest > LARGEST * wish.travel {
        let _ = write!(
            wrong,
            "--smallest {:.3e} leaves no room for nested strokes, the largest of which is {LARGEST} of --travel, {:.3e}; ",
            wish.smallest,
            LARGEST * wish.travel
        );
    }
    if wish.repeats == 0 {
        wrong += "--repeats must be 1 or more; ";
    }
    match wrong.strip_suffix("; ") {
        Some(wrong) => Err(wrong.to_owned()),
        None => Ok(()),
    }
}

/// What is planned so far.
struct Path<'a> {
    wish: &'a Wish,
    at: f64,
    repeat: u32,
    pieces: Vec<Piece>,
}

/// A stroke, or a rest from and to the same place.
struct Piece {
    from: f64,
    to: f64,
    rows: f64,
    repeat: u32,
}

impl Path<'_> {
    /// Sees to it that it ends in time, before anything is made of it.
    fn check(&self) -> Result<(), String> {
        let rows: f64 = self.pieces.iter().map(|piece| piece.rows).sum();
        let seconds = rows / self.wish.rate;
        if seconds > LONGEST {
            return Err(format!(
                "the motion would last {}, and an hour is the most; raise --speed or --acceleration, or lower --travel or --repeats",
                duration(seconds)
            ));
        }
        if rows > MOST {
            return Err(format!(
                "the motion would have {rows:.0} rows in {}, and {MOST:.0} are the most; lower --rate",
                duration(seconds)
            ));
        }
        Ok(())
    }

    /// Position and repeat at each row.
    fn rows(&self) -> Vec<(f64, u32)> {
        let mut rows = vec![(0.0, 1)];
        for piece in &self.pieces {
            let last = piece.rows as u32;
            rows.extend((1..=last).map(|row| {
                let s = f64::from(row) / f64::from(last);
                let share = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
                let by = (piece.to - piece.from) * share;
                (piece.from + by, piece.repeat)
            }));
        }
        rows
    }

    /// Strokes that shrink around here, then grow again by the same turning points: loops inside loops, closed.
    fn nested(&mut self, speed: f64) {
        let centre = self.at;
        let mut sizes = Vec::new();
        let mut stroke = LARGEST * self.wish.travel;
        while stroke >= self.wish.smallest {
            sizes.push(stroke);
            stroke *= SHRINK;
        }
        let inwards = sizes.clone();
        for (i, size) in inwards
            .into_iter()
            .chain(sizes.into_iter().rev())
            .enumerate()
        {
            let side = if i % 2 == 0 { 0.5 } else { -0.5 };
            // Small strokes are slow ones, so that each takes some time.
            self.go(centre + side * size, speed.min(size / 0.1));
        }
        self.go(centre, speed);
        self.rest(REST);
    }

    /// Over the travel and back, at one speed after the other.
    fn passes(&mut self) {
        let end = 0.5 * self.wish.travel;
        for share in SPEEDS {
            let speed = share * self.wish.speed;
            if 2.0 * end / speed > SLOWEST {
                continue;
            }
            self.go(end, speed);
            self.go(-end, speed);
        }
    }

    /// To a position at up to `speed`: `10s³ − 15s⁴ + 6s⁵`, which starts and stops without a jerk. Its peaks are `1.875·L/T` and
    /// `10/√3·L/T²`.
    fn go(&mut self, to: f64, speed: f64) {
        let by = to - self.at;
        if by == 0.0 {
            return;
        }
        let gentle = (10.0 / 3.0_f64.sqrt() * by.abs() / self.wish.acceleration).sqrt();
        let time = (1.875 * by.abs() / speed).max(gentle);
        // A row more, so that sampling does not sharpen the peaks.
        let rows = (time * self.wish.rate).ceil() + 1.0;
        self.piece(to, rows);
    }

    fn rest(&mut self, time: f64) {
        self.piece(self.at, (time * self.wish.rate).ceil());
    }

    fn piece(&mut self, to: f64, rows: f64) {
        let (from, repeat) = (self.at, self.repeat);
        self.pieces.push(Piece {
            from,
            to,
            rows,
            repeat,
        });
        self.at = to;
    }
}

impl Plan {
    /// Duration (s).
    pub fn seconds(&self) -> f64 {
        (self.rows.len() - 1) as f64 / self.rate
    }
}
