//! `capture tcp:HOST:PORT OUT.csv`: until `preslide capture` is wired.

use preslide::control::Settings;
use preslide_host::capture::{Scale, capture, open};

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (Some(source), Some(file)) = (arguments.next(), arguments.next()) else {
        anyhow::bail!("usage: capture tcp:HOST:PORT OUT.csv");
    };
    let scale = Scale::of(&Settings::PAPER_AXIS, 20);
    let summary = capture(
        open(&source)?,
        std::fs::File::create(file)?,
        &scale,
        None,
        |_| {},
    )?;
    println!("{summary:?}");
    Ok(())
}
