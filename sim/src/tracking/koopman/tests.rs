use super::firmware::{WEIGHTS, firmware, guided, source, yields};
use super::learnt::learn;
use super::outer::{Outer, Sample, Task};
use super::predictive::Predictive;
use super::{FORCE_N, TICKS};
use crate::stage::StageConfig;
use crate::tracking::{Axis, Step, Tracking, motions};
use preslide::control::{Axis as Settings, NoFriction};
use preslide::{Friction, Units};

/// An outer task whose order comes too late in all but one of so many samples.
#[derive(Clone, PartialEq)]
struct Late {
    task: Predictive,
    every: usize,
}

impl Task for Late {
    type State = (<Predictive as Task>::State, usize);

    fn start(&self) -> Self::State {
        (self.task.start(), 0)
    }

    fn run(&self, state: &mut Self::State, sample: &Sample) -> Option<f64> {
        state.1 += 1;
        let order = self.task.run(&mut state.0, sample);
        order.filter(|_| (state.1 - 1).is_multiple_of(self.every))
    }
}

/// The paper's axis with the integral's place free, on a stage of a quarter of the usual steps.
fn axis() -> (Settings, StageConfig) {
    let settings = guided(&Settings::PAPER_AXIS);
    let stage = StageConfig {
        substeps: 2,
        ..StageConfig::default().on(&settings)
    };
    (settings, stage)
}

/// RMS error (m) over the nested triangles on a stage that was not identified, the missed samples, and the ticks.
fn follow<F: Friction>(
    settings: &Settings,
    friction: F,
    missed: fn(&F::State) -> u32,
) -> (f64, u32, u32) {
    let stage = StageConfig {
        seed: 101,
        ..axis().1
    };
    let moves = Step::plan_all(&motions::nested_triangles(), settings).expect("planned");
    let mut axis = Axis::try_new(settings, friction, Units::SI, stage).expect("built");
    let mut tracking = Tracking::default();
    let mut ticks = 0;
    axis.follow(&moves, |now| {
        tracking.add(&now, settings.encoder.count);
        ticks += 1;
    });
    let missed = missed(axis.friction_state());
    (tracking.rms_m().expect("no fault"), missed, ticks)
}

/// What the outer task is for, and what is left of it where its orders come late: the loop below goes on, and every miss is counted.
#[test]
fn an_outer_task_removes_most_of_the_error_and_its_absence_harms_nothing() {
    let (settings, stage) = axis();
    let yields = yields();
    let none = NoFriction::<f32>::new;
    let learnt = learn(&settings, none(), stage, &yields, false).expect("learnt");
    println!("{:?} of {} m", learnt.errors_m, learnt.size_m);
    assert!(learnt.errors_m[1] < 0.1 * learnt.size_m);
    let moves = Step::plan_all(&motions::nested_triangles(), &settings).expect("planned");
    let task = Predictive::try_new(&learnt, &yields, false, WEIGHTS, &settings, &moves);
    let task = task.expect("built");
    let late = |every| {
        let task = Late {
            task: task.clone(),
            every,
        };
        let outer = Outer::try_new(none(), FORCE_N, task).expect("built");
        follow(&settings, outer, |state| state.guided.missed())
    };
    let integral = Settings::PAPER_AXIS;
    let [feedback, pid] = [&settings, &integral].map(|s| follow(s, none(), |()| 0).0);
    let [
        (in_time, none_missed, ticks),
        (half, half_missed, _),
        (never, all_missed, _),
    ] = [1, 2, usize::MAX].map(late);
    let nm = [pid, feedback, in_time, half, never].map(|rms| rms * 1e9);
    println!("PID, PD, in time, every second order, the first only: {nm:.0?} nm");
    assert!(in_time < 0.15 * pid && none_missed == 0);
    assert!(half < feedback && half > in_time);
    // Nobody waits for an order in the first sample, and the second has one.
    let samples = ticks.div_ceil(TICKS);
    assert_eq!((all_missed, half_missed), (samples - 2, (samples - 1) / 2));
    assert!((never / feedback - 1.0).abs() < 0.01);
}

/// What the firmware is built with is what is learnt. `cargo run --release -p preslide-cli --example track -- koopman-firmware` writes it.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn the_firmware_is_told_what_is_learnt() {
    let kept = include_str!("../../../../cli/tests/exported/koopman.rs");
    let settings = Settings::PAPER_AXIS;
    let learnt = firmware(&settings, StageConfig::default().on(&settings)).expect("learnt");
    let learnt = source(&learnt);
    let words = |text: &str| -> Vec<String> {
        let split = text.split(|c: char| c.is_whitespace() || "[]{},;".contains(c));
        split.map(str::to_owned).collect()
    };
    let (kept, learnt) = (words(kept), words(&learnt));
    assert_eq!(kept.len(), learnt.len());
    let mut numbers = 0;
    for (kept, learnt) in kept.iter().zip(&learnt) {
        let (Ok(a), Ok(b)) = (kept.parse::<f64>(), learnt.parse::<f64>()) else {
            assert_eq!(kept, learnt);
            continue;
        };
        // Another machine's sine may round otherwise, and a regression makes more of it.
        assert!((a - b).abs() <= 1e-6 * b.abs(), "{a}, and now {b}");
        numbers += 1;
    }
    assert!(numbers > 200);
}
