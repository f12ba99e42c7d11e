//! Autosave and recovery: the session of a changed document is saved separately, and found again after a crash.
//!
//! Each running program has one file, named after its process with a random part. It is removed when the document agrees
//! with its file and on a clean exit. So a file whose process has ended contains unsaved work.

use super::{
    Document, History,
    relative::absolute,
    session::{AUTOSAVE_KEY, EXTENSION, SessionError, Unknown, read_json, save_for_recovery},
};
use serde::{Deserialize, Serialize};
use std::{
    hash::{BuildHasher, Hasher, RandomState},
    io,
    path::{Path, PathBuf},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

const PREFIX: &str = "autosave-";

/// Where processes cannot be looked up, a running one touches its file at this interval,
const HEARTBEAT: Duration = Duration::from_secs(20);

/// and one that has not for this long counts as ended.
const GONE_AFTER: Duration = Duration::from_secs(60);

/// Saves the session of a changed document separately now and then.
#[derive(Debug)]
pub struct Autosave {
    file: PathBuf,
    interval: Duration,
    /// Time to write the changes so far.
    due: Option<Instant>,
    /// The revision that the file holds, and when it was last written or touched.
    written: Option<(u64, Instant)>,
}

/// A process, identified by its number and the time at which it began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Process {
    id: u32,
    /// In clock ticks after the boot on Linux, else in milliseconds since 1970.
    start: u64,
}

/// Metadata of an autosave.
#[derive(Serialize, Deserialize)]
struct Note {
    /// The session file of the document, if it had one.
    session: Option<String>,
    /// Seconds since 1970.
    saved_at: u64,
}

/// Work of a process that ended without saving it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// The autosave, to be opened by [`super::session::load`].
    pub file: PathBuf,
    /// The session file of the document, if it had one.
    pub session_path: Option<PathBuf>,
    /// The scene file of the document, or else its dataset, as written.
    pub subject: Option<PathBuf>,
    /// When it was written.
    pub saved_at: SystemTime,
}

impl Autosave {
    /// Writes below the state folder `folder`, at most `interval` after a change and not more often.
    pub fn new(folder: &Path, interval: Duration) -> Self {
        let Process { id, start } = Process::this();
        // Nobody can guess the name: a file there is ours.
        let random = RandomState::new().build_hasher().finish();
        let file = folder.join(format!("{PREFIX}{id}-{start}-{random:016x}.{EXTENSION}"));
        Self { file, interval, due: None, written: None }
    }

    /// Must be called every frame, or at least every few seconds while the document is changed. Returns whether the
    /// session was written. After a failure the next attempt follows an interval later.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn tick(
        &mut self,
        now: Instant,
        document: &Document,
        history: &History,
        kept: &Unknown,
        session_path: Option<&Path>,
    ) -> Result<bool, SessionError> {
        if !history.is_modified() {
            return self.finish().map(|()| false);
        }
        if self.written.is_some_and(|(revision, _)| revision == history.revision()) {
            self.beat(now);
            return Ok(false);
        }
        if now < *self.due.get_or_insert(now + self.interval) {
            self.beat(now);
            return Ok(false);
        }
        self.due = Some(now + self.interval);
        self.write(document, kept, session_path)?;
        self.due = None;
        self.written = Some((history.revision(), now));
        Ok(true)
    }

    /// Removes the file: the program ends, or another document is opened.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn finish(&mut self) -> Result<(), SessionError> {
        self.due = None;
        if self.written.take().is_none() {
            return Ok(());
        }
        remove(&self.file).map_err(|source| SessionError::Io { action: "remove", path: self.file.clone(), source })
    }

    fn write(&self, document: &Document, kept: &Unknown, session_path: Option<&Path>) -> Result<(), SessionError> {
        let folder = self.file.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|source| SessionError::Io {
            action: "write",
            path: folder.into(),
            source,
        })?;
        let note = Note {
            session: session_path.map(|path| absolute(path).to_string_lossy().into_owned()),
            saved_at: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs(),
        };
        let note = serde_json::to_value(note).expect("a note is text and numbers");
        save_for_recovery(document, kept, note, &self.file)
    }

    /// Marks this process as alive for others. If that fails, they offer its work for recovery, which is harmless.
    fn beat(&mut self, now: Instant) {
        if let Some((_, at)) = &mut self.written
            && now.saturating_duration_since(*at) >= HEARTBEAT
        {
            *at = now;
            let touched = std::fs::File::options().write(true).open(&self.file);
            let _ = touched.and_then(|file| file.set_modified(SystemTime::now()));
        }
    }
}

/// Autosaves in the state folder whose processes have ended, the newest first. Unreadable ones stay there.
pub fn recoverable(folder: &Path) -> Vec<Recovery> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut found: Vec<Recovery> = entries.flatten().filter_map(|entry| Recovery::of(entry.path())).collect();
    found.sort_by_key(|recovery| std::cmp::Reverse(recovery.saved_at));
    found
}

impl Recovery {
    fn of(file: PathBuf) -> Option<Self> {
        if Process::of_file(&file)?.is_running(&file) {
            return None;
        }
        let mut session = read_json(&file).ok()?;
        let note: Note = serde_json::from_value(session.remove(AUTOSAVE_KEY)?).ok()?;
        let named = |key: &str| session.get(key)?.as_str().map(PathBuf::from);
        let subject = named("scene").or_else(|| named("dataset"));
        let saved_at = UNIX_EPOCH.checked_add(Duration::from_secs(note.saved_at))?;
        Some(Self { file, session_path: note.session.map(Into::into), subject, saved_at })
    }

    /// Removes the autosave.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn discard(self) -> io::Result<()> {
        remove(&self.file)
    }
}

impl Process {
    fn this() -> Self {
        let id = std::process::id();
        let now = || SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as u64;
        Self { id, start: start_of(id).unwrap_or_else(now) }
    }

    /// The process that an autosave is named after.
    fn of_file(file: &Path) -> Option<Self> {
        let is_session = file.extension().is_some_and(|e| e == EXTENSION);
        let (id, start) = file.file_stem()?.to_str()?.strip_prefix(PREFIX)?.split_once('-')?;
        let start = start.split_once('-').map_or(start, |(start, _)| start);
        is_session.then_some(Self { id: id.parse().ok()?, start: start.parse().ok()? })
    }

    fn is_running(self, file: &Path) -> bool {
        let can_look_up = start_of(std::process::id()).is_some();
        if can_look_up { start_of(self.id) == Some(self.start) } else { self == Self::this() || was_touched(file) }
    }
}

/// When a running process began, in clock ticks after the boot. `None` if there is no such process, it has ended, or the
/// system is not Linux.
fn start_of(id: u32) -> Option<u64> {
    start_in(&std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?)
}

/// The 22nd field of a process's status; the second is a name in parentheses. `None` for a process that has ended but is still
/// listed: it has a flag while its memory is freed, which may take a second, and is a zombie until its parent has noticed.
fn start_in(status: &str) -> Option<u64> {
    const EXITING: u64 = 4;
    let fields: Vec<&str> = status.rsplit_once(')')?.1.split_whitespace().collect();
    let (state, flags, start) = (fields.first()?, fields.get(6)?, fields.get(19)?);
    let has_ended = ["Z", "X", "x"].contains(state) || flags.parse::<u64>().ok()? & EXITING != 0;
    start.parse().ok().filter(|_| !has_ended)
}

fn was_touched(file: &Path) -> bool {
    let modified = std::fs::metadata(file).and_then(|m| m.modified());
    // A time in the future counts as now.
    modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age < GONE_AFTER))
}

fn remove(file: &Path) -> io::Result<()> {
    std::fs::remove_file(file).or_else(|e| if e.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(e) })
}

#[cfg(test)]
mod tests;
