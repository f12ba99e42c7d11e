//! The error of a picture, split into its causes by replacing one factor at a time with its true value.
//!
//! A chain of pictures leads from the rendered one to light paths. All use the same samples of the same pixels; none is estimated.
//! Their background is black, so an environment behind the scene does not enter any norm. Neighbors differ in one factor only, and
//! their difference is that factor's error:
//!
//! | picture | sum over | radiance | visibility | BRDF | what the step to the next one shows |
//! |---|---|---|---|---|---|
//! | [`Rendered`](SplitPicture::Rendered) | nodes of lit cuts | node mean | interpolated lit cuts | one sample per node | lit cuts |
//! | [`StoredCuts`](SplitPicture::StoredCuts) | nodes of the merged cut, refined or not | node mean | interpolated cuts | one sample per node | BRDF sampling |
//! | [`MeanBrdf`](SplitPicture::MeanBrdf) | the same nodes | node mean | interpolated cuts | mean over the node's leaves | the light's clusters |
//! | [`AllLeaves`](SplitPicture::AllLeaves) | all leaves | leaf | interpolated cuts | leaf | the clusters of the visibility cuts |
//! | [`TracedVertices`](SplitPicture::TracedVertices) | all leaves | leaf | rays from the three vertices, interpolated | leaf | interpolation |
//! | [`Samples`](SplitPicture::Samples) | all leaves | leaf | rays from the pixel | leaf | light samples |
//! | [`Paths`](SplitPicture::Paths) | light paths | continuous | rays | continuous | |
//!
//! Without lit cuts, `StoredCuts` is the rendered picture and is left out. `MeanBrdf` is Eq. 4 of the paper; the renderer samples
//! by Eq. 6. `TracedVertices` needs a function that traces vertices as the bake did. Without one, and for surface sources, it is
//! left out, and one step shows both visibility errors. For surface sources the paths have one bounce, and the last step includes
//! the error of the sources' discs. Step errors are vectors: they may cancel and do not sum to the total. No lobe reads the
//! environment's map here, and none has rays ([`crate::shade::mirror`]): only light samples are split.

mod leaf_sum;
pub(crate) mod vertices;

use crate::{
    light::{
        bounce::SourceLighting,
        components::Components,
        environment::{Illumination, SceneLighting},
    },
    measure::{
        compare::{CompareError, compare},
        cut_light::{CutLight, FieldJob, NoCuts},
        region::picture_of,
    },
    reference::{
        path::settings::PathSettings,
        samples::{distant::LightSamples, sources::SourceSamples},
    },
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::Backdrop,
        merge::Shader,
        node_field::NodeField,
        pixel_sampler::PixelSampler,
        point_shader::PointShader,
        surface::{FirstHit, SurfacePoint},
    },
    view::{Preview, Progress, View},
};
use glam::Vec3;
use lapidary_core::{
    cut::packed::PackedCuts,
    image::{Image, Region, RegionError},
    lights::Light,
};
use leaf_sum::NodesByLeaves;
use serde::Serialize;
use thiserror::Error;
use vertices::{TraceVertex, TracedVertices};

/// The picture whose error is split.
#[derive(Clone, Copy)]
pub struct SplitJob<'a> {
    /// Camera, size and samples of the picture.
    pub view: &'a View,
    /// Pixels to split.
    pub region: Region,
    /// Light gathered by cuts, with its illumination cut.
    pub light: CutLight<'a>,
    /// BRDF sampling on nodes.
    pub sampling: BrdfSampling,
    /// The continuous environment: the true light of the environment's tree and of its bounces.
    pub illumination: &'a Illumination,
    /// Local lights whose bounce the sources hold.
    pub lights: &'a [Light],
    /// Paths per pixel; rounded up to whole sets of the pixel's samples for each of two halves.
    pub spp: u32,
    /// Traces a vertex of the environment's cuts as the bake did.
    pub trace_vertex: Option<TraceVertex<'a>>,
}

/// One picture of the chain from the rendered one to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplitPicture {
    /// As rendered.
    Rendered,
    /// Stored cuts and the illumination cut in place of lit cuts, refined.
    StoredCuts,
    /// The same nodes, each with the mean BRDF over its leaves.
    MeanBrdf,
    /// All leaves, with the interpolated visibility of the stored cuts.
    AllLeaves,
    /// All leaves, with the interpolated visibility of rays from the vertices.
    TracedVertices,
    /// All leaves, with rays from the pixel: the samples reference.
    Samples,
    /// Light paths.
    Paths,
}

impl SplitPicture {
    /// Name in file names and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rendered => "rendered",
            Self::StoredCuts => "stored-cuts",
            Self::MeanBrdf => "mean-brdf",
            Self::AllLeaves => "all-leaves",
            Self::TracedVertices => "traced-vertices",
            Self::Samples => "samples",
            Self::Paths => "paths",
        }
    }
}

/// The difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SplitStep {
    /// The factor in which they differ.
    pub factor: &'static str,
    /// The picture farther from the truth.
    pub from: SplitPicture,
    /// The picture closer to the truth.
    pub to: SplitPicture,
    /// Root mean square of the difference.
    pub rmse: f64,
    /// RMSE over the root mean square of `to`.
    pub rel_rmse: f64,
    /// Mean FLIP of the difference.
    pub flip: f64,
    /// Share of `rel_rmse` that is noise of the light paths, from the difference of two halves; squares of error and noise add.
    pub noise: f64,
}

/// A picture's error by cause.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorSplit {
    /// Split pixels.
    pub region: Region,
    /// Paths per pixel.
    pub spp: u32,
    /// Steps between neighbors of the chain, from the rendered picture to the truth.
    pub steps: Vec<SplitStep>,
    /// Difference of the rendered picture from the truth.
    pub total: SplitStep,
    /// All pictures in chain order.
    #[serde(skip)]
    pub pictures: Vec<(SplitPicture, Image)>,
}

/// Why an error cannot be split.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum SplitError {
    /// Invalid region.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The region shows only background.
    #[error("no pixel of the region shows a surface; choose a region that does")]
    NoSurface,
    /// The dataset lacks the cuts.
    #[error(transparent)]
    NoCuts(#[from] NoCuts),
    /// The pictures have no finite pixels.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

impl Renderer {
    /// Splits the error of a picture or a part of it; `None` if cancelled. `progress` receives every picture of the
    /// chain as soon as it is complete.
    ///
    /// # Errors
    /// A region without pixels or surfaces, or a dataset without cuts for this light.
    pub fn split_error(&self, job: &SplitJob, progress: &dyn Progress) -> Result<Option<ErrorSplit>, SplitError> {
        job.region.check(job.view.size)?;
        let cuts = job.light.cuts_of(&self.dataset)?;
        let mut plain = match job.light {
            CutLight::Environment(lighting) => Some(lighting.clone()),
            CutLight::Sources(_) => None,
        };
        plain.iter_mut().for_each(|lighting| lighting.lights.mirrored = None);
        let job = &SplitJob { light: plain.as_ref().map_or(job.light, CutLight::Environment), ..*job };
        let view = View { mirrors: false, ..job.view.of_surfaces() };
        let backdrop = Backdrop::black();
        let chain = Chain { renderer: self, sampler: PixelSampler::new(self, &view, &backdrop), cuts, job, progress };
        if !chain.shows_surface() {
            return Err(SplitError::NoSurface);
        }
        let Some((pictures, noise)) = chain.pictures() else { return Ok(None) };
        Ok(Some(split_of(job, pictures, noise)?))
    }
}

/// Errors between neighboring pictures; the last picture has `noise`.
fn split_of(job: &SplitJob, pictures: Vec<(SplitPicture, Image)>, noise: f64) -> Result<ErrorSplit, CompareError> {
    let step = |factor, (from, a): &(SplitPicture, Image), (to, b): &(SplitPicture, Image)| {
        let metrics = compare(a, b)?;
        let noise = if *to == SplitPicture::Paths { noise } else { 0.0 };
        let (rmse, rel_rmse, flip) = (metrics.rmse, metrics.rel_rmse, metrics.flip);
        Ok(SplitStep { factor, from: *from, to: *to, rmse, rel_rmse, flip, noise })
    };
    let neighbours = pictures.windows(2).map(|pair| step(factor(pair[0].0, pair[1].0), &pair[0], &pair[1]));
    let steps = neighbours.collect::<Result<_, CompareError>>()?;
    let total = step("all", &pictures[0], &pictures[pictures.len() - 1])?;
    Ok(ErrorSplit { region: job.region, spp: 2 * half_of(job), steps, total, pictures })
}

/// The factor in which two neighbors of the chain differ.
fn factor(from: SplitPicture, to: SplitPicture) -> &'static str {
    match (from, to) {
        (SplitPicture::Rendered, SplitPicture::StoredCuts) => "lit cuts",
        (SplitPicture::Rendered | SplitPicture::StoredCuts, _) => "BRDF sampling",
        (SplitPicture::MeanBrdf, _) => "light clusters",
        (SplitPicture::AllLeaves, SplitPicture::Samples) => "visibility",
        (SplitPicture::AllLeaves, _) => "visibility clusters",
        (SplitPicture::TracedVertices, _) => "interpolation",
        (SplitPicture::Samples | SplitPicture::Paths, _) => "light samples",
    }
}

/// Paths per pixel in each half: whole patterns of the pixel's samples.
fn half_of(job: &SplitJob) -> u32 {
    job.spp.div_ceil(2).max(1).next_multiple_of(job.view.aa.max(1))
}

/// State of computing the pictures.
struct Chain<'a> {
    renderer: &'a Renderer,
    sampler: PixelSampler<'a>,
    cuts: &'a PackedCuts,
    job: &'a SplitJob<'a>,
    progress: &'a dyn Progress,
}

/// Units of progress per pixel for a picture of all leaves; a path is one unit.
const LEAVES_UNITS: u64 = 16;

impl Chain<'_> {
    fn shows_surface(&self) -> bool {
        let samples = self.job.view.aa.max(1) as usize;
        let is_surface = |x, y| (0..samples).any(|i| matches!(self.sampler.sight(x, y, i).seen, FirstHit::Surface(_)));
        self.job.region.rows().any(|y| self.job.region.columns().any(|x| is_surface(x, y)))
    }

    /// All pictures and the noise of the last one; `None` if cancelled.
    fn pictures(&self) -> Option<(Vec<(SplitPicture, Image)>, f64)> {
        let mut pictures = Vec::new();
        let suns = self.suns();
        let mut push = |kind, mut image: Image| {
            // Paths find suns in the map.
            suns.iter().filter(|_| kind != SplitPicture::Paths).for_each(|suns| image.add(suns));
            self.progress.preview(&Preview { image: &image, step: 1, noise: None });
            pictures.push((kind, image));
        };
        push(SplitPicture::Rendered, self.merged(self.job.sampling)?);
        if self.job.sampling == BrdfSampling::Lit {
            push(SplitPicture::StoredCuts, self.merged(self.stored_sampling())?);
        }
        push(SplitPicture::MeanBrdf, self.job.light.with_field(MeanBrdf { chain: self, number: 1 })?);
        push(SplitPicture::AllLeaves, self.all_leaves()?);
        if let (CutLight::Environment(lighting), Some(trace)) = (self.job.light, self.job.trace_vertex) {
            let traced = TracedVertices::new(lighting, trace);
            push(SplitPicture::TracedVertices, self.picture(3, || traced.shader(lighting))?);
        }
        push(SplitPicture::Samples, self.samples()?);
        let (paths, noise) = self.paths()?;
        push(SplitPicture::Paths, paths);
        Some((pictures, noise))
    }

    /// Direct light of the suns, by rays; cuts do not contain it.
    fn suns(&self) -> Option<Image> {
        let suns = match self.job.light {
            CutLight::Environment(_) => self.job.illumination.suns(),
            CutLight::Sources(_) => Vec::new(),
        };
        let view = View { region: Some(self.job.region), ..self.sampler.view.clone() };
        (!suns.is_empty()).then(|| self.renderer.direct_light(&view, &suns).crop(self.job.region))
    }

    /// BRDF sampling for nodes of stored cuts.
    fn stored_sampling(&self) -> BrdfSampling {
        match self.job.sampling {
            BrdfSampling::Lit | BrdfSampling::Refine => BrdfSampling::Refine,
            BrdfSampling::Once => BrdfSampling::Once,
        }
    }

    /// The picture as rendered.
    fn merged(&self, sampling: BrdfSampling) -> Option<Image> {
        self.job.light.with_field(Merged { chain: self, sampling })
    }

    /// All leaves separately: the nodes of an illumination cut of all leaves.
    fn all_leaves(&self) -> Option<Image> {
        match self.job.light {
            CutLight::Environment(lighting) => {
                let tree = &self.renderer.dataset.tree;
                let leaves = SceneLighting::new(tree, &lighting.nodes.radiance[tree.len()..], tree.len() as u32);
                CutLight::Environment(&leaves).with_field(MeanBrdf { chain: self, number: 2 })
            }
            CutLight::Sources(lighting) => {
                let count = lighting.lights.len();
                let radiance = &lighting.nodes.radiance[count..];
                let leaves = SourceLighting::new(lighting.lights.clone(), radiance, count as u32)
                    .with_sent(lighting.sent.clone());
                CutLight::Sources(&leaves).with_field(MeanBrdf { chain: self, number: 2 })
            }
        }
    }

    fn samples(&self) -> Option<Image> {
        match self.job.light {
            CutLight::Environment(lighting) => {
                let samples = LightSamples::of(&self.renderer.dataset.tree, lighting);
                self.picture(4, || samples.shader(self.renderer))
            }
            CutLight::Sources(lighting) => {
                let samples = SourceSamples::new(self.renderer, lighting);
                self.picture(4, || samples.shader(self.renderer))
            }
        }
    }

    /// Light paths, and their noise as a relative RMSE from the difference of two halves.
    fn paths(&self) -> Option<(Image, f64)> {
        let half = half_of(self.job);
        let components = match self.job.light {
            CutLight::Environment(_) => Components { environment: true, ..Components::NONE },
            CutLight::Sources(_) => Components { indirect: true, ..Components::NONE },
        };
        let bounces = u32::from(components.indirect);
        let job = self.job;
        let settings = PathSettings { bounces, components, ..PathSettings::direct(2 * half) };
        let view = View { region: Some(job.region), ..self.sampler.view.clone() };
        let part = self.part(5, 0, 2 * u64::from(half));
        let picture = self.renderer.path_picture(&view, job.illumination, job.lights, settings, &part);
        (!self.progress.cancelled()).then(|| (picture.image.crop(job.region), picture.noise.unwrap_or(0.0)))
    }

    fn picture<S: PointShader>(&self, number: u64, shader: impl Fn() -> S + Sync) -> Option<Image> {
        picture_of(&self.sampler, self.job.region, shader, &self.part(number, 0, LEAVES_UNITS))
    }

    /// Progress of picture `number`, after `before` units of earlier pictures, with `units` per pixel.
    fn part(&self, number: u64, before: u64, units: u64) -> Part<'_> {
        let total = 5 * LEAVES_UNITS + 2 * u64::from(half_of(self.job));
        Part { whole: self.progress, before: number * LEAVES_UNITS + before, units, total }
    }
}

/// Picture of the merged cut's nodes with their mean BRDF.
struct MeanBrdf<'a> {
    chain: &'a Chain<'a>,
    /// Index in the chain.
    number: u64,
}

impl FieldJob for MeanBrdf<'_> {
    type Output = Option<Image>;

    fn run<F: NodeField + Sync>(self, field: F) -> Option<Image> {
        let Self { chain, number } = self;
        chain.picture(number, || NodesByLeaves::new(Shader::new(field, chain.cuts, chain.stored_sampling()), field))
    }
}

/// A picture as rendered.
struct Merged<'a> {
    chain: &'a Chain<'a>,
    sampling: BrdfSampling,
}

impl FieldJob for Merged<'_> {
    type Output = Option<Image>;

    fn run<F: NodeField + Sync>(self, field: F) -> Option<Image> {
        let Self { chain, sampling } = self;
        chain.picture(0, || Shader::new(field, chain.cuts, sampling))
    }
}

impl<F: NodeField> PointShader for Shader<'_, F> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        Shader::shade(self, point)
    }
}

/// Progress of a part of the work.
struct Part<'a> {
    whole: &'a dyn Progress,
    before: u64,
    units: u64,
    total: u64,
}

impl Progress for Part<'_> {
    fn advanced(&self, done: u64, total: u64) {
        self.whole.advanced(self.before * total + self.units * done, self.total * total);
    }

    fn cancelled(&self) -> bool {
        self.whole.cancelled()
    }
}

#[cfg(test)]
mod tests;
