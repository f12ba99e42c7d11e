//! Collects the parts of objects that are left out, for the final report.

use super::primitive::is_surface;
use crate::{features::gltf::LINES, names::listed};

/// Largest number of sentences of one kind in the report.
const MOST_SENTENCES: usize = 5;

/// Objects with parts left out.
#[derive(Default)]
pub(super) struct Notes {
    pub not_surfaces: Vec<String>,
    /// Sentences on unusable deformations of objects.
    pub deformations: Vec<String>,
    /// Objects whose vertex colors have an alpha that counts.
    pub faded: Vec<String>,
    pub turned: Vec<String>,
}

impl Notes {
    pub fn inspect(&mut self, name: &str, mesh: &gltf::Mesh) {
        if mesh.primitives().any(|p| !is_surface(p.mode())) {
            self.not_surfaces.push(name.to_owned());
        }
    }

    pub fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.deformations.iter().take(MOST_SENTENCES).cloned());
        if let Some(more) = self.deformations.len().checked_sub(MOST_SENTENCES).filter(|more| *more > 0) {
            warnings.push(format!("{more} more objects show without a part of their deformation"));
        }
        warnings.extend(LINES.warning("objects", &self.not_surfaces));
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
