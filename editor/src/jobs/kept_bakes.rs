//! Bakes that began by themselves are kept, so that a scene need not be baked again; the oldest make room for new ones.

use std::{
    fs::DirEntry,
    path::{Path, PathBuf},
    time::SystemTime,
};

/// Most bytes of such bakes.
pub const MOST_BYTES: u64 = 8 << 30;

/// Removes the bakes of a folder that are the oldest, until the others have at most `most` bytes. `latest` stays in any case, and
/// so does what cannot be removed.
pub fn remove_oldest(folder: &Path, latest: &Path, most: u64) {
    let mut bakes: Vec<(SystemTime, u64, PathBuf)> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().filter_map(bake).collect();
    let mut bytes: u64 = bakes.iter().map(|(_, size, _)| size).sum();
    bakes.sort();
    for (_, size, path) in bakes.into_iter().filter(|(.., path)| path != latest) {
        if bytes <= most {
            break;
        }
        if std::fs::remove_file(path).is_ok() {
            bytes -= size;
        }
    }
}

/// When a bake was written, and its size.
fn bake(entry: DirEntry) -> Option<(SystemTime, u64, PathBuf)> {
    let (path, data) = (entry.path(), entry.metadata().ok()?);
    let is_bake = data.is_file() && path.extension().is_some_and(|extension| extension == "cuts");
    is_bake.then_some((data.modified().ok()?, data.len(), path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_oldest_bakes_make_room_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, age: u64| {
            let path = folder.path().join(name);
            std::fs::write(&path, [0; 100]).unwrap();
            let written = SystemTime::now() - Duration::from_secs(age);
            std::fs::File::options().write(true).open(&path).unwrap().set_modified(written).unwrap();
            path
        };
        let [oldest, old, new] = [("a.cuts", 900), ("b.draft.cuts", 800), ("c.cuts", 10)].map(|(n, age)| file(n, age));
        let other = file("notes.txt", 5000);
        remove_oldest(folder.path(), &new, 300);
        assert!([&oldest, &old, &new, &other].iter().all(|path| path.is_file()), "they fit");
        remove_oldest(folder.path(), &oldest, 200);
        assert!(oldest.is_file() && !old.is_file() && new.is_file() && other.is_file());
        remove_oldest(folder.path(), &new, 0);
        assert!(!oldest.is_file() && new.is_file(), "the latest stays");
    }
}
