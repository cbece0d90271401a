//! scratch
use preslide_host::{identify::*, progress::Progress, recording::*};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let r = load(std::path::Path::new(&a[1]), &LoadOptions::default()).unwrap();
    for w in &r.warnings {
        println!("{w}");
    }
    let w = |i: usize| a.get(i).map(|s| split::parse_window(s).unwrap());
    let t = std::time::Instant::now();
    let id = identify(
        &r,
        &Options {
            train: w(2),
            test: w(3),
        },
        &Progress::new("identify", 20),
    )
    .unwrap();
    println!("band {} {:?}", id.band_hz, t.elapsed());
    for (n, e) in &id.rigid_body {
        println!("{n} {} {:?}", e.value, e.ci95);
    }
    for c in &id.candidates {
        println!(
            "{} {} {} train {:.4} test {:.4} m {:.3} b {:.3} off {:.4} {:?}",
            c.method.name(),
            c.model.friction.kind(),
            c.size(),
            c.nmse_train,
            c.nmse_test,
            c.model.inertia,
            c.model.viscous,
            c.model.constant_force,
            c.blocks
                .iter()
                .map(|(k, d)| (k.value, d.value))
                .collect::<Vec<_>>()
        );
    }
    println!("{}", id.recommendation);
}
