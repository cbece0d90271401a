//! Lines that the book says a command prints, against those that it printed.

use anyhow::{Context as _, Result};

/// Numbers may differ by this share, or by one in their last digit: other processors and mathematical libraries round
/// otherwise.
const TOLERANCE: f64 = 0.01;

/// Stands for any number of lines.
const LEFT_OUT: &str = "…";

/// Every expected line is printed, in order and next to each other where no `…` stands between.
pub fn compare(expected: &[String], printed: &str) -> Result<()> {
    walk(expected, printed, alike).map(|_| ())
}

/// The expected lines with the numbers that are printed now. What is printed as expected stays: of several rows that differ by
/// their numbers only, the first would take its place.
pub fn blessed(expected: &[String], printed: &str) -> Result<Vec<String>> {
    if compare(expected, printed).is_ok() {
        return Ok(expected.to_vec());
    }
    let lines = walk(expected, printed, |a, b| skeleton(a) == skeleton(b))?;
    Ok(lines.iter().map(|line| narrow(line)).collect())
}

/// The line with at most two blanks between its columns, so that it fits on a page.
fn narrow(line: &str) -> String {
    let mut narrow = String::new();
    for c in line.trim().chars() {
        if c != ' ' || !narrow.ends_with("  ") {
            narrow.push(c);
        }
    }
    narrow
}

/// The printed line of each expected one.
fn walk<'a>(
    expected: &'a [String],
    printed: &'a str,
    same: impl Fn(&str, &str) -> bool,
) -> Result<Vec<&'a str>> {
    let lines: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let (mut next, mut anywhere) = (0, true);
    let mut found = Vec::new();
    for line in expected {
        if line.trim() == LEFT_OUT {
            anywhere = true;
            found.push(line.as_str());
            continue;
        }
        let rest = &lines[next..];
        let within = if anywhere {
            rest.len()
        } else {
            rest.len().min(1)
        };
        let at = rest[..within]
            .iter()
            .position(|printed| same(line, printed));
        let at = at.with_context(|| {
            // The nearest thing to show: the printed line of the same words, or the next one.
            let mut near = lines.iter();
            let near = near.find(|printed| skeleton(printed) == skeleton(line));
            let near = near.or(rest.first()).copied().unwrap_or("nothing");
            format!("`{line}` is not printed here, but `{near}`")
        })?;
        found.push(rest[at]);
        next += at + 1;
        anywhere = false;
    }
    Ok(found)
}

fn alike(expected: &str, printed: &str) -> bool {
    let (expected, printed) = (parts(expected), parts(printed));
    expected.len() == printed.len()
        && expected.iter().zip(&printed).all(|pair| match pair {
            (Part::Text(a), Part::Text(b)) => a == b,
            (Part::Number(a, unit), Part::Number(b, _)) => {
                (a - b).abs() <= (TOLERANCE * a.abs()).max(1.001 * unit)
            }
            _ => false,
        })
}

/// The line without its numbers.
fn skeleton(line: &str) -> Vec<String> {
    let text = |part| match part {
        Part::Text(text) => text,
        Part::Number(..) => "#".to_owned(),
    };
    parts(line).into_iter().map(text).collect()
}

enum Part {
    Text(String),
    /// Value, and one in its last digit.
    Number(f64, f64),
}

/// Text and numbers by turns; blanks and rules, whose length follows the numbers, are one blank.
fn parts(line: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut text = String::new();
    let mut rest = line.trim();
    while let Some(first) = rest.chars().next() {
        let mut length = first.len_utf8();
        if let Some(number) = number_at(rest) {
            length = number.len();
            let (mantissa, exponent) = number.split_once('e').unwrap_or((number, "0"));
            let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32);
            let exponent: i32 = exponent.parse().unwrap_or(0);
            let last_digit = 10_f64.powi(exponent - decimals);
            let value = number.parse().unwrap_or(f64::NAN);
            parts.push(Part::Text(std::mem::take(&mut text)));
            parts.push(Part::Number(value, last_digit));
        } else if !first.is_whitespace() && first != '─' {
            text.push(first);
        } else if !text.ends_with(' ') {
            text.push(' ');
        }
        rest = &rest[length..];
    }
    parts.push(Part::Text(text));
    parts
}

/// The number that the text begins with, if it does.
fn number_at(text: &str) -> Option<&str> {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with('-'));
    let mut end = sign + digits(sign);
    if end == sign {
        return None;
    }
    if text[end..].starts_with('.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    if let Some(exponent) = text[end..].strip_prefix('e') {
        let start = end + 1 + usize::from(exponent.starts_with('-'));
        if digits(start) > 0 {
            end = start + digits(start);
        }
    }
    Some(&text[..end])
}

#[cfg(test)]
mod tests {
    use super::{blessed, compare};

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_string).collect()
    }

    const PRINTED: &str = "head\nmass   2.8754  kg\nN = 4  1.2e-6\nlast 7 words";

    #[test]
    fn printed_lines_are_found_in_order_with_room_for_rounding() {
        for expected in [
            "mass 2.8760 kg\nN = 4 1.2e-6",
            "head\n…\nN = 4 1.3e-6",
            "last 7 words",
        ] {
            assert!(compare(&lines(expected), PRINTED).is_ok(), "{expected}");
        }
        for wrong in [
            "mass 3.1 kg",
            "head\nN = 4 1.2e-6",
            "N = 4 1.2e-6\n…\nmass 2.8754 kg",
            "last 9 words",
            "mass 2.8754 g",
        ] {
            assert!(compare(&lines(wrong), PRINTED).is_err(), "{wrong}");
        }
    }

    #[test]
    fn blessing_takes_the_numbers_and_not_other_words() {
        assert_eq!(
            blessed(&lines("mass 1 kg\n…\nlast 3 words"), PRINTED).unwrap(),
            ["mass  2.8754  kg", "…", "last 7 words"]
        );
        assert!(blessed(&lines("weight 1 kg"), PRINTED).is_err());
        // The second of two rows that differ by their numbers only.
        assert_eq!(
            blessed(&lines("…\nrow 2"), "row 1\nrow 2").unwrap(),
            ["…", "row 2"]
        );
    }
}
