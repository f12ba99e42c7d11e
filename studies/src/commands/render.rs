//! `lapidary render`: a picture by merged cuts.

use crate::{
    args::{LocalLightArgs, PictureArgs, PoseArgs, ViewArgs, choices, warn_of_buried},
    export::{Finished, LayerList, Studio, check_pictures, is_exr, wanted_layers},
    outputs::CommandFiles,
    terminal::{Console, Outcome, write_json},
};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::dataset::Dataset;
use lapidary_render::{BasisView, Look, RenderStats, Solution, ViewMode};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    picture: PictureArgs,
    /// Picture to write: .exr or .hdr (scene-linear), .png (as displayed); may be given several times
    #[arg(long, value_name = "FILE")]
    out: Vec<PathBuf>,
    /// Layers of exr files beside the picture, separated by commas: environment, direct and indirect (light, which sums to the
    /// picture), normal, albedo, roughness, position, depth, coverage (surfaces), visibility-nodes, merged-nodes and
    /// brdf-evaluations (work), or all
    #[arg(long, value_name = "LIST")]
    layers: Option<LayerList>,
    /// Quantity to show
    #[arg(long, value_name = "QUANTITY", default_value = "shaded", value_parser = choices::view_mode())]
    show: ViewMode,
    /// Level for --show basis-level; 0 is the coarsest
    #[arg(long, value_name = "L", default_value_t = 0)]
    level: u32,
    /// Function for --show basis-function, counted from 0, coarsest first
    #[arg(long, value_name = "N", default_value_t = 0)]
    function: u32,
    /// Write times and counts as JSON
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
}

impl RenderArgs {
    /// The look for the requested quantity.
    fn shown(&self, mut look: Look, dataset: &Dataset) -> Result<Look> {
        if self.show.is_of_basis() && dataset.meshless.is_none() {
            bail!("the dataset has no meshless basis to show; bake it with --mode meshless");
        }
        if self.show == ViewMode::Gloss && !dataset.settings.mode.has_all(Solution::CutsGloss.needs()) {
            bail!("the view gloss needs surface sources and a meshless basis; bake the scene with --mode all");
        }
        look.view.mode = self.show;
        look.view.basis = BasisView { level: self.level, function: self.function };
        look.components.indirect |= self.show.is_of_bounce();
        Ok(look)
    }

    /// Files that it reads and writes.
    ///
    /// # Errors
    /// A picture of unknown format.
    pub fn files(&self) -> Result<CommandFiles> {
        check_pictures(&self.out)?;
        let files = self.view.files(&self.local).reads(&self.picture.backplate);
        Ok(self.pose.files(files).writes(&self.out).writes(&self.stats))
    }
}

/// Renders and writes the picture.
///
/// # Errors
/// Unreadable or unwritable files, or contradictory options.
pub fn run(args: &RenderArgs, console: Console) -> Result<Outcome> {
    if args.layers.is_some() && !args.out.iter().any(|path| is_exr(path)) {
        bail!("only exr files hold layers; add --out FILE.exr, or leave --layers out");
    }
    args.view.check_memory(1 + args.layers.as_ref().map_or(0, LayerList::most))?;
    let mut viewed = args.view.resolve(&args.local, console)?;
    viewed.view.aa = args.view.smooth_samples(&viewed.view.camera);
    viewed.poses = args.pose.read(&viewed.baked.dataset.scene, &args.view.import_options(), console)?;
    let look = args.shown(args.picture.look(&viewed)?, &viewed.baked.dataset)?;
    let layers = wanted_layers(args.layers.as_ref(), &look)?;
    let baked = viewed.baked.clone();
    let mut studio = Studio::new(args.picture.device.open()?, baked.clone())?;
    warn_of_buried(&look.renderer(&baked), &viewed.local.lights, console);
    let finished = Finished::take(&mut studio, &look, &layers, &|| false)?;
    studio.remarks().iter().for_each(|remark| console.warning(remark));
    let stats = finished.taken.stats.clone();
    finished.write(&look, &viewed.baked.dataset, &args.out)?;
    if let Some(path) = &args.stats {
        write_json(path, &stats)?;
    }
    if args.out.is_empty() && args.stats.is_none() {
        console.note("nothing was written; add --out FILE.png or --out FILE.exr");
    }
    console.summary(summary(&args.out, viewed.view.size, &stats))?;
    Ok(Outcome::Done)
}

fn summary(out: &[PathBuf], [width, height]: [u32; 2], stats: &RenderStats) -> String {
    let names: Vec<String> = out.iter().map(|p| format!("{}: ", p.display())).collect();
    format!(
        "{}{width} x {height} in {:.2} s, {:.0} merged nodes and {:.0} BRDF evaluations a sample",
        names.concat(),
        stats.seconds,
        stats.mean_merged_nodes,
        stats.mean_brdf_evaluations
    )
}
