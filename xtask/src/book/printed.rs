//! Lines that the book says a command prints, against those that it printed.

/// Numbers may differ by this share, or by one in their last digit: other processors and mathematical libraries round
/// otherwise.
const TOLERANCE: f64 = 0.01;

/// Stands for any number of lines.
const LEFT_OUT: &str = "…";

/// Every expected line is printed, in order and next to each other where no `…` stands between.
pub fn compare(expected: &[String], printed: &str) -> Result<(), String> {
    walk(expected, printed, alike).map(|_| ())
}

/// The expected lines with the numbers that are printed now.
pub fn blessed(expected: &[String], printed: &str) -> Result<Vec<String>, String> {
    walk(expected, printed, |expected, printed| {
        skeleton(expected) == skeleton(printed)
    })
    .map(|lines| lines.iter().map(|line| narrow(line)).collect())
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

fn walk(
    expected: &[String],
    printed: &str,
    same: impl Fn(&str, &str) -> bool,
) -> Result<Vec<String>, String> {
    let lines: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let (mut next, mut anywhere) = (0, true);
    let mut found = Vec::new();
    for line in expected {
        if line.trim() == LEFT_OUT {
            anywhere = true;
            found.push(line.clone());
            continue;
        }
        let rest = lines.get(next..).unwrap_or_default();
        let at = if anywhere {
            rest.iter().position(|printed| same(line, printed))
        } else {
            rest.first()
                .is_some_and(|printed| same(line, printed))
                .then_some(0)
        };
        let Some(at) = at else {
            // The nearest thing to show: the printed line of the same words, or the next one.
            let near = lines
                .iter()
                .find(|printed| skeleton(printed) == skeleton(line));
            let near = near.or(rest.first()).copied().unwrap_or("nothing");
            return Err(format!("`{line}` is not printed here, but `{near}`"));
        };
        found.push(lines[next + at].to_string());
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
    parts(line)
        .into_iter()
        .map(|part| match part {
            Part::Text(text) => text,
            Part::Number(..) => "#".to_string(),
        })
        .collect()
}

#[derive(Debug)]
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
        let length = number_at(rest);
        if length > 0 {
            let (number, after) = rest.split_at(length);
            let (mantissa, exponent) = number.split_once('e').unwrap_or((number, "0"));
            let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32);
            let exponent: i32 = exponent.parse().unwrap_or(0);
            parts.push(Part::Text(std::mem::take(&mut text)));
            parts.push(Part::Number(
                number.parse().unwrap_or(f64::NAN),
                10_f64.powi(exponent - decimals),
            ));
            rest = after;
        } else if first.is_whitespace() || first == '─' {
            if !text.ends_with(' ') {
                text.push(' ');
            }
            rest = &rest[first.len_utf8()..];
        } else {
            text.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    parts.push(Part::Text(text));
    parts
}

/// Length of the number that `text` begins with, 0 for none.
fn number_at(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let rest = bytes.get(from..).unwrap_or_default();
        rest.iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let sign = usize::from(bytes.first() == Some(&b'-'));
    let whole = digits(sign);
    if whole == 0 {
        return 0;
    }
    let mut end = sign + whole;
    if bytes.get(end) == Some(&b'.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    if bytes.get(end) == Some(&b'e') {
        let minus = usize::from(bytes.get(end + 1) == Some(&b'-'));
        let exponent = digits(end + 1 + minus);
        if exponent > 0 {
            end += 1 + minus + exponent;
        }
    }
    end
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
            assert_eq!(compare(&lines(expected), PRINTED), Ok(()), "{expected}");
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
    }
}
