//! What the build script of every board does: it links, has the axis and the exported model compiled in, and checks the table of pins.

mod pins;

pub use pins::pins;

/// Links by these scripts, in their order; with the board's feature `log` by that of defmt, too.
pub fn link(scripts: &[&str]) {
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-link-search={folder}");
    println!("cargo:rerun-if-changed=memory.x");
    for script in scripts {
        println!("cargo:rustc-link-arg=-T{script}");
    }
    if std::env::var_os("CARGO_FEATURE_LOG").is_some() {
        println!("cargo:rustc-link-arg=-Tdefmt.x");
    }
}

/// Writes the axis.toml that PRESLIDE_AXIS names, or the project's own, as Rust into the build's folder: `axis.rs`, and for a board with a
/// bridge of its own `board.rs`.
pub fn axis(board: Option<&str>) {
    println!("cargo:rerun-if-env-changed=PRESLIDE_AXIS");
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

/// Tells the compiler that there is a friction model that `preslide export` wrote, where PRESLIDE_MODEL names its file.
pub fn exported_model() {
    written("PRESLIDE_MODEL", "exported_model", "`preslide export`");
}

/// And that there is an outer task, where PRESLIDE_KOOPMAN names the file that says what was learnt for it.
pub fn outer_task() {
    written(
        "PRESLIDE_KOOPMAN",
        "outer_task",
        "`track -- koopman-firmware`",
    );
}

/// Has the compiler know a file that a variable names, by a path that does not depend on the folder of the build.
fn written(variable: &str, cfg: &str, by: &str) {
    println!("cargo:rustc-check-cfg=cfg({cfg})");
    println!("cargo:rerun-if-env-changed={variable}");
    let Ok(named) = std::env::var(variable) else {
        return;
    };
    match std::fs::canonicalize(&named) {
        Ok(path) => {
            println!("cargo:rustc-cfg={cfg}");
            println!("cargo:rustc-env={variable}={}", path.display());
            println!("cargo:rerun-if-changed={}", path.display());
        }
        Err(error) => println!(
            "cargo::error={variable}={named}: {error}; give the full path of the file that {by} wrote"
        ),
    }
}
