//! The row that chooses a layer of a picture.

use super::entries::combo_row;
use egui::Ui;
use lapidary_interchange::image::{file_and_layer, layers_in, with_layer};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    time::SystemTime,
};

/// Most files whose layers are kept; a panel shows fewer.
const KEPT: usize = 64;

/// The layers of files that were shown.
#[derive(Default)]
pub struct Layers(HashMap<PathBuf, Known>);

struct Known {
    version: Version,
    names: Vec<String>,
}

/// Changes when a file does: its time and size; `None` for a missing one.
type Version = Option<(SystemTime, u64)>;

fn version(file: &Path) -> Version {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

impl Layers {
    /// The names in a file, which is read again only where it changed.
    fn of(&mut self, file: &Path) -> &[String] {
        let version = version(file);
        if self.0.len() >= KEPT && !self.0.contains_key(file) {
            self.0.clear();
        }
        let read = || Known { version, names: layers_in(file) };
        let known = self.0.entry(file.to_owned()).or_insert_with(read);
        if known.version != version {
            *known = read();
        }
        &known.names
    }

    /// Shows the row if the picture at `path` has several layers. Returns the path of the chosen one.
    pub fn row(&mut self, ui: &mut Ui, path: &Path) -> Option<PathBuf> {
        let (file, layer) = file_and_layer(path);
        let names = self.of(file);
        if names.is_empty() {
            return None;
        }
        // A name may be shortened.
        let is_shown = |name: &String| layer.is_some_and(|layer| name.eq_ignore_ascii_case(layer));
        let before = names.iter().position(is_shown).or(layer.is_none().then_some(0));
        let mut chosen = before;
        let mut choices: Vec<_> = names.iter().enumerate().map(|(i, name)| (Some(i), name.as_str(), "")).collect();
        choices.extend(layer.filter(|_| before.is_none()).map(|layer| (None, layer, "")));
        let help = "Part or layer of the file: colors, vectors such as normals, or a channel such as depth.";
        let edited = combo_row(ui, "Layer", help, &mut chosen, &choices);
        chosen.filter(|_| edited.changed).map(|chosen| with_layer(file, &names[chosen]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::image::Image;
    use lapidary_interchange::image::{Layer, LayeredImage, Metadata};
    use std::{fs::File, time::Duration};

    fn write(path: &Path, names: [&str; 2]) {
        let layers = names.map(|name| Layer::color(name, &Image::filled([1, 1], glam::Vec3::ONE))).into();
        LayeredImage { size: [1, 1], layers, metadata: Metadata::default() }.write(path).unwrap();
    }

    #[test]
    fn a_file_is_read_again_only_where_it_changed() {
        let folder = tempfile::tempdir().unwrap();
        let [path, other] = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
        write(&path, ["aa", "bb"]);
        write(&other, ["xx", "yy"]);
        let mut layers = Layers::default();
        assert_eq!(layers.of(&path), ["aa", "bb"]);
        let before = path.metadata().unwrap().modified().unwrap();
        write(&path, ["cc", "dd"]);
        let touch = |time| File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        touch(before);
        assert_eq!(layers.of(&other), ["xx", "yy"]);
        assert_eq!(layers.of(&path), ["aa", "bb"], "kept beside another");
        touch(before + Duration::from_secs(1));
        assert_eq!(layers.of(&path), ["cc", "dd"]);
        std::fs::remove_file(&path).unwrap();
        assert!(layers.of(&path).is_empty());
    }

    #[test]
    fn few_files_are_kept() {
        let mut layers = Layers::default();
        (0..1000).for_each(|i| assert!(layers.of(&PathBuf::from(format!("gone-{i}.exr"))).is_empty()));
        assert!(layers.0.len() <= KEPT);
    }
}
