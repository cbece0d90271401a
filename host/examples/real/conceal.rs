//! A term that the data need is taken out of the model: is it named, and how well is it measured?

use super::{figure, load, parameters, run, screw, words};
use nalgebra::{DMatrix, DVector};
use preslide::Sliding;
use preslide_host::diagnose::Diagnosis;
use preslide_host::friction::FrictionModel;
use preslide_host::identify::{Options, STEPS, identify};
use preslide_host::model::Model;
use preslide_host::progress::Progress;
use preslide_host::recording::Recording;
use preslide_host::report::Table;
use std::f64::consts::TAU;

/// A block that yields after this share of the travel is as good as Coulomb friction.
const STIFF: f64 = 1e-6;

/// A model, what was taken out of it, and what a fit that has the term says.
struct Case<'a> {
    recording: &'a Recording,
    concealed: Option<&'static str>,
    model: Model,
    reference: String,
}

/// What `identify`, which shares no fit with the diagnosis, says of a recording.
fn identified(recording: &Recording) -> Result<(Model, [f64; 2]), String> {
    let progress = Progress::new(format!("{}: identify", recording.name), STEPS);
    let found = identify(recording, &Options::default(), &progress)?;
    let value = |name: &str| {
        let all = &found.best().rigid_body;
        all.iter().find(|p| p.0 == name).map_or(0.0, |p| p.1.value)
    };
    Ok((
        found.best().model.clone(),
        [value("viscous"), value("offset")],
    ))
}

/// One stiff block of a given breakaway force.
fn stiff(recording: &Recording, breakaway: f64) -> FrictionModel {
    let bound = |pick: fn(f64, f64) -> f64| recording.position.iter().copied().reduce(pick);
    let travel = bound(f64::max).unwrap_or(1.0) - bound(f64::min).unwrap_or(0.0);
    FrictionModel::maxwell_slip(&[breakaway / (STIFF * travel)], &[STIFF * travel])
}

/// Largest harmonic of the position in the effort of a slow map there and back, beside a constant and Coulomb friction, by
/// plain least squares: period [rad] and amplitude.
fn largest_harmonic(recording: &Recording) -> [f64; 2] {
    let (x, effort) = (&recording.position, &recording.effort);
    let turn = (0..x.len())
        .max_by(|&a, &b| x[a].total_cmp(&x[b]))
        .unwrap_or(0);
    let target = DVector::from_column_slice(effort);
    let amplitude = |order: f64| {
        let columns = DMatrix::from_fn(x.len(), 4, |row, column| match column {
            0 => 1.0,
            1 if row <= turn => 1.0,
            1 => -1.0,
            2 => (order * x[row]).cos(),
            _ => (order * x[row]).sin(),
        });
        let normal = columns.tr_mul(&columns).cholesky();
        let c = normal.map(|n| n.solve(&columns.tr_mul(&target)));
        c.map_or(0.0, |c| c[2].hypot(c[3]))
    };
    let best = (1..=150).map(|order| [TAU / f64::from(order), amplitude(f64::from(order))]);
    best.max_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or([0.0; 2])
}

fn row(case: &Case, found: Result<(Diagnosis, f64), String>) -> Vec<String> {
    let mut row = vec![
        case.recording.name.clone(),
        case.concealed.unwrap_or("nothing").to_owned(),
    ];
    let (d, _) = match found {
        Ok(found) => found,
        Err(reason) => {
            row.push(reason);
            return row;
        }
    };
    let named = d
        .effects
        .iter()
        .enumerate()
        .find(|(_, e)| Some(e.id()) == case.concealed);
    let others: Vec<String> = d
        .effects
        .iter()
        .filter(|e| Some(e.id()) != case.concealed)
        .map(words)
        .collect();
    row.push(match (case.concealed, named) {
        (None, _) => "–".to_owned(),
        (_, None) => "not named".to_owned(),
        (_, Some((place, effect))) => format!("{}. {}", place + 1, words(effect)),
    });
    row.push(named.map_or("–".to_owned(), |(_, effect)| {
        let form = effect.standing.as_ref().and_then(|s| s.form);
        let changed = form.map_or(String::new(), |(axis, _)| {
            format!("; its size changes with {}", axis.name(&d.ground.rows.s))
        });
        match effect.id() {
            "presliding_shape" => format!(
                "NMSE {} % by the model's shape, {} % by the core's",
                figure(effect.nmse_test[0]),
                figure(effect.nmse_test[1])
            ),
            _ => parameters(effect, case.recording) + &changed,
        }
    }));
    row.push(case.reference.clone());
    row.push(others.join("; "));
    row.push(super::unknown(&d));
    row
}

pub fn table() -> Result<Table, String> {
    let emps = load("emps/emps_tracking.csv")?;
    let tribometer = load("tribometer_reciprocating/reciprocating_5N.csv")?;
    let cogging = load("laas_cogging/hold_map_fwd_rev.csv")?;
    let mut cases = Vec::new();

    let (_, [viscous, offset]) = identified(&emps)?;
    let level = 20.4;
    let whole = Model {
        viscous,
        constant_force: offset,
        ..Model::of_friction(emps.kind, FrictionModel::Coulomb { coulomb: level })
    };
    let mut conceal = |recording, concealed, model, reference: String| {
        cases.push(Case {
            recording,
            concealed,
            model,
            reference,
        });
    };
    conceal(&emps, None, whole.clone(), String::new());
    let model = Model {
        constant_force: 0.0,
        ..whole.clone()
    };
    let reference = format!("{} N; published −3.165 N", figure(offset));
    conceal(&emps, Some("constant_force"), model, reference);
    let model = Model {
        viscous: 0.0,
        ..whole.clone()
    };
    let reference = format!("{} N·s/m; published 203.5 N·s/m", figure(viscous));
    conceal(&emps, Some("viscous"), model, reference);
    let model = Model {
        friction: stiff(&emps, level),
        ..whole
    };
    let reference = "one stiff block: `identify` finds that Coulomb friction will do".to_owned();
    conceal(&emps, None, model, reference);

    let (model, _) = identified(&tribometer)?;
    let FrictionModel::Gms {
        breakaway, blocks, ..
    } = &model.friction
    else {
        return Err(format!("{}: identify found no blocks", tribometer.name));
    };
    let yields: Vec<String> = blocks
        .iter()
        .map(|b| figure(1e6 * b.weight * breakaway / b.stiffness))
        .collect();
    let reference = format!("`identify`: yields after {} µm", yields.join(", "));
    let concealed = Model {
        friction: stiff(&tribometer, *breakaway),
        ..model.clone()
    };
    conceal(&tribometer, None, model.clone(), String::new());
    conceal(
        &tribometer,
        Some("presliding_shape"),
        concealed,
        format!("{reference}; the model has one stiff block"),
    );
    let coulomb = FrictionModel::Coulomb {
        coulomb: *breakaway,
    };
    let concealed = Model {
        friction: coulomb,
        ..model.clone()
    };
    let reference = format!("{reference}; the model has Coulomb friction");
    conceal(&tribometer, Some("presliding_shape"), concealed, reference);

    let drives = (1..=3)
        .map(|drive| Ok((drive, screw::steady_state(drive)?)))
        .collect::<Result<Vec<(u32, Recording)>, String>>()?;
    for (drive, recording) in &drives {
        let [coulomb, velocity, level] = screw::stribeck(*drive)?;
        // Drive 2's mean torques grow with speed: there is nothing to conceal.
        if level < 0.05 {
            continue;
        }
        let breakaway = coulomb * (1.0 + level);
        let FrictionModel::Gms { blocks, .. } = stiff(recording, breakaway) else {
            continue;
        };
        let friction = |sliding| FrictionModel::Gms {
            breakaway,
            blocks: blocks.clone(),
            sliding,
        };
        let sliding = Sliding {
            coulomb,
            stribeck_velocity: velocity,
            stribeck_exponent: 1.0,
            attraction: f64::INFINITY,
        };
        let with = |sliding| Model {
            viscous: 1e-6,
            constant_force: 1e-6,
            ..Model::of_friction(recording.kind, friction(sliding))
        };
        conceal(recording, None, with(Some(sliding)), String::new());
        let reference = format!(
            "mean torques: level {}, velocity {} rad/s",
            figure(level),
            figure(velocity)
        );
        conceal(recording, Some("stribeck"), with(None), reference);
    }

    let [period, amplitude] = largest_harmonic(&cogging);
    let reference = format!(
        "least squares: period {} rad, {} A",
        figure(period),
        figure(amplitude)
    );
    let model = Model::of_friction(cogging.kind, FrictionModel::Coulomb { coulomb: 0.03 });
    conceal(&cogging, Some("periodic_force"), model, reference);

    let rows = cases
        .iter()
        .map(|case| {
            let what = format!(
                "{} without {}",
                case.recording.name,
                case.concealed.unwrap_or("nothing")
            );
            row(case, run(&what, case.recording, Some(&case.model)))
        })
        .collect();
    Ok(Table {
        caption: "Concealed: a term taken out of the model".to_owned(),
        head: [
            "recording",
            "taken out",
            "named",
            "as",
            "a fit that has it",
            "named besides",
            "unknown follows",
        ]
        .map(String::from)
        .to_vec(),
        rows,
    })
}
