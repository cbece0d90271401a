//! Columns of the catalogue's effects as a fixed dictionary, for the naive recipes.
//!
//! Shapes are grids; periods are the strongest of the spectrum that inertia, stops and the plain columns leave. Frictional lag, ageing,
//! compliance, backlash, creep, dead zone and saturation are no fixed columns and are left out.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector};

use super::motion::{Extent, Motion, slope};
use super::oracle::{YIELDS, binned};
use super::table::Table;

/// Speeds of a Stribeck curve, in the top speed.
const STRIBECK: [f64; 4] = [0.01, 0.03, 0.1, 0.3];
/// Half waves of a smooth map over the travel.
const MAP: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
/// Places of a spot, and its widths (1/e), in the travel.
const PLACES: usize = 9;
const WIDTHS: [f64; 2] = [0.06, 0.15];
/// Paths over which friction runs in, in the whole path.
const RUN_IN: [f64; 2] = [0.05, 0.3];
/// Waves in the travel that a period may have, and Hz of a vibration.
const WAVES: [f64; 2] = [3.0, 2000.0];
const SHAKES_HZ: [f64; 2] = [1.0, 40.0];
/// Cells of a coordinate in a spectrum, for each wave of the shortest.
const CELLS_A_WAVE: f64 = 4.0;
/// Strongest lines of each spectrum that become columns.
const LINES: usize = 3;
/// Rows that a fit needs.
const LEAST_ROWS: usize = 200;

/// Columns over the averaged rows.
pub struct Candidates {
    /// Inertia and stops.
    pub base: Vec<Vec<f64>>,
    /// The effect of each candidate …
    pub ids: Vec<&'static str>,
    /// … and its column.
    pub columns: Vec<Vec<f64>>,
    /// What is to be explained.
    pub effort: Vec<f64>,
}

/// What every column is made of, along one part.
struct Part<'a> {
    table: &'a Table,
    motion: &'a Motion,
    /// Position in the travel, 0 … 1.
    along: Vec<f64>,
    /// Friction's sign.
    friction: Vec<f64>,
}

/// The columns of a recording.
///
/// # Errors
/// Where it is too short or does not move.
pub fn candidates(parts: &[Table], motions: &[Motion]) -> Result<Candidates, String> {
    let extent = Extent::of(motions);
    if !(extent.travel > 0.0 && extent.top > 0.0) {
        return Err("nothing moves".to_owned());
    }
    let parts: Vec<Part> = parts
        .iter()
        .zip(motions)
        .map(|(table, motion)| Part {
            table,
            motion,
            along: motion
                .x
                .iter()
                .map(|x| (x - extent.low) / extent.travel)
                .collect(),
            friction: motion.stop(extent.yielding()),
        })
        .collect();
    let mut all = Candidates {
        base: Vec::new(),
        ids: Vec::new(),
        columns: Vec::new(),
        effort: Vec::new(),
    };
    all.base.push(over(&parts, |p, i| p.motion.a[i]));
    for share in YIELDS {
        let stops: Vec<Vec<f64>> = parts
            .iter()
            .map(|p| p.motion.stop(share * extent.travel))
            .collect();
        all.base.push(joined(&parts, &stops));
    }
    all.effort = over(&parts, |p, i| p.table.columns[p.table.effort()][i]);
    if all.effort.len() < LEAST_ROWS {
        return Err(format!(
            "{} rows of 10 ms; a fit needs {LEAST_ROWS}",
            all.effort.len()
        ));
    }
    plain(&mut all, &parts, &extent);
    maps(&mut all, &parts);
    lines(&mut all, &parts, &extent);
    Ok(all)
}

/// A column of averaged rows.
fn over(parts: &[Part], at: impl Fn(&Part, usize) -> f64) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = parts
        .iter()
        .map(|p| (0..p.along.len()).map(|i| at(p, i)).collect())
        .collect();
    joined(parts, &columns)
}

fn joined(parts: &[Part], columns: &[Vec<f64>]) -> Vec<f64> {
    let parts = parts.iter().zip(columns);
    parts
        .flat_map(|(p, c)| binned(c, p.motion, p.table.sample_time()))
        .collect()
}

impl Candidates {
    fn push(&mut self, id: &'static str, parts: &[Part], at: impl Fn(&Part, usize) -> f64) {
        self.ids.push(id);
        self.columns.push(over(parts, at));
    }
}

/// Effects of speed, direction, time and further columns.
fn plain(all: &mut Candidates, parts: &[Part], extent: &Extent) {
    all.push("constant_force", parts, |_, _| 1.0);
    all.push("coulomb_asymmetry", parts, |p, i| p.friction[i].abs());
    all.push("viscous", parts, |p, i| p.motion.v[i]);
    all.push("quadratic_drag", parts, |p, i| {
        p.motion.v[i] * p.motion.v[i].abs()
    });
    for share in STRIBECK {
        let speed = share * extent.top;
        all.push("stribeck", parts, |p, i| {
            p.friction[i] * (-p.motion.v[i].abs() / speed).exp()
        });
    }
    all.push("position_spring", parts, |p, i| p.along[i] - 0.5);
    if parts.iter().all(|p| p.table.rotary()) && extent.travel > 1.0 {
        all.push("gravity", parts, |p, i| p.motion.x[i].sin());
        all.push("gravity", parts, |p, i| p.motion.x[i].cos());
    }
    let rates = parts.iter().map(|p| {
        let m = p.motion;
        let reach = ((10e-3 / p.table.sample_time()).round() as usize).max(1);
        slope(&p.table.columns[p.table.effort()], &m.t, reach, &m.pieces)
    });
    let rates: Vec<Vec<f64>> = rates.collect();
    all.ids.push("channel_delay");
    all.columns.push(joined(parts, &rates));
    let further = |name: &str| {
        parts.iter().all(|p| {
            p.table
                .find(name)
                .is_some_and(|c| p.table.columns[c].iter().all(|v| v.is_finite()))
        })
    };
    let value =
        |p: &Part, name: &str, i: usize| p.table.find(name).map_or(0.0, |c| p.table.columns[c][i]);
    if further("temperature_C") {
        all.push("thermal_drift", parts, |p, i| {
            p.friction[i] * value(p, "temperature_C", i)
        });
    } else {
        all.push("thermal_drift", parts, |p, i| p.friction[i] * p.motion.t[i]);
    }
    if further("load_N") {
        all.push("load_dependent_friction", parts, |p, i| {
            p.friction[i] * value(p, "load_N", i)
        });
    }
    for share in RUN_IN {
        let worn = parts.iter().map(|p| {
            let steps = p.motion.x.windows(2).map(|x| (x[1] - x[0]).abs());
            let whole: f64 = steps.clone().sum::<f64>().max(f64::MIN_POSITIVE);
            let mut path = 0.0;
            let level = std::iter::once(0.0).chain(steps).zip(&p.friction);
            level
                .map(|(step, z)| {
                    path += step;
                    z * (-path / (share * whole)).exp()
                })
                .collect()
        });
        let worn: Vec<Vec<f64>> = worn.collect();
        all.ids.push("run_in");
        all.columns.push(joined(parts, &worn));
    }
}

/// Effects of the place.
fn maps(all: &mut Candidates, parts: &[Part]) {
    for half in MAP {
        all.push("position_force", parts, |p, i| {
            (PI * half * p.along[i]).cos()
        });
        all.push("position_friction", parts, |p, i| {
            p.friction[i] * (PI * half * p.along[i]).cos()
        });
    }
    for width in WIDTHS {
        for place in (1..=PLACES).map(|k| k as f64 / (PLACES + 1) as f64) {
            let bump = move |s: f64| (-((s - place) / width).powi(2)).exp();
            all.push("local_friction_spot", parts, |p, i| {
                p.friction[i] * bump(p.along[i])
            });
        }
    }
}

/// Effects with a period, at the strongest lines of what all columns so far leave.
fn lines(all: &mut Candidates, parts: &[Part], extent: &Extent) {
    let left = residual(all);
    let place = over(parts, |p, i| p.along[i]);
    let friction = over(parts, |p, i| p.friction[i]);
    let squares = over(parts, |p, i| (p.motion.v[i] / extent.top).powi(2));
    let of =
        |weights: &[f64]| -> Vec<f64> { left.iter().zip(weights).map(|(r, w)| r * w).collect() };
    let quarter = PI / 2.0;
    for waves in strongest(&place, &left, WAVES) {
        for phase in [0.0, quarter] {
            all.push("periodic_force", parts, |p, i| {
                (TAU * waves * p.along[i] + phase).cos()
            });
        }
    }
    for waves in strongest(&place, &of(&friction), WAVES) {
        for phase in [0.0, quarter] {
            all.push("periodic_friction", parts, |p, i| {
                p.friction[i] * (TAU * waves * p.along[i] + phase).cos()
            });
        }
    }
    // The acceleration of a misread position e·cos(kx): an error is felt through the mass.
    for waves in strongest(&place, &of(&squares), WAVES) {
        let k = TAU * waves / extent.travel;
        for phase in [0.0, quarter] {
            all.push("encoder_error", parts, |p, i| {
                let (sin, cos) = (TAU * waves * p.along[i] + phase).sin_cos();
                k * p.motion.v[i].powi(2) * cos + p.motion.a[i] * sin
            });
        }
    }
    let time = over(parts, |p, i| p.motion.t[i]);
    let (first, last) = time
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| {
            (a.min(*t), b.max(*t))
        });
    let duration = (last - first).max(f64::MIN_POSITIVE);
    let along: Vec<f64> = time.iter().map(|t| (t - first) / duration).collect();
    for cycles in strongest(&along, &left, SHAKES_HZ.map(|f| f * duration)) {
        for phase in [0.0, quarter] {
            all.push("external_vibration", parts, |p, i| {
                (TAU * cycles / duration * p.motion.t[i] + phase).cos()
            });
        }
    }
}

/// What least squares on base and candidates leave of the effort.
fn residual(all: &Candidates) -> Vec<f64> {
    let columns: Vec<&Vec<f64>> = all.base.iter().chain(&all.columns).collect();
    let x = DMatrix::from_fn(all.effort.len(), columns.len(), |i, j| columns[j][i]);
    let y = DVector::from_column_slice(&all.effort);
    let mut normal = x.tr_mul(&x);
    for j in 0..columns.len() {
        normal[(j, j)] = normal[(j, j)] * (1.0 + 1e-6) + f64::MIN_POSITIVE;
    }
    let Some(factor) = normal.cholesky() else {
        return all.effort.clone();
    };
    let left = &y - &x * factor.solve(&x.tr_mul(&y));
    left.iter().copied().collect()
}

/// The strongest lines of a spectrum of `values` over a coordinate in 0 … 1, in waves over it: local maxima, strongest first.
fn strongest(along: &[f64], values: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let cells = (CELLS_A_WAVE * to).ceil() as usize;
    // As many zeros again: lines stand half a wave apart.
    let mut sums = vec![Complex::new(0.0, 0.0); 2 * cells.next_power_of_two()];
    let cells = sums.len() / 2;
    for (s, value) in along.iter().zip(values) {
        sums[((s * cells as f64) as usize).min(cells - 1)] += value;
    }
    preslide_fft::in_place(&mut sums);
    let powers: Vec<f64> = sums.iter().map(|c| c.norm_sqr()).collect();
    let wanted = (2.0 * from).ceil() as usize..=(2.0 * to) as usize;
    let mut peaks: Vec<usize> = wanted
        .filter(|&i| powers[i] > powers[i - 1] && powers[i] >= powers[i + 1])
        .collect();
    peaks.sort_by(|a, b| powers[*b].total_cmp(&powers[*a]));
    peaks.iter().take(LINES).map(|&i| 0.5 * i as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_lines_are_those_that_were_put_in() {
        // Unevenly spread, as a position is; 37.5 waves stand between two full ones.
        let along: Vec<f64> = (0..9000)
            .map(|i| 0.5 - 0.5 * (f64::from(i) * 0.0123).cos())
            .collect();
        let wave = |s: &f64| 2.0 * (TAU * 37.5 * s).cos() + (TAU * 400.0 * s + 1.0).cos();
        let values: Vec<f64> = along.iter().map(wave).collect();
        let found = strongest(&along, &values, WAVES);
        assert_eq!(found[0], 37.5);
        assert!(strongest(&along, &values, [300.0, 2000.0])[0] == 400.0);
    }
}
