//! Running other programs: shown before they start, never without an end.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use wait4::{ResUse, Wait4};

/// The folder of the root `Cargo.toml`.
pub fn root() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}

/// Where cargo, started in `folder`, puts what it builds: `target` there, unless CARGO_TARGET_DIR says otherwise. Cargo takes a path that is not
/// absolute from where it is started.
pub fn target_of(folder: &Path) -> PathBuf {
    let chosen = ["CARGO_TARGET_DIR", "CARGO_BUILD_TARGET_DIR"]
        .into_iter()
        .find_map(|name| std::env::var_os(name).filter(|dir| !dir.is_empty()));
    folder.join(chosen.unwrap_or_else(|| "target".into()))
}

/// A program that cargo has built in the root workspace with the release profile: `preslide`, `examples/drive`.
pub fn released(program: &str) -> PathBuf {
    target_of(root()).join("release").join(program)
}

/// `cargo` of the running toolchain, started at the workspace root.
pub fn cargo(arguments: &[&str]) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// The words of a command line that quotes none.
pub fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// What builds for a microcontroller whatever its user's environment says: in increments code is cut otherwise, costs other cycles, and calls what
/// an interrupt must not reach.
pub const IN_ONE_PIECE: (&str, &str) = ("CARGO_INCREMENTAL", "0");

/// Builds programs and examples of the root workspace as its tests are built: of one package alone, cargo resolves other features, and
/// compiles the host and all that stands on it again.
pub fn build_as_tests(what: &[&str]) -> Result<(), String> {
    let workspace = ["build", "--release", "--workspace"];
    run(cargo(&workspace)
        .args(["--exclude", "preslide-bench"])
        .args(what))
}

/// `git`, started at the workspace root.
pub fn git(arguments: &[&str]) -> Command {
    let mut command = Command::new("git");
    command.args(arguments).current_dir(root());
    command
}

/// Where `program` stands on the search path.
pub fn find(program: &str) -> Option<PathBuf> {
    std::env::split_paths(&std::env::var_os("PATH")?)
        .map(|folder| folder.join(program))
        .find(|path| path.is_file())
}

/// The command as one would type it, with the program's folder left out.
fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let program = program.file_name().unwrap_or(program.as_os_str());
    let mut words = Vec::new();
    for (name, value) in command.get_envs() {
        let value = value.unwrap_or_default().to_string_lossy();
        words.push(format!("{}='{value}'", name.to_string_lossy()));
    }
    for word in std::iter::once(program).chain(command.get_args()) {
        words.push(word.to_string_lossy().into_owned());
    }
    words.join(" ")
}

/// Shows the command, runs it with this process's output, prints how long it took, and reports failure with the command in it.
pub fn run(command: &mut Command) -> Result<(), String> {
    let line = shown(command);
    println!("$ {line}");
    let start = Instant::now();
    let child = command.stdin(Stdio::null()).spawn();
    let ended = child.and_then(Wait4::wait4);
    succeeded(&line, start, ended)
}

/// The command's end as a result; prints how long it took, and how long it kept a core busy: a step's minutes are those of its commands.
fn succeeded(line: &str, start: Instant, ended: std::io::Result<ResUse>) -> Result<(), String> {
    let ended = ended.map_err(|error| format!("`{line}` did not run: {error}"))?;
    let busy = ended.rusage.utime + ended.rusage.stime;
    let [time, busy] = [start.elapsed(), busy].map(|time| time.as_secs_f64());
    println!("  ({time:.1} s, {busy:.1} s of a core)");
    if ended.status.success() {
        Ok(())
    } else {
        Err(format!("`{line}` failed ({})", ended.status))
    }
}

/// As `run`, and counts the lines on standard error that begin with `word`, which are shown as the others are.
pub fn run_counting(command: &mut Command, word: &str) -> Result<usize, String> {
    let line = shown(command);
    println!("$ {line}");
    let start = Instant::now();
    let started = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = started.map_err(|error| format!("`{line}` did not start: {error}"))?;
    let mut count = 0;
    if let Some(said) = child.stderr.take() {
        for said in BufReader::new(said).lines().map_while(Result::ok) {
            count += usize::from(said.starts_with(word));
            eprintln!("{said}");
        }
    }
    succeeded(&line, start, child.wait4())?;
    Ok(count)
}

/// As `run`, but ends the program when `limit` has passed.
pub fn run_for(command: &mut Command, limit: Duration) -> Result<(), String> {
    let line = shown(command);
    println!("$ {line}    (at most {} s)", limit.as_secs());
    let mut child = command
        .spawn()
        .map_err(|error| format!("`{line}` did not start: {error}"))?;
    let start = Instant::now();
    loop {
        match child.try_wait4().transpose() {
            Some(ended) => return succeeded(&line, start, ended),
            None if start.elapsed() < limit => std::thread::sleep(Duration::from_millis(20)),
            None => {
                // It may have ended in this moment; either way it is gone after the wait.
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("`{line}` did not end within {} s", limit.as_secs()));
            }
        }
    }
}

/// Standard output and standard error of a command that must succeed before `limit` has passed.
pub fn output_for(command: &mut Command, limit: Duration) -> Result<(String, String), String> {
    let folder = std::env::temp_dir().join(format!("preslide-output-{}", std::process::id()));
    let told = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(told)?;
    // Files take any amount while nobody reads.
    let (out, err) = (folder.join("out"), folder.join("err"));
    let file = |path| std::fs::File::create(path).map_err(told);
    let result = run_for(command.stdout(file(&out)?).stderr(file(&err)?), limit);
    let texts = [out, err].map(|path| std::fs::read(path).unwrap_or_default());
    let [out, err] = texts.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    // What stays is in the way of nothing.
    let _ = std::fs::remove_dir_all(&folder);
    result.map_err(|reason| format!("{reason}: {}", err.trim()))?;
    Ok((out, err))
}

/// Standard output of a command that must succeed.
pub fn output(command: &mut Command) -> Result<String, String> {
    let line = shown(command);
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("`{line}` did not start: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        let reason = String::from_utf8_lossy(&output.stderr).into_owned();
        Err(format!(
            "`{line}` failed ({}): {}",
            output.status,
            reason.trim()
        ))
    }
}

/// Standard output of a command that reads `input` and must succeed.
pub fn output_of(
    command: &mut Command,
    input: &(impl AsRef<[u8]> + ?Sized),
) -> Result<String, String> {
    let input = input.as_ref();
    let line = shown(command);
    let told = |error: std::io::Error| format!("`{line}`: {error}");
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = piped.spawn().map_err(told)?;
    let output = std::thread::scope(|scope| {
        // It may answer before it has read everything.
        if let Some(mut stdin) = child.stdin.take() {
            scope.spawn(move || stdin.write_all(input));
        }
        child.wait_with_output()
    });
    let output = output.map_err(told)?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("`{line}` failed ({})", output.status))
    }
}

/// A port of this machine that was free a moment ago; the program that is started binds it next.
pub fn free_port() -> Result<String, String> {
    let listener = std::net::TcpListener::bind("127.0.0.1:0");
    let address = listener.and_then(|listener| listener.local_addr());
    let address = address.map_err(|error| format!("no free port on 127.0.0.1: {error}"))?;
    Ok(address.port().to_string())
}
