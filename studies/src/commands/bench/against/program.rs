//! A measured program: its options, and runs as a child process with a time limit.

use anyhow::{Context, Result, anyhow, bail};
use std::{
    collections::BTreeSet,
    ffi::OsStr,
    fs::File,
    io::{self, Read, Seek},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};
use tempfile::TempDir;
use thiserror::Error;

/// Polling interval of a child; a bake takes a thousand times as long.
const POLL: Duration = Duration::from_millis(5);

/// Time limit for a program to list its options.
const ANSWER_LIMIT: Duration = Duration::from_secs(10);

/// Most characters of a program's last output in a remark.
const MOST_LAST_WORDS: usize = 120;

/// Variables that name a display; a child has none, or our virtual one.
const DISPLAYS: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"];

/// Why a run of a program has no figures.
#[derive(Debug, Error)]
pub enum RunError {
    /// The system cannot start it.
    #[error("cannot be started: {0}")]
    Start(io::Error),
    /// It ended with an error.
    #[error("failed ({status}): {last_words}")]
    Failed {
        /// Its exit code or signal.
        status: ExitStatus,
        /// Last line on standard error.
        last_words: String,
    },
    /// It reached the time limit.
    #[error("was stopped after {} s", .0.as_secs_f64())]
    Hung(Duration),
    /// Xvfb is missing.
    #[error("has no display")]
    NoDisplay,
    /// It was stopped by an interruption.
    #[error("was stopped by Ctrl-C")]
    Interrupted,
}

/// Output and duration of a run.
#[derive(Debug)]
pub struct Finished {
    /// Standard output.
    pub text: String,
    /// Duration.
    pub time: Duration,
}

/// When to stop a run.
#[derive(Clone, Copy)]
pub struct Patience<'a> {
    /// Time limit.
    pub limit: Duration,
    /// Stops the run when true.
    pub stops: &'a dyn Fn() -> bool,
}

/// A child process that ends with its owner.
pub struct Guarded(Child);

impl Guarded {
    /// Starts it.
    ///
    /// # Errors
    /// The system's error.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        command.stdin(Stdio::null()).spawn().map(Self)
    }

    /// Exit status, if it has ended.
    ///
    /// # Errors
    /// The system's error.
    pub fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        // Both fail only if it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A child whose output goes to files, which never fill up; a pipe would have to be drained meanwhile.
pub struct Running {
    child: Guarded,
    out: File,
    err: File,
    start: Instant,
}

impl Running {
    /// Starts it.
    ///
    /// # Errors
    /// The system's error.
    pub fn start(mut command: Command) -> Result<Self, RunError> {
        let mut open = || {
            let [out, err] = [tempfile::tempfile()?, tempfile::tempfile()?];
            command.stdout(out.try_clone()?).stderr(err.try_clone()?);
            let start = Instant::now();
            Ok(Self { child: Guarded::start(&mut command)?, out, err, start })
        };
        open().map_err(RunError::Start)
    }

    /// Time from start to end.
    ///
    /// # Errors
    /// See [`RunError`].
    pub fn finish(&mut self, patience: Patience) -> Result<Duration, RunError> {
        loop {
            let ended = self.child.ended().map_err(RunError::Start)?;
            let time = self.start.elapsed();
            match ended {
                Some(status) if status.success() => return Ok(time),
                Some(status) => return Err(self.failed(status)),
                None => self.pause(POLL, patience)?,
            }
        }
    }

    /// Time from start until `is_reached`, checked every `poll`.
    ///
    /// # Errors
    /// See [`RunError`]; ending earlier counts as failure.
    pub fn until(
        &mut self,
        poll: Duration,
        patience: Patience,
        is_reached: &dyn Fn() -> bool,
    ) -> Result<Duration, RunError> {
        loop {
            if is_reached() {
                return Ok(self.start.elapsed());
            }
            if let Some(status) = self.child.ended().map_err(RunError::Start)? {
                return Err(self.failed(status));
            }
            self.pause(poll, patience)?;
        }
    }

    fn pause(&self, poll: Duration, Patience { limit, stops }: Patience) -> Result<(), RunError> {
        if stops() {
            return Err(RunError::Interrupted);
        }
        if self.start.elapsed() > limit {
            return Err(RunError::Hung(limit));
        }
        sleep(poll);
        Ok(())
    }

    fn failed(&mut self, status: ExitStatus) -> RunError {
        RunError::Failed { status, last_words: last_words(&text_of(&mut self.err)) }
    }
}

/// A program with the words of its help.
#[derive(Debug)]
pub struct Program {
    /// Absolute, so that a bare name is not searched for elsewhere.
    pub path: PathBuf,
    /// Version text.
    pub version: String,
    /// Words of `bench --help`: options and their values.
    words: BTreeSet<String>,
    /// An empty home folder.
    home: TempDir,
}

impl Program {
    /// Queries a program, so that a wrong file is reported before any measurement.
    ///
    /// # Errors
    /// A file that cannot be started, or that lacks this program's `bench`.
    pub fn open(path: &Path) -> Result<Self> {
        let path = std::path::absolute(path)?;
        let home =
            tempfile::tempdir().context("cannot write to the folder for temporary files; check its free space")?;
        let mut program = Self { path, version: String::new(), words: BTreeSet::new(), home };
        let patience = Patience { limit: ANSWER_LIMIT, stops: &|| false };
        let ask = |words: &[&str]| program.run(words, patience);
        let asked = ask(&["bench", "--help"]).and_then(|help| Ok((help.text, ask(&["--version"])?.text)));
        let place = program.path.display();
        let (help, version) =
            asked.map_err(|error| anyhow!("the program {error}; name a program of lapidary ({place})"))?;
        program.words = words_in(&help);
        program.version = version.trim().into();
        if !program.has("--json") {
            bail!("the program has no `bench --json`; name a program of lapidary ({})", program.path.display());
        }
        Ok(program)
    }

    /// Whether the help of `bench` names an option, or a value of one.
    pub fn has(&self, word: &str) -> bool {
        self.words.contains(word)
    }

    /// A command without the user's files and without a display.
    pub fn command(&self, words: &[impl AsRef<OsStr>]) -> Command {
        let mut command = Command::new(&self.path);
        command.args(words).env("LAPIDARY_HOME", self.home.path());
        for variable in DISPLAYS {
            command.env_remove(variable);
        }
        command
    }

    /// Runs it to completion.
    ///
    /// # Errors
    /// See [`RunError`].
    pub fn run(&self, words: &[impl AsRef<OsStr>], patience: Patience) -> Result<Finished, RunError> {
        let mut running = Running::start(self.command(words))?;
        let time = running.finish(patience)?;
        Ok(Finished { text: text_of(&mut running.out), time })
    }
}

/// Text of an output file; empty if unreadable.
fn text_of(file: &mut File) -> String {
    let mut bytes = Vec::new();
    let _ = file.rewind().and_then(|()| file.read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

fn last_words(text: &str) -> String {
    let line = text.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it says nothing");
    line.strip_prefix("error: ").unwrap_or(line).chars().take(MOST_LAST_WORDS).collect()
}

/// All words of a text: options such as `--illum-cuts`, and values such as `cuts+gloss`.
fn words_in(help: &str) -> BTreeSet<String> {
    help.split(|c: char| !(c.is_ascii_alphanumeric() || "-+".contains(c))).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_values_are_whole_words_of_the_help() {
        let words = words_in("  --sun <SUN>  with --frames\n--illum-cuts=1 [possible values: cuts, cuts+gloss]");
        for word in ["--sun", "--frames", "--illum-cuts", "cuts", "cuts+gloss"] {
            assert!(words.contains(word), "{word} is not in {words:?}");
        }
        for part in ["--illum", "gloss", "sun"] {
            assert!(!words.contains(part), "{part} is in {words:?}");
        }
    }

    #[test]
    fn the_last_line_that_says_something_is_told_in_few_words() {
        assert_eq!(last_words("warning: a\nerror: no adapter (a.cuts)\n \n"), "no adapter (a.cuts)");
        assert_eq!(last_words(""), "it says nothing");
        assert_eq!(last_words(&"a".repeat(1000)).len(), MOST_LAST_WORDS);
    }
}
