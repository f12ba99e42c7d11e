//! Output of a format's reader.

use super::{repair::RawMesh, report::ImportError};
use glam::{DVec3, Vec3};
use lapidary_core::{
    camera::Camera,
    lights::Light,
    material::Material,
    parts::{Part, Variants},
    scene::Object,
    texture::Texture,
};
use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

/// Files with more vertices or triangles than this are refused: at some 100 bytes each they would take 10 GB.
const MAX_ELEMENTS: u64 = 100_000_000;

/// Output of the reader of one format.
#[derive(Default)]
pub(super) struct Source {
    pub mesh: RawMesh,
    /// What was subtracted from the coordinates of the file, if the scene is far from their origin.
    pub origin: Option<DVec3>,
    pub materials: Vec<Material>,
    /// Indices of the materials whose base color no file gives.
    pub uncolored: HashSet<usize>,
    pub textures: Vec<Texture>,
    pub objects: Vec<Object>,
    pub cameras: Vec<Camera>,
    pub lights: Vec<Light>,
    pub variants: Variants,
    /// Names of the scenes of the file, if it has several.
    pub scenes: Vec<String>,
    /// The one of them that is imported by default.
    pub default_scene: Option<String>,
    pub warnings: Vec<String>,
    pub unread: Vec<String>,
    pub outside: Vec<String>,
    pub files: Vec<PathBuf>,
}

impl Source {
    /// Shows the colors of a part's vertices, whichever variant is chosen.
    pub fn show_vertex_colors(&mut self, part: Part) {
        let of_variants = self.variants.parts.iter().filter(|variants| variants.part == part);
        let others = of_variants.flat_map(|variants| variants.in_variants.iter().copied().chain([variants.plain]));
        let all: Vec<u32> = others.chain([part.material]).collect();
        for index in all {
            self.color_by_vertices(index as usize);
        }
    }

    /// Multiplies a material by the colors of the vertices, which are all its color where no file gives another.
    pub fn color_by_vertices(&mut self, index: usize) {
        let material = &mut self.materials[index];
        if self.uncolored.contains(&index) {
            material.parameters.set("base_color", Vec3::ONE);
        }
        material.vertex_colors = true;
    }

    /// Adds a material whose base color no file gives.
    pub fn push_uncolored(&mut self, material: Material) {
        self.uncolored.insert(self.materials.len());
        self.materials.push(material);
    }

    /// Adds the material of surfaces without one.
    pub fn push_default_material(&mut self) {
        self.push_uncolored(Material { name: "default".into(), ..Default::default() });
    }
}

/// Checks a count against the limit.
pub(super) fn check_count(what: &'static str, count: u64, path: &Path) -> Result<(), ImportError> {
    if count <= MAX_ELEMENTS {
        return Ok(());
    }
    Err(ImportError::TooLarge { path: path.into(), what, count, limit: MAX_ELEMENTS })
}
