//! scratch
use preslide_host::{identify::*, progress::Progress, recording::*};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let r = load(std::path::Path::new(&a[1]), &LoadOptions::default()).unwrap();
    let w = |i: usize| a.get(i).map(|s| split::parse_window(s).unwrap());
    let id = identify(
        &r,
        &Options {
            train: w(2),
            test: w(3),
        },
        &Progress::new("identify", 20),
    )
    .unwrap();
    let c = id
        .candidates
        .iter()
        .find(|c| c.method == Method::Optimal)
        .unwrap();
    let mut m = std::collections::BTreeMap::<u32, (f64, f64, f64, f64, f64, f64)>::new();
    for i in 0..r.len() {
        let e = m
            .entry(r.repeat[i])
            .or_insert((r.t_s[i], 0., 0., 0., 0., 0.));
        e.1 += (r.effort[i] - c.fitted[i]).powi(2);
        e.2 += r.effort[i].powi(2);
        if id.velocity[i].abs() > 1.5e-4 && (c.fitted[i].abs() > 2.2) {
            e.3 += r.effort[i].abs();
            e.4 += 1.0;
        }
        if id.velocity[i].abs() < 1e-5 {
            e.5 += (r.effort[i] - c.fitted[i]).powi(2);
        }
    }
    for (k, v) in m {
        println!(
            "{k} t {:.1} err share {:.3}% of its power; rest part {:.2}; level {:.4} n {}",
            v.0,
            100. * v.1 / v.2,
            v.5 / v.1,
            v.3 / v.4,
            v.4
        );
    }
}
