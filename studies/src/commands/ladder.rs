//! `lapidary ladder`: the sufficient size of the illumination cut for a picture, and a comparison with lit cuts.

use crate::{
    args::{DeviceArgs, LocalLightArgs, ViewArgs, choices, warn_of_buried},
    ladder::{self, Ladder, Settings, Summary, climb},
    outputs::{CommandFiles, take_folder},
    terminal::{Console, Outcome, ProgressReporter, StepProgress, write_json},
    values,
};
use anyhow::{Context, Result};
use clap::Args;
use lapidary_core::{cut::lit::DEFAULT_TAU, output::write_atomically};
use lapidary_render::{BrdfSampling, LitScene, Look, Post};
use std::path::PathBuf;

/// Options of `ladder`.
#[derive(Args, Clone, Debug)]
pub struct LadderArgs {
    /// Folder for the pictures (PNG and EXR), sheet.png, ladder.html and ladder.json; it is created if missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Sizes of the illumination cut, separated by commas
    #[arg(long, value_name = "K,..", value_delimiter = ',', default_values_t = ladder::SIZES,
          value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cuts: Vec<u32>,
    /// How the BRDF is sampled with illumination cuts
    #[arg(long, default_value = "refine", value_parser = choices::stored_sampling())]
    brdf: BrdfSampling,
    /// Largest share of a vertex's light that a node of its lit cut moves, 0 to 1, for the picture of lit cuts
    #[arg(long, value_name = "TAU", default_value_t = DEFAULT_TAU, value_parser = values::share)]
    lit_cuts: f32,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
}

impl LadderArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let names =
            ["ladder.json", "ladder.html", "sheet.png", "reference.png", "reference.exr", "cut-*.png", "cut-*.exr"];
        self.view.files(&self.local).fills(&self.out, names)
    }
}

/// Renders, traces, compares and writes the results.
///
/// # Errors
/// Unreadable or unwritable files, or contradictory options.
pub fn run(args: &LadderArgs, console: Console) -> Result<Outcome> {
    let _taken = take_folder(&args.out)?;
    let interrupt = ProgressReporter::interruptible(console);
    args.view.check_memory(args.illum_cuts.len() + 4)?;
    let viewed = args.view.resolve(&args.local, console)?;
    let look = Look { tau: args.lit_cuts, sampling: args.brdf, ..viewed.look()? };
    warn_of_buried(&look.renderer(&viewed.baked), &look.lights, console);
    let mut scene = LitScene::new(args.device.open()?, viewed.baked)?;
    let progress = StepProgress::new("reference", "pixels", &interrupt, console.quiet);
    let settings = Settings::sizes(&args.illum_cuts, &look);
    let ladder = climb(&mut scene, &look, &settings, None, &progress, &mut |found| {
        tell(found, console)?;
        ladder::write_picture(found, &args.out, "")
    })?;
    progress.finish();
    let Some(ladder) = ladder else {
        console
            .note(format_args!("stopped early: {} has the pictures so far, without their errors", args.out.display()));
        return Ok(Outcome::Interrupted);
    };
    write(args, &look, &ladder)?;
    console.summary(format_args!("open {}", args.out.join("ladder.html").display()))?;
    Ok(Outcome::Done)
}

fn tell(found: ladder::Found, console: Console) -> Result<()> {
    match found {
        ladder::Found::Picture(rung) => {
            console.note(format_args!("{}: {:.2} s", rung.cuts.label(), rung.stats.seconds));
        }
        ladder::Found::Truth(truth) => console.note(format_args!("reference: {:.1} s", truth.seconds)),
        ladder::Found::Step(step) => console.summary(format_args!(
            "{:>12}: relative RMSE {:.4}, FLIP {:.4}, {:.2} s, {:.0} merged nodes",
            step.rung.cuts.label(),
            step.metrics.rel_rmse,
            step.metrics.flip,
            step.rung.stats.seconds,
            step.rung.stats.mean_merged_nodes
        ))?,
    }
    Ok(())
}

fn write(args: &LadderArgs, look: &Look, ladder: &Ladder) -> Result<()> {
    ladder::sheet(ladder, &Post::default()).write_png(&args.out.join("sheet.png"))?;
    let summary = Summary::new(look, ladder, "");
    write_json(&args.out.join("ladder.json"), &summary)?;
    let page = args.out.join("ladder.html");
    write_atomically(&page, ladder::page(&summary).as_bytes())
        .with_context(|| format!("cannot write the page; check the free space ({})", page.display()))
}
