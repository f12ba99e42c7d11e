//! `lapidary compare`: metrics, an error map, and bounds for scripts.

use crate::{
    args::choices,
    export::{check_pictures, write_pictures},
    outputs::CommandFiles,
    terminal::{Console, Outcome, write_json},
    values,
};
use anyhow::Result;
use clap::Args;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_render::compare::{
    Metrics, compare,
    map::{ErrorMap, error_map},
};
use std::{
    path::{Path, PathBuf},
    slice,
};

/// Options of `compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// Picture to measure: exr (FILE.exr#LAYER for one of its layers), hdr, png, jpg, tif, webp or tga
    test: PathBuf,
    /// Reference of the same size
    reference: PathBuf,
    /// Layer of the picture, if it is an exr file with layers [default: the picture itself, beauty]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Layer of the reference [default: the picture itself, beauty]
    #[arg(long, value_name = "NAME")]
    reference_layer: Option<String>,
    /// Write the metrics as JSON; infinity becomes null
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Draw this error of each pixel to --out
    #[arg(long, requires = "out", value_parser = choices::error_map())]
    map: Option<ErrorMap>,
    /// Error at the upper end of the map's colors, above 0 [default: 1 for flip, else large enough for 99 % of the pixels]
    #[arg(long, value_name = "ERROR", requires = "map", value_parser = values::positive)]
    map_top: Option<f32>,
    /// Error map to write
    #[arg(long, value_name = "FILE.png", requires = "map")]
    out: Option<PathBuf>,
    /// Exit with code 3 if the metric is above the value; may be given several times
    #[arg(long, value_name = "METRIC=VALUE", value_parser = bound)]
    fail_above: Vec<Bound>,
    /// Exit with code 3 if the metric is below the value; may be given several times
    #[arg(long, value_name = "METRIC=VALUE", value_parser = bound)]
    fail_below: Vec<Bound>,
}

impl CompareArgs {
    /// Files that it reads and writes.
    ///
    /// # Errors
    /// A picture of unknown format.
    pub fn files(&self) -> Result<CommandFiles> {
        check_pictures(self.out.as_slice())?;
        let inputs = [&self.test, &self.reference].map(|path| image::file_and_layer(path).0);
        Ok(CommandFiles::default().reads(inputs).writes(&self.out).writes(&self.json))
    }
}

/// A metric with its limit.
#[derive(Clone, Debug, PartialEq)]
struct Bound {
    metric: String,
    value: f64,
}

fn bound(text: &str) -> Result<Bound, String> {
    let (metric, value) = text.split_once('=').ok_or("a bound is METRIC=VALUE, as in rel_rmse=0.1")?;
    if !Metrics::NAMES.contains(&metric) {
        return Err(format!("there is no metric \"{metric}\"; there are {}", Metrics::NAMES.join(", ")));
    }
    let value = value.parse().ok().filter(|v: &f64| !v.is_nan()).ok_or(format!("\"{value}\" is not a number"))?;
    Ok(Bound { metric: metric.into(), value })
}

/// Compares pictures and reports exceeded bounds.
///
/// # Errors
/// Unreadable or unwritable files, or pictures of different sizes.
pub fn run(args: &CompareArgs, console: Console) -> Result<Outcome> {
    warn_of_literal_bounds(args, console);
    let test = read(&args.test, args.layer.as_deref())?;
    let reference = read(&args.reference, args.reference_layer.as_deref())?;
    let metrics = compare(&test, &reference)?;
    if metrics.non_finite_pixels > 0 {
        console.warning(format_args!("{} pixels are not finite and were left out", metrics.non_finite_pixels));
    }
    if let (Some(kind), Some(out)) = (args.map, &args.out) {
        let map = error_map(&test, &reference, kind, args.map_top)?;
        write_pictures(&map.image, None, slice::from_ref(out))?;
    }
    if let Some(path) = &args.json {
        write_json(path, &metrics)?;
    }
    console.summary(table(&metrics))?;
    let exceeded = exceeded(args, &metrics);
    exceeded.iter().for_each(|text| eprintln!("out of bounds: {text}"));
    Ok(if exceeded.is_empty() { Outcome::Done } else { Outcome::OutOfBounds })
}

fn read(path: &Path, layer: Option<&str>) -> Result<Image> {
    Ok(match layer {
        Some(name) => image::read_layer(path, name)?,
        None => image::read(path)?,
    })
}

/// Warns of bounds on PSNR and SSIM in the wrong direction.
fn warn_of_literal_bounds(args: &CompareArgs, console: Console) {
    for Bound { metric, value } in args.fail_above.iter().filter(|b| b.metric == "psnr" || b.metric == "ssim") {
        console.warning(format_args!(
            "larger is better for {metric}, but this fails above {value}; you may mean --fail-below {metric}={value}"
        ));
    }
}

fn exceeded(args: &CompareArgs, metrics: &Metrics) -> Vec<String> {
    // Phrased so that NaN is out of bounds.
    let above =
        |b: &Bound| metrics.get(&b.metric).filter(|found| !(*found <= b.value)).map(|v| (b.clone(), v, "above"));
    let below =
        |b: &Bound| metrics.get(&b.metric).filter(|found| !(*found >= b.value)).map(|v| (b.clone(), v, "below"));
    let all = args.fail_above.iter().filter_map(above).chain(args.fail_below.iter().filter_map(below));
    all.map(|(bound, found, side)| format!("{} is {found:.6}, {side} {}", bound.metric, bound.value)).collect()
}

fn table(metrics: &Metrics) -> String {
    let rows = [
        ("rmse", metrics.rmse, "root mean square error, scene-linear"),
        ("rel_rmse", metrics.rel_rmse, "the same over the root mean square of the reference"),
        ("rel_mse", metrics.rel_mse, "mean of squared errors relative to each pixel"),
        ("psnr", metrics.psnr, "decibels, as displayed; larger is better"),
        ("ssim", metrics.ssim, "1 for equal pictures, as displayed"),
        ("flip", metrics.flip, "0 for equal pictures, as seen"),
    ];
    let lines: Vec<String> = rows.iter().map(|(name, value, text)| format!("{name:<9}{value:>12.6}  {text}")).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_name_a_metric_and_a_number() {
        assert_eq!(bound("flip=0.1"), Ok(Bound { metric: "flip".into(), value: 0.1 }));
        for bad in ["flip", "flip=", "flip=x", "flip=nan", "mse=1", "=1"] {
            assert!(bound(bad).is_err(), "{bad}");
        }
    }
}
