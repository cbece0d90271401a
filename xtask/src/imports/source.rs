//! The paths that a source file names: its `use` items, and `crate::…`, `super::…` in its code. Not a parser of Rust: it reads
//! formatted code, without comments, texts and tests.

/// A name that a `use` brings in.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Its path as written, `super` and all.
    pub path: Vec<String>,
    /// What it is called here; `*` for everything.
    pub alias: String,
}

/// The code alone: comments and texts are emptied, and modules under `#[cfg(test)]` left out.
pub fn code(text: &str) -> String {
    without_tests(&without_words(text))
}

/// Without comments and without what stands between quotation marks.
fn without_words(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(inside) = rest.strip_prefix("r#\"") {
            inside.find("\"#").map_or(rest.len(), |end| end + 5)
        } else if let Some(inside) = rest.strip_prefix('"') {
            1 + end_of_text(inside)
        } else if rest.starts_with("'\"'") || rest.starts_with("'\\\"'") {
            rest[1..].find("'").map_or(rest.len(), |end| end + 2)
        } else {
            kept.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        };
        rest = &rest[skipped..];
    }
    kept
}

/// Bytes up to and with the quotation mark that ends a text.
fn end_of_text(inside: &str) -> usize {
    let mut escaped = false;
    for (at, c) in inside.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    inside.len()
}

/// Without the item that follows a `#[cfg(test)]`: to its closing brace at the same indentation, or to its semicolon.
fn without_tests(code: &str) -> String {
    let mut kept = String::with_capacity(code.len());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push_str(line);
            kept.push('\n');
            continue;
        }
        let indent = &line[..line.len() - line.trim_start().len()];
        let end = format!("{indent}}}");
        for line in lines.by_ref() {
            if line.ends_with(';')
                && line.starts_with(indent)
                && !line.starts_with(&format!("{indent} "))
                || line == end
            {
                break;
            }
        }
    }
    kept
}

/// Everything that `use` items bring in.
pub fn imports(code: &str) -> Vec<Import> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].trim_end_matches(' ');
        let begins = before.is_empty()
            || before.ends_with(['\n', ';', '{', '}'])
            || before.ends_with("pub")
            || before.ends_with(')');
        let item = code[at + 4..].split(';').next().unwrap_or("");
        if begins && !item.contains('=') {
            let words: String = item.replace(" as ", "@").split_whitespace().collect();
            expand(&[], &words, &mut found);
        }
    }
    found
}

/// Takes one tree of a `use` apart, `a::{b, c as d}` with ` as ` written `@`.
fn expand(before: &[String], tree: &str, found: &mut Vec<Import>) {
    let (head, group) = match tree.split_once('{') {
        Some((head, rest)) => (head, rest.strip_suffix('}')),
        None => (tree, None),
    };
    let mut path = before.to_vec();
    path.extend(head.split("::").filter(|s| !s.is_empty()).map(String::from));
    if let Some(group) = group {
        for branch in branches(group) {
            expand(&path, branch, found);
        }
        return;
    }
    let Some(last) = path.pop() else { return };
    let (last, alias) = last.split_once('@').unwrap_or((&last, &last));
    let alias = match (last, path.last()) {
        ("self", Some(own)) if alias == "self" => own.clone(),
        _ => alias.to_owned(),
    };
    if !["self", "*"].contains(&last) || path.is_empty() {
        path.push(last.to_owned());
    }
    found.push(Import { path, alias });
}

/// The parts of `a, b::{c, d}` between the commas that stand outside braces.
fn branches(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[start..]);
    parts.retain(|part| !part.is_empty());
    parts
}

/// Paths in expressions and types that begin with `crate::` or `super::`.
pub fn spelled_out(code: &str) -> Vec<Vec<String>> {
    let starts = code
        .match_indices("crate::")
        .chain(code.match_indices("super::"));
    let whole = starts.filter(|(at, _)| {
        !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$')
    });
    whole
        .map(|(at, _)| {
            let end = code[at..].find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
            let path = &code[at..end.map_or(code.len(), |end| at + end)];
            path.split("::")
                .filter(|s| !s.is_empty())
                .map(String::from)
                .collect()
        })
        .collect()
}

/// Whether the file itself defines the name.
pub fn defines(code: &str, name: &str) -> bool {
    const KINDS: [&str; 9] = [
        "struct", "enum", "fn", "trait", "type", "const", "static", "mod", "union",
    ];
    KINDS.iter().any(|kind| {
        let words = format!("{kind} {name}");
        code.match_indices(&words).any(|(at, _)| {
            let after = &code[at + words.len()..];
            !after.starts_with(|c: char| c.is_alphanumeric() || c == '_')
        })
    })
}
