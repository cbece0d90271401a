//! A simulation of the user's own, in further columns of the recording.

use super::Recording;
use super::units::Dimension;
use super::words::{quantity, split};

/// What a simulation did, at the samples.
#[derive(Clone, Debug, PartialEq)]
pub enum Simulated {
    /// The effort that it needs for the recorded motion, in the recording's unit.
    Effort(Vec<f64>),
    /// It moved by itself.
    Motion {
        /// Its position (m or rad).
        position: Vec<f64>,
        /// Its effort, in the recording's unit; `None` where it was driven by the recorded one.
        effort: Option<Vec<f64>>,
    },
}

/// A column of a simulation.
enum Taken {
    Effort(Vec<f64>),
    Position(Vec<f64>),
}

/// Correlation beyond which a column of the other sign is the same quantity.
pub(super) const OPPOSED: f64 = -0.5;

impl Recording {
    /// Takes a simulation out of the further columns, in the unit and with the sign of what was measured: an effort for the recorded
    /// motion, or a position, alone where the recorded effort drives the simulation and with its own effort where a controller does.
    ///
    /// # Errors
    /// Where there is no such column, or it is no such quantity: a message for the user.
    pub fn take_simulated(&mut self, names: &[String]) -> Result<Simulated, String> {
        let taken: Vec<Taken> = names
            .iter()
            .map(|name| self.take(name))
            .collect::<Result<_, _>>()?;
        let mut taken = taken.into_iter();
        match (taken.next(), taken.next(), taken.next()) {
            (Some(Taken::Effort(effort)), None, _) => Ok(Simulated::Effort(effort)),
            (Some(Taken::Position(position)), None, _) => Ok(Simulated::Motion {
                position,
                effort: None,
            }),
            (Some(Taken::Position(position)), Some(Taken::Effort(effort)), None)
            | (Some(Taken::Effort(effort)), Some(Taken::Position(position)), None) => {
                Ok(Simulated::Motion {
                    position,
                    effort: Some(effort),
                })
            }
            _ => Err(format!(
                "--simulated {}: give one column of an effort, one of a position, or one of each",
                names.join(",")
            )),
        }
    }

    fn take(&mut self, name: &str) -> Result<Taken, String> {
        // `force_sim` says `force_sim_N` as well, where it says no other column.
        let found = self.extra.iter().position(|e| e.name == name).or_else(|| {
            let mut alike = (0..self.extra.len()).filter(|i| split(&self.extra[*i].name).0 == name);
            alike.next().filter(|_| alike.next().is_none())
        });
        let Some(place) = found else {
            return Err(no_column(self, name));
        };
        let unit = quantity(&self.extra[place].name).unit;
        let factor = unit.map_or(1.0, |u| u.factor);
        let dimension = unit.map_or(Dimension::of_effort(self.role), |u| u.dimension);
        let is_effort = dimension == Dimension::of_effort(self.role);
        if !is_effort && dimension != Dimension::of_position(self.kind) {
            return Err(other_quantity(self, name));
        }
        let mut values = self.extra.remove(place).values;
        values.iter_mut().for_each(|v| *v *= factor);
        if is_effort {
            return Ok(Taken::Effort(self.checked(name, values)?));
        }
        if correlation(&values, &self.position) < OPPOSED {
            values.iter_mut().for_each(|v| *v = -*v);
            self.warnings.push(warning!(
                "simulated-sign",
                "{name} has the sign opposite to the measured position: taken times -1"
            ));
        }
        Ok(Taken::Position(values))
    }

    /// The same recording of another motion, under another effort where one is given: what a simulation did meanwhile.
    pub fn of_simulation(&self, position: &[f64], effort: Option<&[f64]>) -> Self {
        Self {
            name: format!("the simulation beside {}", self.name),
            position: position.to_vec(),
            effort: effort.unwrap_or(&self.effort).to_vec(),
            reference: None,
            velocity: None,
            extra: Vec::new(),
            warnings: Vec::new(),
            ..self.clone()
        }
    }
}

fn no_column(recording: &Recording, name: &str) -> String {
    let names: Vec<&str> = recording.extra.iter().map(|e| e.name.as_str()).collect();
    let there = if names.is_empty() {
        "has no further column that varies".to_owned()
    } else {
        format!("has {}", names.join(", "))
    };
    format!(
        "--simulated {name}: there is no file of that name, and no such column of numbers that vary in {}, which {there}; log the force or torque that the simulation needs for the recorded motion as one more column, or the position that it reaches under the recorded effort",
        recording.name
    )
}

fn other_quantity(recording: &Recording, name: &str) -> String {
    let (effort, unit) = (recording.role.name(), recording.effort_unit());
    let position = recording.position_unit();
    format!(
        "--simulated {name}: its unit is neither that of a {effort}, which the recording is in ({unit}), nor that of its position ({position}); log the simulation in these, or convert the recording with --map"
    )
}

/// Correlation about the means.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let (of_a, of_b) = (mean(a), mean(b));
    let (mut product, mut square, mut other) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        product += (x - of_a) * (y - of_b);
        square += (x - of_a).powi(2);
        other += (y - of_b).powi(2);
    }
    product / (square * other).sqrt().max(1e-300)
}

#[cfg(test)]
mod tests {
    use super::super::Recording;
    use super::super::tests::read;
    use super::Simulated;

    const FILE: &str = "t_s,x_m,force_N,sim_mN,x_sim_mm,sim_Nm,plain\n\
        0,0,1,-1000,0,1,1\n1,1,2,-2000,-1000,2,2\n2,0,4,-4100,0,3,4\n";

    fn load() -> Recording {
        read(FILE)
    }

    fn taken(recording: &mut Recording, names: &[&str]) -> Result<Simulated, String> {
        let names: Vec<String> = names.iter().map(|&n| n.to_owned()).collect();
        recording.take_simulated(&names)
    }

    #[test]
    fn an_effort_or_a_position_comes_in_the_unit_and_sign_of_the_measured_one() {
        let mut recording = load();
        let effort = vec![1.0, 2.0, 4.1];
        let motion = |effort| {
            let position = vec![0.0, 1.0, 0.0];
            Simulated::Motion { position, effort }
        };
        for (names, right) in [
            (&["sim_mN"][..], Simulated::Effort(effort.clone())),
            (&["plain"], Simulated::Effort(vec![1.0, 2.0, 4.0])),
            (&["x_sim_mm"], motion(None)),
            (&["x_sim_mm", "sim_mN"], motion(Some(effort))),
        ] {
            assert_eq!(taken(&mut load(), names), Ok(right));
        }
        taken(&mut recording, &["sim_mN"]).expect("taken");
        let last = recording.warnings.last().map(|w| w.code);
        assert_eq!(last, Some("simulated-sign"));
    }

    #[test]
    fn what_is_no_simulation_is_refused_with_what_would_be() {
        for (names, part) in [
            (&["sim_Nm"][..], "(N)"),
            (&["sim"], "has sim_mN, x_sim_mm"),
            (&["sim_mN", "plain"], "one column of an effort"),
        ] {
            let error = taken(&mut load(), names).expect_err(part);
            assert!(error.contains(part), "{names:?}: {error}");
        }
    }
}
