//! Stretches in which a column of two values, such as `torque_enabled`, shows that the drive was off: the effort is zero there and no
//! channel was lost.

use std::ops::Range;

use super::frame::Frame;
use super::known::Slot;

/// Beside the drive's being on, an effort is zero at fewer than this share of samples: more, and the column means something else.
const ZERO_WHEN_ON: f64 = 0.5;
/// The fewest samples that the drive is off in all.
const FEWEST: usize = 8;

/// The column that shows it, and where the drive is off, within the `pieces`.
pub(super) struct DriveOff {
    pub(super) column: String,
    pub(super) ranges: Vec<Range<usize>>,
}

/// Where a further column shows that the drive is off.
pub(super) fn drive_off(frame: &Frame, pieces: &[Range<usize>]) -> Option<DriveOff> {
    let effort = &frame.numbers.iter().find(|c| c.0 == Slot::Effort)?.1;
    frame.extra.iter().find_map(|extra| {
        let off = off_value(&extra.values, effort)?;
        let is_off = |&i: &usize| extra.values[i] == off;
        let ranges = pieces.iter().flat_map(|p| stretches(p.clone(), is_off));
        Some(DriveOff {
            column: extra.name.clone(),
            ranges: ranges.collect(),
        })
    })
}

/// Of a column with two values the one at which the effort is always zero; at the other it mostly is not.
fn off_value(flag: &[f64], effort: &[f64]) -> Option<f64> {
    let first = *flag.first()?;
    let second = *flag.iter().find(|v| **v != first)?;
    if flag.iter().any(|v| *v != first && *v != second) {
        return None;
    }
    let zero_share = |value: f64| {
        let at = flag.iter().zip(effort).filter(|(v, _)| **v == value);
        let (zeros, all) = at.fold((0, 0), |(zeros, all), (_, f)| {
            (zeros + usize::from(*f == 0.0), all + 1)
        });
        (zeros as f64 / f64::from(all), all as usize)
    };
    [(first, second), (second, first)]
        .into_iter()
        .find(|&(off, on)| {
            let (zeros, samples) = zero_share(off);
            zeros == 1.0 && samples >= FEWEST && zero_share(on).0 < ZERO_WHEN_ON
        })
        .map(|(off, _)| off)
}

/// The longest ranges of `within` whose samples all are so.
fn stretches(within: Range<usize>, so: impl Fn(&usize) -> bool) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for i in within.filter(so) {
        match found.last_mut() {
            Some(last) if last.end == i => last.end = i + 1,
            _ => found.push(i..i + 1),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::Recording;
    use super::super::tests::{read, said, warns};

    /// A swing at 1 kHz whose drive is off for 1.5 of 4 s, and coasts; `effort` names the column, `flag` that of the drive, which is 0 from `first` on.
    fn load(effort: &str, flag: &str, first: usize) -> Recording {
        let row = |i: usize| {
            let phase = i as f64 * 0.003;
            let f = match i {
                1000..2500 => 0.0,
                _ => 5.0 * (20.0 * phase.cos()).tanh(),
            };
            let on = i32::from(!(first..2500).contains(&i));
            let x = 0.02 * phase.sin();
            format!("{:.3},{x:.8},{f:.5},{on}\n", i as f64 * 1e-3)
        };
        let rows: String = (0..4000).map(row).collect();
        read(&format!("t_s,x_m,{effort},{flag}\n{rows}"))
    }

    #[test]
    fn a_drive_that_is_off_is_no_dropout() {
        let force = load("force_N", "drive_enabled", 1000);
        assert_eq!(force.len(), 4000);
        assert!(warns(&force, "drive-off"), "{:?}", force.warnings);
        assert!(!warns(&force, "dropout"), "{:?}", force.warnings);
    }

    #[test]
    fn a_voltage_of_a_drive_that_is_off_is_left_out() {
        let voltage = load("voltage_V", "torque_enabled", 1000);
        assert!(!warns(&voltage, "dropout"), "{:?}", voltage.warnings);
        let off = said(&voltage, "drive-off");
        for part in [
            "`torque_enabled`",
            "1500 samples in 1 places, first from line 1002 to line 2501",
        ] {
            assert!(off.contains(part), "{off}");
        }
        assert_eq!((voltage.len(), voltage.pieces.len()), (2500, 2));
        assert!(voltage.extra.is_empty(), "it is on in all that is left");
    }

    /// What is off for as long, but not where the effort is zero.
    #[test]
    fn a_column_that_tells_something_else_is_not_believed() {
        let read = load("force_N", "valve", 900);
        assert!(!warns(&read, "drive-off"), "{:?}", read.warnings);
        assert!(warns(&read, "dropout"), "{:?}", read.warnings);
    }
}
