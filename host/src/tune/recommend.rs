//! Which choice to take, and why.

use super::{Budget, Choice};

/// Another block is worth its cycles if it takes away a tenth of the error…
const WORTH: f64 = 0.1;
/// …and at least this much of it (percentage points of NMSE).
const LEAST_WORTH: f64 = 0.05;
/// Arithmetic may add this much (% of `F_s`, rms), and no kernel that adds more is recommended.
const ARITHMETIC: f64 = 0.5;

/// The fewest blocks after which no more are worth their cycles, in the cheapest arithmetic that adds little: its index and the
/// reason, or why there is none.
pub(super) fn recommend(choices: &[Choice], budget: Budget) -> Result<(usize, String), String> {
    let fitting = fitting(choices, budget)?;
    let sound = |c: &&Choice| c.arithmetic <= ARITHMETIC;
    let pool: Vec<&Choice> = fitting.iter().copied().filter(sound).collect();
    if pool.is_empty() {
        return Err(too_coarse(choices, &fitting));
    }
    let best = pool
        .iter()
        .filter_map(|c| c.nmse_test)
        .fold(f64::INFINITY, f64::min);
    let enough = |c: &&&Choice| {
        c.nmse_test
            .is_none_or(|nmse| nmse <= best + (WORTH * best).max(LEAST_WORTH))
    };
    // A kernel asks for its controller's arithmetic: what counts is the tick that both make, where it is known.
    let takes = |c: &Choice| c.tick.map_or(c.share, |tick| budget.share_of(tick.worst));
    let chosen = pool.iter().filter(enough).min_by(|a, b| {
        let blocks = a.cost.blocks.cmp(&b.cost.blocks);
        blocks.then(takes(a).total_cmp(&takes(b)))
    });
    let Some(chosen) = chosen else {
        return Err("no choice has a finite error; see the notes".to_owned());
    };
    let index = choices
        .iter()
        .position(|c| std::ptr::eq(c, *chosen))
        .unwrap_or(0);
    let (accuracy, cycles) = (why_so_many(chosen, best), what_it_takes(chosen, budget));
    Ok((index, format!("{accuracy}; {cycles}")))
}

/// The choices that the processor has time for, or by how much the cheapest misses it and what to change.
fn fitting(choices: &[Choice], budget: Budget) -> Result<Vec<&Choice>, String> {
    let cheapest = choices.iter().min_by(|a, b| a.share.total_cmp(&b.share));
    let Some(cheapest) = cheapest else {
        return Err("no kernel can run this model; see the notes".to_owned());
    };
    if cheapest.share > budget.share {
        let name = cheapest.kernel.name();
        return Err(format!(
            "nothing fits: the cheapest, {name} with N = {}, takes {} of the processor, the budget is {}; lower --rate to {:.0} Hz or allow --budget {}",
            cheapest.cost.blocks,
            percent(cheapest.share),
            percent(budget.share),
            (budget.rate * budget.share / cheapest.share).floor(),
            enough(cheapest.share),
        ));
    }
    let fitting: Vec<&Choice> = choices.iter().filter(|c| c.fits(budget)).collect();
    if fitting.is_empty() {
        let shortest = choices.iter().filter_map(|c| c.tick.map(|tick| tick.worst));
        let shortest = shortest.fold(f64::INFINITY, f64::min);
        return Err(format!(
            "nothing fits: the whole control tick takes {shortest:.0} cycles at worst with the cheapest kernel, and {:.0} lie between two ticks; lower --rate to {:.0} Hz",
            budget.clock / budget.rate,
            (budget.clock / shortest).floor(),
        ));
    }
    Ok(fitting)
}

/// A budget that holds a share, as it is typed: no less when it is rounded.
fn enough(share: f64) -> String {
    format!("{:.2}%", (1e4 * share).ceil() / 100.0)
}

/// By how much the arithmetic of all that fit misses its bound, and what would keep it.
fn too_coarse(choices: &[Choice], fitting: &[&Choice]) -> String {
    let finest = fitting
        .iter()
        .min_by(|a, b| a.arithmetic.total_cmp(&b.arithmetic));
    let least = finest.map_or(String::new(), |c| {
        format!(
            ": {} with N = {} adds least, {:.3} %",
            c.kernel.name(),
            c.cost.blocks,
            c.arithmetic
        )
    });
    let sound = choices.iter().filter(|c| c.arithmetic <= ARITHMETIC);
    let remedy = match sound.min_by(|a, b| a.share.total_cmp(&b.share)) {
        Some(c) => format!(
            "allow --budget {} for {} with N = {}, which adds {:.3} %",
            enough(c.share),
            c.kernel.name(),
            c.cost.blocks,
            c.arithmetic
        ),
        None => "check --count against the encoder, and the model's yield displacements against the motion".to_owned(),
    };
    format!(
        "no arithmetic within the budget adds at most {ARITHMETIC} % of the breakaway force to the model's error{least}; {remedy}"
    )
}

/// The number of blocks, beside the `best` error (% NMSE) of all that fit.
fn why_so_many(chosen: &Choice, best: f64) -> String {
    let blocks = chosen.cost.blocks;
    match chosen.nmse_test {
        Some(nmse) if blocks == 1 => {
            format!(
                "N = 1 is enough here: it leaves {nmse:.2} % NMSE on motion held out, and no larger model within the budget less than {best:.2} %"
            )
        }
        Some(nmse) => format!(
            "N = {blocks} leaves {nmse:.2} % NMSE on motion held out; more blocks within the budget reach {best:.2} % at best, fewer leave over a tenth more"
        ),
        None => format!("the model has N = {blocks}; give --recording to have N chosen as well"),
    }
}

/// The arithmetic, its rounding and its share of the processor.
fn what_it_takes(chosen: &Choice, budget: Budget) -> String {
    let whole = chosen.tick.map_or(String::new(), |tick| {
        format!(
            "; the whole control tick then takes {} at worst, {:.0} cycles",
            percent(budget.share_of(tick.worst)),
            tick.worst
        )
    });
    format!(
        "{} ({}) is the cheapest arithmetic that adds at most {ARITHMETIC} % of the breakaway force (it adds {:.3} %) and takes {} of the processor at worst, {:.0} cycles a tick, of {} allowed{whole}",
        chosen.kernel.name(),
        chosen.kernel.description(),
        chosen.arithmetic,
        percent(chosen.share),
        chosen.cost.cycles_worst,
        percent(budget.share),
    )
}

fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}
