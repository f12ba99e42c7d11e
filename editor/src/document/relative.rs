//! Paths in session files: relative to the file, with forward slashes on every system.
//!
//! `..` is resolved in the text and not by the file system, on writing and on reading alike, so that a path comes back
//! as it was even where folders are links.

use lapidary_interchange::image::file_and_layer;
use std::path::{Component, Path, PathBuf};

/// The path from the root, without `.` and `..`.
pub fn absolute(path: &Path) -> PathBuf {
    clean(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
}

/// The folder that a file lies in, from the root.
pub fn folder_of(file: &Path) -> PathBuf {
    let file = absolute(file);
    file.parent().unwrap_or(&file).to_owned()
}

/// `path` as seen from `folder`, which is absolute. If they share only the root, as on two drives, the path stays absolute, since
/// they will hardly move together.
pub fn relative_to(path: &Path, folder: &Path) -> PathBuf {
    let path = absolute(path);
    let (to, from): (Vec<_>, Vec<_>) = (path.components().collect(), folder.components().collect());
    let shared = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    if !to[..shared].iter().any(|c| matches!(c, Component::Normal(_))) {
        return path.to_string_lossy().into_owned().into();
    }
    let up = from[shared..].iter().map(|_| "..".into());
    let down = to[shared..].iter().map(|c| c.as_os_str().to_string_lossy());
    up.chain(down).collect::<Vec<_>>().join("/").into()
}

/// The absolute path that a file in `folder` means by `path`.
pub fn resolve(path: &Path, folder: &Path) -> PathBuf {
    let joined = folder.join(path);
    let cleaned = clean(&joined);
    // It may name a layer of a picture.
    let exists = |path: &Path| file_and_layer(path).0.exists();
    if !exists(&cleaned) && exists(&joined) { joined } else { cleaned }
}

fn clean(path: &Path) -> PathBuf {
    let mut cleaned = PathBuf::new();
    for component in path.components() {
        match (component, cleaned.components().next_back()) {
            (Component::CurDir, _) | (Component::ParentDir, Some(Component::RootDir)) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                cleaned.pop();
            }
            (component, _) => cleaned.push(component),
        }
    }
    cleaned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_come_back() {
        let root = std::env::temp_dir().join("lapidary-nowhere");
        let folder = root.join("sessions/july");
        for (path, expected) in [
            ("scene.gltf", "../../scene.gltf"),
            ("sessions/a.cuts", "../a.cuts"),
            ("sessions/july/b.png", "b.png"),
            ("sessions/./x/../july/b.png", "b.png"),
        ] {
            let relative = relative_to(&root.join(path), &folder);
            assert_eq!(relative, Path::new(expected));
            assert_eq!(resolve(&relative, &folder), absolute(&root.join(path)));
        }
    }

    #[test]
    #[cfg(unix)]
    fn paths_that_share_only_the_root_stay_absolute() {
        assert_eq!(relative_to(Path::new("/mnt/a.hdr"), Path::new("/home/me")), Path::new("/mnt/a.hdr"));
        assert_eq!(resolve(Path::new("/mnt/a.hdr"), Path::new("/home/me")), Path::new("/mnt/a.hdr"));
        assert_eq!(clean(Path::new("/../a/./b/../../../c")), Path::new("/c"));
    }

    #[test]
    #[cfg(unix)]
    fn a_path_through_a_link_is_found_as_the_file_system_means_it() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("deep/real")).unwrap();
        std::fs::write(root.path().join("deep/a.png"), b"").unwrap();
        let link = root.path().join("link");
        std::os::unix::fs::symlink(root.path().join("deep/real"), &link).unwrap();
        assert!(resolve(Path::new("../a.png"), &link).is_file());
        assert!(!resolve(Path::new("../b.png"), &link).exists());
        std::fs::write(root.path().join("deep/a.exr"), b"").unwrap();
        assert!(resolve(Path::new("../a.exr#N"), &link).starts_with(&link), "a layer of it");
        assert!(!resolve(Path::new("../b.exr#N"), &link).starts_with(&link), "negative control");
    }
}
