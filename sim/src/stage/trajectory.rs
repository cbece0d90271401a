//! Reference trajectories: position, velocity and acceleration as functions of time.
//!
//! All are polylines in time, with corners optionally rounded by a constant acceleration over a window `w`. A rounded corner
//! stays short of its vertex by `|Δv|·w/8`.

/// Strokes of the nested reversals of figure 1 \[m\]: 50, 20, 5 and 1 µm.
pub const NESTED_STROKES_M: [f64; 4] = [50e-6, 20e-6, 5e-6, 1e-6];
/// The small step of figure 1 \[m\]: 100 nm.
pub const SMALL_STEP_M: f64 = 100e-9;
/// The slide of figure 1 [m/s]: 1 mm/s.
pub const SLIDE_SPEED_M_S: f64 = 1e-3;

/// Why a trajectory could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// A parameter is out of range.
    #[error("trajectory: {key} = {value} is out of range; it must be {bound}")]
    OutOfRange {
        /// The parameter.
        key: &'static str,
        /// The value given.
        value: f64,
        /// What it must be.
        bound: &'static str,
    },
    /// Fewer than two vertices.
    #[error("trajectory: {0} vertices make no line; give at least 2")]
    TooShort(usize),
    /// Time runs backwards.
    #[error("trajectory: time runs backwards at vertex {vertex}; sort the vertices by time")]
    Backwards {
        /// The vertex, from zero.
        vertex: usize,
    },
    /// Two corners overlap.
    #[error(
        "trajectory: vertices {vertex} and {} are {gap_s} s apart, too near for corners of {corner_s} s; shorten the \
         corners or slow down", vertex + 1
    )]
    CornersOverlap {
        /// The first of the two vertices, from zero.
        vertex: usize,
        /// Time between them \[s\].
        gap_s: f64,
        /// Time of a corner \[s\].
        corner_s: f64,
    },
}

/// The reference at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reference {
    /// Position \[m\].
    pub position_m: f64,
    /// Velocity [m/s].
    pub velocity_m_s: f64,
    /// Acceleration [m/s²]; the impulse of a sharp corner or a jump is not in it.
    pub acceleration_m_s2: f64,
}

/// From `start_s` on: `x + v·t + a·t²/2`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start_s: f64,
    x: f64,
    v: f64,
    a: f64,
}

/// A polyline in time with rounded corners; at rest before its first and after its last vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    origin: f64,
    pieces: Vec<Piece>,
    duration_s: f64,
}

/// The first thing that makes vertices no trajectory.
fn refuse(vertices: &[(f64, f64)], corner_s: f64) -> Result<(), TrajectoryError> {
    if vertices.len() < 2 {
        return Err(TrajectoryError::TooShort(vertices.len()));
    }
    in_range(
        "corner_s",
        corner_s,
        corner_s >= 0.0,
        "zero or more, and finite",
    )?;
    for &(t, x) in vertices {
        in_range("time of a vertex", t, true, "finite")?;
        in_range("position of a vertex", x, true, "finite")?;
    }
    for (vertex, gap_s) in gaps(vertices).enumerate() {
        if gap_s < 0.0 {
            return Err(TrajectoryError::Backwards { vertex: vertex + 1 });
        }
        // Half a corner at either end; a hair for rounding.
        if gap_s > 0.0 && gap_s < corner_s * (1.0 - 1e-9) {
            return Err(TrajectoryError::CornersOverlap {
                vertex,
                gap_s,
                corner_s,
            });
        }
    }
    Ok(())
}

/// Slope into each vertex and out of the last, at rest before and after; `None` is a jump.
fn slopes(vertices: &[(f64, f64)]) -> Vec<Option<f64>> {
    let rest = std::iter::once(Some(0.0));
    let between = vertices
        .iter()
        .zip(vertices.iter().skip(1))
        .map(|(&(t0, x0), &(t1, x1))| (t1 > t0).then(|| (x1 - x0) / (t1 - t0)));
    rest.clone().chain(between).chain(rest).collect()
}

/// The lines between the vertices, with a parabola over `corner_s` in place of each corner.
fn rounded(vertices: &[(f64, f64)], corner_s: f64) -> Vec<Piece> {
    let mut pieces = Vec::with_capacity(2 * vertices.len());
    for (&(t, x), slopes) in vertices.iter().zip(slopes(vertices).windows(2)) {
        match *slopes {
            [Some(before), Some(after)] if before != after && corner_s > 0.0 => {
                let half = 0.5 * corner_s;
                pieces.push(Piece {
                    start_s: t - half,
                    x: x - before * half,
                    v: before,
                    a: (after - before) / corner_s,
                });
                pieces.push(Piece {
                    start_s: t + half,
                    x: x + after * half,
                    v: after,
                    a: 0.0,
                });
            }
            [_, Some(after)] => pieces.push(Piece {
                start_s: t,
                x,
                v: after,
                a: 0.0,
            }),
            // The vertex after the jump starts the next piece.
            _ => {}
        }
    }
    pieces
}

impl Trajectory {
    /// Straight lines between `(time \[s\], position \[m\])`, corners rounded over `corner_s` (0: sharp). Two vertices at the
    /// same time are a jump, which is not rounded.
    ///
    /// # Errors
    /// [`TrajectoryError`]: too few vertices, a number that is not finite, time running backwards, overlapping corners.
    pub fn try_polyline(vertices: &[(f64, f64)], corner_s: f64) -> Result<Self, TrajectoryError> {
        let (Some(&(first_s, origin)), Some(&(last_s, _))) = (vertices.first(), vertices.last())
        else {
            return Err(TrajectoryError::TooShort(0));
        };
        refuse(vertices, corner_s)?;
        let duration_s = if last_s > first_s {
            last_s + 0.5 * corner_s
        } else {
            last_s
        };
        Ok(Self {
            origin,
            pieces: rounded(vertices, corner_s),
            duration_s,
        })
    }

    /// Nested triangles about the far end of each other: out by the first stroke, back by the second, out by the third …, and
    /// the same way home, so that every inner loop closes inside the next. `corner_s` rounds, `hold_s` rests at both ends.
    ///
    /// # Errors
    /// [`TrajectoryError`]: a stroke, speed or time out of range, or corners longer than the shortest stroke takes.
    pub fn nested_triangles(
        strokes_m: &[f64],
        speed_m_s: f64,
        hold_s: f64,
        corner_s: f64,
    ) -> Result<Self, TrajectoryError> {
        let mut moves = Vec::with_capacity(2 * strokes_m.len());
        for (depth, &stroke) in strokes_m.iter().enumerate() {
            in_range("stroke", stroke, stroke > 0.0, "positive and finite")?;
            moves.push(if depth % 2 == 0 { stroke } else { -stroke });
        }
        let home: Vec<f64> = moves.iter().rev().map(|m| -m).collect();
        moves.extend(home);
        Self::moves(&moves, speed_m_s, hold_s, corner_s)
    }

    /// `count` steps of `step_m` up and as many down, each taking `rise_s` (0: a jump) and followed by `dwell_s` of rest.
    ///
    /// # Errors
    /// [`TrajectoryError`]: a value out of range.
    pub fn steps(
        step_m: f64,
        count: usize,
        dwell_s: f64,
        rise_s: f64,
    ) -> Result<Self, TrajectoryError> {
        in_range("step", step_m, true, "finite")?;
        in_range("dwell_s", dwell_s, dwell_s > 0.0, "positive and finite")?;
        in_range("rise_s", rise_s, rise_s >= 0.0, "zero or more, and finite")?;
        in_range("count", count as f64, count > 0, "at least 1")?;
        let mut vertices = vec![(0.0, 0.0)];
        let mut t = 0.0;
        for index in 0..2 * count {
            let level = |i: usize| step_m * (if i <= count { i } else { 2 * count - i }) as f64;
            t += dwell_s;
            vertices.push((t, level(index)));
            t += rise_s;
            vertices.push((t, level(index + 1)));
        }
        vertices.push((t + dwell_s, 0.0));
        Self::try_polyline(&vertices, 0.0)
    }

    /// `cycles` slides of `stroke_m` there and back at `speed_m_s`.
    ///
    /// # Errors
    /// [`TrajectoryError`]: a value out of range, or corners longer than a stroke takes.
    pub fn slide(
        stroke_m: f64,
        speed_m_s: f64,
        cycles: usize,
        hold_s: f64,
        corner_s: f64,
    ) -> Result<Self, TrajectoryError> {
        in_range("stroke", stroke_m, stroke_m > 0.0, "positive and finite")?;
        in_range("cycles", cycles as f64, cycles > 0, "at least 1")?;
        Self::moves(
            &[stroke_m, -stroke_m].repeat(cycles),
            speed_m_s,
            hold_s,
            corner_s,
        )
    }

    /// Moves one after the other at constant speed, with a rest before and after.
    fn moves(
        moves: &[f64],
        speed_m_s: f64,
        hold_s: f64,
        corner_s: f64,
    ) -> Result<Self, TrajectoryError> {
        in_range(
            "speed_m_s",
            speed_m_s,
            speed_m_s > 0.0,
            "positive and finite",
        )?;
        in_range("hold_s", hold_s, hold_s > 0.0, "positive and finite")?;
        let (mut t, mut x) = (hold_s, 0.0);
        let mut vertices = vec![(0.0, x), (t, x)];
        for step in moves {
            t += step.abs() / speed_m_s;
            x += step;
            vertices.push((t, x));
        }
        vertices.push((t + hold_s, x));
        Self::try_polyline(&vertices, corner_s)
    }

    /// The reference at `t_s`.
    pub fn at(&self, t_s: f64) -> Reference {
        let next = self.pieces.partition_point(|piece| piece.start_s <= t_s);
        let Some(piece) = next.checked_sub(1).and_then(|index| self.pieces.get(index)) else {
            return Reference {
                position_m: self.origin,
                ..Reference::default()
            };
        };
        let t = t_s - piece.start_s;
        Reference {
            position_m: piece.x + t * (piece.v + 0.5 * t * piece.a),
            velocity_m_s: piece.v + t * piece.a,
            acceleration_m_s2: piece.a,
        }
    }

    /// Time at which it has come to rest \[s\].
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }
}

/// A force that climbs and falls slowly: the paper's quasi-static loading with reversals.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceRamp(Trajectory);

impl ForceRamp {
    /// From zero to each of `turns_n` in order, at `rate_n_per_s`.
    ///
    /// # Errors
    /// [`TrajectoryError`]: no turning point, a value out of range.
    pub fn try_new(turns_n: &[f64], rate_n_per_s: f64) -> Result<Self, TrajectoryError> {
        in_range(
            "rate",
            rate_n_per_s,
            rate_n_per_s > 0.0,
            "positive and finite",
        )?;
        let mut vertices = vec![(0.0, 0.0)];
        let (mut t, mut force) = (0.0, 0.0);
        for &turn in turns_n {
            t += f64::abs(turn - force) / rate_n_per_s;
            force = turn;
            vertices.push((t, force));
        }
        Trajectory::try_polyline(&vertices, 0.0).map(Self)
    }

    /// The force at `t_s` \[N\].
    pub fn force_n(&self, t_s: f64) -> f64 {
        self.0.at(t_s).position_m
    }

    /// Time at which the last turning point is reached \[s\].
    pub fn duration_s(&self) -> f64 {
        self.0.duration_s
    }
}

fn gaps(vertices: &[(f64, f64)]) -> impl Iterator<Item = f64> {
    vertices
        .iter()
        .zip(vertices.iter().skip(1))
        .map(|(a, b)| b.0 - a.0)
}

fn in_range(
    key: &'static str,
    value: f64,
    valid: bool,
    bound: &'static str,
) -> Result<(), TrajectoryError> {
    if valid && value.is_finite() {
        return Ok(());
    }
    Err(TrajectoryError::OutOfRange { key, value, bound })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position, velocity and acceleration belong together.
    fn consistent(trajectory: &Trajectory) {
        let h = 1e-6;
        let mut t = 0.0;
        while t < trajectory.duration_s() + 0.01 {
            let (a, b) = (trajectory.at(t), trajectory.at(t + h));
            let x = a.position_m + h * a.velocity_m_s;
            assert!((b.position_m - x).abs() < 1e-12, "position jumps at {t}");
            assert!(
                (b.velocity_m_s - a.velocity_m_s - h * a.acceleration_m_s2).abs() < 1e-6,
                "velocity at {t}"
            );
            t += 3.7e-5;
        }
    }

    #[test]
    fn nested_triangles_reach_their_vertices_and_come_home() {
        let trajectory =
            Trajectory::nested_triangles(&NESTED_STROKES_M, 100e-6, 0.1, 0.0).expect("valid");
        // Vertices 0, 50, 30, 35, 34, 35, 30, 50, 0 µm at 100 µm/s after 0.1 s.
        for (t, um) in [
            (0.05, 0.0),
            (0.6, 50.0),
            (0.8, 30.0),
            (0.85, 35.0),
            (0.86, 34.0),
            (0.87, 35.0),
            (0.92, 30.0),
            (1.12, 50.0),
            (1.62, 0.0),
            (5.0, 0.0),
        ] {
            let x = trajectory.at(t).position_m;
            assert!((x - um * 1e-6).abs() < 1e-12, "{x} at {t}");
        }
        assert!((trajectory.duration_s() - 1.72).abs() < 1e-9);
    }

    #[test]
    fn rounded_corners_are_smooth() {
        consistent(
            &Trajectory::nested_triangles(&NESTED_STROKES_M, 100e-6, 0.1, 4e-3).expect("valid"),
        );
        consistent(&Trajectory::slide(0.5e-3, SLIDE_SPEED_M_S, 2, 0.1, 20e-3).expect("valid"));
    }

    #[test]
    fn steps_jump_and_rest() {
        let trajectory = Trajectory::steps(SMALL_STEP_M, 3, 0.1, 0.0).expect("valid");
        let levels: Vec<i32> = (0..7)
            .map(|i| {
                (trajectory.at(0.05 + 0.1 * f64::from(i)).position_m / SMALL_STEP_M).round() as i32
            })
            .collect();
        assert_eq!(levels, [0, 1, 2, 3, 2, 1, 0]);
        assert_eq!(trajectory.at(0.15).velocity_m_s, 0.0);
        let ramped = Trajectory::steps(SMALL_STEP_M, 1, 0.1, 0.01).expect("valid");
        assert!((ramped.at(0.105).position_m - 0.5 * SMALL_STEP_M).abs() < 1e-15);
    }

    #[test]
    fn force_ramp_turns_where_it_is_told() {
        let ramp = ForceRamp::try_new(&[0.8, 0.2, 0.8], 0.1).expect("valid");
        for (t, force) in [
            (0.0, 0.0),
            (4.0, 0.4),
            (8.0, 0.8),
            (14.0, 0.2),
            (20.0, 0.8),
            (30.0, 0.8),
        ] {
            assert!((ramp.force_n(t) - force).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn bad_input_is_refused_with_a_reason() {
        let overlap = Trajectory::nested_triangles(&NESTED_STROKES_M, 1e-3, 0.1, 0.01)
            .expect_err("corners overlap");
        assert!(overlap.to_string().contains("slow down"), "{overlap}");
        assert!(Trajectory::try_polyline(&[(0.0, 0.0)], 0.0).is_err());
        assert!(Trajectory::try_polyline(&[(0.0, 0.0), (f64::NAN, 0.0)], 0.0).is_err());
        assert!(Trajectory::try_polyline(&[(1.0, 0.0), (0.0, 0.0)], 0.0).is_err());
        assert!(Trajectory::slide(-1.0, 1.0, 1, 0.1, 0.0).is_err());
        assert!(Trajectory::slide(1.0, f64::NAN, 1, 0.1, 0.0).is_err());
        assert!(ForceRamp::try_new(&[], 1.0).is_err());
        assert!(ForceRamp::try_new(&[f64::INFINITY], 1.0).is_err());
    }
}
