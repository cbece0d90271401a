// Part of each board's build script: the axis.toml that PRESLIDE_AXIS names, or the project's own, as Rust.

/// Writes `axis.rs`, and for a board with a bridge of its own `board.rs`, into the build's folder.
fn axis(board: Option<&str>) {
    println!("cargo:rerun-if-env-changed=PRESLIDE_AXIS");
    println!("cargo:rerun-if-changed=../axis.rs");
    let named = std::env::var("PRESLIDE_AXIS").unwrap_or_else(|_| "../../../axis.toml".to_owned());
    println!("cargo:rerun-if-changed={named}");
    let written = preslide_axis::AxisFile::read(named.as_ref()).and_then(|file| {
        let mut written = vec![("axis.rs", preslide_axis::rust(&file.axis()))];
        if let Some(board) = board {
            written.push(("board.rs", format!("{:?}\n", file.board(board)?)));
        }
        Ok(written)
    });
    let folder = std::path::PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    match written {
        Ok(written) => {
            for (name, text) in written {
                if let Err(error) = std::fs::write(folder.join(name), text) {
                    println!("cargo::error={name}: {error}");
                }
            }
        }
        Err(error) => {
            for line in format!("PRESLIDE_AXIS: {error}").lines() {
                println!("cargo::error={line}");
            }
        }
    }
}
