//! The shaders: plain WGSL, one entry point per file, joined with the libraries that it uses.

use super::{
    bindings::Binding::{self, Storage, Uniform, Written},
    models::ModelSet,
};
use crate::post::ToneMap;
use lapidary_core::brdf::BrdfModel;
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// A file of `shaders/`.
macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        /// Every file, by name.
        const PARTS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wgsl")))),*];
    };
}

parts!(
    "brdf",
    "bumps",
    "camera",
    "color",
    "cut",
    "direct_lights",
    "direct_pass",
    "display_pass",
    "distance_key",
    "environment",
    "forest",
    "frame",
    "fullscreen",
    "geometry",
    "guide",
    "hemisphere",
    "history_pass",
    "implicit_bounce_kernel",
    "implicit_cover",
    "implicit_nodes_kernel",
    "implicit_pull_kernel",
    "implicit_update_kernel",
    "implicit_visit",
    "implicit_walk_kernel",
    "keep_pass",
    "leaf_light",
    "marks_pass",
    "lit_cut",
    "lit_pass",
    "materials",
    "merge_pass",
    "meshless_pass",
    "mirror",
    "octahedron",
    "opacity",
    "ordered",
    "parameters_pass",
    "past",
    "posed",
    "predict_pass",
    "procedural",
    "rays_pass",
    "receiver",
    "refine",
    "scene",
    "shading_point",
    "shadow",
    "shadow_filter",
    "shadow_pass",
    "sketch_pass",
    "slice",
    "sums",
    "surface",
    "surface_pass",
    "tonemap",
    "traverse",
    "tree",
    "visibility_pass",
    "wireframe",
);

/// An entry point with the libraries that it uses, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Name of the pass.
    pub name: &'static str,
    /// What several programs begin with, and the rest.
    parts: [&'static [&'static str]; 2],
}

/// A kernel of one compute step, with the kinds of its data's bindings 0, 1, ...
#[derive(Clone, Copy, Debug)]
pub struct KernelProgram {
    /// Its text.
    pub program: Program,
    /// Kinds of its data.
    pub bindings: &'static [Binding],
}

impl KernelProgram {
    const fn new(name: &'static str, parts: [&'static [&'static str]; 2], bindings: &'static [Binding]) -> Self {
        Self { program: Program { name, parts }, bindings }
    }
}

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
    "shading_point",
];

/// In place of a file the models that a scene uses, and the dispatch to them.
const MODELS: &str = "models";

/// In place of a file the choice of a tone curve.
const TONE_CURVE: &str = "tone_curve";

/// Which triangle each pixel sees.
pub const VISIBILITY: Program = Program {
    name: "visibility_pass",
    parts: [&["frame", "camera", "scene"], &["surface", "materials", "procedural", "opacity", "visibility_pass"]],
};
/// Barycentric weights and frames.
pub const SURFACE: Program = Program {
    name: "surface_pass",
    parts: [
        &[],
        &[
            "frame",
            "camera",
            "fullscreen",
            "scene",
            "surface",
            "geometry",
            "materials",
            "procedural",
            "bumps",
            "surface_pass",
        ],
    ],
};
/// Rays for bakes.
pub const RAYS: Program = Program { name: "rays_pass", parts: [&[], &["ordered", "traverse", "rays_pass"]] };
/// Base color and roughness.
pub const PARAMETERS: Program = Program {
    name: "parameters_pass",
    parts: [
        &[],
        &[
            "frame",
            "camera",
            "fullscreen",
            "scene",
            "geometry",
            "environment",
            "surface",
            "materials",
            "procedural",
            "bumps",
            "brdf",
            MODELS,
            "parameters_pass",
        ],
    ],
};
/// The merge of cuts.
pub const MERGE: Program = Program {
    name: "merge_pass",
    parts: [
        SHADING,
        &["receiver", "tree", "cut", "lit_cut", "refine", "environment", "mirror", "wireframe", "posed", "merge_pass"],
    ],
};
/// Lit cuts.
pub const LIT: Program = Program { name: "lit_pass", parts: [&[], &["frame", "color", "tree", "cut", "lit_pass"]] };
/// Depth from a light.
pub const SHADOW: Program = Program {
    name: "shadow_pass",
    parts: [&["frame", "camera", "scene"], &["surface", "materials", "procedural", "opacity", "shadow", "shadow_pass"]],
};
/// Local lights.
pub const DIRECT: Program =
    Program { name: "direct_pass", parts: [SHADING, &["shadow", "shadow_filter", "direct_lights", "direct_pass"]] };
/// Bounced light of the meshless basis.
pub const MESHLESS: Program = Program { name: "meshless_pass", parts: [SHADING, &["color", "posed", "meshless_pass"]] };
/// The post pass.
pub const DISPLAY: Program = Program {
    name: "display_pass",
    parts: [&[], &["fullscreen", "color", "tonemap", TONE_CURVE, "sums", "display_pass"]],
};
/// What the pixels show.
pub const MARKS: Program = Program { name: "marks_pass", parts: [&[], &["fullscreen", "scene", "marks_pass"]] };
/// What an edit leaves of the pixels.
pub const KEEP: Program = Program { name: "keep_pass", parts: [&[], &["fullscreen", "sums", "keep_pass"]] };

/// The filter between the pixels of a lattice.
pub const SKETCH: Program =
    Program { name: "sketch_pass", parts: [SHADING, &["environment", "wireframe", "color", "guide", "sketch_pass"]] };
/// What is kept of a picture for one from another camera.
pub const HISTORY: Program = Program { name: "history_pass", parts: [SHADING, &["guide", "past", "history_pass"]] };
/// What the last picture tells of this one.
pub const PREDICT: Program = Program { name: "predict_pass", parts: [SHADING, &["guide", "past", "predict_pass"]] };

/// What kernels of implicit visibility begin with.
const FOREST: &[&str] = &["slice", "ordered", "forest"];

/// Discs of leaves.
pub const IMPLICIT_UPDATE: KernelProgram =
    KernelProgram::new("implicit_update_kernel", [FOREST, &["implicit_update_kernel"]], &[Storage, Storage, Written]);
/// The nodes above them.
pub const IMPLICIT_NODES: KernelProgram =
    KernelProgram::new("implicit_nodes_kernel", [FOREST, &["implicit_nodes_kernel"]], &[Storage, Storage, Written]);
/// What leaves see.
pub const IMPLICIT_WALK: KernelProgram = KernelProgram::new(
    "implicit_walk_kernel",
    [FOREST, &["hemisphere", "distance_key", "implicit_visit", "implicit_cover", "implicit_walk_kernel"]],
    &[Uniform, Storage, Storage, Storage, Storage, Storage, Written],
);
/// Radiance of nodes.
pub const IMPLICIT_PULL: KernelProgram = KernelProgram::new(
    "implicit_pull_kernel",
    [FOREST, &["leaf_light", "implicit_pull_kernel"]],
    &[Uniform, Storage, Storage, Storage, Storage, Written],
);
/// Irradiance of leaves.
pub const IMPLICIT_BOUNCE: KernelProgram = KernelProgram::new(
    "implicit_bounce_kernel",
    [FOREST, &["hemisphere", "octahedron", "leaf_light", "implicit_bounce_kernel"]],
    &[Uniform, Storage, Storage, Storage, Storage, Storage, Storage, Written],
);

/// Those of one compute step.
#[cfg(test)]
pub const KERNELS: [Program; 6] = [
    RAYS,
    IMPLICIT_UPDATE.program,
    IMPLICIT_NODES.program,
    IMPLICIT_WALK.program,
    IMPLICIT_PULL.program,
    IMPLICIT_BOUNCE.program,
];

/// Those of a vertex and a fragment shader, or of two compute steps.
#[cfg(test)]
pub const PASSES: [Program; 14] = [
    VISIBILITY, SURFACE, PARAMETERS, MARKS, MERGE, DISPLAY, SHADOW, DIRECT, MESHLESS, KEEP, SKETCH, HISTORY, PREDICT,
    LIT,
];

/// All of them.
#[cfg(test)]
pub fn programs() -> impl Iterator<Item = &'static Program> {
    KERNELS.iter().chain(&PASSES)
}

/// Where shaders come from.
#[derive(Clone, Debug, Default)]
pub enum ShaderSource {
    /// As they were when the program was built.
    #[default]
    Embedded,
    /// Files of a folder, for work on the shaders.
    Folder(PathBuf),
}

impl ShaderSource {
    /// The whole text of a program for scenes with some models.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn text(&self, program: &Program, models: &ModelSet) -> std::io::Result<String> {
        let part = |part| match part {
            MODELS => self.models(models).map(Cow::Owned),
            TONE_CURVE => Ok(Cow::Owned(ToneMap::wgsl())),
            name => self.part(name),
        };
        let texts: std::io::Result<Vec<Cow<str>>> = program.parts.concat().into_iter().map(part).collect();
        Ok(texts?.join("\n"))
    }

    fn models(&self, models: &ModelSet) -> std::io::Result<String> {
        let mut text = models.text();
        for &model in models.models() {
            match self {
                Self::Embedded => text += model.wgsl(),
                Self::Folder(folder) => text += &std::fs::read_to_string(model_file(folder, model))?,
            }
        }
        Ok(text)
    }

    /// Files to watch; none if embedded.
    pub fn files(&self) -> Vec<PathBuf> {
        match self {
            Self::Embedded => Vec::new(),
            Self::Folder(folder) => {
                let parts = PARTS.iter().map(|(name, _)| folder.join(name).with_extension("wgsl"));
                parts.chain(BrdfModel::ALL.iter().map(|&model| model_file(folder, model))).collect()
            }
        }
    }

    fn part(&self, name: &str) -> std::io::Result<Cow<'static, str>> {
        match self {
            Self::Embedded => {
                let part = PARTS.iter().find(|(n, _)| *n == name);
                Ok(Cow::Borrowed(part.expect("programs name files that are embedded").1))
            }
            Self::Folder(folder) => std::fs::read_to_string(folder.join(name).with_extension("wgsl")).map(Cow::Owned),
        }
    }
}

fn model_file(folder: &Path, model: BrdfModel) -> PathBuf {
    folder.join("brdf").join(model.key()).with_extension("wgsl")
}
