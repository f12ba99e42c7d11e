//! The commands, one file each, with their `--help` texts. `demo` and `evidence` have their own folders.

pub mod bake;
mod bench;
pub(crate) mod bounces;
mod compare;
mod explain;
mod export;
pub mod info;
mod ladder;
pub mod merge;
mod models;
mod predict;
mod reference;
mod render;
mod sequence;
pub mod verify;

use crate::{
    demo::{self, DemoArgs},
    evidence::{self, EvidenceArgs},
    outputs::CommandFiles,
    terminal::{Console, Outcome},
};
use anyhow::Result;
use bake::BakeArgs;
use bench::BenchArgs;
use bounces::BouncesArgs;
use clap::Subcommand;
use compare::CompareArgs;
use explain::ExplainArgs;
use export::ExportArgs;
use info::InfoArgs;
use ladder::LadderArgs;
use merge::MergeArgs;
use models::ModelsArgs;
use predict::PredictArgs;
use reference::ReferenceArgs;
use render::RenderArgs;
use sequence::SequenceArgs;
use verify::VerifyArgs;

/// A command that needs no window.
#[derive(Clone, Subcommand)]
pub enum Command {
    /// Bake, render, trace and compare the bundled still life, and write a report
    #[command(after_help = "\
It takes under two minutes on two cores. It writes pictures (PNG and EXR), report.json (all figures) and report.html.

Example:
  lapidary demo --out /tmp/demo")]
    Demo(DemoArgs),
    /// Bake a scene's visibility into a dataset
    #[command(after_help = "\
Ctrl-C leaves a checkpoint beside the output (exit code 130). The same command with --resume continues from it.
Units are meters. The result is the same, bit for bit, for any number of threads and chunks.

Examples:
  lapidary bake scene.obj -o scene.cuts --preset draft
  lapidary bake scene.gltf -o scene.cuts --sigma 1.5 --max-vertices 200000 --report bake.json
  lapidary bake scene.gltf -o scene.cuts --resume")]
    Bake(BakeArgs),
    /// Merge the shares of machines that baked with --shard into a dataset
    #[command(after_help = "\
The shares must be beside the dataset. The result equals a single bake bit for bit; the shares are then removed.

Example, for two machines that share a folder:
  lapidary bake scene.gltf -o scene.cuts --shard 1/2
  lapidary bake scene.gltf -o scene.cuts --shard 2/2
  lapidary merge scene.cuts")]
    Merge(MergeArgs),
    /// Describe a dataset, or a scene with its materials and their variants
    #[command(after_help = "Examples:\n  lapidary info scene.cuts --json | jq .report.mean_cut\n  lapidary info \
shoe.glb --json | jq .variants")]
    Info(InfoArgs),
    /// List the BRDF models with their parameters
    #[command(after_help = "\
A material file is JSON: {\"model\": \"ggx\", \"parameters\": {\"roughness\": 0.3}}. Missing parameters have their defaults.

Example:
  lapidary models --json | jq '.models[] | .model'")]
    Models(ModelsArgs),
    /// Retrace random vertices of a dataset, and compare
    #[command(after_help = "It fails (exit code 1) if the dataset disagrees with its scene.\n\nExample:\n  lapidary \
verify scene.cuts --vertices 1000")]
    Verify(VerifyArgs),
    /// Render a picture with cuts, free of noise, in seconds
    #[command(after_help = "\
Examples:
  lapidary render scene.cuts --env sky.hdr --out picture.png
  lapidary render scene.cuts --env sun-sky:30 --rotate 120 --size 1280x960 --aa 4 --out a.exr --out a.png
  lapidary render scene.cuts --env studio --eye 0.3,0.5,3.5 --target 0,0.4,0 --fov 35 --out close.png
  lapidary render scene.cuts --env studio --base-color 0.9,0.6,0.3 --metalness 1 --stats stats.json
  lapidary render scene.cuts --lights lamps.json --out lamps.png
  lapidary render scene.cuts --lights lamps.json --env sky.hdr --components direct --out only-lamps.exr
  lapidary render scene.cuts --env sky.hdr --out layers.exr --layers environment,normal,depth

A session has its own light, materials, camera and looks: lapidary render look.lapidary [--look NAME | --all] --out FILE.
`lapidary render look.lapidary --help` explains its options.")]
    Render(RenderArgs),
    /// Render turntables, parameter sweeps and animations as image sequences
    #[command(after_help = "\
Turns are about the vertical through the camera's target. Visibility was baked for the scene as it stands, so
--turn object turns the whole scene: camera, environment and lights turn the other way together.
A turn and sweeps run together. Ctrl-C keeps the finished frames (exit code 130). The same command with --resume continues.

Examples:
  lapidary sequence scene.cuts --env studio --turn object --frames 48 --out turn/frame.####.png
  lapidary sequence scene.cuts --env sky.hdr --turn environment --frames 24 --out env/f.##.exr --contact-sheet env.png
  lapidary sequence scene.cuts --sweep roughness=0.05..0.8 --frames 16 --out sweep/r.##.png --contact-sheet r.png
  lapidary sequence scene.cuts --brdf refine --sweep illum-cut=log:1..512 --sweep exposure=-1..1 --frames 10 --out cuts/c.##.png
  lapidary sequence tower.cuts --animation tower.gltf --fps 24 --frames 48 --out bend/b.##.png
  lapidary sequence room.cuts --env none --sweep light-position@lamp=-1,2,0..1,2,0 --out lamp/l.###.exr --layers all")]
    Sequence(SequenceArgs),
    /// Measure frame times by pass, with lit cuts or by size of the illumination cut; times of drags and edits; or all of them
    /// beside another program
    #[command(after_help = "\
It prints medians. Here each pass waits for the one before; in the window they may overlap.

--against runs this program and another build of it in turn on the bundled scenes, which each bakes for itself, and takes
up to ten minutes on two cores. It prints times, ratios (this over the other, the median of all pairs of runs), the least and
largest ratio, and the ratios with both on the dataset of one of them. Where a program fails, hangs or lacks an option, the
row says so, the others go on, and the exit code is 1.

Examples:
  lapidary bench scene.cuts --size 1920x1080 --json
  lapidary bench scene.cuts --backend cpu --illum-cuts 256 --frames 5
  lapidary bench scene.cuts --edits Copper --env studio --backend cpu
  lapidary bench --against ./lapidary-before --json ratios.json
  lapidary bench --against ./lapidary-before --fail-above 1.2")]
    Bench(BenchArgs),
    /// Render the same picture by ray tracing, as a reference
    #[command(after_help = "\
Ctrl-C writes the unfinished picture (exit code 130).

Examples:
  lapidary reference scene.cuts --env sky.hdr --out truth.exr
  lapidary reference scene.cuts --env sky.hdr --kind path --spp 256 --out truth.exr
  lapidary reference scene.cuts --lights lamps.json --kind path --bounces 4 --spp 256 --out truth.exr
  lapidary reference scene.cuts --lights lamps.json --kind path --bounces 1 --components indirect --out bounce.exr")]
    Reference(ReferenceArgs),
    /// Measure each solution of bounced light against light paths
    #[command(after_help = "\
It takes minutes. Light paths are noisy; their noise is estimated and subtracted from the error. It writes bounces.json
and, for each solution, reference, solution and error side by side (PNG) and the pictures themselves (EXR).

Examples:
  lapidary bounces room.cuts --size 160x120 --spp 1024 --out /tmp/bounces
  lapidary bounces room.cuts --lights lamps.json --solution cuts --illum-cut 512 --out /tmp/bounces")]
    Bounces(BouncesArgs),
    /// Find the size of the illumination cut that suffices for a shot
    #[command(after_help = "\
It renders the picture at each size, traces every light sample as a reference, and measures the error. It writes all
pictures (PNG and EXR), sheet.png (all of them, with error and time), ladder.html (with curves) and ladder.json. The
reference takes longest, in proportion to pixels and lights: start with a small --size.

Examples:
  lapidary ladder scene.cuts --env studio --size 160x120 --out ladder
  lapidary ladder scene.cuts --env sky.hdr --roughness 0.2 --metalness 1 --illum-cuts 128,256,512,1024 --out ladder")]
    Ladder(LadderArgs),
    /// Reproduce the paper's figures: clusters, wavelets, cut sizes, the table, and errors by setting
    #[command(after_help = "\
It runs unattended; the bundled scenes take some tens of minutes on two cores. It writes evidence.html, one page with
pictures, and evidence.json. Each figure is on disk before the next begins; Ctrl-C keeps them (exit code 130).

Examples:
  lapidary evidence --out evidence
  lapidary evidence --out mine --no-bundled --scenes teapot.obj room.glb --env sky.hdr
  lapidary evidence --out mine --no-bundled --scenes room.glb --papers meshless,wavelet
  lapidary evidence --out try --quick")]
    Evidence(EvidenceArgs),
    /// Explain a pixel by its merged cut, and split the error of a picture into its causes
    #[command(after_help = "\
It writes explain.json. For the pixel it writes the merged cut on the map of directions (cut.png), the light that rays
find there (traced.png), and where interpolated visibility lets light through (red) or blocks it (blue, visibility.png).
For the region it writes a series of pictures from the rendered one to light paths. Each differs from the next in one
factor (EXR; split.png shows all, and below each the change to the next). It takes seconds for a pixel and its
surroundings, minutes for a picture.

Examples:
  lapidary explain scene.cuts --env sky.hdr --pixel 320,240 --out why
  lapidary explain scene.cuts --env sky.hdr --region 100,80,200,150 --spp 1024 --out why
  lapidary explain room.cuts --lights lamps.json --tree sources --pixel 320,240 --no-split --out why")]
    Explain(ExplainArgs),
    /// Predict the error of a picture from the variances in its clusters, without tracing rays
    #[command(after_help = "\
The bound is the sum of the error bounds of all clusters. --calibrate traces the true error; a table then tells for how
many pixels the bound holds, and how well it ranks pixels by their error.

Examples:
  lapidary predict scene.cuts --env sky.hdr --out predicted.png --out predicted.exr
  lapidary predict scene.cuts --env sky.hdr --kind expected --size 320x240 --calibrate --out predicted.png")]
    Predict(PredictArgs),
    /// Measure the error of a picture against a reference
    #[command(after_help = "\
rmse, rel_rmse and rel_mse use scene-linear values; equal pictures have 0.
psnr (decibels), ssim (1 for equal pictures) and flip (0 for equal pictures) use displayed values.
For psnr and ssim larger is better: use --fail-below.

Examples:
  lapidary compare picture.exr truth.exr
  lapidary compare picture.exr truth.exr --map flip --out flip.png
  lapidary compare layers.exr truth.exr --layer indirect
  lapidary compare picture.exr truth.exr --fail-above rel_rmse=0.1 --fail-below ssim=0.95")]
    Compare(CompareArgs),
    /// Write the scene for another renderer, or its materials for other programs
    #[command(after_help = "\
It takes the view, material and light options of `render`. materials.xml has Mitsuba's closest BSDFs. materials-exact.xml
has this program's formulas, for the plugin in tests/crosscheck.

Examples:
  lapidary export scene.cuts --env sky.hdr --rotate 30 --mitsuba /tmp/scene
  mitsuba -m scalar_rgb -D spp=64 /tmp/scene/scene.xml
  lapidary export scene.cuts --materials scene.mtlx --surface standard-surface
  lapidary export scene.cuts --materials edited.glb --original scene.glb")]
    Export(ExportArgs),
}

impl Command {
    /// Files that it reads and writes.
    ///
    /// # Errors
    /// Invalid output names.
    pub fn files(&self) -> Result<CommandFiles> {
        Ok(match self {
            Self::Demo(args) => args.files(),
            Self::Bake(args) => args.files(),
            Self::Merge(args) => args.files(),
            Self::Info(args) => args.files(),
            Self::Models(args) => args.files(),
            Self::Verify(args) => args.files(),
            Self::Render(args) => args.files()?,
            Self::Sequence(args) => args.files()?,
            Self::Bench(args) => args.files(),
            Self::Reference(args) => args.files()?,
            Self::Bounces(args) => args.files(),
            Self::Ladder(args) => args.files(),
            Self::Evidence(args) => args.files(),
            Self::Explain(args) => args.files(),
            Self::Predict(args) => args.files()?,
            Self::Compare(args) => args.files()?,
            Self::Export(args) => args.files(),
        })
    }

    /// Checks the outputs and runs the command.
    ///
    /// # Errors
    /// Any failure, as a message for the user.
    pub fn run(&self, console: Console) -> Result<Outcome> {
        self.files()?.check()?;
        match self {
            Self::Demo(args) => demo::run(args, console),
            Self::Bake(args) => bake::run(args, console),
            Self::Merge(args) => merge::run(args, console),
            Self::Info(args) => args.run().map(|()| Outcome::Done),
            Self::Models(args) => args.run().map(|()| Outcome::Done),
            Self::Verify(args) => args.run().map(|()| Outcome::Done),
            Self::Render(args) => render::run(args, console),
            Self::Sequence(args) => sequence::run(args, console),
            Self::Bench(args) => bench::run(args, console),
            Self::Reference(args) => reference::run(args, console),
            Self::Bounces(args) => bounces::run(args, console),
            Self::Ladder(args) => ladder::run(args, console),
            Self::Evidence(args) => evidence::run(args, console),
            Self::Explain(args) => explain::run(args, console),
            Self::Predict(args) => predict::run(args, console),
            Self::Compare(args) => compare::run(args, console),
            Self::Export(args) => export::run(args, console),
        }
    }
}
