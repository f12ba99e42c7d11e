//! The row that chooses a layer of a picture.

use super::entries::combo_row;
use egui::Ui;
use lapidary_interchange::image::{file_and_layer, layers_in, with_layer};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// The layers of files that were shown.
#[derive(Default)]
pub struct Layers(HashMap<PathBuf, (usize, Vec<String>)>);

impl Layers {
    /// The names in a file; `version` changes whenever the file does.
    fn of(&mut self, file: &Path, version: usize) -> &[String] {
        let known = self.0.entry(file.to_owned()).or_insert_with(|| (version, layers_in(file)));
        if known.0 != version {
            *known = (version, layers_in(file));
        }
        &known.1
    }

    /// Shows the row if the picture at `path` has several layers. Returns the path of the chosen one.
    pub fn row(&mut self, ui: &mut Ui, path: &Path, version: usize) -> Option<PathBuf> {
        let (file, layer) = file_and_layer(path);
        let names = self.of(file, version);
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
