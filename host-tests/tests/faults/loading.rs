//! A model with its effects over the link: as if it had been compiled in, without a bump, kept over a reset.

use super::drive::{Drive, Flash};
use preslide_app::{Exported, Model as _, Starting};
use preslide_fit::model::Model;
use preslide_host::drive::{loadable, starting};
use preslide_link::{GainSettings, Mode, ModelPart, PART, Refusal, Reply, Request};

#[rustfmt::skip]
#[allow(dead_code)]
#[path = "../../../cli/tests/exported/full.rs"]
mod full;

/// Breakaway, Coulomb and viscous friction, and the periodic force, as another recording may have them.
fn other() -> [f64; full::PARAMETERS.len()] {
    let mut values = full::PARAMETERS;
    for (at, factor) in [(0, 0.9), (1, 0.9), (11, 1.5), (12, 2.0)] {
        values[at] = f64::from((values[at] * factor) as f32);
    }
    values
}

type Firmware = Exported<full::Model, { full::PARAMETERS.len() }>;

fn built(values: [f64; full::PARAMETERS.len()]) -> Firmware {
    Exported::new(full::LAYOUT, values, full::with)
}

fn parts(layout: u32, values: &[f64]) -> Vec<Request> {
    let chunks = values.chunks(PART).enumerate();
    let part = |(n, chunk): (usize, &[f64])| {
        let mut values = [0.0; PART];
        values
            .iter_mut()
            .zip(chunk)
            .for_each(|(to, from)| *to = *from as f32);
        let first = (n * PART) as u8;
        Request::Model(ModelPart {
            layout,
            first,
            values,
        })
    };
    chunks.map(part).collect()
}

/// The codes of so many ticks.
fn codes(drive: &mut Drive<Firmware>, ticks: usize) -> Vec<i32> {
    let code = |_| {
        let _ = drive.tick();
        drive.bridge.code
    };
    (0..ticks).map(code).collect()
}

/// Enabled, located, on its way.
fn moving(drive: &mut Drive<Firmware>) {
    drive.done(Request::Zero { position_m: 0.0 });
    drive.done(Request::Enable);
    drive.done(Request::Jog { speed_m_s: 1e-3 });
}

fn largest_step(codes: &[i32]) -> u32 {
    let steps = codes.windows(2).map(|two| two[1].abs_diff(two[0]));
    steps.max().unwrap_or(0)
}

#[test]
fn what_was_loaded_acts_as_if_compiled_in_and_comes_back_after_a_reset() {
    let mut loaded = Drive::of(built(full::PARAMETERS), Flash::erased());
    let mut compiled_in = Drive::of(built(other()), Flash::erased());
    let mut as_before = Drive::of(built(full::PARAMETERS), Flash::erased());
    let [first, last] = parts(full::LAYOUT, &other())[..] else {
        panic!("15 parameters are two parts");
    };
    loaded.done(first);
    loaded.done(last);
    for drive in [&mut compiled_in, &mut as_before] {
        // As many requests and orders, so that all are told the rest in the same ticks.
        drive.done(Request::Ping);
        drive.done(Request::Gains(GainSettings {
            proportional: 1e5,
            integral: 3e6,
            derivative: 600.0,
        }));
    }
    for drive in [&mut loaded, &mut compiled_in, &mut as_before] {
        drive.done(Request::Save);
    }
    let run = |drive: &mut Drive<Firmware>| {
        moving(drive);
        codes(drive, 10_000)
    };
    let wanted = run(&mut compiled_in);
    assert_ne!(run(&mut as_before), wanted);
    assert_eq!(run(&mut loaded), wanted);
    let flash = loaded.off();
    let mut restored = Drive::of(built(full::PARAMETERS), flash.clone());
    let mut compiled_in = Drive::of(built(other()), Flash::erased());
    assert_eq!(run(&mut restored), run(&mut compiled_in));
    // Saved over another model: what was compiled in rules.
    let mut anew = full::PARAMETERS;
    anew[2] *= 2.0;
    let [mut over, mut without] =
        [flash, Flash::erased()].map(|flash| Drive::of(built(anew), flash));
    assert_eq!(run(&mut over), run(&mut without));
}

#[test]
fn nothing_of_a_loaded_model_waits_for_another_part() {
    let mut drive = Drive::of(built(full::PARAMETERS), Flash::erased());
    let [first, last] = parts(full::LAYOUT, &other())[..] else {
        panic!("15 parameters are two parts");
    };
    drive.done(first);
    drive.done(last);
    assert_eq!(drive.ask(last), Reply::Refused(Refusal::OutOfRange));
}

#[test]
fn a_model_is_loaded_in_motion_without_a_bump() {
    let mut drive = Drive::of(built(full::PARAMETERS), Flash::erased());
    moving(&mut drive);
    let before = codes(&mut drive, 10_000);
    let mut after = Vec::new();
    for request in parts(full::LAYOUT, &other()) {
        after.push(drive.bridge.code);
        drive.done(request);
        after.push(drive.bridge.code);
    }
    after.extend(codes(&mut drive, 10_000));
    assert_eq!(drive.state().mode, Mode::Moving);
    assert!(largest_step(&after) <= largest_step(&before[5000..]) + 2);
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let mut drive = Drive::of(built(full::PARAMETERS), Flash::erased());
    let mut undisturbed = Drive::of(built(full::PARAMETERS), Flash::erased());
    let mut refused = |drive: &mut Drive<Firmware>, request, refusal| {
        assert_eq!(drive.ask(request), Reply::Refused(refusal));
        undisturbed.done(Request::Ping);
    };
    let [first, last] = parts(full::LAYOUT, &other())[..] else {
        panic!("15 parameters are two parts");
    };
    refused(&mut drive, last, Refusal::OutOfRange);
    refused(
        &mut drive,
        parts(starting(), &[0.9; 9])[0],
        Refusal::OtherModel,
    );
    drive.done(first);
    let mut nonsense = other();
    nonsense[13] = f64::NAN;
    refused(
        &mut drive,
        parts(full::LAYOUT, &nonsense)[1],
        Refusal::OutOfRange,
    );
    nonsense[13] = -1.0;
    refused(
        &mut drive,
        parts(full::LAYOUT, &nonsense)[1],
        Refusal::OutOfRange,
    );
    undisturbed.done(Request::Ping);
    let [found, wanted] = [&mut drive, &mut undisturbed].map(|drive| {
        moving(drive);
        codes(drive, 5000)
    });
    assert_eq!(found, wanted);
}

#[test]
fn tool_and_firmware_agree_on_the_parameters() {
    let mut paper = Starting::<f32>::PAPER;
    assert_eq!(starting(), paper.table().layout);
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../cli/tests/exported/full.toml"
    );
    let model = Model::load(file.as_ref()).expect("a model");
    let loaded = loadable(&model, full::LAYOUT).expect("of the same parts");
    let values: Vec<f64> = loaded.parameters.into_iter().map(|p| p.1).collect();
    assert_eq!(values, full::PARAMETERS);
    assert!(loaded.left_out.is_empty());
}
