//! Where names stand beside the marks of a picture: not over another name or mark, off the curves where there is room, and near.

/// In units of the picture, `y` downwards.
pub type Point = (f64, f64);

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn holds(&self, (x, y): Point) -> bool {
        (self.left..self.right).contains(&x) && (self.top..self.bottom).contains(&y)
    }

    /// The point of it that is nearest.
    pub fn nearest(&self, (x, y): Point) -> Point {
        (
            x.clamp(self.left, self.right),
            y.clamp(self.top, self.bottom),
        )
    }

    fn around((x, y): Point, half: f64) -> Self {
        Self {
            left: x - half,
            top: y - half,
            right: x + half,
            bottom: y + half,
        }
    }

    fn has(&self, inner: &Self) -> bool {
        self.left <= inner.left
            && inner.right <= self.right
            && self.top <= inner.top
            && inner.bottom <= self.bottom
    }
}

/// A letter of 11 units on average, and a line of them.
const LETTER: f64 = 5.3;
const LINE: f64 = 11.0;
/// Half a mark, with the air that a name leaves around it.
const MARK: f64 = 4.0;
/// A name that stands so far from its mark needs a line to it.
pub const FAR: f64 = 9.5;

/// Distances from the mark that are tried, nearest first.
const DISTANCES: [f64; 6] = [3.0, 10.0, 18.0, 28.0, 40.0, 55.0];
/// Directions that are tried, from the mark to the name: right before left, above before below.
const DIRECTIONS: [Point; 12] = [
    (1.0, -1.0),
    (0.5, -1.0),
    (0.5, 1.0),
    (-0.5, -1.0),
    (-0.5, 1.0),
    (1.0, 0.0),
    (1.0, 1.0),
    (0.0, -1.0),
    (0.0, 1.0),
    (-1.0, -1.0),
    (-1.0, 0.0),
    (-1.0, 1.0),
];
/// What a unit of distance costs beside a covered point of a curve.
const DISTANCE: f64 = 0.3;
/// Covering a name or a mark, or leaving the panel, costs more than any curve.
const NEVER: f64 = 1e6;

/// The area of each mark's name within `panel`, chosen one after the other. `curves` are points along what is drawn besides.
pub fn placed(marks: &[(Point, &str)], curves: &[Point], panel: &Area) -> Vec<Area> {
    let crosses: Vec<Area> = marks.iter().map(|m| Area::around(m.0, MARK)).collect();
    let mut names: Vec<Area> = Vec::new();
    let mut leaders: Vec<Point> = Vec::new();
    for (mark, name) in marks {
        let others = crosses.iter().filter(|cross| !cross.holds(*mark));
        let others: Vec<Area> = others.copied().collect();
        let cost = |(area, distance): &(Area, f64)| {
            let own = leader(*mark, area);
            let crossed = |other: &&Area| own.iter().any(|point| other.holds(*point));
            let hidden = crosses.iter().filter(|other| other.overlaps(area)).count()
                + names.iter().filter(|other| other.overlaps(area)).count()
                + names.iter().filter(crossed).count()
                + others.iter().filter(crossed).count()
                + leaders.iter().filter(|point| area.holds(**point)).count();
            let outside = usize::from(!panel.has(area));
            let covered = curves.iter().filter(|point| area.holds(**point)).count();
            NEVER * (hidden + outside) as f64 + covered as f64 + DISTANCE * distance
        };
        let best = candidates(*mark, name).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        if let Some((area, _)) = best {
            leaders.extend(leader(*mark, &area));
            names.push(area);
        }
    }
    names
}

/// Points of the line from a mark to its name; none where the name stands beside it.
fn leader(mark: Point, name: &Area) -> Vec<Point> {
    let (x, y) = name.nearest(mark);
    let length = (x - mark.0).hypot(y - mark.1);
    let steps = if length > FAR {
        length.ceil() as u32
    } else {
        0
    };
    (0..steps)
        .map(|i| {
            let part = f64::from(i) / length;
            (mark.0 + part * (x - mark.0), mark.1 + part * (y - mark.1))
        })
        .collect()
}

/// Areas around a mark, and how far from it.
fn candidates(mark: Point, name: &str) -> impl Iterator<Item = (Area, f64)> {
    let width = LETTER * name.chars().count() as f64;
    DISTANCES.into_iter().flat_map(move |distance| {
        DIRECTIONS.into_iter().map(move |(right, down)| {
            let (reach_x, reach_y) = (
                MARK + distance + 0.5 * width,
                MARK + 0.8 * distance + 0.5 * LINE,
            );
            let middle = (mark.0 + right * reach_x, mark.1 + down * reach_y);
            let area = Area {
                left: middle.0 - 0.5 * width,
                right: middle.0 + 0.5 * width,
                top: middle.1 - 0.5 * LINE,
                bottom: middle.1 + 0.5 * LINE,
            };
            (area, distance)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANEL: Area = Area {
        left: 0.0,
        top: 0.0,
        right: 300.0,
        bottom: 300.0,
    };

    #[test]
    fn names_of_marks_close_together_hide_neither_each_other_nor_a_mark() {
        let marks = [
            ((100.0, 100.0), "Dahl, n = 1"),
            ((112.0, 103.0), "two-state"),
            ((125.0, 99.0), "Bouc-Wen"),
            ((104.0, 111.0), "Dahl, n = 1.6"),
            ((297.0, 2.0), "in the corner"),
        ];
        let names = placed(&marks, &[], &PANEL);
        for (i, name) in names.iter().enumerate() {
            assert!(PANEL.has(name), "{name:?}");
            assert!(names[..i].iter().all(|other| !other.overlaps(name)));
            for (mark, _) in marks {
                assert!(!Area::around(mark, MARK).overlaps(name), "{name:?}");
            }
        }
    }

    #[test]
    fn a_name_stands_off_a_curve_where_there_is_room() {
        let curve: Vec<Point> = (0..60).map(|i| (100.0 + f64::from(i), 91.0)).collect();
        let names = placed(&[((100.0, 100.0), "LuGre")], &curve, &PANEL);
        assert!(curve.iter().all(|point| !names[0].holds(*point)));
    }
}
