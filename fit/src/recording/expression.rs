//! What `--map` writes to the right of `=`: a sum of products of numbers and columns.

/// A product of a number and columns of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    pub(super) factor: f64,
    /// Indices of the file's columns; none in a number alone.
    pub(super) columns: Vec<usize>,
}

/// What is multiplied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Factor<'a> {
    Number(f64),
    /// A column, and the unit that was written behind it, with the text of both.
    Column(usize, Option<(&'a str, &'a str)>),
}

/// The sign of each product and its factors, of `2*a - b[mm]*c + 1e-3`.
///
/// A column's name may hold blanks and the signs `*`, `+` and `-`: the longest text that is one counts.
///
/// # Errors
/// The part that is neither a number nor a column.
pub(super) fn products<'a>(
    text: &'a str,
    find: impl Fn(&str) -> Option<usize>,
) -> Result<Vec<(f64, Vec<Factor<'a>>)>, &'a str> {
    let mut products = Vec::new();
    let mut rest = text.trim_start();
    loop {
        let sign = match rest.strip_prefix(['+', '-']) {
            Some(after) => {
                let sign = if rest.starts_with('-') { -1.0 } else { 1.0 };
                rest = after;
                sign
            }
            None => 1.0,
        };
        let mut factors = Vec::new();
        loop {
            let factor;
            (factor, rest) = first(rest, &find)?;
            factors.push(factor);
            match rest.strip_prefix('*') {
                Some(after) => rest = after,
                None => break,
            }
        }
        products.push((sign, factors));
        if rest.is_empty() {
            return Ok(products);
        }
    }
}

/// The first factor, and what follows it.
fn first<'a>(
    text: &'a str,
    find: impl Fn(&str) -> Option<usize>,
) -> Result<(Factor<'a>, &'a str), &'a str> {
    let signs = text.char_indices().filter(|(_, c)| "*+-".contains(*c));
    let ends: Vec<usize> = signs.map(|(i, _)| i).chain([text.len()]).collect();
    let read = |&end: &usize| Some((factor(text[..end].trim(), &find)?, &text[end..]));
    let shortest = ends.iter().copied().find(|&e| e > 0).unwrap_or(0);
    ends.iter()
        .rev()
        .find_map(read)
        .ok_or(text[..shortest].trim())
}

fn factor<'a>(part: &'a str, find: impl Fn(&str) -> Option<usize>) -> Option<Factor<'a>> {
    let number = || part.parse::<f64>().ok().filter(|n| n.is_finite());
    let with_unit = || {
        let (name, unit) = part.strip_suffix(']')?.rsplit_once('[')?;
        Some(Factor::Column(find(name.trim())?, Some((unit, part))))
    };
    let column = find(part).map(|i| Factor::Column(i, None));
    column
        .or_else(|| number().map(Factor::Number))
        .or_else(with_unit)
}

#[cfg(test)]
mod tests {
    use super::Factor::{Column, Number};
    use super::*;

    #[test]
    fn sums_products_and_names_that_hold_signs_are_told_apart() {
        let names = ["a", "b", "a-b", "p A [bar]", "x*y", "e"];
        let find = |name: &str| names.iter().position(|n| *n == name);
        let col = |i| Column(i, None);
        for (text, expected) in [
            ("a", vec![(1.0, vec![col(0)])]),
            ("a-b", vec![(1.0, vec![col(2)])]),
            ("a - b", vec![(1.0, vec![col(0)]), (-1.0, vec![col(1)])]),
            (
                "-1e-3*a + 2E+1*x*y-e",
                vec![
                    (-1.0, vec![Number(1e-3), col(0)]),
                    (1.0, vec![Number(20.0), col(4)]),
                    (-1.0, vec![col(5)]),
                ],
            ),
            (
                "100*p A [bar]-b[mm]*a+0.5",
                vec![
                    (1.0, vec![Number(100.0), col(3)]),
                    (-1.0, vec![Column(1, Some(("mm", "b[mm]"))), col(0)]),
                    (1.0, vec![Number(0.5)]),
                ],
            ),
            (
                "2*-3*a",
                vec![(1.0, vec![Number(2.0), Number(-3.0), col(0)])],
            ),
        ] {
            assert_eq!(products(text, find), Ok(expected), "{text}");
        }
        for (text, part) in [
            ("2*q", "q"),
            ("a+", ""),
            ("", ""),
            ("a b", "a b"),
            ("q-2", "q"),
        ] {
            assert_eq!(products(text, find), Err(part), "{text}");
        }
    }
}
