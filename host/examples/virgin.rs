//! scratch
use preslide_host::identify::{refine::*, regression::*, search::*};
fn main() {
    let t10: [(f64, f64); 10] = [(270313., 0.292), (57886., 0.125), (24903., 0.135), (8590., 0.093), (3517., 0.057), (1927., 0.042), (1219., 0.033), (841., 0.027), (616., 0.023), (3987., 0.173)];
    let x: Vec<f64> = (0..2001).map(|i| i as f64 * 40e-6 / 2000.0).collect();
    let f: Vec<f64> = x.iter().map(|&x| t10.iter().map(|&(k, a)| (k * x).min(a * 0.9)).sum()).collect();
    let n = x.len();
    let pieces = [0..n];
    let reg = Regression { position: &x, pieces: &pieces, force: f, columns: vec![], filter: Box::new(|v| v.to_vec()), folds: vec![(0..n).collect()] };
    let grid: Vec<f64> = (0..120).map(|j| 0.2e-6 * (200.0f64).powf(j as f64 / 119.0)).collect();
    let t = std::time::Instant::now();
    let g = reg.grams(&grid);
    let var = g[0].force_variation();
    let best = best_choices(&g[0], 0, 10);
    println!("search {:?}", t.elapsed());
    for (i, b) in best.iter().enumerate() {
        let mut fits: Vec<_> = b.iter().take(6).filter_map(|c| refine(&reg, &reg.folds[0], c.yields.iter().map(|&j| grid[j]).collect(), (1e-8, 40e-6))).collect();
        fits.sort_by(|a, b| a.squared_error.total_cmp(&b.squared_error));
        println!("N={} grid {:.5} -> {:?}", i + 1, 100.0 * b[0].squared_error / var, fits.iter().map(|f| 100.0 * f.squared_error / var).collect::<Vec<_>>());
    }
    println!("{:?}", t.elapsed());
}
