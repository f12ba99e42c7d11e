//! Finds moved files by name, below a folder that the user chooses.

use super::{LoadedSession, read::forget_what_can_be_baked};
use lapidary_interchange::image::{file_and_layer, with_layer};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// Folders this deep below the given one are searched.
const DEPTH: usize = 4;

/// Most files and folders searched, so that a whole disk does not stop the window for long.
const MAX_ENTRIES: usize = 100_000;

impl LoadedSession {
    /// Searches `folder` and below for the missing files by name. Returns the number found.
    pub fn relink(&mut self, folder: &Path) -> usize {
        let files = files_below(folder);
        let find = |missing: &Path| {
            let (file, layer) = file_and_layer(missing);
            let found = best(&files, file)?;
            Some((missing.to_owned(), layer.map_or_else(|| found.clone(), |layer| with_layer(&found, layer))))
        };
        let found: HashMap<PathBuf, PathBuf> = self.missing.iter().filter_map(|m| find(&m.path)).collect();
        self.session.visit_paths(&mut |_, path| {
            if let Some(new) = found.get(path) {
                path.clone_from(new);
            }
        });
        self.missing.retain(|m| !found.contains_key(&m.path));
        forget_what_can_be_baked(&self.session, &mut self.missing);
        found.len()
    }
}

/// Parts of a path from the last to the first, in lower case: the session may come from another system.
fn parts_from_end(path: &Path) -> Vec<String> {
    let text = path.to_string_lossy().to_lowercase();
    text.rsplit(['/', '\\']).filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// The file of the same name that shares the most folders with the missing one; of equals, the one nearest the top.
fn best(files: &[PathBuf], missing: &Path) -> Option<PathBuf> {
    let wanted = parts_from_end(missing);
    let shared = |file: &PathBuf| parts_from_end(file).iter().zip(&wanted).take_while(|(a, b)| a == b).count();
    let candidates = files.iter().map(|file| (shared(file), file)).filter(|(shared, _)| *shared > 0);
    // The first of the greatest: `max_by_key` would give the last.
    candidates.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, file)| file.clone())
}

/// Files in `folder` and below, level by level, each in order of names. Linked folders are not entered.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let (mut files, mut level) = (Vec::new(), vec![folder.to_owned()]);
    let mut entries_left = MAX_ENTRIES;
    for _ in 0..=DEPTH {
        let mut next = Vec::new();
        for folder in level {
            let Ok(entries) = std::fs::read_dir(folder) else { continue };
            let mut entries: Vec<_> = entries.flatten().take(entries_left).collect();
            entries_left -= entries.len();
            entries.sort_by_key(std::fs::DirEntry::file_name);
            for entry in entries {
                let is_folder = entry.file_type().is_ok_and(|t| t.is_dir());
                if is_folder { next.push(entry.path()) } else { files.push(entry.path()) }
            }
        }
        level = next;
    }
    files.retain(|file| file.is_file());
    files
}
