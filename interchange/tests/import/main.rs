//! Imports of small scenes with known answers, and of damaged ones, which are errors and never panics.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic as the tests do")]

mod damage;
mod damaged_fields;
mod gltf;
mod gltf_compressed;
mod gltf_extensions;
mod gltf_foreign;
mod limits;
mod material_files;
mod numbers;
mod obj;
mod other_programs;
mod outside;
mod ply;
mod repair;
mod vertex_attributes;

use glam::{Vec2, Vec3};
use lapidary_core::{
    lights::Emission,
    material::BrdfModel,
    scene::{MeshError, Scene},
    texture::{Channel, ColorSpace, UvSet},
};
use lapidary_interchange::import::{
    ImportError, ImportOptions, Imported, import, import_with, load_material, pictures_of_material,
};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder of input files.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn add(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, contents).unwrap();
        path
    }

    fn add_png(&self, name: &str, rgb: [f32; 3]) -> PathBuf {
        let image = lapidary_core::image::Image::filled([2, 2], Vec3::from_array(rgb));
        self.add(name, lapidary_interchange::image::encode_png(&image))
    }

    fn add_rgba(&self, name: &str, [width, height]: [u32; 2], texels: &[u8]) -> PathBuf {
        let path = self.add(name, "");
        image::save_buffer(&path, texels, width, height, image::ColorType::Rgba8).expect("a folder that takes files");
        path
    }
}

/// Imports `contents` as the only file of a folder.
fn import_alone(name: &str, contents: impl AsRef<[u8]>) -> Result<Imported, ImportError> {
    let files = Files::new();
    import(&files.add(name, contents))
}

fn check_valid(imported: &Imported) {
    let scene = &imported.scene;
    scene.mesh.validate(scene.materials.len(), scene.objects.len()).unwrap();
    for (normal, tangent) in scene.mesh.normals.iter().zip(&scene.mesh.tangents) {
        assert!((normal.length() - 1.0).abs() < 1e-3 && (tangent.truncate().length() - 1.0).abs() < 1e-3);
        assert!(normal.dot(tangent.truncate()).abs() < 1e-2 && tangent.w.abs() == 1.0);
    }
    for slot in scene.materials.iter().flat_map(|m| m.maps.slots()) {
        assert!((slot.texture as usize) < scene.textures.len());
    }
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

/// A ring of `sides` quads around the y axis, and optionally its top.
fn prism(sides: usize, capped: bool) -> String {
    let mut obj = String::new();
    for i in 0..sides {
        let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
        obj += &format!("v {sin} 0 {cos}\nv {sin} 1 {cos}\n");
    }
    for i in 0..sides {
        let j = (i + 1) % sides;
        obj += &format!("f {} {} {} {}\n", 2 * i + 1, 2 * j + 1, 2 * j + 2, 2 * i + 2);
    }
    if capped {
        obj += "f";
        (0..sides).for_each(|i| obj += &format!(" {}", 2 * i + 2));
    }
    obj
}
