//! Everything that decides a picture of a baked scene.

use crate::{Appearance, BrdfSampling, Components, Illumination, Post, Solution, View};
use lapidary_core::lights::Light;
use std::sync::Arc;

/// Everything that decides a picture of a baked scene. Copying it copies no texels and no maps.
#[derive(Clone, Debug)]
pub struct Look {
    /// Materials and textures.
    pub appearance: Appearance,
    /// The environment as it is turned and scaled.
    pub light: Illumination,
    /// Local lights.
    pub lights: Arc<[Light]>,
    /// Which parts of the light are in the picture.
    pub components: Components,
    /// How bounced light is computed; one that the dataset has.
    pub solution: Solution,
    /// Most nodes of the illumination cut.
    pub illum_cut: u32,
    /// How the BRDF is sampled.
    pub sampling: BrdfSampling,
    /// Camera, size, samples a pixel, and what lies behind the scene.
    pub view: View,
    /// Exposure and tone curve, of what is shown and not of scene-linear files.
    pub post: Post,
}

impl Look {
    /// Whether surfaces are the same.
    pub fn same_appearance(&self, other: &Self) -> bool {
        let (a, b) = (&self.appearance, &other.appearance);
        let same_texture = |(a, b): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(a, b);
        a.materials == b.materials
            && a.textures.len() == b.textures.len()
            && a.textures.iter().zip(&b.textures).all(same_texture)
    }

    /// Whether both give one scene-linear picture; exposure and tone curve may differ.
    pub fn same_picture(&self, other: &Self) -> bool {
        self.same_appearance(other) && self.same_but_for_surfaces(other)
    }

    /// The same, whatever the surfaces look like.
    pub fn same_but_for_surfaces(&self, other: &Self) -> bool {
        // All fields by name, so that a new one is not forgotten.
        let Self { appearance: _, light: _, lights, components, solution, illum_cut: _, sampling, view, post: _ } =
            self;
        self.same_environment(other)
            && *lights == other.lights
            && (*components, *solution) == (other.components, other.solution)
            && *sampling == other.sampling
            && *view == other.view
    }

    /// Whether the environment and its illumination cut are the same.
    pub fn same_environment(&self, other: &Self) -> bool {
        same_light(&self.light, &other.light) && self.illum_cut == other.illum_cut
    }
}

/// Whether both give the same light.
pub fn same_light(a: &Illumination, b: &Illumination) -> bool {
    Arc::ptr_eq(&a.environment, &b.environment) && a.rotation == b.rotation && a.intensity == b.intensity
}
