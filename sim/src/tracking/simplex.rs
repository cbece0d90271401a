//! Nelder and Mead's simplex search, argmin's, for costs whose derivative is not worth having.

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;
use nalgebra::SVector;

struct Cost<C, const P: usize>(C);

impl<C: Fn(&[f64; P]) -> f64, const P: usize> CostFunction for Cost<C, P> {
    type Param = SVector<f64, P>;
    type Output = f64;

    fn cost(&self, p: &SVector<f64, P>) -> Result<f64, Error> {
        Ok((self.0)(&(*p).into()))
    }
}

/// The smallest cost found from `start` in so many steps of one or two evaluations each, the simplex reaching 0.5 along every axis,
/// and where it is. `None` where no finite cost was met.
pub fn minimise<const P: usize>(
    cost: impl Fn(&[f64; P]) -> f64,
    start: [f64; P],
    steps: u64,
) -> Option<([f64; P], f64)> {
    let corner = |axis| SVector::from_fn(|i, _| start[i] + if Some(i) == axis { 0.5 } else { 0.0 });
    let simplex = std::iter::once(None).chain((0..P).map(Some));
    let simplex = simplex.map(corner).collect();
    let search = Executor::new(Cost(cost), NelderMead::new(simplex))
        .configure(|state| state.max_iters(steps))
        .timer(false);
    let found = search.run().ok()?.state;
    let best = found.best_param.filter(|_| found.best_cost.is_finite())?;
    Some((best.into(), found.best_cost))
}

#[cfg(test)]
mod tests {
    use super::minimise;

    #[test]
    fn finds_the_bottom_of_a_curved_valley() {
        let rosenbrock =
            |p: &[f64; 2]| (1.0 - p[0]).powi(2) + 100.0 * (p[1] - p[0].powi(2)).powi(2);
        let (p, cost) = minimise(rosenbrock, [-1.2, 1.0], 250).unwrap();
        assert!(cost < 1e-10, "{p:?} {cost}");
    }

    #[test]
    fn a_start_without_any_finite_cost_leads_nowhere() {
        assert_eq!(minimise(|_| f64::INFINITY, [0.0; 3], 250), None);
        assert_eq!(minimise(|_| f64::NAN, [0.0; 3], 250), None);
    }
}
