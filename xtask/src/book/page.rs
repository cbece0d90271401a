//! The book's pages and their fenced blocks.

use std::path::{Path, PathBuf};

use super::{files, read};
use crate::process::root;

/// A chapter.
pub struct Page {
    /// Below `docs/src`.
    pub name: String,
    pub file: PathBuf,
    pub text: String,
    pub blocks: Vec<CodeBlock>,
}

/// A fenced block.
pub struct CodeBlock {
    pub kind: Kind,
    /// Index of its first line inside the fence.
    pub first: usize,
    pub lines: Vec<String>,
}

/// What is done with a block; see the module `book`.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// In the shared folder, or in the one given.
    Run {
        folder: Option<PathBuf>,
    },
    Recordings,
    /// In the shared folder, beside a copy of that recording, `axis.csv`.
    Axis(String),
    Ci(String),
    /// Takes minutes; the next block, or a step of CI that it names, runs a part of it.
    Long,
    Board,
    File(String),
    Printed,
    Other,
}

impl Kind {
    fn of(info: &str) -> Result<Self, String> {
        let words: Vec<&str> = info.split([',', ' ']).map(str::trim).collect();
        let value = |key: &str| words.iter().find_map(|word| word.strip_prefix(key));
        if let Some(name) = value("file=") {
            if name.contains(['/', '\\']) {
                return Err(format!("`{name}` is no plain file name"));
            }
            return Ok(Self::File(name.to_string()));
        }
        if let Some(recording) = value("axis=") {
            return Ok(Self::Axis(recording.to_string()));
        }
        Ok(match words[..] {
            ["sh"] => Self::Run { folder: None },
            ["sh", "root"] => Self::Run {
                folder: Some(root().to_path_buf()),
            },
            ["sh", "recordings"] => Self::Recordings,
            ["sh", "long"] => Self::Long,
            ["sh", "board"] => Self::Board,
            ["sh", other] => match other.strip_prefix("ci=") {
                Some(step) => Self::Ci(step.to_string()),
                None => return Err(format!("`{info}` is no kind of block")),
            },
            ["text", "printed"] => Self::Printed,
            // A command that nothing looks at must not pass for one that is run.
            ["bash" | "shell" | "console", ..] => {
                return Err(format!("`{info}`: commands stand in `sh` blocks"));
            }
            _ => Self::Other,
        })
    }
}

/// All pages in the order of `SUMMARY.md`, which must name every one.
pub fn all(folder: &Path) -> Result<Vec<Page>, String> {
    let summary = read(&folder.join("SUMMARY.md"))?;
    let named: Vec<&str> = summary
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .collect();
    let pages = named
        .iter()
        .map(|name| page(folder, name))
        .collect::<Result<Vec<_>, _>>()?;
    for file in files(folder, "md")? {
        let known = pages.iter().any(|page| page.file == file);
        if !known && file.file_name().is_none_or(|name| name != "SUMMARY.md") {
            return Err(format!("{} is not in SUMMARY.md", file.display()));
        }
    }
    Ok(pages)
}

/// One page.
pub fn page(folder: &Path, name: &str) -> Result<Page, String> {
    let file = folder.join(name);
    let text = read(&file)?;
    let blocks = blocks(&text).map_err(|reason| format!("{name}: {reason}"))?;
    Ok(Page {
        name: name.to_string(),
        file,
        text,
        blocks,
    })
}

fn blocks(text: &str) -> Result<Vec<CodeBlock>, String> {
    let mut blocks = Vec::new();
    let mut open: Option<CodeBlock> = None;
    for (index, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), open.as_mut()) {
            (Some(""), Some(_)) => blocks.extend(open.take()),
            (Some(info), None) => {
                open = Some(CodeBlock {
                    kind: Kind::of(info)
                        .map_err(|reason| format!("line {}: {reason}", index + 1))?,
                    first: index + 1,
                    lines: Vec::new(),
                });
            }
            (_, Some(block)) => block.lines.push(line.to_string()),
            (None, None) => {}
        }
    }
    for pair in blocks.windows(2) {
        let runs = matches!(
            pair[1].kind,
            Kind::Run { .. } | Kind::Recordings | Kind::Axis(_)
        );
        let first = |block: &CodeBlock| -> String {
            let line = block.lines.first().map_or("", String::as_str);
            line.split('#').next().unwrap_or("").trim().to_string()
        };
        let part = matches!(pair[1].kind, Kind::Ci(_))
            || runs && first(&pair[1]).starts_with(&first(&pair[0]));
        if pair[0].kind == Kind::Long && !part {
            return Err(format!(
                "line {}: the next block must run a part of this long command",
                pair[0].first
            ));
        }
    }
    if blocks.last().is_some_and(|block| block.kind == Kind::Long) {
        return Err("nothing runs a part of the last, long command".to_string());
    }
    match open {
        Some(block) => Err(format!("the block from line {} on has no end", block.first)),
        None => Ok(blocks),
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, blocks};

    #[test]
    fn blocks_are_what_their_info_says() {
        let found =
            blocks("a\n```sh\nls\n```\n```toml,file=a.toml\nx\ny\n```\n```sh,ci=qemu\n```\n")
                .unwrap();
        assert_eq!(found[0].kind, Kind::Run { folder: None });
        assert_eq!((found[0].first, found[0].lines.len()), (2, 1));
        assert_eq!(found[1].kind, Kind::File("a.toml".to_string()));
        assert_eq!(found[1].lines, ["x", "y"]);
        assert_eq!(found[2].kind, Kind::Ci("qemu".to_string()));
    }

    #[test]
    fn commands_that_nothing_would_run_are_refused() {
        for text in [
            "```bash\nls\n```\n",
            "```sh,later\nls\n```\n",
            "```sh\nls\n",
            "```text,file=../x\n```\n",
            "```sh,long\nls /\n```\n",
            "```sh,long\nls /\n```\n```sh\necho\n```\n",
        ] {
            assert!(blocks(text).is_err(), "{text}");
        }
    }
}
