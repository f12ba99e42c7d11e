//! The shaders: plain WGSL, one pass or kernel per file, joined with the libraries that it uses.

use super::{models::ModelSet, output::Output};
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
    "boundaries_pass",
    "brdf",
    "brdf_dispatch",
    "brdf_written",
    "bumps",
    "camera",
    "cells",
    "coefficient",
    "color",
    "concentric",
    "cone",
    "cut",
    "cut_vertex",
    "direct_lights",
    "direct_pass",
    "display_pass",
    "distance_key",
    "entries",
    "environment",
    "fans_pass",
    "first_part",
    "forest",
    "frame",
    "fullscreen",
    "geometry",
    "glossy_leaves",
    "guide",
    "hemisphere",
    "hierarchy",
    "history_pass",
    "implicit_bounce_kernel",
    "implicit_cover",
    "implicit_cuts",
    "implicit_cuts_count_kernel",
    "implicit_cuts_write_kernel",
    "implicit_gloss_kernel",
    "implicit_leaves_kernel",
    "implicit_nodes_kernel",
    "implicit_pull_kernel",
    "implicit_update_kernel",
    "implicit_vertices_kernel",
    "implicit_visit",
    "implicit_walk_kernel",
    "keep_pass",
    "leaf_beside",
    "leaf_light",
    "leaf_value",
    "lit_count_kernel",
    "lit_cut",
    "lit_parts",
    "lit_write_kernel",
    "marks_pass",
    "materials",
    "merge_pass",
    "merged_tree",
    "meshless_pass",
    "mirror",
    "mirror_rays_pass",
    "mirrored_surface_pass",
    "mirrors_pass",
    "node",
    "octahedron",
    "opacity",
    "ordered",
    "parameters_pass",
    "past",
    "posed",
    "predict_pass",
    "prefix_sums",
    "probe_pass",
    "procedural",
    "radiosity_count_kernel",
    "radiosity_gather_kernel",
    "radiosity_level",
    "radiosity_pull_kernel",
    "radiosity_scan_kernel",
    "radiosity_write_kernel",
    "ray_origin",
    "ray_shift",
    "ray_start",
    "rays_pass",
    "receiver",
    "refine",
    "reflected_light",
    "replaced_cuts_kernel",
    "rough",
    "scene",
    "second_rays_pass",
    "seen_along",
    "seen_surface",
    "sent",
    "shading_point",
    "shadow",
    "shadow_filter",
    "shadow_pass",
    "shadow_rays_pass",
    "sketch_pass",
    "slice",
    "sums",
    "sun_cells",
    "sun_rays",
    "suns_pass",
    "surface",
    "surface_pass",
    "tables",
    "tonemap",
    "traverse",
    "tree",
    "turned",
    "turned_leaves_kernel",
    "turned_means_kernel",
    "turned_nodes_kernel",
    "visibility_pass",
    "wavelet_pass",
    "wireframe",
);

/// A pass or a kernel with the libraries that it uses, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Name of the pass.
    pub name: &'static str,
    /// What several programs begin with, and the rest.
    pub parts: [&'static [&'static str]; 2],
    /// What it writes if it has two entry points, whose text is added.
    pub output: Option<Output>,
}

/// In place of a file the models that a scene uses, and the dispatch to them.
pub const MODELS: &str = "models";

/// The same for points whose values come without maps: models of files are left out.
pub const MODELS_WITHOUT_MAPS: &str = "models_without_maps";

/// In place of a file the choice of a tone curve.
pub const TONE_CURVE: &str = "tone_curve";

/// Where shaders come from.
#[derive(Clone, Debug, Default)]
pub enum ShaderSource {
    /// As they were when the program was built.
    #[default]
    Embedded,
    /// Files of a folder, for work on the shaders.
    Folder(PathBuf),
    /// The embedded ones, with each program changed.
    #[cfg(test)]
    Changed(fn(&str) -> String),
}

impl ShaderSource {
    /// Whether they are being edited.
    pub fn is_edited(&self) -> bool {
        matches!(self, Self::Folder(_))
    }

    /// The whole text of a program for scenes with some models.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn text(&self, program: &Program, models: &ModelSet) -> std::io::Result<String> {
        let part = |part| match part {
            MODELS => self.models(models).map(Cow::Owned),
            MODELS_WITHOUT_MAPS => self.models(&models.without_maps()).map(Cow::Owned),
            TONE_CURVE => Ok(Cow::Owned(ToneMap::wgsl())),
            name => self.part(name),
        };
        let texts: std::io::Result<Vec<Cow<str>>> = program.parts.concat().into_iter().map(part).collect();
        let mut text = texts?.join("\n");
        if let Some(output) = program.output {
            text += &output.entries(&self.part("entries")?);
        }
        #[cfg(test)]
        if let Self::Changed(change) = self {
            return Ok(change(&text));
        }
        Ok(text)
    }

    /// Texts in which the models of a scene are filled: the dispatch to them, and what one has that a user wrote.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn templates(&self) -> std::io::Result<[Cow<'static, str>; 2]> {
        Ok([self.part("brdf_dispatch")?, self.part("brdf_written")?])
    }

    fn models(&self, models: &ModelSet) -> std::io::Result<String> {
        let [dispatch, written] = self.templates()?;
        let mut text = models.text([&dispatch, &written]);
        for &model in models.models() {
            match self {
                Self::Folder(folder) => text += &std::fs::read_to_string(model_file(folder, model))?,
                _ => text += model.wgsl(),
            }
        }
        Ok(text)
    }

    /// Files to watch; none if embedded.
    pub fn files(&self) -> Vec<PathBuf> {
        let Self::Folder(folder) = self else { return Vec::new() };
        let parts = PARTS.iter().map(|(name, _)| folder.join(name).with_extension("wgsl"));
        parts.chain(BrdfModel::ALL.iter().map(|&model| model_file(folder, model))).collect()
    }

    fn part(&self, name: &str) -> std::io::Result<Cow<'static, str>> {
        if let Self::Folder(folder) = self {
            return std::fs::read_to_string(folder.join(name).with_extension("wgsl")).map(Cow::Owned);
        }
        let part = PARTS.iter().find(|(n, _)| *n == name);
        Ok(Cow::Borrowed(part.expect("programs name files that are embedded").1))
    }
}

fn model_file(folder: &Path, model: BrdfModel) -> PathBuf {
    folder.join("brdf").join(model.key()).with_extension("wgsl")
}
