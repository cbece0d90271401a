//! `lead_error`: what a second measurement of position says of the first.
//!
//! The difference of the two is fitted by a smooth curve over the travel, Legendre polynomials to the eighth, beside what it does with
//! direction (backlash), effort (compliance), velocity and acceleration (delay) and time (warming). It acts in the position and not in
//! the effort, so it is no term of a hypothesis. Passes are held out in turn.

use super::signals::{Signals, bounds};
use crate::recording::{Extra, Recording};
use crate::statistics::Estimate;
use nalgebra::{DMatrix, DVector};

/// Correlation from which a further column measures this position: what slips or lags more is another coordinate.
const POSITION: f64 = 0.99;
/// Where both are in the same unit and their ratio is within this share of one, its deviation from one is the lead's; otherwise
/// there is a transmission between them whose exact ratio nobody said.
const SAME: f64 = 0.02;
/// Share of the stroke before after which a reversal's backlash counts as taken up.
const TAKEN_UP: f64 = 0.1;
/// Degree of the curve: a slow variation over the travel.
const DEGREE: usize = 8;
/// Groups of passes that are held out in turn, and the fewest passes.
const GROUPS: usize = 12;
const FEWEST: usize = 6;
/// Standard errors, over groups of passes, from which something is stated: with six groups the chance is below one in a hundred.
const CERTAIN: f64 = 4.0;
/// Share of the difference that the curve must take of what is held out.
const MATERIAL: f64 = 0.05;
/// Samples that are fitted.
const MOST: usize = 100_000;
/// Points of the curve that is told.
const POINTS: usize = 41;

/// Columns beside the curve: one, time, effort, direction, velocity, acceleration.
const CONSTANT: usize = 0;
const EFFORT: usize = 2;
const DIRECTION: usize = 3;
const BESIDE: usize = 6;
/// Those that hide what follows effort and direction: inertia and friction make of them an effort again.
const HIDING: [usize; 2] = [4, 5];

/// What a second position says.
pub struct SecondPosition {
    /// Its column.
    pub column: String,
    /// The second position over the first, where a transmission or an unknown unit lies between them and the slope cannot be told.
    pub ratio: Option<f64>,
    /// Passes between reversals that were compared.
    pub passes: usize,
    /// Second less first, smooth over the travel; `None` where there is none.
    pub lead: Option<Lead>,
    /// How far the second stays behind at a reversal (m or rad), where certain and apart from a delay.
    pub lost_motion: Option<Estimate>,
    /// How far it stays behind the effort (m or rad per unit of effort), where certain.
    pub compliance: Option<Estimate>,
    /// RMS of what is left on passes held out (m or rad).
    pub left: f64,
}

/// A difference that is smooth over the travel.
pub struct Lead {
    /// Its slope (m/m), where it can be told.
    pub slope: Option<Estimate>,
    /// What is left of it without the slope, from its lowest to its highest (m or rad) …
    pub bow: f64,
    /// … and where those are (m or rad).
    pub lowest_at: f64,
    /// See [`lowest_at`](Self::lowest_at).
    pub highest_at: f64,
    /// Position and difference (m or rad), the mean taken off.
    pub curve: Vec<[f64; 2]>,
    /// Share of the squared difference that it takes on passes held out …
    pub share: f64,
    /// … in standard errors between them.
    pub z: f64,
}

/// What each further column says that measures this position, too.
pub fn of(recording: &Recording) -> Vec<SecondPosition> {
    let measures = |e: &Extra| {
        let factor = e.position_factor(recording.kind);
        Some((
            e.name.clone(),
            brought(&e.values, &recording.position, factor)?,
        ))
    };
    let found: Vec<_> = recording.extra.iter().filter_map(measures).collect();
    if found.is_empty() {
        return Vec::new();
    }
    // A turn that is not seen makes backlash look like something of the velocity: the rows' own turns are for friction, which needs longer ones.
    let s = Signals::of(recording).with_every_turn();
    let all = found.into_iter();
    all.filter_map(|(name, (values, ratio))| compared(name, &values, ratio, &recording.effort, &s))
        .collect()
}

/// A column in the unit of the position, and its ratio to it where that had to be fitted; `None` where it measures something else, or
/// is the same measurement once more.
fn brought(
    values: &[f64],
    position: &[f64],
    factor: Option<f64>,
) -> Option<(Vec<f64>, Option<f64>)> {
    let n = position.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (mx, my) = (mean(position), mean(values));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in position.iter().zip(values) {
        let (x, y) = (x - mx, y - my);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    if xy * xy < POSITION * POSITION * xx * yy || xx <= 0.0 {
        return None;
    }
    let fitted = xy / xx;
    let known = factor.map(|f| f * fitted.signum());
    let known = known.filter(|k| (fitted * k - 1.0).abs() < SAME);
    let scale = known.unwrap_or(1.0 / fitted);
    let values: Vec<f64> = values.iter().map(|y| scale * (y - my) + mx).collect();
    // The same counts, written twice, differ by no more than their steps.
    let steps = position.windows(2).map(|p| (p[1] - p[0]).abs());
    let count = steps.filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let furthest = position.iter().zip(&values);
    let furthest = furthest.map(|(x, y)| (y - x).abs()).fold(0.0, f64::max);
    (furthest > count).then_some((values, known.is_none().then_some(fitted)))
}

fn compared(
    column: String,
    second: &[f64],
    ratio: Option<f64>,
    effort: &[f64],
    s: &Signals,
) -> Option<SecondPosition> {
    let (low, high) = bounds(&s.x);
    let pass = passes(s);
    let passes = pass.last()? + 1;
    if passes < FEWEST {
        return None;
    }
    let groups = passes.min(GROUPS);
    let most_effort = size(effort);
    let scale = (high - low).max(1e-300);
    let sums = sums(second, effort, most_effort, s, &pass, groups);
    // A ratio that was fitted leaves no slope to tell.
    let plain: Vec<usize> = (0..BESIDE + usize::from(ratio.is_some())).collect();
    let every: Vec<usize> = (0..BESIDE + DEGREE).collect();
    let (without, with) = (HeldOut::of(&sums, &plain)?, HeldOut::of(&sums, &every)?);
    let (share, z) = with.better_than(&without);
    let lead = (z > CERTAIN && share > MATERIAL).then(|| Lead {
        share,
        z,
        ..Lead::of(&with, low, scale, ratio.is_none())
    });
    let (told, columns) = if lead.is_some() {
        (&with, every)
    } else {
        (&without, plain)
    };
    // Where velocity and acceleration tell nothing that effort and direction do not, these are told apart.
    let seen: Vec<usize> = columns
        .into_iter()
        .filter(|c| !HIDING.contains(c))
        .collect();
    let seen = HeldOut::of(&sums, &seen)?;
    let alone = told.better_than(&seen).0 < MATERIAL;
    let certain = |column, unit| alone.then(|| seen.certain(column, unit)).flatten();
    Some(SecondPosition {
        column,
        ratio,
        passes,
        lost_motion: certain(DIRECTION, -2.0 * scale),
        compliance: certain(EFFORT, -scale / most_effort),
        left: scale * told.left(),
        lead,
    })
}

impl Lead {
    /// The curve of a fit over a travel of length `scale` from `low`; it has a slope where that is told.
    fn of(fit: &HeldOut, low: f64, scale: f64, sloped: bool) -> Self {
        let of_degree = |d: usize| fit.coefficients[BESIDE + d - 1];
        let point = |k: usize| 2.0 * k as f64 / (POINTS - 1) as f64 - 1.0;
        let place = |k: usize| low + 0.5 * scale * (point(k) + 1.0);
        let from = |first: usize| -> Vec<f64> {
            let at = |k| {
                let p = legendre(point(k));
                let terms = (first..=DEGREE).map(|d| scale * of_degree(d) * p[d - 1]);
                terms.sum()
            };
            (0..POINTS).map(at).collect()
        };
        let bow = from(2);
        let at = |sign: f64| {
            let best = (0..POINTS).max_by(|a, b| (sign * bow[*a]).total_cmp(&(sign * bow[*b])));
            best.unwrap_or(0)
        };
        let (lowest, highest) = (at(-1.0), at(1.0));
        Self {
            // The first polynomial goes from −1 to 1 over the travel.
            slope: sloped.then(|| fit.estimate(BESIDE, 2.0)),
            bow: bow[highest] - bow[lowest],
            lowest_at: place(lowest),
            highest_at: place(highest),
            curve: (0..).zip(from(1)).map(|(k, d)| [place(k), d]).collect(),
            share: 0.0,
            z: 0.0,
        }
    }
}

/// Sums over the samples of each group of passes in which a reversal's backlash is taken up.
fn sums(
    second: &[f64],
    effort: &[f64],
    most_effort: f64,
    s: &Signals,
    pass: &[usize],
    groups: usize,
) -> Vec<Sums> {
    let (low, high) = bounds(&s.x);
    let scale = (high - low).max(1e-300);
    let (duration, top) = (s.duration().max(1e-300), s.top_speed().max(1e-300));
    let most_a = size(&s.a);
    let mut sums = vec![Sums::new(); groups];
    for i in (0..s.x.len()).step_by(s.x.len().div_ceil(MOST)) {
        if s.since_reversal[i] < TAKEN_UP * s.last_stroke[i] {
            continue;
        }
        let beside = [
            1.0,
            s.t[i] / duration - 0.5,
            effort[i] / most_effort,
            s.direction[i],
            s.v[i] / top,
            s.a[i] / most_a,
        ];
        let curve = legendre(2.0 * (s.x[i] - low) / scale - 1.0);
        let columns: Vec<f64> = beside.into_iter().chain(curve).collect();
        sums[pass[i] % groups].add(&DVector::from(columns), (second[i] - s.x[i]) / scale);
    }
    sums.retain(|s| s.count > 0.0);
    sums
}

fn size(v: &[f64]) -> f64 {
    v.iter().fold(1e-300, |m: f64, v| m.max(v.abs()))
}

/// The number of the pass between reversals that each sample belongs to.
fn passes(s: &Signals) -> Vec<usize> {
    let mut pass = 0;
    (0..s.x.len())
        .map(|i| {
            pass += usize::from(i > 0 && s.direction[i] != s.direction[i - 1]);
            pass
        })
        .collect()
}

/// Legendre polynomials of degree 1 to [`DEGREE`].
fn legendre(u: f64) -> [f64; DEGREE] {
    let mut p = [u; DEGREE];
    let mut before = 1.0;
    for d in 1..DEGREE {
        let n = d as f64;
        p[d] = ((2.0 * n + 1.0) * u * p[d - 1] - n * before) / (n + 1.0);
        before = p[d - 1];
    }
    p
}

/// Sums of one group of passes.
#[derive(Clone)]
struct Sums {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    count: f64,
}

impl Sums {
    fn new() -> Self {
        Self {
            normal: DMatrix::zeros(BESIDE + DEGREE, BESIDE + DEGREE),
            right: DVector::zeros(BESIDE + DEGREE),
            square: 0.0,
            count: 0.0,
        }
    }

    fn add(&mut self, columns: &DVector<f64>, value: f64) {
        self.normal.ger(1.0, columns, columns, 1.0);
        self.right.axpy(value, columns, 1.0);
        self.square += value * value;
        self.count += 1.0;
    }

    /// Coefficients of all columns, those that are not `used` zero.
    fn solve(groups: &[&Sums], used: &[usize]) -> Option<DVector<f64>> {
        let n = used.len();
        let sum = |i: usize, j: usize| groups.iter().map(|g| g.normal[(i, j)]).sum::<f64>();
        let normal = DMatrix::from_fn(n, n, |i, j| sum(used[i], used[j]));
        let right = DVector::from_fn(n, |i, _| groups.iter().map(|g| g.right[used[i]]).sum());
        // What is not there, such as an effort of zero, has no coefficient.
        let solved = normal.svd(true, true);
        let least = 1e-12 * solved.singular_values.max();
        let own = solved.solve(&right, least).ok()?;
        let mut all = DVector::zeros(BESIDE + DEGREE);
        used.iter().zip(own.iter()).for_each(|(&i, c)| all[i] = *c);
        Some(all)
    }

    /// Sum of squares that some coefficients leave.
    fn left(&self, c: &DVector<f64>) -> f64 {
        (self.square - 2.0 * c.dot(&self.right) + c.dot(&(&self.normal * c))).max(0.0)
    }
}

/// A fit to all groups, and to all but each.
struct HeldOut {
    coefficients: DVector<f64>,
    others: Vec<DVector<f64>>,
    /// Mean square on each group, of the fit to the others.
    squares: Vec<f64>,
}

impl HeldOut {
    fn of(sums: &[Sums], used: &[usize]) -> Option<Self> {
        let all: Vec<&Sums> = sums.iter().collect();
        let but = |k: usize| {
            let rest: Vec<&Sums> = (0..sums.len())
                .filter(|i| *i != k)
                .map(|i| all[i])
                .collect();
            Sums::solve(&rest, used)
        };
        let others: Vec<DVector<f64>> = (0..sums.len()).map(but).collect::<Option<_>>()?;
        let own = sums.iter().zip(&others);
        let squares = own
            .map(|(s, c)| {
                // The level of a group is its own: a drift between passes is no lead.
                let mut c = c.clone();
                let off =
                    (s.right[CONSTANT] - s.normal.row(CONSTANT).transpose().dot(&c)) / s.count;
                c[CONSTANT] += off;
                s.left(&c) / s.count
            })
            .collect();
        Some(Self {
            coefficients: Sums::solve(&all, used)?,
            others,
            squares,
        })
    }

    /// Share of the other's squared error that is less, and how many standard errors between groups.
    fn better_than(&self, other: &Self) -> (f64, f64) {
        let less = other.squares.iter().zip(&self.squares).map(|(a, b)| a - b);
        let less: Vec<f64> = less.collect();
        let n = less.len() as f64;
        let mean = less.iter().sum::<f64>() / n;
        let scatter = less.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let whole = other.squares.iter().sum::<f64>() / n;
        (
            mean / whole.max(1e-300),
            mean / (scatter / n).sqrt().max(1e-300),
        )
    }

    /// RMS of what is left of the groups held out.
    fn left(&self) -> f64 {
        (self.squares.iter().sum::<f64>() / self.squares.len().max(1) as f64).sqrt()
    }

    /// A coefficient times `unit`, with its interval by the jackknife.
    fn estimate(&self, column: usize, unit: f64) -> Estimate {
        let error = unit.abs() * self.error(column);
        Estimate::new(
            unit * self.coefficients[column],
            Some(error),
            self.others.len(),
        )
    }

    fn error(&self, column: usize) -> f64 {
        let n = self.others.len() as f64;
        let mean = self.others.iter().map(|c| c[column]).sum::<f64>() / n;
        let squares = self.others.iter().map(|c| (c[column] - mean).powi(2));
        ((n - 1.0) / n * squares.sum::<f64>()).sqrt()
    }

    fn certain(&self, column: usize, unit: f64) -> Option<Estimate> {
        let is_certain = self.coefficients[column].abs() > CERTAIN * self.error(column);
        is_certain.then(|| self.estimate(column, unit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, load_csv};

    const SLOPE: f64 = 60e-6;

    /// Slope and bow over ±0.12 m.
    fn lead(x: f64) -> f64 {
        SLOPE * x + 4e-6 * (std::f64::consts::PI * x / 0.12).cos()
    }

    /// 60 s over 0.24 m against 4 N and 20 N·s/m, 3 kg; `second` tells a second position from the first, the effort and the play of a
    /// backlash of 10 µm, beside 0.3 µm of noise. `scale` is what its column is multiplied by.
    fn recorded(name: &str, scale: f64, second: impl Fn(f64, f64, f64) -> f64) -> Recording {
        const SEED: u32 = 5;
        println!("seed {SEED}");
        let mut seed = SEED;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        let mut text = format!("t_s,x_m,force_N,{name}\n");
        let mut play = 0.0_f64;
        for i in 0..30_000 {
            let t = f64::from(i) / 500.0;
            let waves = [(0.09, 2.1), (0.03, 5.3)];
            let sum =
                |of: &dyn Fn(f64, f64) -> f64| waves.iter().map(|(a, w)| of(*a, *w)).sum::<f64>();
            let x = sum(&|a, w| a * (w * t).sin());
            let v = sum(&|a, w| a * w * (w * t).cos());
            let a = -sum(&|a, w| a * w * w * (w * t).sin());
            let force = 3.0 * a + 4.0 * (v / 1e-3).tanh() + 20.0 * v + 0.05 * noise();
            play = play.clamp(x - 5e-6, x + 5e-6);
            let y = second(x, force, play) + 1e-6 * noise();
            let x = (x / 1e-7).round() * 1e-7;
            text += &format!("{t:.3},{x:.8},{force:.4},{:.9}\n", scale * y + 0.4);
        }
        let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
        recording.unwrap_or_else(|e| panic!("{e}"))
    }

    /// What is found in such a recording.
    fn made(name: &str, scale: f64, second: impl Fn(f64, f64, f64) -> f64) -> Vec<SecondPosition> {
        let recording = recorded(name, scale, second);
        let all = of(&recording);
        all.iter().for_each(|p| println!("{}", p.words(&recording)));
        all
    }

    fn only(all: Vec<SecondPosition>) -> SecondPosition {
        assert_eq!(all.len(), 1);
        all.into_iter().next().expect("one")
    }

    #[test]
    fn a_lead_error_is_told_beside_backlash_and_compliance() {
        let found = only(made("x_scale_mm", 1e3, |x, f, play| {
            lead(x) + play - f / 4e6
        }));
        let lead_error = found.lead.expect("a lead error");
        let slope = lead_error.slope.expect("one unit").value;
        assert!((slope / SLOPE - 1.0).abs() < 0.03, "slope {slope}");
        let off: Vec<f64> = lead_error.curve.iter().map(|[x, d]| d - lead(*x)).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let most = off.iter().fold(0.0, |m: f64, d| m.max((d - mean).abs()));
        let rms = (off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt();
        println!("curve: largest {most:.1e} m, RMS {rms:.1e} m");
        // Of 7 µm each way; the noise of the second position is 0.3 µm RMS.
        assert!(most < 5e-7 && rms < 2e-7, "largest {most}, RMS {rms}");
        assert!(lead_error.share > 0.5, "{}", lead_error.share);
        let width = found.lost_motion.expect("backlash").value;
        assert!((width / 10e-6 - 1.0).abs() < 0.05, "width {width}");
        let compliance = found.compliance.expect("compliance").value;
        assert!(
            (compliance * 4e6 - 1.0).abs() < 0.1,
            "compliance {compliance}"
        );
    }

    #[test]
    fn the_words_tell_backlash_and_compliance_with_their_intervals() {
        let recording = recorded("x_scale_m", 1.0, |_, f, play| play - f / 4e6);
        let found = only(of(&recording));
        let words = found.words(&recording);
        println!("{words}");
        // The value and what stands behind ± in the clause that ends in `end`, in the unit `unit`.
        let told = |start: &str, end: &str, units: &[(&str, f64)]| -> [f64; 2] {
            let clause = words.split(start).nth(1).expect(start);
            let clause = clause.split(end).next().expect(end);
            let (value, reach) = clause.split_once(" ± ").expect("an interval");
            let number = |text: &str| {
                let mut parts = text.split_whitespace();
                let figure: f64 = parts.next().and_then(|f| f.parse().ok()).expect("a figure");
                let unit = parts.next();
                let factor = units.iter().find(|(u, _)| Some(*u) == unit);
                figure * factor.map_or(1.0, |(_, f)| *f)
            };
            [number(value), number(reach)]
        };
        let units = [("µm", 1e-6), ("nm", 1e-9), ("m/N", 1.0)];
        for (estimate, [value, reach]) in [
            (
                found.compliance.expect("compliance"),
                told("behind the effort by ", " (compliance)", &units),
            ),
            (
                found.lost_motion.expect("backlash"),
                told("it stays behind by ", " (backlash", &units),
            ),
        ] {
            let [low, high] = estimate.ci95.expect("an interval");
            // Two figures of the interval, three of the value.
            assert!((value / estimate.value - 1.0).abs() < 6e-3, "{value}");
            assert!((2.0 * reach / (high - low) - 1.0).abs() < 0.06, "{reach}");
        }
    }

    #[test]
    fn backlash_compliance_and_nothing_are_no_lead_error() {
        let found = only(made("x_scale_m", 1.0, |_, _, play| play));
        assert!(found.lead.is_none());
        let width = found.lost_motion.expect("backlash").value;
        assert!((width / 10e-6 - 1.0).abs() < 0.05, "width {width}");

        let found = only(made("x_scale_m", 1.0, |x, f, _| x - f / 4e6));
        assert!(found.lead.is_none());
        let compliance = found.compliance.expect("compliance").value;
        assert!(
            (compliance * 4e6 - 1.0).abs() < 0.05,
            "compliance {compliance}"
        );

        let found = only(made("x_scale_m", 1.0, |x, _, _| x));
        assert!(found.lead.is_none() && found.lost_motion.is_none() && found.compliance.is_none());
        assert!((found.left / 2.9e-7 - 1.0).abs() < 0.1, "{}", found.left);
    }

    #[test]
    fn units_and_mirrored_scales_change_nothing() {
        let of = |name: &str, scale: f64| {
            let found = only(made(name, scale, |x, _, play| lead(x) + play));
            let slope = found.lead.and_then(|l| l.slope).expect("a slope");
            let gap = found.lost_motion.expect("backlash");
            let [low, high] = slope.ci95.expect("an interval");
            assert!((low..high).contains(&SLOPE), "{low} to {high}");
            [slope.value, gap.value]
        };
        let metres = of("x_scale_m", 1.0);
        for other in [of("x_scale_um", 1e6), of("x_scale_mm", -1e3)] {
            for (a, b) in metres.iter().zip(other) {
                // The file has nine decimals: 1 nm in metres.
                assert!((b / a - 1.0).abs() < 1e-3, "{a} and {b}");
            }
        }
    }

    #[test]
    fn beside_a_gear_the_bow_is_told_and_no_slope() {
        let found = only(made("motor_counts", 12_345.6, |x, _, _| x + lead(x)));
        let lead_error = found.lead.expect("a lead error");
        assert!(lead_error.slope.is_none() && found.ratio.is_some());
        // Of the cosine 8 µm, and what the best straight line leaves of it.
        assert!(
            (lead_error.bow / 8e-6 - 1.0).abs() < 0.1,
            "{}",
            lead_error.bow
        );
    }
}
