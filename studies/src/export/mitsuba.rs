//! A dataset's scene for Mitsuba 3, so that an independent renderer can render the same picture.
//!
//! | file | |
//! |---|---|
//! | `scene.xml` | integrator, camera, light, shapes; its defaults `materials`, `max_depth` and `spp` can be set from outside |
//! | `materials.xml` | the BSDFs of Mitsuba that are nearest to the materials |
//! | `materials-exact.xml` | the same materials by the formulas of this program, for the plugin `tests/crosscheck/lapidary_ggx.py` |
//! | `meshes/*.ply` | triangles by material and side, as they were baked; those that shine on both sides twice |
//! | `textures/*.exr` | maps of the materials, multiplied by their parameters, linear |
//! | `environment.exr` | the map on the grid on which Mitsuba interpolates as this program does |
//!
//! The modules `bsdf`, `emitters` and `sensor` describe the differences by definition.

mod bsdf;
mod emitters;
mod meshes;
mod sensor;
mod textures;
mod xml;

use crate::outputs::create_folder;
use anyhow::{Context, Result};
use lapidary_core::{dataset::Dataset, lights::Light, output::write_atomically, scene::Scene};
use lapidary_interchange::image;
use lapidary_render::{Illumination, View};
use meshes::Part;
use std::{collections::BTreeSet, path::Path};
use textures::TextureFolder;

/// File names in the folder; `*` stands for any text.
pub const FILES: [&str; 6] =
    ["scene.xml", "materials.xml", "materials-exact.xml", "environment.exr", "meshes/*.ply", "textures/*.exr"];

/// The exported scene.
pub struct MitsubaScene<'a> {
    /// Mesh, sidedness and materials.
    pub dataset: &'a Dataset,
    /// Camera, picture size, and visibility of the environment.
    pub view: &'a View,
    /// The environment, if it gives light.
    pub environment: Option<&'a Illumination>,
    /// Local lights; dark ones are omitted.
    pub lights: Vec<&'a Light>,
    /// Whether to export emission of surfaces, if there are emissive surfaces.
    pub emission: bool,
    /// Bounces of light between surfaces before the one toward the eye.
    pub bounces: u32,
}

/// Summary of the export.
pub struct Exported {
    /// PLY files.
    pub meshes: usize,
    /// Triangles in them.
    pub triangles: usize,
    /// Materials in use.
    pub materials: usize,
    /// Differences in Mitsuba's picture, in sentences.
    pub remarks: Vec<String>,
}

impl MitsubaScene<'_> {
    /// Writes all files into `folder`, which is created if missing; existing files are replaced.
    ///
    /// # Errors
    /// An unwritable folder or file.
    pub fn write(&self, folder: &Path) -> Result<Exported> {
        for part in ["", "meshes", "textures"] {
            create_folder(&folder.join(part))?;
        }
        let Scene { mesh, textures, .. } = &self.dataset.scene;
        let parts = meshes::parts(self.dataset, |material| self.shines(material));
        let mut textures = TextureFolder::new(folder, textures);
        let mut remarks = sensor::remarks(self);
        remarks.extend(emitters::remarks(&self.lights));
        let shapes = self.shapes(&parts, &mut textures)?;
        let scene = sensor::integrator_and_sensor(self) + &self.emitters(folder)? + &shapes;
        write_text(folder, "scene.xml", &xml::document(&(sensor::DEFAULTS.to_owned() + &scene)))?;
        for part in &parts {
            write_file(folder, &part.file(), &part.ply(mesh))?;
        }
        let used: BTreeSet<u32> = parts.iter().map(|part| part.material).collect();
        self.write_materials(folder, &parts, &used, &mut textures, &mut remarks)?;
        let triangles = parts.iter().map(|part| part.triangles.len()).sum();
        Ok(Exported { meshes: parts.len(), triangles, materials: used.len(), remarks })
    }

    /// Whether any surface transmits light.
    fn lets_through(&self) -> bool {
        self.dataset.scene.materials.iter().any(bsdf::lets_through)
    }

    /// Whether surfaces of a material emit light.
    fn shines(&self, material: u32) -> bool {
        self.emission && self.dataset.scene.materials[material as usize].shines()
    }

    fn shapes(&self, parts: &[Part], textures: &mut TextureFolder) -> Result<String> {
        let mut text = String::new();
        for part in parts {
            let emitter = if self.shines(part.material) {
                emitters::surface(&self.dataset.scene.materials[part.material as usize], part.material, textures)?
            } else {
                String::new()
            };
            text += &part.shape(&emitter);
        }
        Ok(text)
    }

    fn emitters(&self, folder: &Path) -> Result<String> {
        let mut text = String::new();
        if let Some(light) = self.environment {
            image::write(&emitters::environment_map(&light.environment.map), &folder.join(emitters::ENVIRONMENT_FILE))?;
            text += &emitters::environment(light);
        }
        text.extend(self.lights.iter().copied().filter_map(emitters::local));
        Ok(text)
    }

    fn write_materials(
        &self,
        folder: &Path,
        parts: &[Part],
        used: &BTreeSet<u32>,
        textures: &mut TextureFolder,
        remarks: &mut Vec<String>,
    ) -> Result<()> {
        for (file, models) in [("materials.xml", bsdf::Models::Nearest), ("materials-exact.xml", bsdf::Models::Exact)] {
            let mut text = String::new();
            for &index in used {
                let material = &self.dataset.scene.materials[index as usize];
                let both = [false, true]
                    .map(|two_sided| parts.iter().any(|p| (p.material, p.two_sided) == (index, two_sided)));
                text += &bsdf::bsdfs(material, index, both, models, textures)?;
                if models == bsdf::Models::Nearest {
                    remarks.extend(bsdf::remarks(material));
                    if self.shines(index) {
                        remarks.extend(emitters::remarks_of_surface(material, both[1]));
                    }
                }
            }
            write_text(folder, file, &xml::document(&text))?;
        }
        Ok(())
    }
}

fn write_text(folder: &Path, name: &str, text: &str) -> Result<()> {
    write_file(folder, name, text.as_bytes())
}

fn write_file(folder: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let path = folder.join(name);
    write_atomically(&path, bytes)
        .with_context(|| format!("cannot write; check the permissions and the free space ({})", path.display()))
}

#[cfg(test)]
mod tests;
