//! `lapidary explain`: why a pixel looks as it does, and which of its causes the error of a picture has.

mod report;
mod sheet;

use super::bounces::strip;
use crate::{
    args::{BrdfOption, LocalLightArgs, Shot, ViewArgs, values},
    export::create_folder,
    terminal::{Console, Outcome, ProgressReporter, ProgressStyle, StepProgress, write_json},
};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use lapidary_core::image::Image;
use lapidary_precompute::VertexSampler;
use lapidary_render::{
    Baked, Components, CutLight, ErrorSplit, GatheredLight, LocalRig, PixelExplanation, Region, Renderer, Solution,
    SplitJob,
};
use serde::Serialize;
use std::{path::PathBuf, sync::Arc};

/// Options of `explain`.
#[derive(Args, Clone, Debug)]
pub struct ExplainArgs {
    /// Pixel to explain: its column and row, counted from 0 at the top left
    #[arg(long, value_name = "X,Y", value_parser = values::pixel)]
    pixel: Option<[u32; 2]>,
    /// Part of the picture whose error is split, by its left column, upper row, width and height [default: 64 x 64 pixels
    /// around the pixel, or the whole picture without one]
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::region)]
    region: Option<Region>,
    /// Only explain the pixel
    #[arg(long, requires = "pixel", conflicts_with = "region")]
    no_split: bool,
    /// Which light [default: environment if the dataset has its visibility]
    #[arg(long, value_enum)]
    tree: Option<TreeOption>,
    /// Most nodes of the illumination cut
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// How the BRDF is sampled
    #[arg(long, value_enum, default_value_t)]
    brdf: BrdfOption,
    /// Light paths a pixel, the truth of the split
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TreeOption {
    /// The environment: clusters of directions
    Environment,
    /// Bounced light: clusters of surface sources
    Sources,
}

/// Side in pixels of the square whose error is split around a pixel.
const AROUND: u32 = 64;
/// Width in pixels of the maps of a merged cut.
const MAP_WIDTH: u32 = 1024;

/// What `explain.json` says.
#[derive(Serialize)]
struct Report<'a> {
    size: [u32; 2],
    illum_cut: u32,
    /// Nodes left to right in the tree; `by_contribution` are positions among them, the greatest first.
    pixel: Option<&'a PixelExplanation>,
    by_contribution: Option<Vec<usize>>,
    split: Option<ErrorSplit>,
}

/// Explains, splits, and writes what was found.
///
/// # Errors
/// Files that cannot be read or written, pixels and regions without a surface, a dataset without the cuts.
pub fn run(args: &ExplainArgs, console: Console) -> Result<Outcome> {
    if args.local.names_components() {
        bail!("explain is about one light at a time; choose it by --tree and leave --components out");
    }
    let interrupt = ProgressReporter::new(if console.quiet { ProgressStyle::None } else { ProgressStyle::Bar });
    interrupt.cancel_on_interrupt();
    let shot = args.view.resolve(&args.local, console)?;
    if shot.local.solution.is_some_and(|solution| solution != Solution::Cuts) {
        bail!("explain shows one bounce by cuts; leave --solution out");
    }
    let region = region_of(args, &shot)?;
    create_folder(&args.out)?;
    let stage = Stage::new(args, &shot);
    let explanation = args.pixel.map(|pixel| stage.explain(pixel, console)).transpose()?;
    let split = match region {
        None => None,
        Some(region) => match stage.split(region, &interrupt, console)? {
            None => return Ok(Outcome::Interrupted),
            split => split,
        },
    };
    let by_contribution = explanation.as_ref().map(PixelExplanation::by_contribution);
    let report =
        Report { size: shot.view.size, illum_cut: args.illum_cut, pixel: explanation.as_ref(), by_contribution, split };
    write_json(&args.out.join("explain.json"), &report)?;
    Ok(Outcome::Done)
}

/// The region to split, if any: checked before the work.
fn region_of(args: &ExplainArgs, shot: &Shot) -> Result<Option<Region>> {
    let size = shot.view.size;
    Ok(match (args.region, args.pixel) {
        _ if args.no_split => None,
        (Some(region), _) => Some(region.check(size)?),
        // A pixel outside is refused when it is explained, which comes first.
        (None, Some(pixel)) if pixel[0] < size[0] && pixel[1] < size[1] => Some(Region::around(pixel, AROUND, size)),
        (None, _) => Some(Region::whole(size)),
    })
}

struct Stage<'a> {
    args: &'a ExplainArgs,
    shot: &'a Shot,
    renderer: Renderer,
    lit: Option<GatheredLight>,
}

impl<'a> Stage<'a> {
    fn new(args: &'a ExplainArgs, shot: &'a Shot) -> Self {
        let baked = Baked::from(shot.dataset.clone());
        let renderer = Renderer::new(baked.clone());
        let environment = renderer.lighting(&shot.light, args.illum_cut);
        let has_environment = shot.dataset.settings.mode.environment();
        let default = if has_environment { TreeOption::Environment } else { TreeOption::Sources };
        let lit = match args.tree.unwrap_or(default) {
            TreeOption::Environment => Some(GatheredLight::Environment(environment.into())),
            TreeOption::Sources => {
                let mut rig = LocalRig::new(&baked);
                rig.set_environment(Some(&Arc::new(environment)));
                rig.set_lights(&shot.local.lights.clone().into());
                rig.lighting(Components::ALL, Solution::Cuts, args.illum_cut).indirect.map(GatheredLight::Sources)
            }
        };
        Self { args, shot, renderer, lit }
    }

    fn light(&self) -> Result<CutLight<'_>> {
        match &self.lit {
            Some(lit) => Ok(lit.light()),
            None => bail!("the dataset has no surface sources; bake it with --mode indirect, cuts or all"),
        }
    }

    /// Explains a pixel, says so, and draws its merged cut.
    fn explain(&self, pixel: [u32; 2], console: Console) -> Result<PixelExplanation> {
        let light = self.light()?;
        let explanation = self.renderer.explain(&self.shot.view, pixel, light, self.args.brdf.into())?;
        console.summary(report::of_pixel(&explanation))?;
        let map = self.renderer.cut_map(&explanation, light, MAP_WIDTH);
        let exposure = map.exposure();
        let exposed = |image: &Image| {
            let pixels = image.pixels.iter().map(|&p| p * exposure).collect();
            Image { size: image.size, pixels }
        };
        self.write("cut.png", &map.with_borders(exposure))?;
        self.write("traced.png", &exposed(&map.traced))?;
        map.visibility.iter().try_for_each(|visibility| self.write("visibility.png", visibility))?;
        Ok(explanation)
    }

    /// Splits the error of a region, says so, and writes the pictures; `None` if interrupted.
    fn split(&self, region: Region, interrupt: &ProgressReporter, console: Console) -> Result<Option<ErrorSplit>> {
        let sampler = VertexSampler::new(&self.shot.dataset, self.renderer.intersector());
        let trace = |vertex: u32, visible: &mut [u8]| sampler.sample(vertex, visible);
        let job = SplitJob {
            view: &self.shot.view,
            region,
            light: self.light()?,
            sampling: self.args.brdf.into(),
            illumination: &self.shot.light,
            lights: &self.shot.local.lights,
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
        Ok(image.write(&self.args.out.join(name))?)
    }
}
