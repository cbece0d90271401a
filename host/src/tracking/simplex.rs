//! Nelder and Mead's simplex search, for costs whose derivative is not worth having.

/// Evaluations per start; five parameters need about half of them.
const EVALUATIONS: usize = 400;

/// The smallest cost found from `start`, the simplex reaching 0.5 along every axis, and where it is.
pub fn minimise<const P: usize>(
    cost: impl Fn(&[f64; P]) -> f64,
    start: [f64; P],
) -> ([f64; P], f64) {
    let rate = |p: [f64; P]| (p, cost(&p));
    let mut simplex = vec![rate(start)];
    for axis in 0..P {
        let mut corner = start;
        corner[axis] += 0.5;
        simplex.push(rate(corner));
    }
    let mut spent = simplex.len();
    while spent < EVALUATIONS {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let worst = simplex[P];
        let mut centre = [0.0; P];
        for (corner, _) in &simplex[..P] {
            for (c, value) in centre.iter_mut().zip(corner) {
                *c += value / P as f64;
            }
        }
        let along = |t: f64| {
            let mut p = centre;
            for (p, w) in p.iter_mut().zip(&worst.0) {
                *p += t * (*w - *p);
            }
            rate(p)
        };
        let reflected = along(-1.0);
        spent += 1;
        let better = if reflected.1 < simplex[0].1 {
            spent += 1;
            let expanded = along(-2.0);
            if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            }
        } else if reflected.1 < simplex[P - 1].1 {
            reflected
        } else {
            spent += 1;
            along(if reflected.1 < worst.1 { -0.5 } else { 0.5 })
        };
        if better.1 < worst.1 {
            simplex[P] = better;
        } else {
            let best = simplex[0].0;
            for corner in &mut simplex[1..] {
                let mut p = best;
                for (p, c) in p.iter_mut().zip(&corner.0) {
                    *p += 0.5 * (c - *p);
                }
                *corner = rate(p);
            }
            spent += P;
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

#[cfg(test)]
mod tests {
    use super::minimise;

    #[test]
    fn finds_the_bottom_of_a_curved_valley() {
        let rosenbrock =
            |p: &[f64; 2]| (1.0 - p[0]).powi(2) + 100.0 * (p[1] - p[0].powi(2)).powi(2);
        let (p, cost) = minimise(rosenbrock, [-1.2, 1.0]);
        assert!(cost < 1e-10, "{p:?} {cost}");
    }
}
