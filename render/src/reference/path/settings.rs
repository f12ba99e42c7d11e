//! The light paths of a picture.

use crate::light::components::Components;
use serde::Deserialize;

/// The paths of [`Renderer::path_reference`](crate::Renderer::path_reference), and their number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// Paths per pixel; noise falls with the square root.
    pub spp: u32,
    /// Number of the first path: pictures of other paths have other noise.
    pub first_pass: u32,
    /// Largest number of reflections between surfaces before the one toward the eye: 0 is direct light, 1 adds one
    /// indirect bounce.
    pub bounces: u32,
    /// Components of the light in the picture.
    pub components: Components,
    /// Where in the pixels paths begin.
    pub positions: SamplePositions,
}

/// Positions of samples in a pixel: where in it paths begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplePositions {
    /// The positions at which cuts are shaded ([`View::pixel_offsets`](crate::View::pixel_offsets)), with the same footprints in
    /// maps: the two pictures differ by light alone. A path has one of the normals of a footprint.
    #[default]
    Shared,
    /// Random positions: in each pixel, and for each first path, the pattern is shifted by another random vector
    /// (Cranley and Patterson 1976), so that no position repeats. The expected value is the mean over the whole pixel,
    /// as in other renderers, and the error of a finite pattern is noise. Maps are looked up at points.
    Shifted,
}

impl PathSettings {
    /// All direct light.
    pub fn direct(spp: u32) -> Self {
        Self { spp, first_pass: 0, bounces: 0, components: Components::ALL, positions: SamplePositions::Shared }
    }
}
