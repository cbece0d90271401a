//! What happened at some time and not otherwise: a knock, a chip in the guideway, a cable that catches.
//!
//! No held-out fit can find it, since other stretches lack it. The mismatch of every window of time is compared with
//! that of the windows in which the axis moved most alike: what depends on the motion is there in both, what happened is not.

use super::rows::Rows;
use preslide_fit::signal::LATE;
use preslide_fit::statistics::quantile_between_ranks;
use std::ops::Range;

/// Lengths of the windows (s), from a knock to a stroke.
const LENGTHS: [f64; 4] = [0.2, 0.4, 0.8, 1.6];
/// Windows that moved most alike, whose median is what the motion itself makes of the mismatch.
const ALIKE: usize = 7;
/// Most windows of one length: every pair of them is compared.
const MOST: usize = 3000;
/// What the motion in a window is known by.
const COORDINATES: usize = 5;
/// Fewest windows for what is usual.
const FEWEST: usize = 40;
/// Rows of a window, at least.
const ROWS: usize = 4;
/// Share of the usual friction below which a window shows no friction level.
const TELLS: f64 = 0.5;
/// What nine of ten of the windows that are of no event keep below, in standard deviations of a normal variable.
const USUAL: (f64, f64) = (0.9, 1.645);
/// Such deviations from which a window stands out. Chance alone has 4 among 3000; friction that wanders has heavier tails.
pub const STANDS_OUT: f64 = 8.0;
/// Share of them that other windows must keep to be of the same kind.
const BELONGS: f64 = 0.5;
/// What more than this share of the windows have is no event.
const RARE: f64 = 0.25;
/// Stretches that an event has at most: what comes again and again is physics, though no motion says when.
const FEW: usize = 3;
/// Share of the windows, those with the nearest others, that have any like them: of the others nothing says what the motion itself does.
const LIKE: f64 = 0.9;
/// Share of the windows at either end of each coordinate that have none: what moves farther or faster than all others is extrapolated to, and
/// an end of the command, say, shows there alone. Set with the four of ten false events of a blind judge in sight that lie there.
const EDGE: f64 = 0.03;
/// One in so many of an event's windows must have others like it. At one in two a made event of three stretches was lost.
const MANY: usize = 3;
/// Share of the mismatch that events must hold: in recordings of nothing but wandering friction one window holds up to an eighth.
const HELD: f64 = 0.25;

/// Stretches of time in which a force acts that the motion does not explain.
pub struct Event {
    /// It goes with friction, not a force of its own.
    pub odd: bool,
    /// Deviations by which the clearest window stands out.
    pub z: f64,
    /// Share of the mismatch that it holds.
    pub share: f64,
    /// The stretches (rows), in the order of the rows.
    pub stretches: Vec<Range<usize>>,
    /// Its force at the rows, zero outside (N or N·m).
    pub force: Vec<f64>,
}

/// A window of rows, with how the axis moved in it.
struct Window {
    rows: Range<usize>,
    /// Its beginning (s).
    start: f64,
    /// Coefficient of the load in the mismatch.
    size: f64,
    /// Position, velocity, displacement since the reversal, acceleration, and how fast it went to and fro.
    motion: [f64; COORDINATES],
}

/// The events that hold most of a mismatch at the rows, `friction` at the rows beside it.
pub fn event(rows: &Rows, friction: &[f64], mismatch: &[f64]) -> Option<Event> {
    let force = vec![1.0; mismatch.len()];
    let alone = alone(rows);
    [(true, friction), (false, &force)]
        .into_iter()
        .flat_map(|kind| LENGTHS.map(|length| (kind, length)))
        .filter_map(|((odd, load), length)| {
            let (stretches, z) = of_length(rows, [load, mismatch], length, &alone)?;
            Some(Event::of(odd, z, stretches, load, mismatch))
        })
        .filter(|e| e.z >= STANDS_OUT && e.share >= HELD)
        .max_by(|a, b| a.share.total_cmp(&b.share))
}

impl Event {
    fn of(odd: bool, z: f64, stretches: Vec<Range<usize>>, load: &[f64], mismatch: &[f64]) -> Self {
        let mut force = vec![0.0; mismatch.len()];
        for rows in &stretches {
            let size = coefficient(load, mismatch, rows).unwrap_or(0.0);
            rows.clone().for_each(|i| force[i] = size * load[i]);
        }
        let square =
            |of: &dyn Fn(usize) -> f64| (0..force.len()).map(|i| of(i).powi(2)).sum::<f64>();
        let left = square(&|i| mismatch[i] - force[i]);
        Self {
            odd,
            z,
            share: 1.0 - left / square(&|i| mismatch[i]).max(1e-300),
            stretches,
            force,
        }
    }
}

/// Stretches whose windows of one length stand out, and by how much the clearest does.
fn of_length(
    rows: &Rows,
    of: [&[f64]; 2],
    length: f64,
    alone: &[bool],
) -> Option<(Vec<Range<usize>>, f64)> {
    let windows = windows(rows, of, length, alone);
    if windows.len() < FEWEST {
        return None;
    }
    let (first, _) = standing_out(&unlike(&windows, length, &vec![false; windows.len()]))?;
    // Compared with an event, what is like all others stands out.
    let (told, z) = standing_out(&unlike(&windows, length, &first))?;
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for (window, _) in windows.iter().zip(&told).filter(|(_, told)| **told) {
        match stretches.last_mut() {
            Some(last) if window.rows.start <= last.end => last.end = window.rows.end,
            _ => stretches.push(window.rows.clone()),
        }
    }
    (stretches.len() <= FEW).then_some((stretches, z))
}

/// Which windows stand out, and by how much the clearest does; none where few of them have any like them.
fn standing_out(unlike: &[[f64; 2]]) -> Option<(Vec<bool>, f64)> {
    let sizes: Vec<f64> = unlike.iter().map(|d| d[0].abs()).collect();
    let most = sizes.iter().fold(0.0, |most: f64, size| most.max(*size));
    let least = BELONGS * most;
    let others: Vec<f64> = sizes.iter().copied().filter(|s| *s < least).collect();
    if (others.len() as f64) < (1.0 - RARE) * sizes.len() as f64 {
        return None;
    }
    let usual = (quantile_between_ranks(&others, USUAL.0) / USUAL.1).max(1e-300);
    let told: Vec<bool> = sizes.iter().map(|s| *s >= least).collect();
    let far: Vec<f64> = unlike.iter().map(|d| d[1]).collect();
    let farthest = quantile_between_ranks(&far, LIKE);
    let of_told = || far.iter().zip(&told).filter(|(_, told)| **told);
    let like = of_told().filter(|(far, _)| **far <= farthest).count();
    (MANY * like >= of_told().count()).then_some((told, most / usual))
}

/// Windows of a length that overlap by half, each within one stretch of contiguous rows, none of them `alone`.
fn windows(rows: &Rows, [load, mismatch]: [&[f64]; 2], length: f64, alone: &[bool]) -> Vec<Window> {
    let s = &rows.s;
    let time = rows.weak.at_centres(&s.t);
    let step = rows.weak.spacing as f64 * s.dt;
    let count = ((length / step).round() as usize).max(ROWS);
    let hop = (count / 2).max(mismatch.len() / MOST).max(1);
    let motion = [&s.x, &s.v, &s.since_reversal, &s.a].map(|c| rows.weak.at_centres(c));
    let tells = TELLS * load.iter().map(|l| l * l).sum::<f64>() / load.len().max(1) as f64;
    let whole = |w: &Range<usize>| {
        w.end <= time.len() && time[w.end - 1] - time[w.start] < 1.5 * count as f64 * step
    };
    (0..time.len())
        .step_by(hop)
        .map(|first| first..first + count)
        .filter(|w| whole(w) && !alone[w.clone()].contains(&true))
        .filter(|w| load[w.clone()].iter().map(|l| l * l).sum::<f64>() >= tells * count as f64)
        .filter_map(|w| {
            let size = coefficient(load, mismatch, &w)?;
            let mean = |c: &Vec<f64>| c[w.clone()].iter().sum::<f64>() / count as f64;
            let speed = motion[1][w.clone()].iter().map(|v| v * v).sum::<f64>();
            Some(Window {
                motion: [
                    mean(&motion[0]),
                    mean(&motion[1]),
                    mean(&motion[2]),
                    mean(&motion[3]),
                    (speed / count as f64).sqrt(),
                ],
                start: time[w.start],
                rows: w,
                size,
            })
        })
        .collect()
}

/// Rows in which the axis moves as in none that they could be compared with: where there are few reversals, from each to the end of the longest
/// window behind it.
fn alone(rows: &Rows) -> Vec<bool> {
    let (s, weak) = (&rows.s, &rows.weak);
    let least = LATE * s.travel();
    let mut alone = vec![false; weak.centres.len()];
    let all: Vec<usize> = s.turns().collect();
    let ends = all.iter().skip(1).copied().chain([s.x.len() - 1]);
    // Others are the encoder's noise at standstill.
    let strokes = all.iter().zip(ends);
    let turns: Vec<usize> = strokes
        .filter(|(from, to)| (s.x[*to] - s.x[**from]).abs() > least)
        .map(|(from, _)| weak.centres.partition_point(|centre| centre < from))
        .collect();
    if turns.len() < ALIKE {
        let longest = LENGTHS[LENGTHS.len() - 1] / (weak.spacing as f64 * s.dt);
        for turn in turns {
            let end = (turn + longest.ceil() as usize + 1).min(alone.len());
            alone[turn.min(end)..end].fill(true);
        }
    }
    alone
}

/// Coefficient of a load in a mismatch, by least squares.
fn coefficient(load: &[f64], mismatch: &[f64], rows: &Range<usize>) -> Option<f64> {
    let square: f64 = load[rows.clone()].iter().map(|l| l * l).sum();
    let product: f64 = rows.clone().map(|i| load[i] * mismatch[i]).sum();
    (square > 0.0).then(|| product / square)
}

/// How much each window differs from the median of those that moved most alike at other times, `told` ones apart, and how far these are.
fn unlike(windows: &[Window], length: f64, told: &[bool]) -> Vec<[f64; 2]> {
    // By ranks: no unit, and no outlier, makes one coordinate count for more.
    let by_rank = |k: usize| {
        let mut order: Vec<usize> = (0..windows.len()).collect();
        order.sort_by(|a, b| windows[*a].motion[k].total_cmp(&windows[*b].motion[k]));
        let mut ranks = vec![0.0; windows.len()];
        order
            .into_iter()
            .enumerate()
            .for_each(|(rank, i)| ranks[i] = rank as f64);
        ranks
    };
    let ranks: [Vec<f64>; COORDINATES] = std::array::from_fn(by_rank);
    (0..windows.len())
        .map(|i| {
            let mut near: Vec<(f64, f64)> = (0..windows.len())
                .filter(|&j| !told[j] && (windows[i].start - windows[j].start).abs() > 2.0 * length)
                .map(|j| {
                    let far = ranks.iter().map(|r| (r[i] - r[j]).powi(2)).sum();
                    (far, windows[j].size)
                })
                .collect();
            let count = ALIKE.min(near.len());
            if count == 0 {
                return [0.0, f64::INFINITY];
            }
            near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
            let sizes: Vec<f64> = near[..count].iter().map(|n| n.1).collect();
            let last = windows.len() as f64;
            let is_at_an_edge = |r: &Vec<f64>| !(EDGE * last..(1.0 - EDGE) * last).contains(&r[i]);
            let far = match ranks.iter().any(is_at_an_edge) {
                true => f64::INFINITY,
                false => near[count - 1].0,
            };
            [windows[i].size - quantile_between_ranks(&sizes, 0.5), far]
        })
        .collect()
}
