//! The library as a user gets it: the package, published but for the upload, and built by another project.

use std::process::Command;
use std::time::Duration;

use crate::process::{cargo, find, output, root, run, run_for, target_of, words};

/// rustup's download hangs on some networks instead of failing.
const RUSTUP_LIMIT: Duration = Duration::from_secs(120);

/// What is wrong with the package, if anything is.
pub fn check() -> Result<(), String> {
    list()?;
    // A developer's tree is usually dirty; what is packed is the same.
    let line = "publish --dry-run --allow-dirty --package preslide";
    run(&mut cargo(&words(line)))?;
    oldest()
}

/// The package holds the library and nothing else.
fn list() -> Result<(), String> {
    let line = "package --list --allow-dirty --package preslide";
    let list = output(&mut cargo(&words(line)))?;
    let made_by_cargo = [
        "Cargo.toml",
        "Cargo.toml.orig",
        "Cargo.lock",
        ".cargo_vcs_info.json",
    ];
    let belongs = |path: &str| {
        path.starts_with("src/")
            || path.starts_with("LICENSE-")
            || path == "build.rs"
            || made_by_cargo.contains(&path)
    };
    let strangers: Vec<&str> = list.lines().filter(|path| !belongs(path)).collect();
    if !strangers.is_empty() {
        return Err(format!(
            "the package would hold {}; narrow `include` in the root Cargo.toml",
            strangers.join(", ")
        ));
    }
    for path in [
        "src/lib.rs",
        "src/README.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
    ] {
        if !list.lines().any(|line| line == path) {
            return Err(format!(
                "the package lacks {path}; see `include` in the root Cargo.toml"
            ));
        }
    }
    println!("{} files, all of them the library's", list.lines().count());
    Ok(())
}

/// A new project that depends on the package builds it with the compiler that the package names, with and without its features; cargo
/// chooses dependencies that this compiler can build, as it does for everyone.
fn oldest() -> Result<(), String> {
    let package = target_of(root()).join(concat!("package/preslide-", env!("CARGO_PKG_VERSION")));
    let manifest = package.join("Cargo.toml");
    let manifest = std::fs::read_to_string(&manifest)
        .map_err(|error| format!("{}: {error}", manifest.display()))?;
    let named = |line: &str| {
        Some(
            line.strip_prefix("rust-version = \"")?
                .trim_end_matches('"')
                .to_owned(),
        )
    };
    let oldest = manifest
        .lines()
        .find_map(named)
        .ok_or("the package names no rust-version")?;
    let install = format!("toolchain install {oldest} --profile minimal --no-self-update");
    let installed = match find("rustup") {
        Some(rustup) => run_for(Command::new(rustup).args(words(&install)), RUSTUP_LIMIT),
        None => Err("there is no rustup".to_owned()),
    };
    if let Err(reason) = installed {
        println!(
            "SKIPPED: the library was NOT built with Rust {oldest}, which it promises: {reason}"
        );
        return Ok(());
    }
    let folder = std::env::temp_dir().join(format!("preslide-package-{}", std::process::id()));
    let told = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(folder.join("src")).map_err(told)?;
    std::fs::write(folder.join("src/lib.rs"), "").map_err(told)?;
    let built = [true, false].into_iter().try_for_each(|features| {
        let project = format!(
            "[package]\nname = \"stranger\"\nedition = \"2024\"\nrust-version = \"{oldest}\"\n\n[workspace]\n\n\
             [dependencies]\npreslide = {{ path = {package:?}, default-features = {features} }}\n"
        );
        std::fs::write(folder.join("Cargo.toml"), project).map_err(told)?;
        let mut build = Command::new("cargo");
        build.arg(format!("+{oldest}")).arg("check").current_dir(&folder);
        // The running cargo's own choice of a compiler.
        build.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO_TARGET_DIR");
        run(&mut build)
    });
    std::fs::remove_dir_all(&folder).map_err(told)?;
    built
}
