//! Collects the parts of objects that are left out, for the final report.

use super::{hierarchy::node_name, json::document_with, primitive::is_surface, scene_file::SceneFile};
use crate::{
    features::gltf::{FURTHER_COLORS, LINES, TARGETS_OF_LOOKS},
    names::listed,
};
use gltf::Semantic;
use serde_json::Value;

/// Largest number of sentences of one kind in the report.
const MOST_SENTENCES: usize = 5;

/// Objects with parts left out.
#[derive(Default)]
pub(super) struct Notes {
    not_surfaces: Vec<String>,
    /// Objects with more than one set of vertex colors.
    further_colors: Vec<String>,
    /// Objects with morph targets of colors or texture coordinates.
    targets_of_looks: Vec<String>,
    /// Sentences on unusable deformations of objects.
    pub deformations: Vec<String>,
    /// Objects whose vertex colors have an alpha that counts.
    pub faded: Vec<String>,
    turned: Vec<String>,
}

impl Notes {
    /// What of a file's scene is left out, before its objects are read.
    pub fn of(file: &SceneFile) -> Self {
        let mut notes = Self { turned: file.turned.clone(), ..Self::default() };
        let have_targets = with_targets_of_looks(&file.json);
        for node in file.nodes_of_scene() {
            let Some(mesh) = node.mesh() else { continue };
            let has = |is_meant: fn(&gltf::Primitive) -> bool| mesh.primitives().any(|primitive| is_meant(&primitive));
            for (names, is_so) in [
                (&mut notes.not_surfaces, has(|primitive| !is_surface(primitive.mode()))),
                (&mut notes.further_colors, has(|primitive| primitive.get(&Semantic::Colors(1)).is_some())),
                (&mut notes.targets_of_looks, have_targets.get(mesh.index()).is_some_and(|has| *has)),
            ] {
                names.extend(is_so.then(|| node_name(&node)));
            }
        }
        notes
    }

    pub fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.deformations.iter().take(MOST_SENTENCES).cloned());
        if let Some(more) = self.deformations.len().checked_sub(MOST_SENTENCES).filter(|more| *more > 0) {
            warnings.push(format!("{more} more objects show without a part of their deformation"));
        }
        for (feature, names) in [
            (LINES, &self.not_surfaces),
            (FURTHER_COLORS, &self.further_colors),
            (TARGETS_OF_LOOKS, &self.targets_of_looks),
        ] {
            warnings.extend(feature.warning("objects", names));
        }
        for (names, text) in [
            (&self.turned, "have a rotation that is not a unit quaternion, which was normalized; export them again"),
            (&self.faded, "have vertex colors with transparency, which was left out; bake it to a texture of opacity"),
        ] {
            if !names.is_empty() {
                warnings.push(format!("the objects {} {text}", listed(names)));
            }
        }
    }
}

/// Whether each mesh has morph targets of colors or texture coordinates, which the `gltf` crate does not tell; empty if none has
/// morph targets.
fn with_targets_of_looks(json: &[u8]) -> Vec<bool> {
    let document = document_with(json, "\"targets\"").unwrap_or_default();
    let is_of_looks = |name: &String| name.starts_with("COLOR_") || name.starts_with("TEXCOORD_");
    let has_such = |mesh: &Value| {
        let primitives = mesh["primitives"].as_array().into_iter().flatten();
        let mut targets = primitives.filter_map(|primitive| primitive["targets"].as_array()).flatten();
        targets.any(|target| target.as_object().is_some_and(|target| target.keys().any(is_of_looks)))
    };
    document["meshes"].as_array().map_or_else(Vec::new, |meshes| meshes.iter().map(has_such).collect())
}
