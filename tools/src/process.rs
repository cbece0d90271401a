//! Running other programs: shown before they start, never without an end.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use wait4::{ResUse, Wait4};

/// The folder of the root `Cargo.toml`.
pub fn root() -> &'static Path {
    let tools = Path::new(env!("CARGO_MANIFEST_DIR"));
    tools.parent().unwrap_or(tools)
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

/// A command as one types it, without quotation marks: the program and its first arguments.
pub fn command(line: &str) -> Command {
    let mut words = line.split_whitespace();
    let mut command = Command::new(words.next().unwrap_or_default());
    command.args(words);
    command
}

/// `cargo` of the running toolchain with the arguments in `line`, started at the workspace root.
pub fn cargo(line: &str) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut cargo = Command::new(program);
    cargo.args(line.split_whitespace()).current_dir(root());
    cargo
}

/// What builds for a microcontroller whatever its user's environment says: in increments code is cut otherwise, costs other cycles, and calls what
/// an interrupt must not reach.
pub const IN_ONE_PIECE: (&str, &str) = ("CARGO_INCREMENTAL", "0");

/// Builds programs and examples of the root workspace as its tests are built: of one package alone, cargo resolves other features, and
/// compiles the host and all that stands on it again.
pub fn build_as_tests(what: &str) -> Result<()> {
    let line = "build --release --workspace --exclude preslide-bench";
    run(cargo(line).args(what.split_whitespace()))
}

/// Where `program` stands on the search path.
pub fn find(program: &str) -> Option<PathBuf> {
    std::env::split_paths(&std::env::var_os("PATH")?)
        .map(|folder| folder.join(program))
        .find(|path| path.is_file())
}

/// Does something with a new folder of temporary files, which goes after it. What a failure leaves is there to be looked at.
pub fn with_folder<T>(what: &str, work: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    let name = format!("preslide-{what}-{}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    fs::create_dir_all(&folder)?;
    let done = work(&folder)?;
    fs::remove_dir_all(&folder)?;
    Ok(done)
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

/// A command that was shown before it started.
struct Shown {
    line: String,
    start: Instant,
}

/// Shows the command, with what is `said` of it, and starts it.
fn start(command: &mut Command, said: &str) -> Result<(Shown, Child)> {
    let line = shown(command);
    println!("$ {line}{said}");
    let start = Instant::now();
    let child = command.spawn();
    let child = child.with_context(|| format!("`{line}` did not start"))?;
    Ok((Shown { line, start }, child))
}

impl Shown {
    /// The command's end as a result; prints how long it took, and how long it kept a core busy: a step's minutes are those of its commands.
    fn ended(&self, used: std::io::Result<ResUse>) -> Result<()> {
        let line = &self.line;
        let used = used.with_context(|| format!("`{line}` did not run"))?;
        let busy = used.rusage.utime + used.rusage.stime;
        let [time, busy] = [self.start.elapsed(), busy].map(|time| time.as_secs_f64());
        println!("  ({time:.1} s, {busy:.1} s of a core)");
        ensure!(used.status.success(), "`{line}` failed ({})", used.status);
        Ok(())
    }
}

/// Shows the command, runs it with this process's output, prints how long it took, and reports failure with the command in it.
pub fn run(command: &mut Command) -> Result<()> {
    let (shown, child) = start(command.stdin(Stdio::null()), "")?;
    shown.ended(child.wait4())
}

/// As [`run`], and counts the lines on standard error that begin with `word`, which are shown as the others are.
pub fn run_counting(command: &mut Command, word: &str) -> Result<usize> {
    command.stdin(Stdio::null()).stderr(Stdio::piped());
    let (shown, mut child) = start(command, "")?;
    let mut count = 0;
    if let Some(said) = child.stderr.take() {
        for said in BufReader::new(said).lines().map_while(Result::ok) {
            count += usize::from(said.starts_with(word));
            eprintln!("{said}");
        }
    }
    shown.ended(child.wait4()).map(|()| count)
}

/// As [`run`], but ends the program when `limit` has passed.
pub fn run_for(command: &mut Command, limit: Duration) -> Result<()> {
    let seconds = limit.as_secs();
    let (shown, mut child) = start(command, &format!("    (at most {seconds} s)"))?;
    loop {
        match child.try_wait4().transpose() {
            Some(used) => return shown.ended(used),
            None if shown.start.elapsed() < limit => {
                std::thread::sleep(Duration::from_millis(20));
            }
            None => {
                // It may have ended in this moment; either way it is gone after the wait.
                let _ = child.kill();
                let _ = child.wait();
                bail!("`{}` did not end within {seconds} s", shown.line);
            }
        }
    }
}

/// Standard output and standard error of a command that must succeed before `limit` has passed.
pub fn output_for(command: &mut Command, limit: Duration) -> Result<(String, String)> {
    // Files take any amount while nobody reads.
    with_folder("output", |folder| {
        let [out, err] = ["out", "err"].map(|name| folder.join(name));
        command.stdout(fs::File::create(&out)?.into_file());
        command.stderr(fs::File::create(&err)?.into_file());
        let ended = run_for(command, limit);
        let texts = [out, err].map(|path| std::fs::read(path).unwrap_or_default());
        let [out, err] = texts.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        // Told here, so that nobody need look for the files.
        Ok(ended
            .with_context(|| err.trim().to_owned())
            .map(|()| (out, err)))
    })?
}

/// Standard output of a command that must succeed.
pub fn output(command: &mut Command) -> Result<String> {
    output_of(command, "")
}

/// Standard output of a command that reads `input` and must succeed.
pub fn output_of(command: &mut Command, input: impl AsRef<[u8]>) -> Result<String> {
    let line = shown(command);
    command.stdin(Stdio::piped());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn();
    let mut child = child.with_context(|| format!("`{line}` did not start"))?;
    let input = input.as_ref();
    let output = std::thread::scope(|scope| {
        // It may answer before it has read everything.
        if let Some(mut stdin) = child.stdin.take() {
            scope.spawn(move || stdin.write_all(input));
        }
        child.wait_with_output()
    })?;
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    ensure!(
        output.status.success(),
        "`{line}` failed ({}): {}",
        output.status,
        err.trim()
    );
    Ok(out.into_owned())
}

/// A port of this machine that was free a moment ago; the program that is started binds it next.
pub fn free_port() -> Result<String> {
    let listener = std::net::TcpListener::bind("127.0.0.1:0");
    let address = listener.and_then(|listener| listener.local_addr());
    let address = address.context("no free port on 127.0.0.1")?;
    Ok(address.port().to_string())
}
