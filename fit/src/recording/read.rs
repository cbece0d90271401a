//! From a file or a stream to a table, by its first bytes.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use super::table::Table;
use super::{
    LoadOptions, Problem, formats, headless, json, labelled, layout, rows, twincat, variables,
};

/// The columns of a file that the options ask for.
pub(super) fn file(path: &Path, options: &LoadOptions) -> Result<Table, Problem> {
    let mut file = File::open(path)?;
    let bytes = file.metadata()?.len();
    let mut start = Vec::new();
    file.by_ref()
        .take(formats::MAGIC_BYTES)
        .read_to_end(&mut start)?;
    let format = formats::of(&start);
    let is_mat = super::mat::is_mat(&start)
        || path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("mat"));
    let limit = if is_mat || format.is_some() {
        options.max_bytes / 2
    } else {
        options.max_bytes
    };
    if bytes > limit {
        return Err(Problem::too_large(bytes, limit));
    }
    if let Some(format) = format {
        file.rewind()?;
        let input = formats::Input {
            path,
            file,
            start: &start,
            budget: options.max_bytes,
        };
        let found = formats::variables(format, input)?;
        return variables::table(&found, options);
    }
    let input = start.as_slice().chain(file);
    match is_mat {
        true => mat(input, options),
        false => text(input, options),
    }
}

/// The table of a text file, by its beginning.
pub(super) fn text(mut input: impl Read, options: &LoadOptions) -> Result<Table, Problem> {
    let mut start = Vec::new();
    input
        .by_ref()
        .take(formats::MAGIC_BYTES)
        .read_to_end(&mut start)?;
    if formats::of(&start).is_some() {
        return Err(formats::refusal(&start));
    }
    let mark = layout::missing_mark(&start);
    let input = mark.chain(start.as_slice()).chain(input);
    if json::is_json(&start) {
        // Its values take several times the room of the text.
        return match json::read(&bytes(input, options.max_bytes / 8)?)? {
            json::Content::Lines(layout, lines) => {
                rows::read(layout, lines.into_iter().map(Ok), options)
            }
            json::Content::Columns(found) => variables::table(&found, options),
        };
    }
    let mut rest = layout::lines(input);
    let head = rest.head()?;
    layout::is_text(&head)?;
    if twincat::is_export(&head) {
        return twincat::read(head, rest, options);
    }
    let mut layout = match labelled::layout(&head) {
        Some(layout) => layout,
        None => layout::of(&head)?,
    };
    let unnamed = match layout.headless {
        true => headless::name(&mut layout, &head),
        false => None,
    };
    let lines = head.into_iter().map(Ok).chain(rest);
    rows::read(layout, lines, options).map_err(|problem| match (problem, unnamed) {
        (Problem::Columns { .. }, Some(unnamed)) => unnamed,
        (problem, _) => problem,
    })
}

/// The table of a MATLAB file.
pub(super) fn mat(input: impl Read, options: &LoadOptions) -> Result<Table, Problem> {
    let found = super::mat::variables(&bytes(input, options.max_bytes / 2)?, options)?;
    variables::table(&found, options)
}

/// All of a file, where it holds at most `limit` bytes.
fn bytes(input: impl Read, limit: u64) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    let read = input
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes)? as u64;
    match read > limit {
        true => Err(Problem::too_large(read, limit)),
        false => Ok(bytes),
    }
}
