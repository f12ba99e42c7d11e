//! The passes that draw: of each its text, what it reads and writes, and what its variants differ in, in one place.

use super::{
    groups::{
        Added, Basis, Display, Frame, Kept, Lattice, Light, LocalLights, Marks, MirroredLight, MirroredScene, Past,
        Patches, QuadLight, Scene, SecondLight, Seen, Shading, ShadowViews, Surfaces,
    },
    targets::format,
};
use crate::device::{
    GroupLayout,
    shaders::{MODELS, Program, TONE_CURVE},
};
use wgpu::TextureFormat;

/// A pass that draws.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub program: Program,
    /// What it reads: groups 0, 1, ...
    pub groups: &'static [GroupLayout],
    /// Formats of the textures that it writes.
    pub targets: &'static [TextureFormat],
    /// Whether it draws triangles in depth; others cover the picture.
    pub has_depth: bool,
    /// Specialization constants, which tell its variants apart. Without any there is one variant.
    pub constants: &'static [&'static str],
}

impl Entry {
    /// Over every pixel, in one variant.
    const fn new(name: &'static str, parts: [&'static [&'static str]; 2]) -> Self {
        Self { program: Program { name, parts }, groups: &[], targets: &[], has_depth: false, constants: &[] }
    }
}

/// What programs begin with that draw triangles, some of which let light through.
const TRIANGLES: &[&str] = &["frame", "camera", "scene", "surface", "materials", "procedural", "opacity"];

/// What programs begin with that find the points of surfaces.
const SURFACES: &[&str] =
    &["frame", "camera", "fullscreen", "scene", "surface", "geometry", "materials", "procedural", "bumps"];

/// What programs begin with that shade the points of surfaces.
const SHADING: &[&str] = &[
    "frame",
    "camera",
    "fullscreen",
    "scene",
    "surface",
    "geometry",
    "materials",
    "procedural",
    "brdf",
    MODELS,
    "sums",
    "seen_along",
    "cone",
    "shading_point",
];

/// Which triangle each pixel sees. Twin of `PixelSampler` in render/src/shade/pixel_sampler.rs.
pub const VISIBILITY: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT],
    targets: &[format::TRIANGLE],
    has_depth: true,
    constants: &["HAS_VEILS"],
    ..Entry::new("visibility_pass", [TRIANGLES, &["visibility_pass"]])
};

/// Barycentric weights and frames. Twin of `Surfaces::point` in render/src/shade/surface.rs.
pub const SURFACE: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Seen::LAYOUT],
    targets: &[format::GEOMETRY, format::FLOATS],
    ..Entry::new("surface_pass", [SURFACES, &["seen_surface", "surface_pass"]])
};

/// Base color and roughness, or the spread of slopes. Twin of `Surfaces::point` in render/src/shade/surface.rs.
pub const PARAMETERS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Surfaces::LAYOUT],
    targets: &[format::FLOATS],
    ..Entry::new("parameters_pass", [SURFACES, &["environment", "brdf", MODELS, "seen_along", "parameters_pass"]])
};

/// What the pixels show. Twin of `Marks::of_surface` in render/src/stale.rs.
pub const MARKS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Patches::LAYOUT, Marks::LAYOUT],
    targets: &[format::MARKS],
    ..Entry::new("marks_pass", [&[], &["fullscreen", "scene", "marks_pass"]])
};

/// The merge of cuts. Twin of `Shader` in render/src/shade/merge.rs. Its variants are those of
/// [`MergeVariant`](super::passes::MergeVariant).
pub const MERGE: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Light::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    constants: &["FIELD", "IS_FIRST", "REFINE", "LIT", "MIRRORS", "BY_DIRECTION"],
    ..Entry::new(
        "merge_pass",
        [
            SHADING,
            &[
                "color",
                "receiver",
                "tree",
                "merged_tree",
                "octahedron",
                "sent",
                "cut",
                "lit_cut",
                "refine",
                "environment",
                "mirror",
                "rough",
                "wireframe",
                "first_part",
                "posed",
                "merge_pass",
            ],
        ],
    )
};

/// Depth from a light. What direct light of the CPU has shadow rays for, see render/src/shade/direct.rs.
pub const SHADOW: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, ShadowViews::LAYOUT],
    has_depth: true,
    constants: &["HAS_VEILS"],
    ..Entry::new("shadow_pass", [TRIANGLES, &["shadow", "shadow_pass"]])
};

/// Local lights. Twin of render/src/shade/direct.rs.
pub const DIRECT: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, LocalLights::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new("direct_pass", [SHADING, &["shadow", "shadow_filter", "concentric", "direct_lights", "direct_pass"]])
};

/// Bounced light of meshless functions, and that of vertices. Twin of `MeshlessLight::at` in render/src/light/bounce/meshless/functions.rs.
pub const MESHLESS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Basis::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new(
        "meshless_pass",
        [
            SHADING,
            &[
                "environment",
                "mirror",
                "rough",
                "color",
                "posed",
                "concentric",
                "cells",
                "coefficient",
                "meshless_pass",
            ],
        ],
    )
};

/// Bounced light of wavelet transport. Twin of `PatchLight::reflected` in render/src/light/bounce/wavelet.rs.
pub const WAVELET: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, QuadLight::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new(
        "wavelet_pass",
        [SHADING, &["environment", "mirror", "rough", "posed", "concentric", "cells", "wavelet_pass"]],
    )
};

/// Rays of mirrors. Twin of `Mirror::ray` in render/src/shade/mirror.rs.
pub const MIRROR_RAYS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, GroupLayout::EMPTY, Shading::LAYOUT],
    targets: &[format::FLOATS, format::FLOATS],
    constants: &["IS_SECOND"],
    ..Entry::new("mirror_rays_pass", [SHADING, &["environment", "mirror", "mirror_rays_pass"]])
};

/// What the rays of mirrors meet. Twin of `SeenScene::mirrored` in render/src/shade/seen_scene.rs.
pub const MIRRORED_SURFACE: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, MirroredScene::LAYOUT],
    targets: &[format::GEOMETRY, format::FLOATS],
    constants: &["HAS_VEILS"],
    ..Entry::new(
        "mirrored_surface_pass",
        [SURFACES, &["seen_surface", "opacity", "ordered", "traverse", "mirrored_surface_pass"]],
    )
};

/// Light along the rays of wider lobes. Twin of `Mirrors::by_second_ray` in render/src/shade/mirrors.rs.
pub const SECOND_RAYS: Entry = Entry {
    groups: &[Frame::LAYOUT, GroupLayout::EMPTY, SecondLight::LAYOUT],
    targets: &[format::FLOATS],
    ..Entry::new("second_rays_pass", [&[], &["frame", "fullscreen", "color", "second_rays_pass"]])
};

/// Light that mirrors show. Twin of `Mirrors::shown` in render/src/shade/mirrors.rs.
pub const MIRRORS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, MirroredLight::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new("mirrors_pass", [SHADING, &["environment", "mirror", "mirrors_pass"]])
};

/// What an edit leaves of the pixels. Twin of `Picture::forget` in render/src/cpu/picture.rs.
pub const KEEP: Entry = Entry {
    groups: &[Kept::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new("keep_pass", [&[], &["fullscreen", "sums", "keep_pass"]])
};

/// The filter between the pixels of a lattice. Twin of render/src/cpu/sketch/filter.rs.
pub const SKETCH: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Lattice::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    constants: &["IS_FIRST"],
    ..Entry::new("sketch_pass", [SHADING, &["environment", "wireframe", "first_part", "color", "guide", "sketch_pass"]])
};

/// What is kept of a picture for one from another camera. Twin of `History` in render/src/cpu/sketch/history.rs.
pub const HISTORY: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Added::LAYOUT, Shading::LAYOUT],
    targets: &format::SUMS,
    ..Entry::new("history_pass", [SHADING, &["guide", "past", "history_pass"]])
};

/// What the last picture tells of this one. Twin of `History::predict` in render/src/cpu/sketch/history.rs.
pub const PREDICT: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Past::LAYOUT, Shading::LAYOUT],
    targets: &[format::FLOATS],
    ..Entry::new("predict_pass", [SHADING, &["guide", "past", "predict_pass"]])
};

/// The mean of all samples as a display shows it. Twin of render/src/cpu/display.rs.
pub const DISPLAY: Entry = Entry {
    groups: &[Display::LAYOUT],
    targets: &[format::SHOWN],
    ..Entry::new("display_pass", [&[], &["fullscreen", "color", "tonemap", TONE_CURVE, "sums", "display_pass"]])
};

/// All of them.
#[cfg(test)]
pub const ALL: [Entry; 18] = [
    VISIBILITY,
    SURFACE,
    PARAMETERS,
    MARKS,
    MERGE,
    SHADOW,
    DIRECT,
    MESHLESS,
    WAVELET,
    MIRROR_RAYS,
    MIRRORED_SURFACE,
    SECOND_RAYS,
    MIRRORS,
    KEEP,
    SKETCH,
    HISTORY,
    PREDICT,
    DISPLAY,
];
