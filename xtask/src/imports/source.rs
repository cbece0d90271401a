//! What a source file imports and names, read from its tokens, those of macros included. Tests are left out.

use std::collections::BTreeSet;

use anyhow::{Result, anyhow};
use proc_macro2::{TokenStream, TokenTree};

/// The names of a path, `crate` and `super` included.
pub type Path = Vec<String>;

/// A name that a `use` brings in.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    pub path: Path,
    /// What it is called here; `*` for everything.
    pub alias: String,
}

#[derive(Default)]
pub struct Source {
    pub imports: Vec<Import>,
    /// Paths in expressions and types that begin with `crate::` or `super::`.
    pub spelled_out: BTreeSet<Path>,
}

impl Source {
    pub fn read(text: &str) -> Result<Self> {
        let tokens: TokenStream = text.parse().map_err(|error| anyhow!("{error}"))?;
        let mut source = Self::default();
        source.take(tokens);
        Ok(source)
    }

    fn take(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let word = token.to_string();
            let (before, after) = (&tokens[..at], &tokens[at + 1..]);
            at += 1;
            match token {
                TokenTree::Punct(_) if word == "#" && after.first().is_some_and(is_for_tests) => {
                    let ends = after.iter().position(|t| is(t, ';') || is_block(t));
                    at += ends.map_or(after.len(), |end| end + 1);
                }
                // Not `impl Trait + use<'a>`.
                TokenTree::Ident(_)
                    if word == "use" && !after.first().is_some_and(|t| is(t, '<')) =>
                {
                    let length = after.iter().position(|t| is(t, ';'));
                    let length = length.unwrap_or(after.len());
                    expand(&[], &after[..length], &mut self.imports);
                    at += length;
                }
                TokenTree::Ident(_)
                    if ["crate", "super"].contains(&word.as_str()) && !continues(before) =>
                {
                    let mut path = vec![word];
                    while let [one, two, TokenTree::Ident(next), ..] = &tokens[at..]
                        && is(one, ':')
                        && is(two, ':')
                    {
                        path.push(next.to_string());
                        at += 3;
                    }
                    self.spelled_out.insert(path);
                }
                TokenTree::Group(group) => self.take(group.stream()),
                _ => {}
            }
        }
    }
}

/// Whether a path is under way: `a::super`, or another crate's, `$crate`.
fn continues(before: &[TokenTree]) -> bool {
    match before {
        [.., one, two] if is(one, ':') && is(two, ':') => true,
        [.., last] => is(last, '$'),
        [] => false,
    }
}

fn is(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == mark)
}

fn is_block(token: &TokenTree) -> bool {
    token.to_string().starts_with('{')
}

/// `[cfg(test)]`.
fn is_for_tests(token: &TokenTree) -> bool {
    token.to_string().replace(' ', "") == "[cfg(test)]"
}

/// Takes one tree of a `use` apart: `a::{b, c as d}`.
fn expand(before: &[String], tree: &[TokenTree], found: &mut Vec<Import>) {
    let (mut path, mut alias) = (before.to_vec(), None);
    let mut tokens = tree.iter();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Group(group) => {
                let group: Vec<TokenTree> = group.stream().into_iter().collect();
                let branches = group.split(|token| is(token, ','));
                return branches.for_each(|branch| expand(&path, branch, found));
            }
            TokenTree::Ident(word) if word == "as" => {
                alias = tokens.next().map(TokenTree::to_string)
            }
            TokenTree::Ident(word) => path.push(word.to_string()),
            token if is(token, '*') => alias = Some(token.to_string()),
            _ => {}
        }
    }
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    // Behind the last comma stands nothing.
    if let Some(alias) = alias.or(path.last().cloned()).filter(|_| !tree.is_empty()) {
        found.push(Import { path, alias });
    }
}
