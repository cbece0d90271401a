//! JSON: an object a line, an array of objects, or an object of arrays.

use std::collections::HashMap;

use serde_json::Value;

use super::clock::Clock;
use super::error::Problem;
use super::layout::{Layout, Line};
use super::variables::Variable;

/// Between cells of the rows that lines become.
const SEPARATOR: char = '\t';

/// Of UTF-8, where a tool writes it.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Longest array within a row that is a column for each of its elements.
const MOST_ELEMENTS: usize = 64;

/// An object that holds a sample.
const EXAMPLE: &str = r#"{"t_s": 0.0, "q_rad": 0.1, "torque_Nm": 0.2}"#;

/// What a file of JSON holds.
pub(super) enum Content {
    /// Rows of cells, each at its line of the file.
    Lines(Layout, Vec<Line>),
    Columns(Vec<Variable>),
}

/// Whether the text begins like JSON that holds objects.
pub(super) fn is_json(head: &[u8]) -> bool {
    let head = head.strip_prefix(MARK).unwrap_or(head);
    let mut bytes = head.iter().filter(|b| !b.is_ascii_whitespace());
    let start = (bytes.next(), bytes.next());
    matches!(start, (Some(b'{'), Some(b'"')) | (Some(b'['), Some(b'{')))
}

/// Reads the whole text.
pub(super) fn read(text: &[u8]) -> Result<Content, Problem> {
    let text = text.strip_prefix(MARK).unwrap_or(text);
    let text = finite(String::from_utf8_lossy(text).into_owned());
    match serde_json::from_str::<Value>(&text) {
        Ok(document) => columns(&document).map(Content::Columns),
        Err(error) => lines(&text).ok_or_else(|| {
            Problem::Other(format!(
                "is JSON that cannot be read ({error}); write one object a line, such as {EXAMPLE}"
            ))
        }),
    }
}

/// Without the words for numbers that are none, which Python writes and JSON does not know.
fn finite(text: String) -> String {
    const WORDS: [&str; 3] = ["-Infinity", "Infinity", "NaN"];
    let replace = |text: String, word: &&str| match text.contains(*word) {
        true => text.replace(*word, "null"),
        false => text,
    };
    WORDS.iter().fold(text, replace)
}

/// An object a line; `None` where no line is one.
fn lines(text: &str) -> Option<Content> {
    let mut names: Vec<String> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut rows: Vec<Result<Vec<(usize, String)>, &str>> = Vec::new();
    for line in text.lines() {
        rows.push(match serde_json::from_str::<Value>(line) {
            Ok(object @ Value::Object(_)) => {
                let mut cells = Vec::new();
                flatten(String::new(), &object, &mut |name, value| {
                    let next = places.len();
                    let place = *places.entry(name).or_insert_with_key(|name| {
                        names.push(name.clone());
                        next
                    });
                    cells.push((place, cell(value)));
                });
                Ok(cells)
            }
            _ => Err(line),
        });
    }
    if names.is_empty() {
        return None;
    }
    let text = |row| match row {
        Ok(cells) => {
            let mut row = vec![String::new(); names.len()];
            for (at, cell) in cells {
                row[at] = cell;
            }
            row.join("\t")
        }
        // No row, which its reader tells.
        Err(line) => str::trim(line).to_owned(),
    };
    let lines = (1..).zip(rows).map(|(number, row)| Line {
        text: text(row),
        number,
    });
    let lines = lines.collect();
    let layout = Layout {
        separator: SEPARATOR as u8,
        names,
        first_line: 1,
        ..Layout::default()
    };
    Some(Content::Lines(layout, lines))
}

/// The name of a part of what has that name.
fn within(name: &str, part: &str) -> String {
    match name {
        "" => part.to_owned(),
        name => format!("{name}.{part}"),
    }
}

/// The values that are no objects nor arrays, by the names of all that they are in.
fn flatten(name: String, value: &Value, take: &mut impl FnMut(String, &Value)) {
    match value {
        Value::Object(members) => members
            .iter()
            .for_each(|(key, value)| flatten(within(&name, key), value, take)),
        Value::Array(elements) if elements.len() <= MOST_ELEMENTS => elements
            .iter()
            .enumerate()
            .for_each(|(i, value)| flatten(within(&name, &i.to_string()), value, take)),
        Value::Array(_) => {}
        value => take(name, value),
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::Bool(is) => u8::from(*is).to_string(),
        Value::String(text) => text.replace([SEPARATOR, '\n', '\r'], " "),
        value => value.to_string(),
    }
}

/// The number of a cell, the seconds of a stamp, NaN where it is lost; `None` for words.
fn number(value: &Value, clock: &mut Clock) -> Option<f64> {
    match value {
        Value::Null => Some(f64::NAN),
        Value::Bool(is) => Some(f64::from(u8::from(*is))),
        Value::Number(number) => number.as_f64(),
        Value::String(text) => clock.seconds(text),
        _ => None,
    }
}

/// The longest array of objects, or else the arrays of numbers, wherever in the document they are.
fn columns(document: &Value) -> Result<Vec<Variable>, Problem> {
    let found = match longest_of_objects(document) {
        Some(rows) => of_rows(rows),
        None => {
            let mut found = Vec::new();
            arrays(String::new(), document, &mut found);
            found
        }
    };
    match found.is_empty() {
        false => Ok(found),
        true => Err(Problem::Other(format!(
            "is JSON without an array of objects or arrays of numbers; write one object a sample, such as {EXAMPLE}"
        ))),
    }
}

fn longest_of_objects(value: &Value) -> Option<&[Value]> {
    let own = value.as_array().map(Vec::as_slice);
    let own = own.filter(|rows| !rows.is_empty() && rows.iter().all(Value::is_object));
    let inner = value.as_object().into_iter().flat_map(|m| m.values());
    let inner = inner.filter_map(longest_of_objects);
    own.into_iter().chain(inner).max_by_key(|rows| rows.len())
}

fn of_rows(rows: &[Value]) -> Vec<Variable> {
    let mut found: Vec<Variable> = Vec::new();
    let mut clocks: Vec<Clock> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for (i, row) in rows.iter().enumerate() {
        flatten(String::new(), row, &mut |name, value| {
            let place = *places.entry(name).or_insert_with_key(|name| {
                found.push(Variable::column(name, vec![f64::NAN; rows.len()]));
                clocks.push(Clock::default());
                found.len() - 1
            });
            let values = &mut found[place].values;
            match (number(value, &mut clocks[place]), &mut *values) {
                (Some(number), Ok(values)) => values[i] = number,
                (None, _) => *values = Err("words"),
                _ => {}
            }
        });
    }
    found
}

fn arrays(name: String, value: &Value, found: &mut Vec<Variable>) {
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                arrays(within(&name, key), value, found);
            }
        }
        Value::Array(elements) => {
            let mut clock = Clock::default();
            let values = elements.iter().map(|value| number(value, &mut clock));
            let values: Option<Vec<f64>> = values.collect();
            found.extend(values.map(|values| Variable::column(name, values)));
        }
        _ => {}
    }
}
