//! `lapidary predict`: the error of a picture before tracing any ray, and its reliability.

use crate::{
    args::{DeviceArgs, LocalLightArgs, ViewArgs, ViewedScene, choices},
    export::check_pictures,
    outputs::CommandFiles,
    terminal::{Console, Interrupted, Outcome, ProgressReporter, StepProgress, write_json},
};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use glam::Vec3;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_precompute::Observer;
use lapidary_render::{
    Background, BrdfSampling, Calibration, LitScene, Look, PredictedError, Renderer, View, calibrate,
    compare::map::{ErrorMap, error_map},
    predicted_error,
};
use serde::Serialize;
use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

/// Options of `predict`.
#[derive(Args, Clone, Debug)]
pub struct PredictArgs {
    /// Prediction to write and summarize
    #[arg(long, value_enum, default_value_t)]
    kind: Kind,
    /// Trace the samples reference and compare the predictions with the true error
    #[arg(long)]
    calibrate: bool,
    /// Most nodes of the illumination cut
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// How the BRDF is sampled
    #[arg(long, default_value = "lit", value_parser = choices::brdf_sampling())]
    brdf: BrdfSampling,
    /// Map to write: .png in false colors with a legend, .exr or .hdr with the luminances; may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Write the calibration of all predictions as JSON
    #[arg(long, value_name = "FILE.json", requires = "calibrate")]
    json: Option<PathBuf>,
    #[command(flatten)]
    view: ViewArgs,
}

impl PredictArgs {
    /// Files that it reads and writes.
    ///
    /// # Errors
    /// A picture of unknown format.
    pub fn files(&self) -> Result<CommandFiles> {
        check_pictures(&self.out)?;
        Ok(self.view.files(&LocalLightArgs::default()).writes(&self.out).writes(&self.json))
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Sum of the nodes' covariance bounds, with the terms that the renderer adds
    #[default]
    Bound,
    /// Sum of the nodes' covariance bounds as the paper prints them
    Printed,
    /// Expected error if the errors of the nodes are independent
    Expected,
}

/// Contents of the JSON file.
#[derive(Serialize)]
struct Report {
    size: [u32; 2],
    illum_cut: u32,
    printed: Calibration,
    bound: Calibration,
    expected: Calibration,
}

/// Groups of pixels with similar predicted error.
const BINS: usize = 10;

/// Predicts, writes the map, and reports the calibration if requested.
///
/// # Errors
/// Unreadable or unwritable files, or a dataset without visibility of the environment.
pub fn run(args: &PredictArgs, console: Console) -> Result<Outcome> {
    let interrupt = ProgressReporter::interruptible(console);
    let viewed = args.view.resolve(&LocalLightArgs::default(), console)?;
    let renderer = Renderer::new(viewed.baked.clone());
    let lighting = renderer.lighting(&viewed.light, args.illum_cut);
    let progress = StepProgress::new("prediction", "pixels", &interrupt, console.quiet);
    let predicted = predicted_error(&renderer, &viewed.view, &lighting, args.brdf, &progress)?;
    progress.finish();
    let Some(predicted) = predicted else { bail!(Interrupted) };
    let shown = args.kind.of(&predicted);
    args.out.iter().try_for_each(|path| write_map(shown, path))?;
    console.summary(summary(args, shown))?;
    if args.calibrate {
        let report = calibration(args, &renderer, &viewed, &predicted, &interrupt, console)?;
        console.summary(table(args.kind.in_report(&report)))?;
        args.json.iter().try_for_each(|path| write_json(path, &report))?;
    }
    Ok(Outcome::Done)
}

/// All predictions against the picture's difference from the samples reference.
fn calibration(
    args: &PredictArgs,
    renderer: &Renderer,
    viewed: &ViewedScene,
    predicted: &PredictedError,
    interrupt: &ProgressReporter,
    console: Console,
) -> Result<Report> {
    let ViewedScene { baked, view, light, .. } = viewed;
    let view = View { background: Background::Flat(Vec3::ZERO), ..view.clone() };
    let look = Look::under_environment(&baked.dataset.scene, view.clone(), light.clone());
    let look = Look { illum_cut: args.illum_cut, sampling: args.brdf, ..look };
    let test = LitScene::new(DeviceArgs::CPU.open()?, baked.clone())?.show_whole(&look)?.image;
    let progress = StepProgress::new("reference", "pixels", interrupt, console.quiet);
    let reference = renderer.samples_reference(&view, light, &progress);
    progress.finish();
    if interrupt.cancelled() {
        bail!(Interrupted);
    }
    let against = |predicted: &Image| calibrate(predicted, &test, &reference, BINS);
    Ok(Report {
        size: view.size,
        illum_cut: args.illum_cut,
        printed: against(&predicted.printed)?,
        bound: against(&predicted.bound)?,
        expected: against(&predicted.expected)?,
    })
}

impl Kind {
    fn of(self, predicted: &PredictedError) -> &Image {
        match self {
            Self::Bound => &predicted.bound,
            Self::Printed => &predicted.printed,
            Self::Expected => &predicted.expected,
        }
    }

    fn in_report(self, report: &Report) -> &Calibration {
        match self {
            Self::Bound => &report.bound,
            Self::Printed => &report.printed,
            Self::Expected => &report.expected,
        }
    }
}

/// Writes the numbers themselves, or a false-color map of them.
fn write_map(predicted: &Image, path: &Path) -> Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        let nothing = Image::filled(predicted.size, Vec3::ZERO);
        image::write(&error_map(predicted, &nothing, ErrorMap::Absolute, None)?.image, path)?;
    } else {
        image::write(predicted, path)?;
    }
    Ok(())
}

fn summary(args: &PredictArgs, shown: &Image) -> String {
    let names: Vec<String> = args.out.iter().map(|p| p.display().to_string()).collect();
    let mean_square = shown.pixels.iter().map(|p| f64::from(p.x).powi(2)).sum::<f64>() / shown.pixels.len() as f64;
    format!("{}: predicted error {:.4} as root mean square of luminance", names.join(", "), mean_square.sqrt())
}

fn table(calibration: &Calibration) -> String {
    let mut text = String::from("predicted error        pixels  true error: 10 %      50 %      90 %   not above\n");
    for bin in &calibration.bins {
        let ([low, high], [q10, q50, q90]) = (bin.predicted, bin.quantiles);
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{low:8.5} to {high:8.5} {:8}           {q10:8.5}  {q50:8.5}  {q90:8.5}   {:7.2} %",
            bin.pixels,
            100.0 * bin.within
        );
    }
    let Calibration { pixels, within, rank_correlation, ratio, .. } = calibration;
    text + &format!(
        "{pixels} pixels: {:.2} % of the true errors are not above the predicted; rank correlation {rank_correlation:.3}; \
         predicted {ratio:.2} times the true error",
        100.0 * within
    )
}
