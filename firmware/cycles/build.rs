//! Links for QEMU's mps2-an386 or for the simulated Hazard3, and builds the C peers with the core's gcc.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The C compiler for a core.
struct Compiler {
    prefix: &'static str,
    cpu: &'static [&'static str],
    /// For linking with its libraries.
    libraries: &'static [&'static str],
}

const CORTEX_M4F: Compiler = Compiler {
    prefix: "arm-none-eabi",
    cpu: &[
        "-mcpu=cortex-m4",
        "-mthumb",
        "-mfloat-abi=hard",
        "-mfpu=fpv4-sp-d16",
    ],
    libraries: &[
        "-mcpu=cortex-m4",
        "-mthumb",
        "-mfloat-abi=hard",
        "-mfpu=fpv4-sp-d16",
    ],
};

const CORTEX_M0PLUS: Compiler = Compiler {
    prefix: "arm-none-eabi",
    cpu: &["-mcpu=cortex-m0plus", "-mthumb", "-mfloat-abi=soft"],
    libraries: &["-mcpu=cortex-m0plus", "-mthumb", "-mfloat-abi=soft"],
};

/// Debian's libraries are built for no bit manipulation.
const HAZARD3: Compiler = Compiler {
    prefix: "riscv64-unknown-elf",
    cpu: &[
        "--specs=picolibc.specs",
        "-march=rv32imac_zba_zbb_zbs_zbkb",
        "-mabi=ilp32",
    ],
    libraries: &[
        "--specs=picolibc.specs",
        "-T/dev/null",
        "-Wl,--no-gc-sections",
        "-march=rv32imac",
        "-mabi=ilp32",
    ],
};

/// Kernel name, source in `peers`, and the compiler's arguments: `src/textbook.rs` calls them by these names.
const PEERS: &[(&str, &str, &[&str])] = &[
    (
        "textbook_float_O2",
        "gms.c",
        &["-O2", "-DREAL=float", "-DEXP=expf"],
    ),
    (
        "textbook_float_O3_fast",
        "gms.c",
        &["-O3", "-ffast-math", "-DREAL=float", "-DEXP=expf"],
    ),
    (
        "textbook_double_O2",
        "gms.c",
        &["-O2", "-DREAL=double", "-DEXP=exp"],
    ),
];

/// What `preslide export --lang c` wrote in `peers/exported`: `src/exported.rs` calls it.
const EXPORTED: [&str; 6] = [
    "gms_f32",
    "quasi_static_f32",
    "packed_f32",
    "count_gms_i16f16",
    "packed_i16f16",
    "slip_reserve_i16f16",
];

/// Of every peer.
const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-ffunction-sections"];

fn main() -> Result<(), String> {
    let crate_folder = env_path("CARGO_MANIFEST_DIR")?;
    let out = env_path("OUT_DIR")?;
    if std::env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("riscv32") {
        let script = crate_folder.join("hazard3.x");
        println!("cargo:rustc-link-arg=-T{}", script.display());
        println!("cargo:rerun-if-changed=hazard3.x");
        return build_peers(&HAZARD3, &crate_folder, &out);
    }
    let is_board = std::env::var_os("CARGO_FEATURE_BOARD").is_some();
    let memory = crate_folder.join(if is_board { "board" } else { "" });
    println!("cargo:rustc-link-search={}", memory.display());
    println!("cargo:rerun-if-changed=board/memory.x");
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=memory.x");
    let is_m0plus = std::env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv6m"));
    let compiler = if is_m0plus {
        &CORTEX_M0PLUS
    } else {
        &CORTEX_M4F
    };
    build_peers(compiler, &crate_folder, &out)
}

/// Every peer at every measured N.
fn build_peers(compiler: &Compiler, crate_folder: &Path, out: &Path) -> Result<(), String> {
    println!("cargo:rerun-if-changed=peers");
    let mut objects = Vec::new();
    let mut names = Vec::new();
    for (kernel, source, arguments) in PEERS {
        let source = crate_folder.join("peers").join(source);
        for n in [1, 2, 3, 4, 6, 8, 10] {
            let name = format!("cycles__{kernel}__{n}");
            let object = out.join(format!("{name}.o"));
            let mut gcc = compiler.gcc();
            gcc.args(compiler.cpu).args(*arguments);
            gcc.arg("-std=c11").args(STRICT);
            gcc.args([format!("-DN={n}"), format!("-DSTEP={name}")]);
            run(gcc.arg("-c").arg(&source).arg("-o").arg(&object))?;
            objects.push(object);
            names.push(name);
        }
    }
    for name in EXPORTED {
        let peers = crate_folder.join("peers");
        let step = format!("cycles__exported_c_{name}__6");
        let object = out.join(format!("{step}.o"));
        let mut gcc = compiler.gcc();
        gcc.args(compiler.cpu)
            .args(["-std=c99", "-O2", "-fwhole-program"])
            .args(STRICT);
        let number = match name.ends_with("f32") {
            true => "float",
            false => "int32_t",
        };
        gcc.args([format!("-DNAME={name}"), format!("-DSTEP={step}")]);
        gcc.arg(format!("-DNUMBER={number}"));
        gcc.arg("-include")
            .arg(peers.join(format!("exported/{name}.c")));
        gcc.arg("-c").arg(peers.join("exported.c"));
        run(gcc.arg("-o").arg(&object))?;
        objects.push(object);
        names.extend([step, format!("{name}_rest"), format!("{name}_bytes")]);
    }
    link_with_own_library(compiler, &objects, &names, out)
}

/// One object with gcc's and newlib's routines inside and only the peers visible: C's exponential and software
/// `double` are then C's own, not the ones that Rust links for itself.
fn link_with_own_library(
    compiler: &Compiler,
    objects: &[PathBuf],
    names: &[String],
    out: &Path,
) -> Result<(), String> {
    let whole = out.join("peers.o");
    let mut gcc = compiler.gcc();
    gcc.args(compiler.libraries)
        .args(["-r", "-nostdlib", "-o"])
        .arg(&whole)
        .args(objects);
    run(gcc.args([
        "-Wl,--start-group",
        "-lm",
        "-lc",
        "-lgcc",
        "-Wl,--end-group",
    ]))?;
    let mut objcopy = Command::new(format!("{}-objcopy", compiler.prefix));
    objcopy.args(
        names
            .iter()
            .map(|name| format!("--keep-global-symbol={name}")),
    );
    run(objcopy.arg(&whole))?;
    println!("cargo:rustc-link-arg={}", whole.display());
    Ok(())
}

impl Compiler {
    fn gcc(&self) -> Command {
        Command::new(format!("{}-gcc", self.prefix))
    }
}

fn env_path(name: &str) -> Result<PathBuf, String> {
    std::env::var_os(name)
        .map(PathBuf::from)
        .ok_or_else(|| format!("cargo did not set {name}"))
}

fn run(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().to_string_lossy().into_owned();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?} failed ({status})")),
        Err(error) => Err(format!(
            "{program} did not start ({error}); run `cargo xtask cycles`, which installs it, or install the Debian \
             packages gcc-arm-none-eabi and libnewlib-arm-none-eabi (for Hazard3 gcc-riscv64-unknown-elf and \
             picolibc-riscv64-unknown-elf)"
        )),
    }
}
