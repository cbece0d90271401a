//! The library as a user gets it: the package, published but for the upload, and built by another project.

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use preslide_tools::process::{
    cargo, command, find, output, root, run, run_for, target_of, with_folder,
};
use preslide_tools::thumb::RUSTUP_LIMIT;

/// What is wrong with the package, if anything is.
pub fn check() -> Result<()> {
    list()?;
    // A developer's tree is usually dirty; what is packed is the same.
    run(&mut cargo(
        "publish --dry-run --allow-dirty --package preslide",
    ))?;
    oldest()
}

/// What the package holds besides `src/`: the first three are ours, and cargo makes the others.
const BESIDE: [&str; 7] = [
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "build.rs",
    "Cargo.toml",
    "Cargo.toml.orig",
    "Cargo.lock",
    ".cargo_vcs_info.json",
];

/// The package holds the library and nothing else.
fn list() -> Result<()> {
    let list = output(&mut cargo(
        "package --list --allow-dirty --package preslide",
    ))?;
    let files: Vec<&str> = list.lines().collect();
    let belongs = |path: &str| path.starts_with("src/") || BESIDE.contains(&path);
    if let Some(stranger) = files.iter().find(|path| !belongs(path)) {
        bail!("the package would hold {stranger}; narrow `include` in the root Cargo.toml");
    }
    for path in ["src/lib.rs", "src/README.md", BESIDE[0], BESIDE[1]] {
        ensure!(
            files.contains(&path),
            "the package lacks {path}; see `include` in the root Cargo.toml"
        );
    }
    println!("{} files, all of them the library's", files.len());
    Ok(())
}

/// A new project that depends on the package builds it with the compiler that the package names, with and without its features; cargo
/// chooses dependencies that this compiler can build, as it does for everyone.
fn oldest() -> Result<()> {
    let package = target_of(root()).join(concat!("package/preslide-", env!("CARGO_PKG_VERSION")));
    let manifest = fs::read_to_string(package.join("Cargo.toml"))?;
    let oldest = manifest
        .lines()
        .find_map(|line| line.strip_prefix("rust-version = \"")?.strip_suffix('"'))
        .context("the package names no rust-version")?;
    let install = format!("rustup toolchain install {oldest} --profile minimal --no-self-update");
    let installed = match find("rustup") {
        Some(_) => run_for(&mut command(&install), RUSTUP_LIMIT),
        None => Err(anyhow::anyhow!("there is no rustup")),
    };
    if let Err(reason) = installed {
        println!(
            "SKIPPED: the library was NOT built with Rust {oldest}, which it promises: {reason:#}"
        );
        return Ok(());
    }
    with_folder("package", |folder| {
        fs::create_dir_all(folder.join("src"))?;
        fs::write(folder.join("src/lib.rs"), "")?;
        [true, false].into_iter().try_for_each(|features| {
            let project = format!(
                "[package]\nname = \"stranger\"\nedition = \"2024\"\nrust-version = \"{oldest}\"\n\n[workspace]\n\n\
                 [dependencies]\npreslide = {{ path = {package:?}, default-features = {features} }}\n"
            );
            fs::write(folder.join("Cargo.toml"), project)?;
            let mut check = command(&format!("cargo +{oldest} check"));
            // The running cargo's own choice of a compiler.
            check.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO_TARGET_DIR");
            run(check.current_dir(folder))
        })
    })
}
