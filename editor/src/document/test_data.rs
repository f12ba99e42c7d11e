//! A small dataset for tests.

use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    camera::Camera,
    cut::packed::{PackedCuts, pack_node},
    dataset::{BakeReport, BakeSettings, Dataset, scene_hash},
    image::Image,
    light_tree::LightTree,
    lights::{Emission, Light},
    material::Material,
    scene::{Mesh, Object, Scene},
    texture::Texture,
};
use lapidary_precompute::Preset;
use std::path::Path;

/// One triangle, with materials and textures of these names.
pub fn dataset(materials: &[&str], textures: &[&str]) -> Dataset {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        normals: vec![Vec3::Y; 3],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        triangles: vec![[0, 2, 1]],
        triangle_material: vec![0],
        triangle_object: vec![0],
    };
    let scene = Scene {
        mesh,
        materials: materials.iter().map(|&name| Material { name: name.into(), ..Default::default() }).collect(),
        textures: textures.iter().map(|name| Texture::missing(name).into()).collect(),
        objects: vec![Object { name: "o".into() }],
        ..Default::default()
    };
    let mut cuts = PackedCuts::default();
    for _ in 0..3 {
        let offset = cuts.push_cut(&[pack_node(0, 1.0)]);
        cuts.push_vertex(offset);
    }
    Dataset {
        indirect: None,
        meshless: None,
        two_sided: vec![false],
        vertex_valid: vec![true; 3],
        tree: LightTree::geometric(64).unwrap(),
        cuts,
        settings: BakeSettings { lights: 64, ..Preset::Draft.settings() },
        scene_hash: scene_hash(&scene),
        report: BakeReport::default(),
        scene,
    }
}

/// A camera of this name.
pub fn camera(name: &str) -> Camera {
    Camera { name: name.into(), ..Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 35.0) }
}

/// A spot above the origin that shines down.
pub fn light() -> Light {
    Light {
        name: "spot".into(),
        enabled: true,
        emission: Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 },
        position: Vec3::new(0.0, 2.0, 0.0),
        target: Vec3::ZERO,
        intensity: Vec3::new(3.0, 2.0, 1.0),
    }
}

/// Writes a small picture.
pub fn write_picture(path: &Path) {
    Image::filled([2, 2], Vec3::splat(0.25)).write(path).unwrap();
}
