//! Which light paths a picture is made of.

use crate::light::components::Components;
use serde::Deserialize;

/// What [`Renderer::path_reference`](crate::Renderer::path_reference) follows, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// Paths per pixel; noise falls with the square root.
    pub spp: u32,
    /// Number of the first path: pictures of other paths have other noise.
    pub first_pass: u32,
    /// Most reflections of light between surfaces before the one toward the eye: 0 is direct light, 1 adds one indirect
    /// bounce.
    pub bounces: u32,
    /// What of the light is in the picture.
    pub components: Components,
    /// Where in the pixels paths begin.
    pub positions: SamplePositions,
}

/// Positions of samples in a pixel: where in it paths begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplePositions {
    /// Where cuts are shaded ([`View::pixel_offsets`](crate::View::pixel_offsets)): pictures of the two differ by light alone.
    #[default]
    Shared,
    /// Anywhere: in each pixel, and for each first path, the pattern is shifted by another random vector (Cranley and
    /// Patterson 1976), and no position comes twice. The mean is that over the whole pixel, as other renderers have it, and
    /// what a pattern misses is noise.
    Shifted,
}

impl PathSettings {
    /// All direct light.
    pub fn direct(spp: u32) -> Self {
        Self { spp, first_pass: 0, bounces: 0, components: Components::ALL, positions: SamplePositions::Shared }
    }
}
