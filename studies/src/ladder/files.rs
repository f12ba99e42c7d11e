//! Files of the ladder: pictures, a contact sheet, `ladder.json`.

use super::{Cuts, Ladder, Rung, Step, Truth};
use crate::{
    report::text::seconds,
    sheet::{DisplayPicture, SheetStyle, Tile, contact_sheet},
};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_render::{Look, Post};
use serde::Serialize;
use std::path::Path;

/// Tiles side by side on the contact sheet.
const COLUMNS: usize = 4;
/// Longest side of a tile's picture in pixels.
const TILE: u32 = 480;
/// Narrowest column in pixels that fits the captions.
const MIN_COLUMN: u32 = 210;

/// All figures of a ladder, written as `ladder.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the environment, as given.
    pub environment: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub aa: u32,
    /// Renderer: `cpu`, or the name of the graphics adapter.
    pub renderer: String,
    /// The reference of the pictures.
    pub reference: ReferenceFigures,
    /// One for each size of the illumination cut, and one of lit cuts.
    pub steps: Vec<StepFigures>,
}

/// Figures of the reference.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceFigures {
    /// `samples`: the lights of the pictures, without cuts.
    pub kind: &'static str,
    /// Description of the traced light.
    pub what: String,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// File, as displayed.
    pub png: String,
    /// File, scene-linear.
    pub exr: String,
}

/// Figures of one picture.
#[derive(Clone, Debug, Serialize)]
pub struct StepFigures {
    /// The merged cuts.
    #[serde(flatten)]
    pub cuts: Cuts,
    /// `||picture - reference|| / ||reference||`.
    pub rel_rmse: f64,
    /// Mean FLIP, 0 for equal pictures to 1.
    pub flip: f64,
    /// Wall-clock seconds from the light to the last pixel.
    pub seconds: f64,
    /// Nodes of the merged cut, averaged over samples that show a surface.
    pub mean_merged_nodes: f64,
    /// BRDF evaluations, averaged likewise.
    pub mean_brdf_evaluations: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Structural similarity, 1 for equal pictures.
    pub ssim: f64,
    /// Pixels that are not finite in picture or reference, and were left out.
    pub non_finite_pixels: usize,
    /// File, as displayed.
    pub png: String,
    /// File, scene-linear.
    pub exr: String,
}

impl Summary {
    /// Figures of a ladder with pictures written by [`write_picture`] as `cut-SIZE`, `cut-lit` and `reference`, after `prefix`.
    pub fn new(look: &Look, ladder: &Ladder, prefix: &str) -> Self {
        let first = ladder.steps.first().map(|step| &step.rung.stats);
        let renderer = first.map(|stats| stats.adapter.clone().unwrap_or_else(|| stats.backend.clone()));
        let Truth { what, seconds, .. } = &ladder.truth;
        let [png, exr] = files(prefix, "reference");
        Self {
            version: env!("CARGO_PKG_VERSION"),
            environment: look.illumination.environment.name.clone(),
            size: look.view.size,
            aa: look.view.aa,
            renderer: renderer.unwrap_or_default(),
            reference: ReferenceFigures { kind: "samples", what: what.clone(), seconds: *seconds, png, exr },
            steps: ladder.steps.iter().map(|step| StepFigures::new(step, prefix)).collect(),
        }
    }
}

impl StepFigures {
    fn new(Step { rung, metrics }: &Step, prefix: &str) -> Self {
        let [png, exr] = files(prefix, &rung_name(rung));
        Self {
            cuts: rung.cuts,
            rel_rmse: metrics.rel_rmse,
            flip: metrics.flip,
            seconds: rung.stats.seconds,
            mean_merged_nodes: rung.stats.mean_merged_nodes,
            mean_brdf_evaluations: rung.stats.mean_brdf_evaluations,
            rmse: metrics.rmse,
            ssim: metrics.ssim,
            non_finite_pixels: metrics.non_finite_pixels,
            png,
            exr,
        }
    }
}

/// Writes a picture or the reference as soon as it is known.
///
/// # Errors
/// An unwritable folder.
pub fn write_picture(found: super::Found, folder: &Path, prefix: &str) -> Result<()> {
    let write = |name: &str, image: &Image| {
        files(prefix, name).iter().try_for_each(|file| image::write(image, &folder.join(file)))
    };
    match found {
        super::Found::Picture(rung) => write(&rung_name(rung), &rung.image)?,
        super::Found::Truth(truth) => write("reference", &truth.image)?,
        super::Found::Step(_) => {}
    }
    Ok(())
}

fn rung_name(rung: &Rung) -> String {
    format!("cut-{}", rung.cuts.stem())
}

fn files(prefix: &str, name: &str) -> [String; 2] {
    ["png", "exr"].map(|extension| format!("{prefix}{name}.{extension}"))
}

/// The contact sheet: all pictures as displayed with `post`, error and time under each, the reference last.
pub fn sheet(ladder: &Ladder, post: &Post) -> DisplayPicture {
    let tile =
        |image: &Image, caption: Vec<String>| Tile { image: DisplayPicture::shown(image, post).shrunk(TILE), caption };
    let step = |step: &Step| tile(&step.rung.image, caption(step));
    let truth = &ladder.truth;
    let last =
        tile(&truth.image, vec!["reference".into(), "every light sample, traced".into(), seconds(truth.seconds)]);
    let tiles: Vec<Tile> = ladder.steps.iter().map(step).chain([last]).collect();
    contact_sheet(&tiles, COLUMNS, &SheetStyle { min_column: MIN_COLUMN, ..Default::default() })
}

/// Caption of a picture.
fn caption(Step { rung, metrics }: &Step) -> Vec<String> {
    vec![
        rung.cuts.label(),
        format!("rel. RMSE {:.3}, FLIP {:.3}", metrics.rel_rmse, metrics.flip),
        format!("{}, {:.0} merged nodes", seconds(rung.stats.seconds), rung.stats.mean_merged_nodes),
    ]
}
