//! Scenes and checks for tests of panels and viewport.

use crate::document::{Document, TextureEntry};
use egui_kittest::{Harness, kittest::NodeT};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeReport, Dataset},
    image::Image,
    material::Material,
    scene::Mesh,
    sources::{Source, SourceTree},
    surfel::Surfel,
    test_scenes,
    texture::{ColorSpace, Texture, TextureSlot},
};
use lapidary_interchange::image;
use lapidary_precompute::Preset;
use lapidary_render::SourceLighting;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Width in points of panels in tests: a narrow inspector's.
pub const WIDTH: f32 = 300.0;

/// Checks that nothing reaches past the right edge.
pub fn assert_fits<State>(panel: &Harness<State>, width: f32) {
    let nodes: Vec<_> = panel.root().children_recursive().collect();
    assert!(nodes.len() > 5, "nothing is shown");
    for node in nodes.iter().filter(|n| n.accesskit_node().raw_bounds().is_some()) {
        let rect = node.rect();
        assert!(rect.right() <= width + 1.0, "{:?} reaches {}", node.accesskit_node().label(), rect.right());
    }
}

/// A dataset of one triangle, baked with the normal preset.
pub fn baked_triangle() -> Dataset {
    Dataset {
        indirect: None,
        meshless: None,
        object_bases: None,
        wavelet: None,
        settings: Preset::Normal.settings(),
        scene_hash: "abc".into(),
        report: BakeReport {
            vertices: 3,
            source_vertices: 3,
            cut_size_histogram: vec![3, 0, 1],
            warnings: vec!["a corner is thin".into()],
            ..Default::default()
        },
        ..test_scenes::dataset(&[""], &[])
    }
}

/// Two squares that face +Z: object 0 of material 1 on the left, object 1 of material 0 on the right.
pub fn two_squares() -> Mesh {
    let square = |x: f32| [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(u, v)| Vec3::new(x + u, v, 0.0));
    Mesh {
        positions: [square(-1.0), square(1.0)].concat(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        triangle_material: vec![1, 1, 0, 0],
        triangle_object: vec![0, 0, 1, 1],
        ..Default::default()
    }
}

/// Four sources in a row on the plane z = 0 that face the eye, the first two much brighter than the others.
pub fn row_of_sources(illum_cut: u32) -> SourceLighting {
    let source = |i: usize| {
        let position = Vec3::new(i as f32 - 1.5, 0.0, 0.0);
        let surfel = Surfel { position, normal: Vec3::Z, ..Default::default() };
        Source { surfel, area: 0.1, spacing: 0.3 }
    };
    let sources: Vec<Source> = (0..4).map(source).collect();
    let radiance = [9.0, 3.0, 0.1, 0.1].map(Vec3::splat);
    SourceLighting::new(Arc::new(SourceTree::new(&sources)), &radiance, illum_cut)
}

/// Writes a small picture.
pub fn write_picture(path: &Path) {
    image::write(&Image::filled([2, 2], Vec3::splat(0.25)), path).unwrap();
}

/// A document of one material, whose map is this file.
pub fn document_with_a_map(file: Option<PathBuf>) -> Document {
    let texture = Arc::new(Texture::missing("wood.png"));
    let slot = Some(TextureSlot { rotation: 0.5, color_space: ColorSpace::Srgb, ..TextureSlot::default() });
    let mut material = Material { name: "wood".into(), ..Default::default() };
    material.maps.set("base_color", slot);
    Document { materials: vec![material], textures: vec![TextureEntry { texture, file }], ..Document::empty() }
}
