//! Several recordings of one machine as one.

use super::checks::{self, FLIPPED};
use super::{EffortRole, MotionKind, Recording, Warning, extra, segments, timing};
use crate::report::figures::quantity;

/// Code of the warning that names columns which not all recordings have.
pub const DROPPED: &str = "columns-dropped";

/// Code of the warning that names recordings of other rates.
pub const RATES: &str = "rates-differ";

/// Code of the warning that a recording was turned because another of the machine was.
pub const FLIPPED_ALIKE: &str = "effort-sign-alike";

/// Sample times within this ratio are one rate.
const SAME_RATE: f64 = 1.1;

/// Refuses to pool two files, by their names, of which one moves or is driven otherwise than the other.
pub(super) fn one_machine(
    what: &str,
    [name, next_name]: [&str; 2],
    [own, next]: [(MotionKind, EffortRole); 2],
) -> Result<(), String> {
    if own == next {
        return Ok(());
    }
    let [is, next_is] =
        [own, next].map(|(kind, role)| format!("{} with a {}", kind.name(), role.name()));
    Err(format!(
        "{name} is {is}, {next_name} is {next_is}: they are not of one machine; give {what} with the same columns"
    ))
}

impl Recording {
    /// Joins recordings of one machine, in order; segments and repeats are numbered on.
    ///
    /// A column that not all of them have is left out of the whole, and so is what is given twice.
    ///
    /// # Errors
    /// Which two recordings do not belong together, and why.
    pub fn join(mut recordings: Vec<Recording>) -> Result<Recording, String> {
        let turned = flip_alike(&mut recordings);
        // One machine holds its load in each of them, or in none.
        Self::take_off_alike(&mut recordings);
        let mut rest = recordings.into_iter();
        let mut whole = rest.next().ok_or("no recording given")?;
        whole.warnings.extend(turned);
        for next in rest {
            let of = |r: &Recording| (r.kind, r.role);
            one_machine(
                "recordings",
                [&whole.name, &next.name],
                [&whole, &next].map(of),
            )?;
            let ratio = next.sample_time_s / whole.sample_time_s;
            if !(1.0 / SAME_RATE..SAME_RATE).contains(&ratio) {
                whole.warnings.push(warning!(
                    RATES,
                    "{} is sampled every {}, {} every {}: each keeps its rate, and a second of it counts as one of the other; a diagnosis brings them to one, and leaves out what is sampled three times slower",
                    whole.name,
                    quantity(whole.sample_time_s, "s"),
                    next.name,
                    quantity(next.sample_time_s, "s")
                ));
            }
            let offset = whole.len();
            let mut further = (
                std::mem::take(&mut whole.extra),
                std::mem::take(&mut whole.constant_extra),
            );
            let dropped = extra::join(
                (&mut further, (next.extra, next.constant_extra)),
                (offset, next.t_s.len()),
            );
            (whole.extra, whole.constant_extra) = further;
            if !dropped.is_empty() {
                whole.warnings.push(warning!(
                    DROPPED,
                    "left out, as not every recording has them: {}",
                    dropped.join(", ")
                ));
            }
            let after = |labels: &[u32]| labels.iter().max().map_or(0, |last| last + 1);
            let (segment, repeat) = (after(&whole.segment), after(&whole.repeat));
            whole.name = format!("{}, {}", whole.name, next.name);
            whole.t_s.extend(&next.t_s);
            whole.position.extend(&next.position);
            whole.effort.extend(&next.effort);
            whole
                .segment
                .extend(next.segment.iter().map(|s| s + segment));
            whole.repeat.extend(next.repeat.iter().map(|r| r + repeat));
            whole
                .pieces
                .extend(next.pieces.iter().map(|p| p.start + offset..p.end + offset));
            for (column, more) in [
                (&mut whole.reference, next.reference),
                (&mut whole.velocity, next.velocity),
                (&mut whole.temperature_c, next.temperature_c),
                (&mut whole.load_n, next.load_n),
                (&mut whole.pressure_pa, next.pressure_pa),
            ] {
                *column = column.take().zip(more).map(|(mut column, more)| {
                    column.extend(more);
                    column
                });
            }
            let joined = next.joined.iter();
            whole
                .joined
                .extend(joined.map(|r| r.start + offset..r.end + offset));
            whole.warnings.extend(next.warnings);
        }
        whole.sample_time_s = timing::sample_time(&whole.t_s, &whole.pieces);
        // What each is too short for, all together may show.
        if whole.len() >= checks::FEW_SAMPLES {
            whole.warnings.retain(|w| w.code != checks::TOO_SHORT);
        }
        Ok(whole.without_copies())
    }
}

/// Where the sign of one recording's effort was found to oppose the model's, those that are too short to show it have it, too.
fn flip_alike(recordings: &mut [Recording]) -> Option<Warning> {
    let is_flipped = |r: &Recording| r.warnings.iter().any(|w| w.code == FLIPPED);
    let opposed = recordings.iter().find(|r| is_flipped(r))?.name.clone();
    let cannot_tell = |r: &Recording| {
        let pieces = r.pieces.iter().cloned();
        let strokes: Vec<_> = pieces.map(|p| segments::strokes(&r.position, p)).collect();
        !is_flipped(r) && !checks::tells_sign(&r.position, &r.effort, &strokes)
    };
    let mut names = Vec::new();
    for recording in recordings.iter_mut().filter(|r| cannot_tell(r)) {
        recording.effort.iter_mut().for_each(|f| *f = -*f);
        names.push(recording.name.clone());
    }
    (!names.is_empty()).then(|| {
        warning!(
            FLIPPED_ALIKE,
            "the effort of {} was multiplied by -1 like that of {opposed}: its own motion is too short to show the sign; --sign -1 says so of all and silences this",
            names.join(", ")
        )
    })
}
