//! Settings of light paths.

use crate::light::components::Components;
use serde::Deserialize;

/// Kind and number of the paths in [`Renderer::path_reference`](crate::Renderer::path_reference).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// Paths per pixel; noise falls with the square root.
    pub spp: u32,
    /// Index of the first path: pictures with other paths have independent noise.
    pub first_pass: u32,
    /// Most reflections between surfaces before the one toward the eye: 0 is direct light, 1 adds one bounce.
    pub bounces: u32,
    /// Components of the light in the picture.
    pub components: Components,
    /// Start positions of paths in the pixels.
    pub positions: SamplePositions,
}

/// Positions of samples in a pixel, where paths start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplePositions {
    /// The positions at which cuts are shaded ([`View::pixel_offsets`](crate::View::pixel_offsets)), with the same footprints in
    /// maps: the two pictures differ in their light alone. A path has one normal of a footprint.
    #[default]
    Shared,
    /// Random positions: a random vector (Cranley and Patterson 1976) per pixel and first path shifts the pattern, so no position
    /// repeats. The expected value is the mean over the whole pixel, as in other renderers; the error of a finite pattern is noise.
    /// Maps use point lookups.
    Shifted,
}

impl PathSettings {
    /// Direct light only.
    pub fn direct(spp: u32) -> Self {
        Self { spp, first_pass: 0, bounces: 0, components: Components::ALL, positions: SamplePositions::Shared }
    }
}
