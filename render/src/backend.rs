//! The interface of the interactive view and of the headless commands to a renderer, on the CPU or on a GPU.
//!
//! A picture is made in steps, between which it can be cancelled: [`Backend::begin`], then [`Backend::render_rows`] for
//! bands of rows of every jittered sample, then [`Backend::display`] or [`Backend::read`] as often as needed. Scene,
//! appearance and light stay until they are replaced, so that an edit redoes only what it changed.

use crate::{
    appearance::Appearance,
    baked::Baked,
    device::Compute,
    error::BackendError,
    light::{
        environment::{Illumination, SceneLighting},
        local::LocalLighting,
    },
    post::Post,
    sampling::BrdfSampling,
    stale::{LightPart, Stale},
    view::View,
};
use lapidary_core::image::Image;
use serde::Serialize;
use std::{ops::Range, sync::Arc};

/// Work in the picture so far, that of kept samples included.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureStats {
    /// Samples of pixels that show a surface.
    pub pixels_shaded: u64,
    /// Nodes of the merged cut, averaged over them.
    pub mean_merged_nodes: f64,
    /// BRDF evaluations, averaged over them.
    pub mean_brdf_evaluations: f64,
    /// Samples that were shaded for it since [`Backend::begin`] or [`Backend::resume`].
    pub shaded: ShadedSamples,
}

/// Samples of pixels that show a surface, by the part of the light that was computed for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadedSamples {
    /// Direct light of the environment, or what a view mode without light shows.
    pub environment: u64,
    /// Bounced light.
    pub bounce: u64,
    /// Direct light of local lights.
    pub direct: u64,
    /// Direct light of local lights that were added.
    pub added: u64,
}

impl ShadedSamples {
    /// Counts by [`LightPart`].
    pub(crate) fn of([environment, bounce, direct, added]: [u64; LightPart::COUNT]) -> Self {
        Self { environment, bounce, direct, added }
    }
}

/// By what the light of a picture was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// By the cuts and the bounces of the bake.
    #[default]
    Cuts,
    /// By the bake, and by implicit visibility what posed objects change of it.
    Implicit,
}

/// How a picture was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderStats {
    /// `cpu` or `gpu`.
    pub backend: String,
    /// Name of the graphics adapter.
    pub adapter: Option<String>,
    /// By what its light was found.
    pub tier: Tier,
    /// Wall-clock seconds for light, illumination cut and pixels.
    pub seconds: f64,
    /// Samples of pixels that show a surface.
    pub pixels_shaded: u64,
    /// Nodes of the merged cut, averaged over them.
    pub mean_merged_nodes: f64,
    /// BRDF evaluations, averaged over them.
    pub mean_brdf_evaluations: f64,
}

impl From<&RenderStats> for PictureStats {
    fn from(stats: &RenderStats) -> Self {
        let &RenderStats { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations, .. } = stats;
        Self { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations, shaded: ShadedSamples::default() }
    }
}

/// Makes a renderer, and another one when its device is lost.
pub type BackendFactory = Arc<dyn Fn() -> Result<Box<dyn Backend>, BackendError> + Send + Sync>;

/// Makes pictures of one scene after another.
pub trait Backend: Send {
    /// `cpu`, or the name of the graphics adapter.
    fn name(&self) -> String;

    /// Rebuilds its programs, as after a change of the shaders. If that fails, the previous ones stay.
    ///
    /// # Errors
    /// A shader that cannot be read or does not compile.
    fn reload(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    /// What computes beside the picture: the cores, or its device if that is more than an emulation on them.
    fn compute(&self) -> Compute {
        Compute::Cores
    }

    /// Sets another scene with the materials of its dataset. Until a light is set, pictures of it are black.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits; the previous scene is kept then.
    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError>;

    /// Takes the scene that it has as it is posed now: the same one, with vertices elsewhere and other visibility cuts for these.
    /// Materials stay; the light is to be set again before a picture is made.
    ///
    /// # Errors
    /// Cuts beyond the adapter's limits, or a lost device; no picture is made then before a scene is set.
    fn pose(&mut self, posed: &Baked) -> Result<(), BackendError>;

    /// Sets other materials. Returns what was changed to make them fit, in sentences.
    ///
    /// # Errors
    /// A lost device.
    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError>;

    /// Lights the scene; `lighting` is made from `light` for the tree of the scene. Returns what was changed to make
    /// the map fit, in sentences.
    ///
    /// # Errors
    /// A lost device.
    fn set_light(&mut self, light: &Illumination, lighting: &Arc<SceneLighting>) -> Result<Vec<String>, BackendError>;

    /// Sets local lights, bounced light, and the components that are shown. A new scene has no such light, and all
    /// components are shown. Returns what was changed to make them fit, in sentences.
    ///
    /// # Errors
    /// Sources beyond the adapter's limits, or a lost device.
    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError>;

    /// Begins a picture; what was rendered before is forgotten.
    ///
    /// # Errors
    /// A picture larger than the adapter's limits, or a lost device.
    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError>;

    /// Begins a picture that keeps what the last one has, unless it is of another view or `stale`: edits since the last
    /// one was begun or resumed. All samples are then rendered from the first on. Of another camera or size, nothing is
    /// kept but what the last picture tells of the sketch.
    ///
    /// # Errors
    /// As [`Self::begin`].
    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        let _ = stale;
        self.begin(view, sampling)
    }

    /// Adds one jittered sample (an index into [`View::pixel_offsets`]) to some rows, and returns when it is done.
    /// All rows of a sample are rendered before those of the next. Pixels that have the sample already stay as they are.
    ///
    /// # Errors
    /// A lost device.
    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError>;

    /// Adds the first sample to the pixels of some [`Tiles`] whose column and row are multiples of `stride`, one of
    /// [`STRIDES`](crate::STRIDES), and returns when it is done. Pixels that have a sample keep it. With a stride of 1 these
    /// are all pixels, and the sample is that of [`Self::render_rows`].
    ///
    /// [`Tiles`]: crate::Tiles
    ///
    /// # Errors
    /// A lost device.
    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError>;

    /// Fills the pixels without a sample from those around them, for [`Self::display`]. All tiles must have been sketched.
    /// A pixel that nothing around it resembles, as on a thin object, is given its first sample if it is one of at most
    /// `most_shaded`. Returns how many were.
    ///
    /// # Errors
    /// A lost device.
    fn fill(&mut self, most_shaded: u32) -> Result<u32, BackendError>;

    /// The picture so far for a display: sRGB-encoded, not premultiplied, row by row from the top.
    ///
    /// `samples` is the number of samples that all rows have; some rows may already have one more, which must not make
    /// them brighter.
    ///
    /// # Errors
    /// A lost device.
    fn display(&mut self, post: &Post, samples: u32) -> Result<Vec<[u8; 4]>, BackendError>;

    /// The picture so far, scene-linear, and how much of each pixel is covered by surfaces, 0 to 1.
    ///
    /// # Errors
    /// A lost device.
    fn read(&mut self, samples: u32) -> Result<(Image, Vec<f32>), BackendError>;

    /// Work in the picture so far, that of kept samples included.
    ///
    /// # Errors
    /// A lost device.
    fn stats(&mut self) -> Result<PictureStats, BackendError>;
}
