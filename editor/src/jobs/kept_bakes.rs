//! Automatic bakes are kept, so that a scene need not be baked again; the oldest make room for new ones.

use std::{
    fs::{DirEntry, File},
    path::{Path, PathBuf},
    time::SystemTime,
};

/// Most bytes of kept bakes.
pub const MOST_BYTES: u64 = 8 << 30;

/// Path of the draft of a bake, which is shown at once while the bake continues.
pub fn draft_of(output: &Path) -> PathBuf {
    output.with_extension("draft.cuts")
}

/// Path of an automatic bake in the folder `bakes`. Another version of the scene has another path.
pub fn kept_in(bakes: &Path, scene: &Path, hash: &str) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    bakes.join(format!("{stem}-{}.cuts", hash.get(..16).unwrap_or(hash)))
}

/// Makes a bake the newest.
pub fn touch(bake: &Path) {
    // An untouched bake is only removed somewhat earlier.
    let _ = File::options().append(true).open(bake).and_then(|file| file.set_modified(SystemTime::now()));
}

/// Removes the oldest bakes and checkpoints of a folder until the rest has at most `most` bytes. `latest` always stays, as do files
/// that cannot be removed.
pub fn remove_oldest(folder: &Path, latest: &Path, most: u64) {
    let mut bakes: Vec<(SystemTime, u64, PathBuf)> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().filter_map(bake).collect();
    let mut bytes: u64 = bakes.iter().map(|(_, size, _)| size).sum();
    bakes.sort();
    for (_, size, path) in bakes.into_iter().filter(|(.., path)| path != latest) {
        if bytes <= most {
            break;
        }
        let removed = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        if removed.is_ok() {
            bytes -= size;
        }
    }
}

/// Time and size of a bake or checkpoint.
fn bake(entry: DirEntry) -> Option<(SystemTime, u64, PathBuf)> {
    let (path, data) = (entry.path(), entry.metadata().ok()?);
    let extension = path.extension().and_then(|extension| extension.to_str())?;
    let size = match extension {
        "cuts" if data.is_file() => data.len(),
        "partial" if data.is_dir() => {
            let files = std::fs::read_dir(&path).ok()?.flatten();
            files.filter_map(|file| Some(file.metadata().ok()?.len())).sum()
        }
        _ => return None,
    };
    Some((data.modified().ok()?, size, path))
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

    #[test]
    fn what_was_opened_lately_is_new_and_what_is_left_of_bakes_counts() {
        let folder = tempfile::tempdir().unwrap();
        let [first, second] = ["a.cuts", "b.cuts"].map(|name| folder.path().join(name));
        for (path, age) in [(&first, 900), (&second, 800)] {
            std::fs::write(path, [0; 100]).unwrap();
            let written = SystemTime::now() - Duration::from_secs(age);
            File::options().append(true).open(path).unwrap().set_modified(written).unwrap();
        }
        touch(&first);
        let left = folder.path().join("c.cuts.partial");
        std::fs::create_dir(&left).unwrap();
        std::fs::write(left.join("chunk"), [0; 100]).unwrap();
        remove_oldest(folder.path(), Path::new(""), 200);
        assert!(first.is_file() && !second.is_file() && left.is_dir());
        remove_oldest(folder.path(), &first, 100);
        assert!(first.is_file() && !left.exists());
    }
}
