//! Time from the start of the window to its first picture, on a virtual display. Xvfb keeps the screen in a file, which is read
//! here without involving the window.

use super::{
    program::{Guarded, Patience, Program, RunError, Running},
    xwd::Xwd,
};
use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// The display server.
const XVFB: &str = "Xvfb";

/// The screen, as large as the window at first start.
const SCREEN: &str = "1440x900x24";

/// The server's screen file in its folder.
const SCREEN_FILE: &str = "Xvfb_screen0";

/// Interval between looks at the screen.
const POLL: Duration = Duration::from_millis(20);

/// Time limit for the server's start.
const SERVER_LIMIT: Duration = Duration::from_secs(10);

/// Side in pixels of the examined square in the middle of the window.
const SIDE: usize = 300;

/// Most colors without a picture. Panels are flat, and text has some dozens at its edges.
const MOST_COLORS_WITHOUT: usize = 512;

/// A virtual display.
pub struct Display {
    _server: Guarded,
    folder: TempDir,
    number: String,
}

impl Display {
    /// Starts the server; `None` if it is not installed.
    ///
    /// # Errors
    /// The server does not start.
    pub fn start() -> io::Result<Option<Self>> {
        let folder = tempfile::tempdir()?;
        let said = folder.path().join("display");
        let mut command = Command::new(XVFB);
        command.args(["-displayfd", "1", "-screen", "0", SCREEN, "-nolisten", "tcp", "-fbdir"]).arg(folder.path());
        command.stdout(File::create(&said)?).stderr(Stdio::null());
        let mut server = match Guarded::start(&mut command) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            started => started?,
        };
        let number = number_of(&mut server, &said)?;
        Ok(Some(Self { _server: server, folder, number }))
    }

    /// Time from the start of a program's window on a dataset to its picture; then the program ends. Use a display once.
    ///
    /// # Errors
    /// The window closes, or shows nothing in time.
    pub fn first_picture(self, program: &Program, dataset: &Path, patience: Patience) -> Result<Duration, RunError> {
        let home = tempfile::tempdir().map_err(RunError::Start)?;
        let words = ["edit".as_ref(), dataset.as_os_str(), "--backend".as_ref(), "cpu".as_ref()];
        let mut command = program.command(&words);
        command.env("LAPIDARY_HOME", home.path()).env("DISPLAY", format!(":{}", self.number));
        Running::start(command)?.until(POLL, patience, &|| self.shows_picture())
    }

    fn shows_picture(&self) -> bool {
        let screen = fs::read(self.screen()).unwrap_or_default();
        Xwd::read(&screen).is_some_and(|screen| screen.colors_in_middle(SIDE) > MOST_COLORS_WITHOUT)
    }

    fn screen(&self) -> PathBuf {
        self.folder.path().join(SCREEN_FILE)
    }
}

/// The display number that the server prints after its start.
fn number_of(server: &mut Guarded, said: &Path) -> io::Result<String> {
    let start = Instant::now();
    while start.elapsed() < SERVER_LIMIT && server.ended()?.is_none() {
        let text = fs::read_to_string(said)?;
        if text.ends_with('\n') {
            return Ok(text.trim().to_owned());
        }
        sleep(POLL);
    }
    Err(io::Error::other("Xvfb does not start a display"))
}
