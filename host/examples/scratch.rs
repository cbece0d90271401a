use preslide::control::learning::*;
use preslide::control::*;
use preslide::*;
use preslide_host::stage::*;
use preslide_host::tracking::*;
type Both = Learning<QuasiStaticGms<4, f32>, (MismatchWatch<f32>, Adaptation<f32>)>;
type Plain = QuasiStaticGms<4, f32>;
fn go<F: Friction>(
    f: F,
    cfg: &StageConfig,
    step: f64,
    steps: &[Step],
    show: bool,
    lvl: fn(&Condition<F::Scalar>) -> String,
) -> f64 {
    let s = Settings::PAPER_AXIS;
    let mut axis = Axis::try_new(&s, f, Units::SI, cfg.clone()).unwrap();
    let mut t = Tracking::default();
    let moves: Vec<_> = steps
        .iter()
        .map(|x| x.plan(&s, Units::SI).unwrap())
        .collect();
    for (i, m) in moves.iter().enumerate() {
        if i == moves.len() / 2 {
            axis.stage_mut().set_friction_level(step).unwrap();
        }
        axis.follow(&[*m], |n| t.add(&n, 25e-9));
        if show {
            eprint!("{} ", lvl(&axis.condition()));
        }
    }
    if show {
        eprintln!();
    }
    t.rms_m().unwrap() * 1e9
}
fn main() {
    let s = Settings::PAPER_AXIS;
    let zero = StageConfig {
        seed: 1,
        friction: FrictionConfig {
            variability: VariabilityConfig {
                bound: 0.0,
                ..Default::default()
            },
            ..Default::default()
        },
        ..Default::default()
    };
    let st = std::time::Instant::now();
    let args: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse().unwrap())
        .collect();
    let e0 = Experiment::run(&s, zero.clone()).unwrap();
    let e1 = Experiment::run(
        &s,
        StageConfig {
            seed: 1,
            ..Default::default()
        },
    )
    .unwrap();
    let m = |e: &Experiment| {
        let (b, f) = e.blocks::<4>().unwrap();
        Plain::try_new(&b, f, Units::SI).unwrap()
    };
    eprintln!("exp {:?}", st.elapsed());
    let mut l = LearningSettings::PAPER_AXIS;
    l.block = args[0] as u32;
    l.adaptation.memory = args[1];
    l.excitation = args[2];
    let nested = motions::nested_triangles();
    let nested: Vec<_> = nested.iter().chain(&nested).copied().collect();
    let slide = motions::slide();
    let slide: Vec<_> = slide.iter().cycle().take(16).copied().collect();
    for (name, e, bound, rep, gain, corr, step) in [
        ("constant", &e0, 0.0, 0.4, 0.3, 1e-4, 1.0),
        ("step+15", &e0, 0.0, 0.4, 0.3, 1e-4, 1.15),
        ("step-15", &e0, 0.0, 0.4, 0.3, 1e-4, 0.85),
        ("default", &e1, 0.15, 0.4, 0.3, 1e-4, 1.0),
        ("gain only 100um", &e0, 0.15, 0.0, 1.0, 1e-4, 1.0),
        ("gain only 1mm", &e0, 0.15, 0.0, 1.0, 1e-3, 1.0),
    ] {
        for (mn, motion) in [("nested", &nested), ("slide", &slide)] {
            let mut out = String::new();
            for seed in 101..104u64 {
                let cfg = StageConfig {
                    seed,
                    friction: FrictionConfig {
                        variability: VariabilityConfig {
                            bound,
                            repeat_share: rep,
                            gain_share: gain,
                            correlation_m: corr,
                        },
                        ..Default::default()
                    },
                    ..Default::default()
                };
                let a = go(m(e), &cfg, step, motion, false, |_| String::new());
                let b = go(
                    Both::try_new(m(e), &l, Units::SI).unwrap(),
                    &cfg,
                    step,
                    motion,
                    seed == 101,
                    |c| format!("{:.3}", c.level.unwrap()),
                );
                out += &format!(" {a:.1}->{b:.1}");
            }
            println!("{name} {mn}: {out}");
        }
    }
    eprintln!("{:?}", st.elapsed());
}
