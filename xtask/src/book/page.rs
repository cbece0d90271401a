//! The book's pages and their fenced blocks.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;

use crate::files::files;

/// A chapter.
pub struct Page {
    /// Below `docs/src`.
    pub name: String,
    pub file: PathBuf,
    pub text: String,
    /// Its lines outside of blocks.
    pub prose: String,
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
    Run(Place),
    Ci(String),
    /// Takes minutes; the next block, or a step of CI that it names, runs a part of it.
    Long,
    Board,
    File(String),
    Printed,
    Other,
}

/// Where commands run.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// In the shared folder.
    Shared,
    Root,
    /// In the root, where there are recordings.
    Recordings,
    /// In the shared folder, beside a copy of that recording, `axis.csv`.
    Axis(String),
}

impl Kind {
    fn of(info: &str) -> Result<Self> {
        let words: Vec<&str> = info.split([',', ' ']).map(str::trim).collect();
        if let Some(name) = words.iter().find_map(|word| word.strip_prefix("file=")) {
            ensure!(
                !name.contains(['/', '\\']),
                "`{name}` is no plain file name"
            );
            return Ok(Self::File(name.to_owned()));
        }
        Ok(match words[..] {
            ["sh"] => Self::Run(Place::Shared),
            ["sh", "root"] => Self::Run(Place::Root),
            ["sh", "recordings"] => Self::Run(Place::Recordings),
            ["sh", "long"] => Self::Long,
            ["sh", "board"] => Self::Board,
            ["sh", other] => match other.split_once('=') {
                Some(("axis", recording)) => Self::Run(Place::Axis(recording.to_owned())),
                Some(("ci", step)) => Self::Ci(step.to_owned()),
                _ => bail!("`{info}` is no kind of block"),
            },
            ["text", "printed"] => Self::Printed,
            // A command that nothing looks at must not pass for one that is run.
            ["sh" | "bash" | "shell" | "console", ..] => {
                bail!("`{info}`: commands stand in `sh` blocks of a known kind")
            }
            _ => Self::Other,
        })
    }
}

/// All pages in the order of `SUMMARY.md`, which must name every one.
pub fn all(folder: &Path) -> Result<Vec<Page>> {
    let summary = fs::read_to_string(folder.join("SUMMARY.md"))?;
    let pages = links(&summary).map(|name| Page::read(folder, name));
    let pages = pages.collect::<Result<Vec<_>>>()?;
    for file in files(folder, "md")? {
        let known = file.ends_with("SUMMARY.md") || pages.iter().any(|page| page.file == file);
        ensure!(known, "{} is not in SUMMARY.md", file.display());
    }
    Ok(pages)
}

/// Where a text's links lead.
pub fn links(text: &str) -> impl Iterator<Item = &str> {
    let rest = text.split("](").skip(1);
    rest.filter_map(|rest| rest.split(')').next())
}

impl Page {
    pub fn read(folder: &Path, name: &str) -> Result<Self> {
        let file = folder.join(name);
        let text = fs::read_to_string(&file)?;
        let (prose, blocks) = blocks(&text).with_context(|| name.to_owned())?;
        Ok(Self {
            name: name.to_owned(),
            file,
            text,
            prose,
            blocks,
        })
    }
}

/// The lines outside of fences, and what stands inside of them.
fn blocks(text: &str) -> Result<(String, Vec<CodeBlock>)> {
    let (mut prose, mut blocks) = (String::new(), Vec::new());
    let mut open: Option<CodeBlock> = None;
    for (index, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), open.as_mut()) {
            (Some(""), Some(_)) => blocks.extend(open.take()),
            (Some(info), None) => {
                let kind = Kind::of(info).with_context(|| format!("line {}", index + 1))?;
                open = Some(CodeBlock {
                    kind,
                    first: index + 1,
                    lines: Vec::new(),
                });
            }
            (_, Some(block)) => block.lines.push(line.to_owned()),
            (None, None) => prose.extend([line, "\n"]),
        }
    }
    if let Some(block) = open {
        bail!("the block from line {} on has no end", block.first);
    }
    for (index, long) in blocks.iter().enumerate() {
        if long.kind == Kind::Long
            && !blocks
                .get(index + 1)
                .is_some_and(|next| next.is_part_of(long))
        {
            bail!(
                "line {}: the next block must run a part of this long command",
                long.first
            );
        }
    }
    Ok((prose, blocks))
}

impl CodeBlock {
    /// Whether it runs a part of a long command: a step of CI, or the same command with more arguments.
    fn is_part_of(&self, long: &Self) -> bool {
        let command = |block: &Self| {
            let line = block.lines.first().map_or("", String::as_str);
            line.split('#').next().unwrap_or("").trim().to_owned()
        };
        match self.kind {
            Kind::Ci(_) => true,
            Kind::Run(_) => command(self).starts_with(&command(long)),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Place, blocks};

    #[test]
    fn blocks_are_what_their_info_says() {
        let text = "a\n```sh\nls\n```\n```toml,file=a.toml\nx\ny\n```\n```sh,ci=qemu\n```\nb";
        let (prose, found) = blocks(text).unwrap();
        assert_eq!(prose, "a\nb\n");
        assert_eq!(found[0].kind, Kind::Run(Place::Shared));
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
