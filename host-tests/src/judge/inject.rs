//! A known effect added to a real recording, as strong as a share of its effort's deviation.

use std::f64::consts::TAU;

use super::case::{Check, Place, Truth};
use super::motion::{Extent, Motion};
use super::oracle::{Base, Verdict, deviation};
use super::table::{Recording, Table};
use crate::trials::draw::Draw;
use crate::trials::effect::{Change, INJECTED, Injected, On, Shows};

/// Shakes, unless the recording is too slow for it (Hz).
const SHAKES_HZ: f64 = 11.3;
/// An encoder's error is felt through the mass: it must make this share of the effort.
const LEAST_INERTIA: f64 = 0.1;

/// A recording with an effect in it.
pub struct Injection {
    /// What the tool gets.
    pub recording: Recording,
    /// What is in it.
    pub truth: Truth,
    /// Whether the data show it.
    pub oracle: Verdict,
}

/// The drawn part of an effect: a place in 0.2…0.8 of the travel, a phase.
struct Shape {
    place: f64,
    phase: f64,
}

/// Adds `id` at an RMS of `percent` of the effort's deviation; `None` where this recording cannot carry it.
pub fn inject(recording: &Recording, id: &'static str, percent: f64) -> Option<Injection> {
    let effect = INJECTED.iter().find(|effect| effect.id == id)?;
    let motions: Vec<Motion> = recording.parts.iter().map(Motion::of).collect();
    let extent = Extent::of(&motions);
    let seed = recording.name.bytes().chain(id.bytes());
    let mut draw = Draw::new(seed.map(u64::from).sum(), 11);
    let shape = Shape {
        place: draw.uniform(0.2, 0.8),
        phase: draw.uniform(0.0, TAU),
    };
    let efforts: Vec<f64> = recording
        .parts
        .iter()
        .flat_map(|p| p.columns[p.effort()].clone())
        .collect();
    let size = percent / 100.0 * deviation(&efforts);
    let first = recording.parts.first()?;
    if id == "gravity" && !(first.rotary() && extent.travel > 1.0) {
        return None;
    }
    if id == "external_vibration" && frequency(first) > 0.15 / first.sample_time() {
        return None;
    }
    let mut changed = recording.clone();
    let added: Vec<Vec<f64>> = match effect.change {
        Change::Delay => delayed(&mut changed, size),
        Change::Misreading(waves) => {
            misread(&mut changed, &motions, &extent, (waves, shape.phase), size)?
        }
        Change::Force(force) => {
            let forces: Vec<Vec<f64>> = recording
                .parts
                .iter()
                .zip(&motions)
                .map(|(part, motion)| forces_of(force, part, motion, &extent, &shape))
                .collect();
            let scale = size / rms(forces.iter().flatten().copied());
            if effect.both_ways && scale > Base::new(&recording.parts, &motions, "").friction() {
                return None;
            }
            let added: Vec<Vec<f64>> = forces
                .iter()
                .map(|force| force.iter().map(|f| scale * f).collect())
                .collect();
            add(&mut changed, &added);
            added
        }
    };
    let moved: Vec<Motion> = changed.parts.iter().map(Motion::of).collect();
    let oracle = Base::new(&changed.parts, &moved, id).asks(&changed.parts, &moved, &added);
    changed.name = format!("{} + {percent} % {id}", recording.name);
    Some(Injection {
        truth: truth(effect, first, &extent, &shape),
        recording: changed,
        oracle,
    })
}

fn frequency(table: &Table) -> f64 {
    SHAKES_HZ.min(0.1 / table.sample_time())
}

fn rms(y: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = y.fold((0, 0.0), |(n, sum), y| (n + 1, sum + y * y));
    (sum / f64::from(n.max(1))).sqrt().max(f64::MIN_POSITIVE)
}

/// A force along a table.
fn forces_of(
    force: fn(&On) -> f64,
    part: &Table,
    motion: &Motion,
    extent: &Extent,
    shape: &Shape,
) -> Vec<f64> {
    let friction = motion.stop(extent.yielding());
    let at = |i: usize| {
        force(&On {
            t: motion.t[i],
            x: motion.x[i],
            v: motion.v[i],
            friction: friction[i],
            along: (motion.x[i] - extent.low) / extent.travel,
            top: extent.top,
            place: shape.place,
            phase: shape.phase,
            shake: frequency(part),
        })
    };
    (0..motion.x.len()).map(at).collect()
}

/// The effort read later so that it changes by an RMS of `size`, between rows by a straight line; returns the change.
fn delayed(recording: &mut Recording, size: f64) -> Vec<Vec<f64>> {
    let late = |part: &Table, delay: f64| -> Vec<f64> {
        let (effort, step) = (&part.columns[part.effort()], part.sample_time());
        let mut late = effort.clone();
        for piece in &Motion::of(part).pieces {
            for i in piece.clone() {
                let at = ((i - piece.start) as f64 - delay / step).max(0.0);
                let from = piece.start + at as usize;
                let next = (from + 1).min(piece.end - 1);
                late[i] = effort[from] + at.fract() * (effort[next] - effort[from]);
            }
        }
        late
    };
    let change = |delay: f64| -> Vec<Vec<f64>> {
        let parts = recording.parts.iter();
        parts
            .map(|part| {
                let effort = &part.columns[part.effort()];
                late(part, delay)
                    .iter()
                    .zip(effort)
                    .map(|(new, old)| new - old)
                    .collect()
            })
            .collect()
    };
    // The change grows with the delay: halve until it fits.
    let step = recording.parts.first().map_or(1e-3, Table::sample_time);
    let (mut low, mut high) = (0.0, 200.0 * step);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if rms(change(middle).iter().flatten().copied()) < size {
            low = middle;
        } else {
            high = middle;
        }
    }
    let added = change(low);
    add(recording, &added);
    added
}

/// Adds to the effort, one value a row of each part.
fn add(recording: &mut Recording, added: &[Vec<f64>]) {
    for (part, added) in recording.parts.iter_mut().zip(added) {
        let effort = part.effort();
        for (f, added) in part.columns[effort].iter_mut().zip(added) {
            *f += added;
        }
    }
}

/// The position misread periodically, so that the mass seems to need forces of an RMS of `size`; returns the force that the acceleration
/// misread asks for beside the recorded effort.
fn misread(
    recording: &mut Recording,
    motions: &[Motion],
    extent: &Extent,
    (waves, phase): (f64, f64),
    size: f64,
) -> Option<Vec<Vec<f64>>> {
    let (inertia, share) = Base::new(&recording.parts, motions, "").inertia();
    if share < LEAST_INERTIA {
        return None;
    }
    let k = TAU * waves / extent.travel;
    let misread = |part: &Table, error: f64| -> (Vec<f64>, Vec<f64>) {
        let x = &part.columns[part.position()];
        let read: Vec<f64> = x
            .iter()
            .map(|x| x + error * (k * x + phase).cos())
            .collect();
        let (before, after) = (
            Motion::of(part),
            Motion::along(part.columns[part.time()].clone(), &read, part.sample_time()),
        );
        let change = after
            .a
            .iter()
            .zip(&before.a)
            .map(|(new, old)| new - old)
            .collect();
        (read, change)
    };
    let small = 1e-6 * extent.travel;
    let felt = inertia
        * rms(recording
            .parts
            .iter()
            .flat_map(|part| misread(part, small).1));
    // Above a tenth of a period, the position would no longer follow the motion.
    let error = small * size / felt;
    if !error.is_finite() || error * k > 0.6 {
        return None;
    }
    let mut changes = Vec::new();
    for part in &mut recording.parts {
        let (read, change) = misread(part, error);
        let position = part.position();
        part.columns[position] = read;
        changes.push(change.iter().map(|a| -inertia * a).collect());
    }
    Some(changes)
}

/// Name, the parameters by which it is known to be this one, and its place.
fn truth(effect: &Injected, part: &Table, extent: &Extent, shape: &Shape) -> Truth {
    let centre = extent.low + shape.place * extent.travel;
    let around = |widths: f64| {
        let reach = 1.5 * extent.travel / widths;
        Some(Place::new("position", centre - reach, centre + reach))
    };
    let (check, place) = match effect.shows {
        Shows::Name => (None, None),
        Shows::Periods(waves) => {
            let period = Check::relative("period", extent.travel / waves, 0.05);
            (Some(period), None)
        }
        Shows::Frequency => {
            let frequency = Check::relative("frequency", frequency(part), 0.05);
            (Some(frequency), None)
        }
        Shows::Bump(widths) => (None, around(widths)),
        Shows::Spot(widths) => {
            let near = Check::within("position", centre, extent.travel / widths);
            (Some(near), around(widths))
        }
        Shows::Slow => (None, Some(Place::new("velocity", 0.0, 0.2 * extent.top))),
    };
    Truth {
        checks: check.into_iter().collect(),
        place,
        ..Truth::named(effect.id)
    }
}
