//! exploring (not committed)
use preslide_host::diagnose::*;
use preslide_host::progress::Progress;
use preslide_host::recording::{LoadOptions, load};
fn main() {
    for path in std::env::args().skip(1) {
        let start = std::time::Instant::now();
        let r = load(std::path::Path::new(&path), &LoadOptions::default()).unwrap();
        let label = std::fs::read_to_string(
            path.replace("rec.csv", "label.json")
                .replace("recording.csv", "label.json"),
        )
        .unwrap_or_default();
        let rows = rows::Rows::new(&r).unwrap();
        eprintln!(
            "== {path} {} rows {} blocks {} folds, rest {:.2}",
            rows.force.len(),
            rows.blocks.len(),
            rows.weak.folds.len(),
            rows.at_rest
        );
        eprintln!(
            "{}",
            label
                .split("\"params\"")
                .next()
                .unwrap_or("")
                .replace('\n', " ")
        );
        let ground = ground::Ground::new(rows, &[]).unwrap();
        eprintln!(
            "ground {:.1} s; mass {:.3} level {:.3} dist {:.4} var {:.3}",
            start.elapsed().as_secs_f64(),
            ground.baseline.mass,
            ground.baseline.level,
            ground.noise.disturbance(),
            ground.noise.variability()
        );
        let found = search::search(
            ground,
            &[],
            &[2e-3, 2.857142857e-4, 1e-5],
            &Progress::new("x", 0),
        )
        .unwrap();
        eprintln!("search {:.1} s", start.elapsed().as_secs_f64());
        for s in naming::standings(&found, 0, &[2e-3, 2.857142857e-4, 1e-5]) {
            eprintln!(
                "=> {} {:?} share {:.3} z {:.1} blocks {:.1} rival {:.2} margin {:.1} nameless {:.2} survival {:.2} amb {:?} tried {:?} conf {:.2}",
                s.term.subject.key(),
                s.term.shape,
                s.evidence.share,
                s.evidence.z,
                s.evidence.blocks,
                s.rival,
                s.margin,
                s.nameless,
                s.survival,
                s.ambiguous.iter().map(|e| e.id()).collect::<Vec<_>>(),
                s.tried,
                confidence::confidence(&s)
            );
        }
        eprintln!("all {:.1} s", start.elapsed().as_secs_f64());
    }
}
