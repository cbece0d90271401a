// Part of each board's build script: the friction model that `preslide export` wrote, where PRESLIDE_MODEL names its file.

/// Tells the compiler that there is such a model, and where, by a path that does not depend on the folder of the build.
fn exported_model() {
    println!("cargo:rustc-check-cfg=cfg(exported_model)");
    println!("cargo:rerun-if-env-changed=PRESLIDE_MODEL");
    println!("cargo:rerun-if-changed=../exported_model.rs");
    let Ok(named) = std::env::var("PRESLIDE_MODEL") else {
        return;
    };
    match std::fs::canonicalize(&named) {
        Ok(path) => {
            println!("cargo:rustc-cfg=exported_model");
            println!("cargo:rustc-env=PRESLIDE_MODEL={}", path.display());
            println!("cargo:rerun-if-changed={}", path.display());
        }
        Err(error) => println!(
            "cargo::error=PRESLIDE_MODEL={named}: {error}; give the full path of the file that `preslide export` wrote"
        ),
    }
}
