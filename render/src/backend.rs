//! The renderer interface of the interactive view and the headless commands, on the CPU or on a GPU.
//!
//! A picture is rendered in steps, between which it can be cancelled: [`Backend::begin`], then [`Backend::render_rows`] for bands
//! of rows of every jittered sample, then [`Backend::display`] or [`Backend::read`] as often as needed. Scene, appearance and light
//! stay until replaced, so an edit redoes only what it changed.

use crate::{
    appearance::Appearance,
    baked::Baked,
    device::{Compute, DeviceCuts},
    error::BackendError,
    light::{
        environment::{EnvironmentLight, Illumination},
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

/// Work in the picture so far, including kept samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureStats {
    /// Samples of pixels that show a surface.
    pub pixels_shaded: u64,
    /// Nodes of the merged cut, averaged over them.
    pub mean_merged_nodes: f64,
    /// BRDF evaluations, averaged over them.
    pub mean_brdf_evaluations: f64,
    /// Samples shaded since [`Backend::begin`] or [`Backend::resume`].
    pub shaded: ShadedSamples,
}

/// Samples of pixels that show a surface, by the computed part of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadedSamples {
    /// Direct light of the environment, or the value of a view mode without light.
    pub environment: u64,
    /// Bounced light.
    pub bounce: u64,
    /// What mirrors show.
    pub mirrors: u64,
    /// Direct light of local lights.
    pub direct: u64,
    /// Direct light of local lights that were added.
    pub added: u64,
}

impl ShadedSamples {
    /// Counts by [`LightPart`].
    pub(crate) fn of([environment, bounce, mirrors, direct, added]: [u64; LightPart::COUNT]) -> Self {
        Self { environment, bounce, mirrors, direct, added }
    }
}

/// Method by which a picture's light was computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// Cuts and bounces of the bake.
    #[default]
    Cuts,
    /// The bake, with implicit visibility for the changes by posed objects.
    Implicit,
    /// Implicit visibility for the environment's light of posed objects; all bounces are those of the posed scene.
    Solved,
}

/// How a picture was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderStats {
    /// `cpu` or `gpu`.
    pub backend: String,
    /// Name of the graphics adapter.
    pub adapter: Option<String>,
    /// Method by which its light was computed.
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

/// Creates a renderer, and a new one when its device is lost.
pub type BackendFactory = Arc<dyn Fn() -> Result<Box<dyn Backend>, BackendError> + Send + Sync>;

/// Renders pictures of one scene after another.
pub trait Backend: Send {
    /// `cpu`, or the name of the graphics adapter.
    fn name(&self) -> String;

    /// Rebuilds its programs, for example after a change of the shaders. On failure the previous ones stay.
    ///
    /// # Errors
    /// A shader that cannot be read or does not compile.
    fn reload(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    /// Device for computations beside the picture: the cores, or the renderer's device if it is not emulated on them.
    fn compute(&self) -> Compute {
        Compute::Cores
    }

    /// Replaces the scene, with the materials of its dataset. Pictures are black until a light is set.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits; the previous scene is kept then.
    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError>;

    /// Poses the current scene: `posed` has other vertex positions, and other visibility cuts for the moved vertices, unless these are
    /// on the device of [`Self::compute`], as `cuts`. Materials and the environment's light stay; set the local lights again before the
    /// next picture.
    ///
    /// # Errors
    /// Cuts beyond the adapter's limits, or a lost device; a scene must then be set before the next picture.
    fn pose(&mut self, posed: &Baked, cuts: Option<&DeviceCuts>) -> Result<(), BackendError>;

    /// Replaces the materials. Returns the changes made to fit them, in sentences.
    ///
    /// # Errors
    /// A lost device.
    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError>;

    /// Lights the scene; `lighting` is made from `light` for the scene's tree, and computed when it is first read. Returns the changes made
    /// to fit the map, in sentences.
    ///
    /// # Errors
    /// A lost device.
    fn set_light(
        &mut self,
        light: &Illumination,
        lighting: &Arc<EnvironmentLight>,
    ) -> Result<Vec<String>, BackendError>;

    /// Sets local lights, bounced light, and the shown components. A new scene has no such light, and shows all components. Returns
    /// the changes made to fit them, in sentences.
    ///
    /// # Errors
    /// Sources beyond the adapter's limits, or a lost device.
    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError>;

    /// Starts a picture and drops the previous one.
    ///
    /// # Errors
    /// A picture larger than the adapter's limits, or a lost device.
    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError>;

    /// Starts a picture that keeps the samples of the last one, unless the view differs or they are `stale` by edits since the last
    /// picture was begun or resumed. Render all samples again from the first. With another camera or size, only the last picture's
    /// data for the sketch is kept.
    ///
    /// # Errors
    /// As [`Self::begin`].
    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        let _ = stale;
        self.begin(view, sampling)
    }

    /// Whether the first sample of the picture that was begun waits for no compiler. Programs that it lacks are being compiled on other
    /// threads; without this call the sample waits for them.
    ///
    /// # Errors
    /// A program that does not compile.
    fn is_ready(&mut self) -> Result<bool, BackendError> {
        Ok(true)
    }

    /// Adds one jittered sample (an index into [`View::pixel_offsets`]) to some rows, and returns when done. Render all rows of a
    /// sample before the next sample. Pixels that already have the sample stay unchanged.
    ///
    /// # Errors
    /// A lost device.
    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError>;

    /// Adds the first sample to the pixels of some [`Tiles`] whose column and row are multiples of `stride`, one of
    /// [`STRIDES`](crate::STRIDES), and returns when done. Pixels that have a sample keep it. A stride of 1 covers all pixels and
    /// gives the sample of [`Self::render_rows`].
    ///
    /// [`Tiles`]: crate::Tiles
    ///
    /// # Errors
    /// A lost device.
    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError>;

    /// Fills pixels without a sample from their neighbors, for [`Self::display`]. All tiles must have been sketched. At most
    /// `most_shaded` pixels that no neighbor fits, as on thin objects, get their first sample instead. Returns the number of these.
    ///
    /// # Errors
    /// A lost device.
    fn fill(&mut self, most_shaded: u32) -> Result<u32, BackendError>;

    /// The picture so far as displayed: sRGB-encoded, not premultiplied, row by row from the top.
    ///
    /// `samples` is the number of samples that all rows have; rows that already have one more must not look brighter.
    ///
    /// # Errors
    /// A lost device.
    fn display(&mut self, post: &Post, samples: u32) -> Result<Vec<[u8; 4]>, BackendError>;

    /// The picture so far, scene-linear, and the surface coverage of each pixel, 0 to 1.
    ///
    /// # Errors
    /// A lost device.
    fn read(&mut self, samples: u32) -> Result<(Image, Vec<f32>), BackendError>;

    /// Work in the picture so far, including kept samples.
    ///
    /// # Errors
    /// A lost device.
    fn stats(&mut self) -> Result<PictureStats, BackendError>;
}
