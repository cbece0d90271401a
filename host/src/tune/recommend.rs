//! Which choice to take, and why.

use super::{Budget, Choice};
use preslide_fit::identify::{Candidate, Identification};
use preslide_fit::report::figures::{left, three};

/// Arithmetic may add this much (% of `F_s`, rms), and no kernel that adds more is recommended.
const ARITHMETIC: f64 = 0.5;

/// As many blocks as `identify` recommends, where it `found` any and so many fit, in the cheapest arithmetic that adds little: its index and the reason,
/// or why there is none.
pub(super) fn recommend(
    choices: &[Choice],
    budget: Budget,
    found: Option<&Identification>,
) -> Result<(usize, String), String> {
    let fitting = fitting(choices, budget)?;
    let sound = |c: &&Choice| c.arithmetic <= ARITHMETIC;
    let mut pool: Vec<&Choice> = fitting.iter().copied().filter(sound).collect();
    if pool.is_empty() {
        return Err(too_coarse(choices, &fitting));
    }
    if let Some(found) = found {
        let has = |blocks| pool.iter().any(|c| c.cost.blocks == blocks);
        let size = found.recommended_among(has).map(Candidate::size);
        pool.retain(|c| Some(c.cost.blocks) == size);
    }
    // A kernel asks for its controller's arithmetic: what counts is the tick that both make, where that is known of all.
    let ticks = pool.iter().all(|c| c.tick.is_some());
    let takes = |c: &Choice| match c.tick.filter(|_| ticks) {
        Some(tick) => tick.worst,
        None => c.cost.cycles_worst,
    };
    let chosen = pool.iter().min_by(|a, b| takes(a).total_cmp(&takes(b)));
    let Some(chosen) = chosen else {
        return Err("no choice has a finite error; see the notes".to_owned());
    };
    let index = choices
        .iter()
        .position(|c| std::ptr::eq(c, *chosen))
        .unwrap_or(0);
    let accuracy = why_so_many(chosen, found);
    let cycles = what_it_takes(chosen, budget, ticks);
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
            "nothing fits: the cheapest, {name} with N = {}, takes {} of the processor, the budget is {}; {}",
            cheapest.cost.blocks,
            percent(cheapest.share),
            percent(budget.share),
            remedy(budget, cheapest.share / budget.share, Some(cheapest.share)),
        ));
    }
    let fitting: Vec<&Choice> = choices.iter().filter(|c| c.fits(budget)).collect();
    if fitting.is_empty() {
        let shortest = choices.iter().filter_map(|c| c.tick.map(|tick| tick.worst));
        let shortest = shortest.fold(f64::INFINITY, f64::min);
        return Err(format!(
            "nothing fits: the whole control tick takes {shortest:.0} cycles at worst with the cheapest kernel, and {:.0} lie between two ticks; {}",
            budget.clock / budget.rate,
            remedy(budget, shortest * budget.rate / budget.clock, None),
        ));
    }
    Ok(fitting)
}

/// What would make room for `times` the cycles that there are, in what an option takes: no rate of no controller, no share above the whole.
fn remedy(budget: Budget, times: f64, share: Option<f64>) -> String {
    /// No controller is slower (Hz).
    const SLOWEST: f64 = 100.0;
    let rate = (budget.rate / times).floor();
    let slower = (rate >= SLOWEST).then(|| format!("lower --rate to {rate:.0} Hz"));
    let more = share.filter(|share| *share <= 1.0);
    let more = more.map(|share| format!("allow --budget {}", enough(share)));
    let remedies: Vec<String> = slower.into_iter().chain(more).collect();
    match remedies.is_empty() {
        false => remedies.join(" or "),
        true => format!(
            "a --clock of {:.3} MHz would do, and {:.3} MHz is given: check its unit",
            1e-6 * budget.clock * times,
            1e-6 * budget.clock
        ),
    }
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
            ": {} with N = {} adds least, {} %",
            c.kernel.name(),
            c.cost.blocks,
            three(c.arithmetic)
        )
    });
    let sound = choices.iter().filter(|c| c.arithmetic <= ARITHMETIC);
    let remedy = match sound.min_by(|a, b| a.share.total_cmp(&b.share)) {
        Some(c) => format!(
            "allow --budget {} for {} with N = {}, which adds {} %",
            enough(c.share),
            c.kernel.name(),
            c.cost.blocks,
            three(c.arithmetic)
        ),
        None => "check --count against the encoder, and the model's yield displacements against the motion".to_owned(),
    };
    format!(
        "no arithmetic within the budget adds at most {ARITHMETIC} % of the breakaway force to the model's error{least}; {remedy}"
    )
}

/// The number of blocks.
fn why_so_many(chosen: &Choice, found: Option<&Identification>) -> String {
    let blocks = chosen.cost.blocks;
    let (Some(found), Some(nmse)) = (found, chosen.nmse_test) else {
        return format!("the model has N = {blocks}; give --recording to have N chosen as well");
    };
    let wanted = found.best();
    if wanted.size() == blocks {
        return format!(
            "`preslide identify` recommends so many blocks, which leave {} NMSE on motion held out",
            left(nmse)
        );
    }
    format!(
        "of the N = {} that `preslide identify` recommends ({} NMSE on motion held out) no arithmetic within the budget is so exact; of the sizes of which one is, N = {blocks} is recommended by the same rule, and leaves {}",
        wanted.size(),
        left(wanted.nmse_test),
        left(nmse)
    )
}

/// The arithmetic, its rounding and its share of the processor; `ticks` says whether the whole tick decided.
fn what_it_takes(chosen: &Choice, budget: Budget, ticks: bool) -> String {
    let whole = chosen.tick.filter(|_| ticks).map(|tick| {
        format!(
            "the shortest control tick at worst, {:.0} cycles or {} of the processor",
            tick.worst,
            percent(budget.share_of(tick.worst))
        )
    });
    format!(
        "of all arithmetic for N = {} within the budget that adds at most {ARITHMETIC} % of the breakaway force, {} ({}) makes {} (it adds {} %); friction takes {} of the processor at worst, {:.0} cycles a tick, of {} allowed",
        chosen.cost.blocks,
        chosen.kernel.name(),
        chosen.kernel.description(),
        whole.unwrap_or_else(|| "the fewest cycles at worst".to_owned()),
        three(chosen.arithmetic),
        percent(chosen.share),
        chosen.cost.cycles_worst,
        percent(budget.share),
    )
}

fn percent(share: f64) -> String {
    format!("{} %", three(100.0 * share))
}
