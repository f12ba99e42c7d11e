//! The passes that draw: of each its text, what it reads and writes, and what its variants differ in, in one place.

use super::{
    groups::{
        Added, Basis, Display, Frame, Kept, Lattice, Light, LocalLights, Marks, MirroredLight, MirroredScene, Past,
        Patches, QuadLight, Scene, SecondLight, Seen, Shading, ShadowViews, SunRays, Surfaces,
    },
    targets::format,
};
use crate::device::{
    Binding,
    Binding::{WrittenFloats, WrittenUints},
    GroupLayout,
    output::{AREAS, FRAME, Output},
    pass::Entry,
    shaders::{MODELS, TONE_CURVE},
};

/// Sums of a part of the light.
const SUMS: Output = output("Sums", &[FRAME, AREAS, ("written_value", WrittenFloats), ("written_work", WrittenUints)]);

/// Surfaces that pixels or rays see.
const SEEN: Output =
    output("Surface", &[FRAME, AREAS, ("written_geometry", WrittenUints), ("written_rotation", WrittenFloats)]);

/// Four numbers.
const NUMBERS: Output = output("vec4<f32>", &[FRAME, AREAS, ("written", WrittenFloats)]);

/// Sets of bits.
const BITS: Output = output("vec4<u32>", &[FRAME, AREAS, ("written", WrittenUints)]);

/// A picture that is kept.
const PAST: Output = output("Past", &[FRAME, AREAS, ("written_value", WrittenFloats), ("written_place", WrittenUints)]);

/// Rays of mirrors.
const RAYS: Output =
    output("MirrorRay", &[FRAME, AREAS, ("written_direction", WrittenFloats), ("written_weight", WrittenFloats)]);

const fn output(name: &'static str, bindings: &'static [(&'static str, Binding)]) -> Output {
    Output { name, bindings }
}

/// What programs begin with that draw triangles, some of which let light through.
const TRIANGLES: &[&str] = &["frame", "camera", "scene", "surface", "tables", "materials", "procedural", "opacity"];

/// What programs begin with that find the points of surfaces.
const SURFACES: &[&str] =
    &["frame", "camera", "fullscreen", "scene", "surface", "geometry", "tables", "materials", "procedural", "bumps"];

/// What programs begin with that shade the points of surfaces.
const SHADING: &[&str] = &[
    "frame",
    "camera",
    "fullscreen",
    "scene",
    "surface",
    "geometry",
    "tables",
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
    depth: Some(format::DEPTH),
    constants: &["HAS_VEILS"],
    ..Entry::new("visibility_pass", [TRIANGLES, &["visibility_pass"]])
};

/// Barycentric weights and frames. Twin of `Surfaces::point` in render/src/shade/surface.rs.
pub const SURFACE: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Seen::LAYOUT],
    ..Entry::writing("surface_pass", [SURFACES, &["seen_surface", "surface_pass"]], SEEN)
};

/// Base color and roughness, or the spread of slopes. Twin of `Surfaces::point` in render/src/shade/surface.rs.
pub const PARAMETERS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Surfaces::LAYOUT],
    ..Entry::writing(
        "parameters_pass",
        [SURFACES, &["environment", "brdf", MODELS, "seen_along", "parameters_pass"]],
        NUMBERS,
    )
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
    constants: &["FIELD", "IS_FIRST", "REFINE", "LIT", "MIRRORS", "BY_DIRECTION", "POSED", "BENT"],
    ..Entry::writing(
        "merge_pass",
        [
            SHADING,
            &[
                "color",
                "receiver",
                "node",
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
        SUMS,
    )
};

/// Depth from a light. What direct light of the CPU has shadow rays for, see render/src/shade/direct.rs.
pub const SHADOW: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, ShadowViews::LAYOUT],
    depth: Some(format::DEPTH),
    constants: &["HAS_VEILS"],
    ..Entry::new("shadow_pass", [TRIANGLES, &["shadow", "shadow_pass"]])
};

/// Rays to suns. Twin of `DirectShader::shares` in render/src/shade/direct.rs.
pub const SUNS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, SunRays::LAYOUT, Shading::LAYOUT],
    constants: &["HAS_VEILS"],
    ..Entry::writing(
        "suns_pass",
        [
            SHADING,
            &[
                "opacity",
                "ordered",
                "traverse",
                "concentric",
                "ray_shift",
                "sun_cells",
                "ray_start",
                "sun_rays",
                "suns_pass",
            ],
        ],
        BITS,
    )
};

/// Local lights. Twin of render/src/shade/direct.rs.
pub const DIRECT: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, LocalLights::LAYOUT, Shading::LAYOUT],
    ..Entry::writing(
        "direct_pass",
        [SHADING, &["shadow", "shadow_filter", "concentric", "ray_shift", "sun_cells", "direct_lights", "direct_pass"]],
        SUMS,
    )
};

/// Bounced light of meshless functions, and that of vertices. Twin of `MeshlessLight::at` in render/src/light/bounce/meshless/functions.rs.
pub const MESHLESS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Basis::LAYOUT, Shading::LAYOUT],
    ..Entry::writing(
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
        SUMS,
    )
};

/// Bounced light of wavelet transport. Twin of `PatchLight::reflected` in render/src/light/bounce/wavelet.rs.
pub const WAVELET: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, QuadLight::LAYOUT, Shading::LAYOUT],
    ..Entry::writing(
        "wavelet_pass",
        [SHADING, &["environment", "mirror", "rough", "posed", "concentric", "cells", "wavelet_pass"]],
        SUMS,
    )
};

/// Rays of mirrors. Twin of `Mirror::ray` in render/src/shade/mirror.rs.
pub const MIRROR_RAYS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, GroupLayout::EMPTY, Shading::LAYOUT],
    constants: &["IS_SECOND"],
    ..Entry::writing("mirror_rays_pass", [SHADING, &["environment", "mirror", "ray_shift", "mirror_rays_pass"]], RAYS)
};

/// What the rays of mirrors meet. Twin of `SeenScene::mirrored` in render/src/shade/seen_scene.rs.
pub const MIRRORED_SURFACE: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, MirroredScene::LAYOUT],
    constants: &["HAS_VEILS"],
    ..Entry::writing(
        "mirrored_surface_pass",
        [SURFACES, &["seen_surface", "opacity", "ordered", "traverse", "ray_start", "mirrored_surface_pass"]],
        SEEN,
    )
};

/// Light along the rays of wider lobes. Twin of `Mirrors::by_second_ray` in render/src/shade/mirrors.rs.
pub const SECOND_RAYS: Entry = Entry {
    groups: &[Frame::LAYOUT, GroupLayout::EMPTY, SecondLight::LAYOUT],
    ..Entry::writing("second_rays_pass", [&[], &["frame", "fullscreen", "color", "second_rays_pass"]], NUMBERS)
};

/// Light that mirrors show. Twin of `Mirrors::shown` in render/src/shade/mirrors.rs.
pub const MIRRORS: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, MirroredLight::LAYOUT, Shading::LAYOUT],
    ..Entry::writing("mirrors_pass", [SHADING, &["environment", "mirror", "mirrors_pass"]], SUMS)
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
    constants: &["IS_FIRST"],
    ..Entry::writing(
        "sketch_pass",
        [SHADING, &["environment", "wireframe", "first_part", "color", "guide", "sketch_pass"]],
        SUMS,
    )
};

/// What is kept of a picture for one from another camera. Twin of `History` in render/src/cpu/sketch/history.rs.
pub const HISTORY: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Added::LAYOUT, Shading::LAYOUT],
    ..Entry::writing("history_pass", [SHADING, &["guide", "past", "history_pass"]], PAST)
};

/// What the last picture tells of this one. Twin of `History::predict` in render/src/cpu/sketch/history.rs.
pub const PREDICT: Entry = Entry {
    groups: &[Frame::LAYOUT, Scene::LAYOUT, Past::LAYOUT, Shading::LAYOUT],
    ..Entry::writing("predict_pass", [SHADING, &["guide", "past", "predict_pass"]], NUMBERS)
};

/// The mean of all samples as a display shows it. Twin of render/src/cpu/display.rs.
pub const DISPLAY: Entry = Entry {
    groups: &[Display::LAYOUT],
    targets: &[format::SHOWN],
    ..Entry::new("display_pass", [&[], &["fullscreen", "color", "tonemap", TONE_CURVE, "sums", "display_pass"]])
};

/// Some work for each texel, to measure paths by.
pub const PROBE: Entry =
    Entry { groups: &[Frame::LAYOUT], ..Entry::writing("probe_pass", [&[], &["fullscreen", "probe_pass"]], NUMBERS) };

/// All of them.
#[cfg(test)]
pub const ALL: [Entry; 20] = [
    VISIBILITY,
    SURFACE,
    PARAMETERS,
    MARKS,
    MERGE,
    SHADOW,
    SUNS,
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
    PROBE,
];
