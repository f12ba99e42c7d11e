//! Detects files that have changed on disk, so that textures and environments follow the program that paints them.
//!
//! It compares times and sizes twice a second instead of asking the system. That also works on network drives, and
//! costs nothing for the few files of a session.

use lapidary_studies::jobs::{Wake, spawn};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    time::{Duration, SystemTime},
};

/// Time between two looks.
const PERIOD: Duration = Duration::from_millis(500);

/// Identifies a version of a file; `None` if there is no file.
type Stamp = Option<(SystemTime, u64)>;

/// Watches files.
pub struct Watcher {
    files: Sender<Vec<PathBuf>>,
    changed: Receiver<PathBuf>,
    /// The watched files.
    pub watched: Vec<PathBuf>,
}

impl Watcher {
    /// Starts the thread; it watches nothing yet and ends with the watcher.
    pub fn start(wake: Wake) -> Self {
        Self::with_period(wake, PERIOD)
    }

    fn with_period(wake: Wake, period: Duration) -> Self {
        let (files, sets) = channel();
        let (sender, changed) = channel();
        spawn("watch", move || watch(&sets, &sender, &wake, period));
        Self { files, changed, watched: Vec::new() }
    }

    /// Watches these files and no others. New ones count as known in their present version.
    pub fn watch(&mut self, files: Vec<PathBuf>) {
        if files != self.watched {
            // The thread ends only with the watcher.
            let _ = self.files.send(files.clone());
            self.watched = files;
        }
    }

    /// Files that have changed since the last call, and are no longer being written.
    pub fn changed(&mut self) -> Vec<PathBuf> {
        self.changed.try_iter().collect()
    }
}

fn watch(sets: &Receiver<Vec<PathBuf>>, changed: &Sender<PathBuf>, wake: &Wake, period: Duration) {
    let mut looks = Looks::default();
    loop {
        let set =
            if looks.0.is_empty() { sets.recv().map_err(RecvTimeoutError::from) } else { sets.recv_timeout(period) };
        match set {
            Ok(files) => looks.replace(&files, stamp),
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {
                for path in looks.look(stamp) {
                    // Fails only when the watcher is gone, which the next turn notices.
                    let _ = changed.send(path);
                    wake();
                }
            }
        }
    }
}

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Seen versions of each file.
#[derive(Default)]
struct Looks(HashMap<PathBuf, FileVersions>);

#[derive(Clone, Copy)]
struct FileVersions {
    /// The version that the program has.
    known: Stamp,
    /// The version at the last look.
    last: Stamp,
}

impl Looks {
    /// Watches other files; keeps the versions of files that stay.
    fn replace(&mut self, files: &[PathBuf], stamp: impl Fn(&Path) -> Stamp) {
        let seen = |path: &PathBuf| {
            let now = || {
                let now = stamp(path);
                FileVersions { known: now, last: now }
            };
            (path.clone(), self.0.get(path).copied().unwrap_or_else(now))
        };
        self.0 = files.iter().map(seen).collect();
    }

    /// Files that differ from the known version and have not changed since the last look.
    fn look(&mut self, stamp: impl Fn(&Path) -> Stamp) -> Vec<PathBuf> {
        let mut changed = Vec::new();
        for (path, seen) in &mut self.0 {
            let now = stamp(path);
            // A missing file is most likely being replaced.
            if now.is_some() && now == seen.last && now != seen.known {
                seen.known = now;
                changed.push(path.clone());
            }
            seen.last = now;
        }
        changed.sort();
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_studies::jobs::testing::{silent, wait_for};

    fn version(number: u64) -> Stamp {
        Some((SystemTime::UNIX_EPOCH, number))
    }

    #[test]
    fn a_change_is_told_once_and_only_when_it_is_stable() {
        let a = PathBuf::from("a");
        let mut looks = Looks::default();
        looks.replace(std::slice::from_ref(&a), |_| version(1));
        assert!(looks.look(|_| version(1)).is_empty());
        assert!(looks.look(|_| version(2)).is_empty(), "may still be written");
        assert!(looks.look(|_| version(3)).is_empty(), "was");
        assert_eq!(looks.look(|_| version(3)), [a]);
        assert!(looks.look(|_| version(3)).is_empty(), "told once");
    }

    #[test]
    fn files_may_vanish_and_return() {
        let a = PathBuf::from("a");
        let mut looks = Looks::default();
        looks.replace(std::slice::from_ref(&a), |_| version(1));
        assert!(looks.look(|_| None).is_empty() && looks.look(|_| None).is_empty());
        assert!(looks.look(|_| version(1)).is_empty() && looks.look(|_| version(1)).is_empty(), "the same as before");
        assert!(looks.look(|_| None).is_empty());
        assert!(looks.look(|_| version(2)).is_empty());
        assert_eq!(looks.look(|_| version(2)), [a]);
    }

    #[test]
    fn another_set_keeps_what_is_known_of_files_in_both() {
        let [a, b] = ["a", "b"].map(PathBuf::from);
        let mut looks = Looks::default();
        looks.replace(std::slice::from_ref(&a), |_| version(1));
        looks.look(|_| version(2));
        looks.replace(&[a.clone(), b], |_| version(2));
        assert_eq!(looks.look(|_| version(2)), [a]);
        looks.replace(&[], |_| version(3));
        assert!(looks.look(|_| version(4)).is_empty());
    }

    #[test]
    fn files_on_disk_are_watched() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.png", "b.png"].map(|name| folder.path().join(name));
        std::fs::write(&a, "1").unwrap();
        std::fs::write(&b, "1").unwrap();
        let mut watcher = Watcher::with_period(silent(), Duration::from_millis(20));
        watcher.watch(vec![a.clone(), b]);
        std::thread::sleep(Duration::from_millis(100));
        assert!(watcher.changed().is_empty());
        // The first look may come after the first change, which then goes unreported.
        let mut text = String::from("1");
        let changed = wait_for("the change", || {
            text.push('2');
            std::fs::write(&a, &text).unwrap();
            std::thread::sleep(Duration::from_millis(200));
            watcher.changed().pop()
        });
        assert_eq!(changed, a);
        std::thread::sleep(Duration::from_millis(100));
        assert!(watcher.changed().is_empty());
    }
}
