//! Guards outputs, so that no file of the document is overwritten.

use super::Workspace;
use crate::document::Document;
use lapidary_core::{brdf::BrdfFile, material::Material, output::check_output};
use lapidary_interchange::image::file_and_layer;
use std::path::{Path, PathBuf};

/// Kind of output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// The session, which may replace its file.
    Session,
    /// A bake, which may replace the previous one.
    Dataset,
    /// A file that the document does not read.
    Other,
}

impl Workspace {
    /// Whether a file can be written without a loss; shows an error if not.
    pub fn may_write(&mut self, path: &Path, what: Written) -> bool {
        let inputs = self.inputs(what);
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        let checked = check_output(path, &inputs);
        if let Err(error) = &checked {
            self.messages.error(error.to_string());
        }
        checked.is_ok()
    }

    /// Files that only their own successors may overwrite.
    pub fn inputs(&self, what: Written) -> Vec<PathBuf> {
        let dataset =
            [&self.document.dataset, &self.scene.bake_output].into_iter().filter(|_| what != Written::Dataset);
        let session = [&self.scene.session].into_iter().filter(|_| what != Written::Session);
        files_in_use(&self.document).into_iter().chain(dataset.chain(session).flatten().cloned()).collect()
    }
}

/// Files of the scene, the materials and the light of a document and its looks, each once.
pub fn files_in_use(document: &Document) -> Vec<PathBuf> {
    let slots = all_materials(document).flat_map(|m| m.maps.slots());
    let textures = slots.filter_map(|slot| document.file_of(document.textures.get(slot.image()?)?));
    let textures = textures.map(|path| file_and_layer(&path).0.to_owned());
    let of_looks = document.looks.iter().filter_map(|look| Some(&look.state.light.as_ref()?.environment));
    let environments = [&document.environment].into_iter().chain(of_looks);
    let environments = environments.filter_map(|map| Some(file_and_layer(map.file()?).0.to_owned()));
    let brdfs = brdf_files(document).map(|file| file.path.clone());
    let views = [&document.view].into_iter().chain(document.looks.iter().filter_map(|look| look.state.view.as_ref()));
    let backplates = views.filter_map(|view| view.backplate.clone());
    let mut files: Vec<PathBuf> =
        textures.chain(brdfs).chain(environments).chain(backplates).chain(document.scene.clone()).collect();
    files.sort();
    files.dedup();
    files
}

/// BRDF files of all materials.
pub fn brdf_files(document: &Document) -> impl Iterator<Item = &BrdfFile> {
    all_materials(document).filter_map(|material| material.file.as_ref())
}

/// Materials of a document and its looks, also those of grounds that are not shown.
fn all_materials(document: &Document) -> impl Iterator<Item = &Material> {
    let of_looks = document.looks.iter().filter_map(|look| look.state.materials.as_ref());
    let of_looks = of_looks.flat_map(|of_look| of_look.materials.iter().chain(&of_look.hidden_ground));
    document.materials.iter().chain(&document.hidden_ground).chain(of_looks)
}
