//! What of a recording no machine has, and the units of its columns that would put all of it right.

use super::columns::Plan;
use super::known::Slot;
use super::names::Source;
use super::summary::short;
use super::units::{self, Dimension, SECOND};
use super::{EffortRole, MotionKind, Recording, Warning, words};
use crate::statistics::{LeastSquares, bounds, quantile};

/// The columns whose units make the values: a value in other units is it times their scales to these powers.
const COLUMNS: [Slot; 4] = [Slot::Time, Slot::Position, Slot::Velocity, Slot::Effort];
type Powers = [i32; 4];
const STEP: Powers = [1, 0, 0, 0];
const EFFORT: Powers = [0, 0, 0, 1];

/// What a recording shows of its machine.
struct Shown {
    /// In words, as it is asked about.
    said: String,
    value: f64,
    powers: Powers,
    /// Between these no machine surprises …
    least: f64,
    most: f64,
    /// … whose units are stated, up to this.
    most_stated: f64,
    /// Of a usual axis: of two units that are possible the one that is nearer to it is the likelier.
    usual: f64,
}

impl Shown {
    /// Its value with the columns in other units.
    fn at(&self, scales: &[f64; 4]) -> f64 {
        let scales = scales.iter().zip(self.powers);
        let scales = scales.map(|(scale, power)| scale.powi(power));
        self.value * scales.product::<f64>()
    }

    fn is_inside(&self, scales: &[f64; 4]) -> bool {
        (self.least..=self.most).contains(&self.at(scales))
    }
}

/// The most of what the axes of one kind have. Beyond it a unit is more likely wrong than the machine is such; `bare` is for a column whose unit
/// neither the file nor a factor of the map states.
struct Most {
    travel: f64,
    bare_travel: f64,
    speed: f64,
    acceleration: f64,
    inertia: f64,
    bare_inertia: f64,
    usual: [f64; 4],
}

/// Gantries of 100 m, but racks without a joint of 20 m; linear motors of 10 m/s; piezo stages that make 10 µm at 10 kHz, 4e4 m/s²; earthquake tables of
/// 2,000 t, but of presses and machine tools 20 t for each metre of travel.
const LINEAR: Most = Most {
    travel: 100.0,
    bare_travel: 20.0,
    speed: 20.0,
    acceleration: 1e5,
    inertia: 3e6,
    bare_inertia: 2e4,
    usual: [0.1, 0.1, 1.0, 10.0],
};
/// A spindle of 60,000 turns a minute, for an hour; galvanometers that make 0.1 rad at 1 kHz, 4e6 rad/s²; telescopes of 1e8 kg·m², but robots' first
/// joints of 500 kg·m². What is taken to and fro by 90 of a unit, and never beyond a turn of degrees, is in degrees rather than 14 turns of a motor.
const ROTARY: Most = Most {
    travel: 2.3e7,
    bare_travel: 90.0,
    speed: 6.3e3,
    acceleration: 1e8,
    inertia: 1e9,
    bare_inertia: 1e3,
    usual: [3.0, 3.0, 10.0, 0.1],
};
/// Least travel: below it no encoder of 2026 counts (m or rad). Least inertia: a mirror of some mm about its axis, a coil of a microgram.
const LEAST_TRAVEL: f64 = 1e-10;
const LEAST_INERTIA: f64 = 1e-11;
/// Most effort by unit, the same in a bare column, and the usual: a press's 10 MN, a slewing ring's 1 MN·m, an inverter's 2 kV; few axes have more than
/// 100 A, where a drive that logs mA shows hundreds.
const EFFORTS: [(&str, f64, f64, f64); 4] = [
    ("N", 1e7, 1e7, 10.0),
    ("Nm", 1e6, 1e6, 1.0),
    ("A", 2e3, 100.0, 1.0),
    ("V", 2e3, 2e3, 5.0),
];
/// Sample times that a recording of friction has (s): the slowest servos log ten a second.
const LEAST_SAMPLE_TIME: f64 = 1e-7;
const LONGEST_SAMPLE_TIME: f64 = 0.5;
/// The longest one of a scan.
const LONGEST_OF_SCAN: f64 = 100.0;
/// Steps in its travel that a scan has at most, which stops at each place to be measured; what is recorded in motion has hundreds in a stroke.
const MOST_PLACES: f64 = 100.0;
/// A turn in degrees: what a joint's angle stays within.
const TURN: f64 = 361.0;
/// A soft loop falls short of its reference, but not thirty times; the next unit is 57 or 1000 times this one.
const FOLLOWS: f64 = 30.0;
/// A recorded velocity is the position's where it is between half and twice as fast; another unit explains it to this share.
const AGREES: f64 = 2.0;
const EXPLAINS: f64 = 1.03;

/// The units that a column is written in, the usual ones first.
fn units_of(dimension: Dimension) -> &'static [&'static str] {
    match dimension {
        Dimension::Time => &["s", "ms", "µs", "ns"],
        Dimension::Length => &["m", "mm", "µm", "nm"],
        Dimension::Angle => &["rad", "deg", "rev", "mrad"],
        Dimension::Speed => &["m/s", "mm/s", "µm/s", "mm/min"],
        Dimension::AngularSpeed => &["rad/s", "deg/s", "rpm", "rev/s"],
        Dimension::Force => &["N", "mN", "kN"],
        Dimension::Torque => &["Nm", "mNm", "kNm"],
        Dimension::Current => &["A", "mA"],
        Dimension::Voltage => &["V", "mV"],
        Dimension::Temperature | Dimension::Pressure => &[],
    }
}

/// A column in another unit.
struct Reading {
    /// 0 where it is as it was read.
    changes: usize,
    stated: usize,
    unit: &'static str,
    /// Decades that it must be nearer to a usual machine to be taken before a more usual unit.
    rank: f64,
    scale: f64,
}

impl Plan {
    /// The source of a role; of the time also its step.
    fn source(&self, slot: Slot) -> Option<&Source> {
        let of = |slot| self.sources.iter().find(|s| s.known.slot == slot);
        of(slot).or(of(Slot::Step).filter(|_| slot == Slot::Time))
    }

    fn is_bare(&self, slot: Slot) -> bool {
        self.source(slot).is_some_and(|s| !s.stated)
    }

    /// The units that a column may be in, with what they make of the values as they were read.
    fn readings(&self, slot: Slot) -> Vec<Reading> {
        let as_it_is = Reading {
            changes: 0,
            stated: 0,
            unit: "",
            rank: 0.0,
            scale: 1.0,
        };
        let mut readings = vec![as_it_is];
        let Some(source) = self.source(slot).filter(|s| !s.terms.is_empty()) else {
            return readings;
        };
        let units = source.known.dimension.map_or(&[][..], units_of).iter();
        let units = units.filter_map(|name| Some((*name, units::unit(name)?.factor)));
        // What the column is read in; the factor of another constant is per SI unit.
        let own = source.terms[0].factor;
        let is_own = |factor: f64| (factor / own - 1.0).abs() < 1e-9;
        let read_in = units
            .clone()
            .map(|u| u.1)
            .find(|f| is_own(*f))
            .unwrap_or(1.0);
        let others = units.enumerate().filter(|(_, u)| u.1 != read_in);
        readings.extend(others.map(|(rank, (unit, factor))| Reading {
            changes: 1,
            stated: usize::from(source.stated),
            unit,
            rank: 1.5 * rank as f64,
            scale: factor / read_in,
        }));
        readings
    }

    /// The column that a role is read from, and the mapping of so many times what it is.
    fn rescaled(&self, slot: Slot, scale: f64) -> Option<(&str, String)> {
        let source = self.source(slot)?;
        let name = |&i: &usize| self.names.get(i).map_or("", String::as_str);
        // To the digits that a unit has.
        let scaled = |factor: f64| {
            let digits = format!("{:.12e}", scale * factor);
            digits.parse().unwrap_or(scale * factor)
        };
        let term = |factor: f64, columns: &[usize]| {
            let columns: Vec<&str> = columns.iter().map(name).collect();
            format!("{:+}*{}", scaled(factor), columns.join("*"))
        };
        let terms = source.terms.iter().map(|t| term(t.factor, &t.columns));
        let mut sum: String = terms.collect();
        if source.offset != 0.0 {
            sum += &format!("{:+}", scaled(source.offset));
        }
        let first = source.columns().next()?;
        let map = format!("{}={}", source.known.name, sum.trim_start_matches('+'));
        Some((name(&first), map))
    }
}

impl Recording {
    /// Whether the time is in seconds by its name, and from one sample to the next it goes a good part of the travel.
    fn is_scan(&self, plan: &Plan, travel: f64) -> bool {
        let is_named = plan.sources.iter().any(|s| {
            let name = s.columns().next().and_then(|i| plan.names.get(i));
            s.is_bare_time() && name.is_some_and(|n| words::quantity(n).unit == Some(SECOND))
        });
        let steps = self.position.windows(2).map(|p| (p[1] - p[0]).abs());
        let usual = quantile(&mut steps.collect::<Vec<_>>(), 0.5);
        is_named && usual.is_some_and(|step| MOST_PLACES * step > travel)
    }

    /// Whether the position goes to and fro, half of its travel at least.
    fn turns_back(&self, travel: f64) -> bool {
        let steps = self.position.windows(2).map(|p| p[1] - p[0]);
        let (fro, to): (f64, f64) = steps.fold((0.0, 0.0), |(fro, to), s| match s < 0.0 {
            true => (fro - s, to),
            false => (fro, to + s),
        });
        fro.min(to) > 0.5 * travel
    }

    /// Places at which the motion is looked at, and the samples to either side that show its acceleration: a tenth of a stroke.
    fn places(&self) -> (Vec<usize>, usize) {
        const PLACES: usize = 2000;
        const LONGEST: usize = 1000;
        let strokes = 1 + self.segment.windows(2).filter(|p| p[0] != p[1]).count();
        let half = (self.len() / strokes / 20).clamp(1, LONGEST);
        let inside = self
            .pieces
            .iter()
            .flat_map(|p| p.start + half..p.end.saturating_sub(half));
        let all: Vec<usize> = inside.collect();
        let every = (all.len() / PLACES).max(1);
        (all.into_iter().step_by(every).collect(), half)
    }

    /// The inertia (kg or kg·m²), where it is seen: it takes a tenth of the effort, and without it twice the squares are left of what friction and a
    /// spring or a weight explain otherwise. Noise makes it less, never more.
    fn visible_inertia(&self) -> Option<f64> {
        const FEWEST: usize = 60;
        let is_force = matches!(self.role, EffortRole::Force | EffortRole::Torque);
        let (places, half) = self.places();
        let is_there = self.position.len() == self.len() && self.effort.len() == self.len();
        if !is_force || places.len() < FEWEST || !is_there {
            return None;
        }
        let (x, t, f) = (&self.position, &self.t_s, &self.effort);
        let slope = |a: usize, b: usize| (x[b] - x[a]) / (t[b] - t[a]);
        let column = |of: &dyn Fn(usize) -> f64| places.iter().map(|&i| of(i)).collect::<Vec<_>>();
        let speed = column(&|i| slope(i - half, i + half));
        let acceleration = column(&|i| {
            2.0 * (slope(i, i + half) - slope(i - half, i)) / (t[i + half] - t[i - half])
        });
        let direction: Vec<f64> = speed.iter().map(|v| v.signum()).collect();
        let [sine, cosine] = match self.kind {
            MotionKind::Linear => [column(&|i| x[i]), vec![0.0; places.len()]],
            MotionKind::Rotary => [column(&|i| x[i].sin()), column(&|i| x[i].cos())],
        };
        let one = vec![1.0; places.len()];
        let mean = |i: usize| {
            let around = &f[i - half..=i + half];
            around.iter().sum::<f64>() / around.len() as f64
        };
        let effort = column(&mean);
        let columns: [&[f64]; 6] = [&one, &speed, &direction, &sine, &cosine, &acceleration];
        let with = LeastSquares::of(&columns)?;
        let without = LeastSquares::of(&columns[..5])?;
        let inertia = with.coefficients(&effort).pop()?;
        let swing =
            |values: &[f64]| quantile(&mut values.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.9);
        let share = inertia * swing(&acceleration)? / swing(&effort)?;
        let seen = without.squares_left(&effort) > 2.0 * with.squares_left(&effort);
        (seen && share > 0.1).then_some(inertia)
    }

    /// How many times its recorded velocity, or its reference, the position goes, where the two go together and it is neither.
    fn disagreement(&self, agrees: f64, path: impl Fn(usize, usize) -> f64) -> Option<f64> {
        let (places, half) = self.places();
        let (mut both, mut squares, mut gone) = (0.0, 0.0, 0.0);
        for i in places {
            let (from, to) = (i - half, i + half);
            let step = self.position[to] - self.position[from];
            let path = path(from, to);
            both += step * path;
            squares += path * path;
            gone += step * step;
        }
        let together = both > 0.0 && both * both > 0.9 * squares * gone;
        let times = both / squares;
        (together && !(agrees.recip()..agrees).contains(&times)).then_some(times)
    }

    /// By the recorded velocity.
    fn against_velocity(&self) -> Option<f64> {
        let recorded = self.velocity.as_ref();
        let velocity = recorded.filter(|_| !self.position_integrated)?;
        self.disagreement(AGREES, |from, to| {
            let mean = velocity[from..=to].iter().sum::<f64>() / (to - from + 1) as f64;
            mean * (self.t_s[to] - self.t_s[from])
        })
    }

    /// By the reference.
    fn against_reference(&self) -> Option<f64> {
        let reference = self.reference.as_ref()?;
        self.disagreement(FOLLOWS, |from, to| reference[to] - reference[from])
    }

    /// What it shows of its machine.
    fn shown(&self, plan: &Plan) -> Vec<Shown> {
        let unit = self.position_unit();
        let most = match self.kind {
            MotionKind::Linear => &LINEAR,
            MotionKind::Rotary => &ROTARY,
        };
        let plus = |a: Powers, b: Powers, times: i32| std::array::from_fn(|k| a[k] + times * b[k]);
        // A position is a column or integrated from the velocity.
        let place: Powers = match self.position_integrated {
            true => [1, 0, 1, 0],
            false => [0, 1, 0, 0],
        };
        let pace = match self.velocity {
            Some(_) => [0, 0, 1, 0],
            None => plus(place, STEP, -1),
        };
        let moved = match self.position_integrated {
            true => Slot::Velocity,
            false => Slot::Position,
        };
        let (low, high) = bounds(&self.position);
        let travel = if low < high { high - low } else { 0.0 };
        let (speed, turns) = (self.top_speed(), self.turns_back(travel));
        let named = |slot| {
            let first = plan.source(slot).and_then(|s| s.columns().next());
            first.map_or("", |i| plan.names[i].as_str()).to_lowercase()
        };
        // A motor behind a gear turns far; so does a spindle, one way.
        let is_joint = turns
            && !self.position_integrated
            && low.abs().max(high) < TURN
            && !named(moved).contains("motor");
        let far = match self.kind {
            MotionKind::Rotary if !is_joint => most.travel,
            _ if plan.is_bare(moved) => most.bare_travel,
            _ => most.travel,
        };
        let step = self.sample_time_s();
        let longest = match self.is_scan(plan, travel) {
            true => LONGEST_OF_SCAN,
            false => LONGEST_SAMPLE_TIME,
        };
        let mut shown = Vec::new();
        let mut show =
            |said: String, value, powers, [least, most, most_stated, usual]: [f64; 4]| {
                shown.push(Shown {
                    said,
                    value,
                    powers,
                    least,
                    most,
                    most_stated,
                    usual,
                });
            };
        let of_step = [LEAST_SAMPLE_TIME, longest, longest, 1e-3];
        show(
            format!("a sample every {}", short(step, "s")),
            step,
            STEP,
            of_step,
        );
        let [usual_travel, usual_speed, usual_ramp, usual_inertia] = most.usual;
        if travel > 0.0 {
            let said = format!("a travel of {}", short(travel, unit));
            let range = [LEAST_TRAVEL, far, most.travel, usual_travel];
            show(said, travel, place, range);
            let said = format!("a speed of {}", short(speed, &format!("{unit}/s")));
            show(
                said,
                speed,
                pace,
                [0.0, most.speed, most.speed, usual_speed],
            );
        }
        if turns {
            // From rest to the top speed and back within the travel.
            let ramp = speed * speed / travel;
            let said = format!("an acceleration of {}", short(ramp, &format!("{unit}/s²")));
            let range = [0.0, most.acceleration, most.acceleration, usual_ramp];
            show(said, ramp, plus(plus(pace, pace, 1), place, -1), range);
        }
        let (low, high) = bounds(&self.effort);
        let effort = high.max(-low);
        let bare = plan.is_bare(Slot::Effort);
        let of_unit = EFFORTS.iter().find(|m| m.0 == self.effort_unit());
        if let Some(&(unit, stated, of_bare, usual)) = of_unit.filter(|_| effort > 0.0) {
            let said = format!("a {} of {}", self.role.name(), short(effort, unit));
            let most = if bare { of_bare } else { stated };
            show(said, effort, EFFORT, [0.0, most, stated, usual]);
        }
        if let Some(inertia) = self.visible_inertia() {
            let (name, unit) = match self.kind {
                MotionKind::Linear => ("a mass", "kg"),
                MotionKind::Rotary => ("an inertia", "kg·m²"),
            };
            // What turns more than robots do is slow.
            let bare_most = match self.kind {
                MotionKind::Linear => most.bare_inertia * travel,
                MotionKind::Rotary if speed * speed > travel => most.bare_inertia,
                MotionKind::Rotary => most.inertia,
            };
            let stated = most.inertia;
            let most = if bare { bare_most } else { stated };
            let range = [LEAST_INERTIA, most, stated, usual_inertia];
            let powers = plus(plus(EFFORT, STEP, 2), place, -1);
            show(
                format!("{name} of {}", short(inertia, unit)),
                inertia,
                powers,
                range,
            );
        }
        let velocity = plus(plus(place, STEP, -1), [0, 0, 1, 0], -1);
        let others = [
            (
                "recorded velocity",
                self.against_velocity(),
                velocity,
                EXPLAINS,
            ),
            ("reference", self.against_reference(), place, AGREES),
        ];
        for (other, times, powers, most) in others {
            let Some(times) = times else { continue };
            let said = format!("a position that goes {times:.4} times its {other}");
            let range = [most.recip(), most, most, 1.0];
            show(said, times, powers, range);
        }
        shown
    }

    /// Values that no machine has, with the units that would put them right: of the fewest columns, of those that no one stated first.
    pub(super) fn implausible(&self, plan: &Plan) -> Option<Warning> {
        let shown = self.shown(plan);
        let as_read = [1.0; 4];
        let found: Vec<&Shown> = shown.iter().filter(|s| !s.is_inside(&as_read)).collect();
        if found.is_empty() {
            return None;
        }
        let readings = COLUMNS.map(|slot| plan.readings(slot));
        let mut right = right(&shown, &readings);
        // Another unit of the same columns is told, too.
        let changed = |r: &Right| r.chosen.map(|reading| reading.changes);
        if let Some(best) = right.first().map(changed) {
            right.retain(|r| changed(r) == best);
        }
        let mut remedies = Vec::new();
        let mut maps = Vec::new();
        for (i, Right { chosen, .. }) in right.iter().take(2).enumerate() {
            let columns = COLUMNS.iter().zip(chosen).filter(|(_, r)| r.changes > 0);
            let columns = columns.filter_map(|(slot, reading)| {
                let (column, map) = plan.rescaled(*slot, reading.scale)?;
                let said = format!("`{column}` is in {}, give --map '{map}'", reading.unit);
                maps.extend((i == 0).then_some(map));
                Some(said)
            });
            remedies.push(format!("if {}", columns.collect::<Vec<_>>().join(" and ")));
        }
        if remedies.is_empty() {
            let other = "check the units of its columns; --map 'NAME=FACTOR*COLUMN' takes another";
            remedies.push(other.to_owned());
        }
        if found
            .iter()
            .all(|s| (s.least..=s.most_stated).contains(&s.value))
        {
            let to = |map: &str| map.split('=').next().map(str::to_owned);
            let asked = |map: &String| maps.iter().any(|m| to(m) == to(map));
            let bare = COLUMNS.iter().filter(|slot| plan.is_bare(**slot));
            let mut as_read = bare.filter_map(|slot| Some(plan.rescaled(*slot, 1.0)?.1));
            let as_it_is = as_read.find(asked);
            remedies.extend(as_it_is.map(|map| format!("if it is right, --map '{map}' says so")));
        }
        let found: Vec<&str> = found.iter().map(|s| s.said.as_str()).collect();
        let (found, remedies) = (found.join("; nor "), remedies.join("; "));
        Some(Warning {
            maps,
            ..warning!("implausible", "hardly any machine has {found}: {remedies}")
        })
    }
}

/// Columns read so that everything is inside.
struct Right<'a> {
    chosen: [&'a Reading; 4],
    /// Changes of what was stated, changes, and decades from a usual machine.
    cost: (usize, usize, f64),
}

/// Every one of them, the likeliest first.
fn right<'a>(shown: &[Shown], readings: &'a [Vec<Reading>; 4]) -> Vec<Right<'a>> {
    let counts = readings.each_ref().map(Vec::len);
    let all = (0..counts.iter().product()).map(|number: usize| {
        let mut rest = number;
        std::array::from_fn(|k| {
            let at = rest % counts[k];
            rest /= counts[k];
            &readings[k][at]
        })
    });
    let mut right: Vec<Right> = all
        .filter_map(|chosen: [&Reading; 4]| {
            let scales = chosen.map(|r| r.scale);
            let sum = |of: fn(&Reading) -> usize| chosen.iter().map(|r| of(r)).sum();
            let apart = shown
                .iter()
                .map(|s| (s.at(&scales) / s.usual).log10().abs().min(20.0));
            let apart = apart.chain(chosen.map(|r| r.rank)).sum();
            let cost = (sum(|r| r.stated), sum(|r| r.changes), apart);
            let is_right = shown.iter().all(|s| s.is_inside(&scales));
            is_right.then_some(Right { chosen, cost })
        })
        .collect();
    let order = |r: &Right| (r.cost.0, r.cost.1);
    right.sort_by(|a, b| order(a).cmp(&order(b)).then(a.cost.2.total_cmp(&b.cost.2)));
    right
}
