//! `lapidary explain`: the origin of a pixel's light, and the error of a picture by cause.

mod report;
mod sheet;

use crate::{
    args::{LocalLightArgs, ViewArgs, ViewedScene, choices},
    outputs::{CommandFiles, take_folder},
    terminal::{Console, Outcome, ProgressReporter, StepProgress, write_json},
    values,
};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_precompute::VertexSampler;
use lapidary_render::{
    BrdfSampling, Components, CpuBackend, CutLight, ErrorSplit, GatheredLight, LitScene, Look, NoCuts,
    PixelExplanation, Region, Renderer, Solution, SplitJob,
};
use serde::Serialize;
use std::path::PathBuf;

/// Options of `explain`.
#[derive(Args, Clone, Debug)]
pub struct ExplainArgs {
    /// Pixel to explain: its column and row, counted from 0 at the top left
    #[arg(long, value_name = "X,Y", value_parser = values::pixel)]
    pixel: Option<[u32; 2]>,
    /// Region whose error is split: left column, top row, width and height [default: 64 x 64 pixels around the pixel; the whole
    /// picture without a pixel]
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::region)]
    region: Option<Region>,
    /// Explain the pixel only
    #[arg(long, requires = "pixel", conflicts_with = "region")]
    no_split: bool,
    /// Light to explain [default: environment if the dataset has its visibility]
    #[arg(long, value_enum)]
    tree: Option<TreeOption>,
    /// Most nodes of the illumination cut
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// How the BRDF is sampled
    #[arg(long, default_value = "lit", value_parser = choices::brdf_sampling())]
    brdf: BrdfSampling,
    /// Light paths per pixel, the reference of the split
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    spp: u32,
    /// Folder for explain.json and the pictures
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
}

impl ExplainArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let names = ["explain.json", "cut.png", "traced.png", "visibility.png", "split.png", "split-*.exr"];
        self.view.files(&self.local).fills(&self.out, names)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TreeOption {
    /// The environment, by clusters of directions
    Environment,
    /// Bounced light, by clusters of surface sources
    Sources,
}

/// Side in pixels of the split square around a pixel.
const AROUND: u32 = 64;
/// Width in pixels of the maps of a merged cut.
const MAP_WIDTH: u32 = 1024;

/// Contents of `explain.json`.
#[derive(Serialize)]
struct Report<'a> {
    size: [u32; 2],
    illum_cut: u32,
    /// Nodes left to right in the tree; `by_contribution` holds indices into them, in descending order.
    pixel: Option<&'a PixelExplanation>,
    by_contribution: Option<Vec<usize>>,
    split: Option<ErrorSplit>,
}

/// Pictures in memory during a split: the chain and the sheet.
const PICTURES_OF_SPLIT: usize = 12;

/// Explains, splits, and writes the results.
///
/// # Errors
/// Unreadable or unwritable files, pixels and regions without a surface, or a dataset without the cuts.
pub fn run(args: &ExplainArgs, console: Console) -> Result<Outcome> {
    if args.local.names_components() {
        bail!("explain shows one light at a time; choose it with --tree and leave out --components");
    }
    let interrupt = ProgressReporter::interruptible(console);
    let splits_all = args.region.is_none() && args.pixel.is_none() && !args.no_split;
    args.view.check_memory(if splits_all { PICTURES_OF_SPLIT } else { 1 })?;
    let viewed = args.view.resolve(&args.local, console)?;
    if viewed.local.solution.is_some_and(|solution| solution != Solution::Cuts) {
        bail!("explain shows one bounce by cuts; leave out --solution");
    }
    let region = region_of(args, &viewed)?;
    let _taken = take_folder(&args.out)?;
    let explainer = Explainer::new(args, &viewed)?;
    let explanation = args.pixel.map(|pixel| explainer.explain(pixel, console)).transpose()?;
    let split = match region {
        None => None,
        Some(region) => match explainer.split(region, &interrupt, console)? {
            None => return Ok(Outcome::Interrupted),
            split => split,
        },
    };
    let by_contribution = explanation.as_ref().map(PixelExplanation::by_contribution);
    let report = Report {
        size: viewed.view.size,
        illum_cut: args.illum_cut,
        pixel: explanation.as_ref(),
        by_contribution,
        split,
    };
    write_json(&args.out.join("explain.json"), &report)?;
    Ok(Outcome::Done)
}

/// The region to split, if any; checked before the work.
fn region_of(args: &ExplainArgs, viewed: &ViewedScene) -> Result<Option<Region>> {
    let size = viewed.view.size;
    Ok(match (args.region, args.pixel) {
        _ if args.no_split => None,
        (Some(region), _) => Some(region.check(size)?),
        // A pixel outside is rejected by the explanation, which comes first.
        (None, Some(pixel)) if pixel[0] < size[0] && pixel[1] < size[1] => Some(Region::around(pixel, AROUND, size)),
        (None, _) => Some(Region::whole(size)),
    })
}

/// Explains pixels of a picture and the light gathered in it.
struct Explainer<'a> {
    args: &'a ExplainArgs,
    viewed: &'a ViewedScene,
    renderer: Renderer,
    gathered: Option<GatheredLight>,
}

impl<'a> Explainer<'a> {
    fn new(args: &'a ExplainArgs, viewed: &'a ViewedScene) -> Result<Self> {
        let ViewedScene { baked, view, light, local, .. } = viewed;
        let has_environment = baked.dataset.settings.mode.environment();
        let default = if has_environment { TreeOption::Environment } else { TreeOption::Sources };
        let tree = args.tree.unwrap_or(default);
        let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone())?;
        scene.light(&Look {
            lights: local.lights.clone().into(),
            components: Components { indirect: tree == TreeOption::Sources, ..Components::ALL },
            solution: Solution::Cuts,
            illum_cut: args.illum_cut,
            ..Look::under_environment(&baked.dataset.scene, view.clone(), light.clone())
        })?;
        let gathered = match tree {
            TreeOption::Environment => scene.environment().cloned().map(GatheredLight::Environment),
            TreeOption::Sources => scene.local().and_then(|local| local.sources().cloned()).map(GatheredLight::Sources),
        };
        Ok(Self { args, viewed, renderer: Renderer::new(baked.clone()), gathered })
    }

    fn light(&self) -> Result<CutLight<'_>> {
        match &self.gathered {
            Some(gathered) => Ok(gathered.light()),
            None => bail!(NoCuts::Sources),
        }
    }

    /// Explains a pixel, prints it, and draws its merged cut.
    fn explain(&self, pixel: [u32; 2], console: Console) -> Result<PixelExplanation> {
        let light = self.light()?;
        let mut explanation = self.renderer.explain(&self.viewed.view, pixel, light, self.args.brdf)?;
        self.renderer.explain_suns(&mut explanation, &self.viewed.light);
        console.summary(report::of_pixel(&explanation))?;
        let map = self.renderer.cut_map(&explanation, light, MAP_WIDTH);
        let exposure = map.exposure();
        self.write("cut.png", &map.with_borders(exposure))?;
        self.write("traced.png", &map.traced.scaled(exposure))?;
        map.visibility.iter().try_for_each(|visibility| self.write("visibility.png", visibility))?;
        Ok(explanation)
    }

    /// Splits the error of a region, prints it, and writes the pictures; `None` if interrupted.
    fn split(&self, region: Region, interrupt: &ProgressReporter, console: Console) -> Result<Option<ErrorSplit>> {
        let sampler = VertexSampler::new(&self.viewed.baked.dataset, self.renderer.intersector());
        let trace = |vertex: u32, visible: &mut [u8]| sampler.sample(vertex, visible);
        let job = SplitJob {
            view: &self.viewed.view,
            region,
            light: self.light()?,
            sampling: self.args.brdf,
            illumination: &self.viewed.light,
            lights: &self.viewed.local.lights,
            spp: self.args.spp,
            trace_vertex: Some(&trace),
        };
        let progress = StepProgress::new("error split", "steps", interrupt, console.quiet);
        let split = self.renderer.split_error(&job, &progress)?;
        progress.finish();
        if let Some(split) = &split {
            self.write_pictures(split)?;
            console.summary(report::of_split(split))?;
        }
        Ok(split)
    }

    fn write_pictures(&self, split: &ErrorSplit) -> Result<()> {
        for (number, (picture, image)) in split.pictures.iter().enumerate() {
            self.write(&format!("split-{}-{}.exr", number + 1, picture.name()), image)?;
        }
        let pictures: Vec<&Image> = split.pictures.iter().map(|(_, image)| image).collect();
        self.write("split.png", &sheet::sheet(&pictures)?)
    }

    fn write(&self, name: &str, image: &Image) -> Result<()> {
        Ok(image::write(image, &self.args.out.join(name))?)
    }
}
