//! One writer at a time, by a lock file beside an output.
//!
//! `OUTPUT.lock` is locked through the system, which frees the lock when its process ends in any way. A file left by a
//! killed process is stale, and is taken over. Its text names the holder.

use same_file::Handle;
use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    path::{Path, PathBuf},
    time::SystemTime,
};
use thiserror::Error;

/// Attempts to lock a file that others create and remove at the same time.
const MOST_TRIES: u32 = 100;

/// Why an output cannot be locked.
#[derive(Debug, Error)]
pub enum LockError {
    /// Another process is writing it.
    #[error("{holder} is writing the output; wait until it ends, stop it, or choose another output ({})", path.display())]
    Held {
        /// The output.
        path: PathBuf,
        /// Process, machine and time as in the lock.
        holder: String,
    },
    /// The file system reports an error.
    #[error("cannot lock the output: {source}; check the path, the permissions and the free space ({})", path.display())]
    Io {
        /// The output.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

/// The right to write an output, held until dropped.
#[derive(Debug)]
pub struct OutputLock {
    /// Locked while open.
    _file: File,
    path: PathBuf,
}

impl OutputLock {
    /// Path of an output's lock.
    pub fn path_of(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".lock");
        name.into()
    }

    /// Locks an output, which need not exist.
    ///
    /// # Errors
    /// [`LockError::Held`] if another process, or another part of this one, holds it.
    pub fn acquire(output: &Path) -> Result<Self, LockError> {
        let path = Self::path_of(output);
        let failed = |source| LockError::Io { path: output.into(), source };
        for _ in 0..MOST_TRIES {
            let mut file = open(&path).map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held { path: output.into(), holder: holder(&path) });
                }
                // Some network file systems have no locks, and report that in many ways; there the file only names the writer.
                Err(TryLockError::Error(_)) => {}
            }
            // The previous holder may have removed the file between opening and locking it here, or another program may
            // have replaced it by a link.
            check_no_link(&path).map_err(failed)?;
            if !is_at(&file, &path) {
                continue;
            }
            file.set_len(0).and_then(|()| file.write_all(this_process().as_bytes())).map_err(failed)?;
            return Ok(Self { _file: file, path });
        }
        Err(LockError::Held { path: output.into(), holder: holder(&path) })
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // Removed before it is unlocked, so that no other process's file is removed.
        let _ = fs::remove_file(&self.path);
    }
}

/// Opens or creates the lock.
fn open(path: &Path) -> io::Result<File> {
    check_no_link(path)?;
    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)
}

/// A link's target would be emptied, and a pipe would wait.
fn check_no_link(path: &Path) -> io::Result<()> {
    if fs::symlink_metadata(path).is_ok_and(|found| !found.is_file()) {
        let what = format!("{} is not a regular file; remove it", path.display());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    Ok(())
}

fn is_at(file: &File, path: &Path) -> bool {
    let opened = file.try_clone().and_then(Handle::from_file);
    matches!((opened, Handle::from_path(path)), (Ok(opened), Ok(found)) if opened == found)
}

fn this_process() -> String {
    let machine = gethostname::gethostname();
    let time = httpdate::fmt_http_date(SystemTime::now());
    format!("process {} on {} since {time}", std::process::id(), machine.display())
}

fn holder(path: &Path) -> String {
    /// Largest length of our own text.
    const LONGEST: usize = 400;
    let text = fs::read_to_string(path).unwrap_or_default();
    let is_ours = text.starts_with("process ") && text.len() < LONGEST && !text.contains(char::is_control);
    if is_ours { text } else { "another process".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_holder_at_a_time_who_is_told_to_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let held = OutputLock::acquire(&output).unwrap();
        let refused = OutputLock::acquire(&output).unwrap_err().to_string();
        let process = format!("process {} on ", std::process::id());
        assert!(refused.starts_with(&process) && refused.contains(" GMT"), "{refused}");
        assert!(refused.ends_with("a.cuts)"), "{refused}");
        assert!(OutputLock::acquire(&folder.path().join("b.cuts")).is_ok(), "negative control: another output");
        drop(held);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing stays behind");
        drop(OutputLock::acquire(&output).unwrap());
    }

    #[test]
    fn the_lock_of_a_process_that_ended_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        fs::write(OutputLock::path_of(&output), "process 1 on elsewhere since long ago, and much more text").unwrap();
        let _held = OutputLock::acquire(&output).unwrap();
        let text = fs::read_to_string(OutputLock::path_of(&output)).unwrap();
        let own = format!("process {} on ", std::process::id());
        assert!(text.starts_with(&own) && text.ends_with("GMT"), "nothing of the stale text is left: {text}");
    }

    #[test]
    fn many_threads_never_hold_it_at_once() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let (holders, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let Ok(lock) = OutputLock::acquire(&output) else { continue };
                        assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0, "two at once");
                        taken.fetch_add(1, Ordering::SeqCst);
                        holders.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert!(taken.load(Ordering::SeqCst) > 0);
    }

    #[cfg(unix)]
    #[test]
    fn a_lock_is_never_written_through_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (output, victim) = (folder.path().join("a.cuts"), folder.path().join("victim"));
        fs::write(&victim, "precious").unwrap();
        std::os::unix::fs::symlink(&victim, OutputLock::path_of(&output)).unwrap();
        assert!(matches!(OutputLock::acquire(&output), Err(LockError::Io { .. })));
        assert_eq!(fs::read_to_string(&victim).unwrap(), "precious");
    }
}
