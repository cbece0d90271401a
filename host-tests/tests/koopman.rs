//! What is promised of the outer controller: the solution of its problem, the bound on what is left of it, its limits, and its deadline.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use preslide::control::NoFriction;
use preslide::control::koopman::{
    Ahead, ErrorLift, Guided, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState,
};
use preslide::{Friction, Units};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::path::motion;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STATES: usize = 4;
const MOVES: usize = 5;
const LENGTHS: [u32; MOVES] = [1, 1, 2, 4, 8];
const SAMPLES: usize = 16;

/// A problem of one sample.
struct Problem {
    model: KoopmanModel<STATES>,
    settings: KoopmanSettings<MOVES>,
    lifted: [f32; STATES],
    ahead: Ahead<MOVES>,
}

/// Any map that a horizon does not blow up, in units in which errors and forces are about 1; half of the problems end at the travel.
fn random(rng: &mut ChaCha8Rng, iterations: u32) -> Problem {
    let mut unit = || rng.random_range(-1.0..1.0_f64);
    let mut map = [(); STATES].map(|()| [(); STATES].map(|()| 0.4 * unit()));
    (0..STATES).for_each(|i| map[i][i] += 0.4);
    let model = KoopmanModel {
        map,
        force: [(); STATES].map(|()| unit()),
        reference: [(); STATES].map(|()| unit()),
    };
    let settings = KoopmanSettings {
        lengths: LENGTHS,
        effort: 10_f64.powf(-1.5 + unit()),
        change: 10_f64.powf(-1.5 + unit()),
        force: 0.3 + 0.2 * unit(),
        slew: 0.15 + 0.1 * unit(),
        travel: 2.0 + unit(),
        iterations,
    };
    let near = unit() > 0.0;
    let mut end = || match near {
        true => (0.3 + 0.3 * unit()) as f32,
        false => f32::INFINITY,
    };
    let (below, above) = ([(); MOVES].map(|()| end()), [(); MOVES].map(|()| end()));
    Problem {
        model,
        settings,
        lifted: [(); STATES].map(|()| unit() as f32),
        ahead: Ahead {
            displacement: [(); MOVES].map(|()| 0.3 * unit() as f32),
            below,
            above,
        },
    }
}

/// To which move each sample belongs.
fn held() -> Vec<usize> {
    (0..MOVES)
        .flat_map(|j| vec![j; LENGTHS[j] as usize])
        .collect()
}

impl Problem {
    /// The cost of a plan from no force, by running the map.
    fn cost(&self, plan: &[f64; MOVES]) -> f64 {
        let (s, held) = (&self.settings, held());
        let mut state = self.lifted.map(f64::from);
        let mut cost = 0.0;
        for k in 0..SAMPLES {
            let j = held[k];
            let reference = f64::from(self.ahead.displacement[j]);
            state = std::array::from_fn(|i| {
                let drift: f64 = self.model.map[i]
                    .iter()
                    .zip(&state)
                    .map(|(a, x)| a * x)
                    .sum();
                drift + self.model.force[i] * plan[j] + self.model.reference[i] * reference
            });
            cost += state[0] * state[0] + s.effort * plan[j] * plan[j];
            if k + 1 == SAMPLES || held[k + 1] != j {
                let over = (state[0] - f64::from(self.ahead.below[j])).max(0.0);
                let under = (-state[0] - f64::from(self.ahead.above[j])).max(0.0);
                cost += s.travel * (over * over + under * under);
                let before = if j == 0 { 0.0 } else { plan[j - 1] };
                cost += s.change * (plan[j] - before).powi(2);
            }
        }
        cost
    }

    /// Clarabel's solution. Nothing is condensed: states are unknowns, the map is a constraint, an excursion is a slack.
    fn solution(&self) -> [f64; MOVES] {
        let (s, held) = (&self.settings, held());
        let state = |k: usize, i: usize| MOVES + k * STATES + i;
        let slack = |j: usize, side: usize| MOVES + SAMPLES * STATES + 2 * j + side;
        let n = MOVES + SAMPLES * STATES + 2 * MOVES;
        let mut cost = vec![vec![0.0; n]; n];
        let (mut equal, mut most) = (Vec::new(), Vec::new());
        for k in 0..SAMPLES {
            let j = held[k];
            cost[j][j] += 2.0 * s.effort;
            cost[state(k, 0)][state(k, 0)] = 2.0;
            for i in 0..STATES {
                let mut row = vec![0.0; n];
                row[state(k, i)] = 1.0;
                row[j] = -self.model.force[i];
                let mut right = self.model.reference[i] * f64::from(self.ahead.displacement[j]);
                for (m, a) in self.model.map[i].iter().enumerate() {
                    match k {
                        0 => right += a * f64::from(self.lifted[m]),
                        _ => row[state(k - 1, m)] -= a,
                    }
                }
                equal.push((row, right));
            }
        }
        let mut at_most = |entries: &[(usize, f64)], right: f64| {
            let mut row = vec![0.0; n];
            entries.iter().for_each(|(i, value)| row[*i] += value);
            most.push((row, right));
        };
        let (mut end, mut start) = (0, 0);
        for j in 0..MOVES {
            end += LENGTHS[j] as usize;
            for side in 0..2 {
                cost[slack(j, side)][slack(j, side)] = 2.0 * s.travel;
                at_most(&[(slack(j, side), -1.0)], 0.0);
            }
            let rooms = [(self.ahead.below[j], 1.0), (self.ahead.above[j], -1.0)];
            for (side, (room, sign)) in rooms.into_iter().enumerate().filter(|r| r.1.0.is_finite())
            {
                at_most(
                    &[(state(end - 1, 0), sign), (slack(j, side), -1.0)],
                    room.into(),
                );
            }
            let reach = s.force.min(s.slew * (start + 1) as f64);
            at_most(&[(j, 1.0)], reach);
            at_most(&[(j, -1.0)], reach);
            start += LENGTHS[j] as usize;
            cost[j][j] += 2.0 * s.change;
            if j > 0 {
                cost[j - 1][j - 1] += 2.0 * s.change;
                cost[j - 1][j] -= 2.0 * s.change;
            }
        }
        let cones = [ZeroConeT(equal.len()), NonnegativeConeT(most.len())];
        let rows: Vec<_> = equal.into_iter().chain(most).collect();
        let right: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let matrix: CscMatrix<f64> = sparse(rows.len(), n, |i, k| rows[i].0[k]);
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-11,
            tol_gap_rel: 1e-11,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let upper = sparse(n, n, |i, k| cost[i][k]);
        let mut solver =
            DefaultSolver::new(&upper, &vec![0.0; n], &matrix, &right, &cones, settings)
                .expect("the problem is well formed");
        solver.solve();
        let found = &solver.solution;
        let solved = [SolverStatus::Solved, SolverStatus::AlmostSolved];
        assert!(solved.contains(&found.status), "{:?}", found.status);
        std::array::from_fn(|j| found.x[j])
    }

    fn plan(&self) -> ([f64; MOVES], f64) {
        let mpc = KoopmanMpc::try_new(&self.model, &self.settings).expect("valid");
        let mut state = KoopmanState::new();
        let force = mpc.solve(&mut state, &self.lifted, &self.ahead);
        assert_eq!(force, state.plan()[0]);
        (state.plan().map(f64::from), mpc.contraction())
    }
}

fn sparse(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> CscMatrix<f64> {
    let (mut starts, mut at, mut values) = (vec![0], Vec::new(), Vec::new());
    for k in 0..columns {
        for i in 0..rows {
            if value(i, k) != 0.0 {
                at.push(i);
                values.push(value(i, k));
            }
        }
        starts.push(at.len());
    }
    CscMatrix::new(rows, columns, starts, at, values)
}

/// With so many iterations that nothing is left, the plan is the interior-point solver's, in units of the largest force that the limits
/// let through. `f32` holds 10⁻⁷; the worst conditioned of these problems makes a thousand times that of it.
#[test]
fn the_plan_is_the_solution_of_the_problem() {
    let mut rng = ChaCha8Rng::seed_from_u64(481);
    let mut apart = Deviation::default();
    let (mut at_a_limit, mut at_an_end) = (0, 0);
    for _ in 0..400 {
        let problem = random(&mut rng, 2000);
        let (plan, solution) = (problem.plan().0, problem.solution());
        for (u, kept) in plan.iter().zip(&solution) {
            apart.add(u / problem.settings.force, kept / problem.settings.force);
        }
        at_a_limit +=
            usize::from(plan[0].abs() > 0.999 * problem.settings.slew.min(problem.settings.force));
        let free = Problem {
            settings: KoopmanSettings {
                travel: 0.0,
                ..problem.settings
            },
            ..problem
        };
        let moved = free
            .plan()
            .0
            .iter()
            .zip(&plan)
            .any(|(a, b)| (a - b).abs() > 1e-3);
        at_an_end += usize::from(moved);
    }
    println!(
        "{apart:?}, rms {:e}, at a limit {at_a_limit}, at an end {at_an_end}",
        apart.rms()
    );
    // Both kinds of limits act, or this were no test of them.
    assert!((50..350).contains(&at_a_limit) && at_an_end > 50);
    apart.assert_within("the plan", 3e-5, 2e-6, 1e-6);
}

/// What a few iterations leave of the cost is less than the bound: twice the contraction, since the distance from the best plan weighs no
/// more than what the start costs more.
#[test]
fn what_is_left_is_within_the_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(482);
    let (mut closest, mut told) = (f64::INFINITY, 0);
    for case in 0..300 {
        let problem = random(&mut rng, [3, 10, 30][case % 3]);
        let (plan, contraction) = problem.plan();
        let best = problem.cost(&problem.solution());
        let start = problem.cost(&[0.0; MOVES]) - best;
        let left = problem.cost(&plan) - best;
        let bound = 2.0 * contraction * start;
        // The costs themselves are known to 10⁻⁶ of what they are, by `f32` and by the other solver.
        assert!(
            left <= bound + 1e-6 * (1.0 + best),
            "case {case}: {left:e} {bound:e}"
        );
        if start > 1e-3 && bound > 1e-4 {
            closest = closest.min(bound / left.max(1e-9));
            told += 1;
        }
    }
    println!("closest to its bound by a factor of {closest:.2}, of {told}");
    assert!(told > 50);
}

/// A lift that is NaN releases the force, sample by sample, and the next finite one finds everything in order.
#[test]
fn limits_hold_and_nan_releases_the_force() {
    let mut rng = ChaCha8Rng::seed_from_u64(483);
    let problem = random(&mut rng, 10);
    let mpc = KoopmanMpc::try_new(&problem.model, &problem.settings).expect("valid");
    let mut state = KoopmanState::new();
    let (force, slew) = (problem.settings.force as f32, problem.settings.slew as f32);
    let mut last = 0.0_f32;
    for k in 0..4000 {
        let lifted = match k % 50 {
            40.. => [f32::NAN; STATES],
            _ => [(); STATES].map(|()| 30.0 * rng.random_range(-1.0..1.0_f32)),
        };
        let u = mpc.solve(&mut state, &lifted, &problem.ahead);
        assert!(
            u.abs() <= force && (u - last).abs() <= slew * 1.000_001,
            "{k}: {u} after {last}"
        );
        if lifted[0].is_nan() {
            assert!(
                u.abs() <= (last.abs() - slew).max(0.0) * 1.000_001,
                "{k}: {u} after {last}"
            );
        }
        last = u;
    }
}

/// Errors that a map foresees leave nothing to learn; one that it does not is learnt at the gain's speed. Against the recurrence written
/// out in `f64`.
#[test]
fn the_lift_is_its_recurrence() {
    const LIFTED: usize = 2 * 3 + 2 + 1;
    let mut rng = ChaCha8Rng::seed_from_u64(484);
    let mut map = [[0.0; LIFTED]; LIFTED];
    map[0] = [0.8, 0.1, -0.2, -0.3, 0.2, 0.1, 0.5, -0.4, 1.0];
    let model = KoopmanModel {
        map,
        force: [0.0; LIFTED],
        reference: [0.7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    let (yields, gain) = ([0.5, 1.5], 0.2);
    for compensated in [false, true] {
        let lift =
            ErrorLift::<LIFTED, 2, 3>::try_new(&yields, compensated, &model, gain).expect("valid");
        let mut state = lift.at_rest();
        let (mut errors, mut forces) = (vec![0.0; 3], vec![0.0; 3]);
        let (mut measured, mut wanted, mut unforeseen) = ([0.0_f64; 2], [0.0_f64; 2], 0.0_f64);
        let mut apart = Deviation::default();
        let mut before = [0.0; LIFTED];
        for _ in 0..2000 {
            let [e, x, r, u] = [(); 4].map(|()| rng.random_range(-1.0..1.0_f64));
            let foreseen: f64 = map[0].iter().zip(&before).map(|(a, b)| a * b).sum();
            unforeseen += gain * (e - foreseen - 0.7 * r);
            errors.insert(0, e);
            forces.insert(0, u);
            for i in 0..2 {
                measured[i] = (measured[i] + x).clamp(-yields[i], yields[i]);
                wanted[i] = (wanted[i] + r).clamp(-yields[i], yields[i]);
            }
            let z = |i: usize| match compensated {
                true => wanted[i] - measured[i],
                false => measured[i],
            };
            before = [
                errors[0],
                errors[1],
                errors[2],
                forces[0],
                forces[1],
                forces[2],
                z(0),
                z(1),
                unforeseen,
            ];
            let [e, x, r, u] = [e, x, r, u].map(|value| value as f32);
            let lifted = lift.take(&mut state, e, x, r, u);
            for (found, kept) in lifted.iter().zip(&before) {
                apart.add((*found).into(), *kept);
            }
        }
        apart.assert_within("the lifted state", 1e-5, 1e-6, 1e-6);
    }
}

/// An order counts from the next sample on; without one the last fades to a third in a sample and the miss is counted.
#[test]
fn a_missed_deadline_is_counted_and_lets_the_force_go() {
    let guided = Guided::try_new(NoFriction::<f32>::new(), 20, 1.0, Units::SI).expect("valid");
    let mut state = guided.at_rest();
    let tick = |state: &mut _| {
        let motion = motion(1e-6, 20e-3);
        guided.velocity(state, 0.5e-6, || 0.0);
        guided.step(state, motion)
    };
    assert_eq!(tick(&mut state), 0.0);
    assert!(state.is_due() && state.missed() == 0);
    assert_eq!(state.travelled(), [0.5e-6, 1e-6]);
    // More than the limit; it waits for the next sample.
    state.order(5.0);
    for _ in 0..19 {
        assert_eq!(tick(&mut state), 0.0);
        assert!(!state.is_due());
    }
    assert_eq!(tick(&mut state), 1.0);
    assert!(state.is_due());
    for _ in 0..19 {
        assert_eq!(tick(&mut state), 1.0);
    }
    // Two samples without an order.
    let faded: Vec<f32> = (0..40).map(|_| tick(&mut state)).collect();
    assert_eq!(state.missed(), 2);
    assert!(
        faded
            .windows(2)
            .all(|pair| pair[1] < pair[0] && pair[1] > 0.0)
    );
    assert!((faded[19] - (-1.0_f32).exp()).abs() < 0.02, "{}", faded[19]);
    state.order(-0.25);
    tick(&mut state);
    assert_eq!((tick(&mut state), state.missed()), (-0.25, 2));
    guided.release(&mut state);
    assert_eq!((tick(&mut state), state.missed()), (0.0, 2));
}
