//! Error of the preview against light paths while an object is dragged, step by step.

use super::{
    super::{Measurement, cases::Case, notebook::Notebook},
    Dragged,
};
use crate::{
    bounces::light_paths::LightPaths,
    report::{
        chart::{AxisScale, Chart, Line},
        table,
        text::short,
    },
};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{Baked, Components, CpuBackend, LitScene, Look, Solution};
use maud::{Markup, html};
use serde::Serialize;

/// Errors over the drag under one kind of light.
#[derive(Serialize)]
struct Curve {
    light: &'static str,
    steps: Vec<Step>,
}

/// Relative RMSE against light paths of the posed scene, without their noise.
#[derive(Serialize)]
struct Step {
    /// Displacement of the object in meters.
    moved: f32,
    preview: f64,
    /// Ratio of the mean luminances.
    preview_energy: f64,
    /// Error of the picture without the pose, as a baseline.
    as_baked: f64,
}

/// Drags an object under each kind of light.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, case: &Case, dragged: &Dragged, notebook: &mut Notebook) -> Result<()> {
    let size = measurement.scale.view;
    let mut curves = Vec::new();
    if let Some(bakes) = &case.environment {
        let look = measurement.lit_from_afar(bakes.mixed(), size);
        let steps = drag(measurement, bakes.mixed().clone().into(), look, 0, dragged)?;
        curves.push(Curve { light: "environment", steps });
    }
    if let Some(dataset) = &case.bounces {
        let mut look = measurement.lit_by_lamps(dataset, size);
        look.components = Components { indirect: true, ..Components::NONE };
        // Light from the environment also bounces, so it must be off.
        look.illumination.intensity = 0.0;
        let steps = drag(measurement, dataset.clone().into(), look, Solution::Cuts.bounces(), dragged)?;
        curves.push(Curve { light: "one bounce", steps });
    }
    let heading = "Implicit visibility: error over a drag";
    notebook.record("implicit_drag", heading, markup(&case.name, dragged, measurement.scale.drag_spp, &curves), &curves)
}

fn drag(measurement: &Measurement, baked: Baked, look: Look, bounces: u32, dragged: &Dragged) -> Result<Vec<Step>> {
    let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone())?;
    let as_baked = scene.show_whole(&look)?.image;
    let count = measurement.scale.drag_steps;
    let step = |i: u32| {
        let share = i as f32 / count as f32;
        let look = Look { poses: dragged.poses(share), ..look.clone() };
        let preview = scene.show_whole(&look)?.image;
        let paths = measurement.posed_paths(&baked, &look, bounces, measurement.scale.drag_spp)?.into();
        Step::new(0.5 * dragged.width * share, &paths, &preview, &as_baked)
    };
    (1..=count).map(step).collect()
}

impl Step {
    fn new(moved: f32, paths: &LightPaths, preview: &Image, as_baked: &Image) -> Result<Self> {
        let figures = paths.against(preview)?;
        let as_baked = paths.against(as_baked)?.error;
        Ok(Self { moved, preview: figures.error, preview_energy: figures.energy, as_baked })
    }
}

fn markup(scene: &str, dragged: &Dragged, spp: u32, curves: &[Curve]) -> Markup {
    html! {
        p {
            "“" (dragged.name) "” of the scene “" (scene) "” is moved by half its width. Relative RMSE against " (spp)
            " light paths per pixel of the scene as it is posed, noise taken off; the picture without the pose beside it."
        }
        @for curve in curves {
            h3 { (curve.light) }
            div.grid.two { (curve.chart()) (curve.table()) }
        }
    }
}

impl Curve {
    fn chart(&self) -> Markup {
        let line = |name: &str, error: fn(&Step) -> f64| Line {
            name: name.into(),
            points: self.steps.iter().map(|step| (step.moved.into(), error(step))).collect(),
        };
        let lines = [line("preview", |step| step.preview), line("as baked", |step| step.as_baked)];
        let (x, y) = (AxisScale::Linear, AxisScale::Linear);
        Chart { title: "Error over a drag", x_label: "meters moved", x, y, lines: &lines }.svg()
    }

    fn table(&self) -> Markup {
        let row =
            |step: &Step| [step.moved.into(), step.preview, step.preview_energy, step.as_baked].map(short).to_vec();
        let head = ["Moved, m", "Preview", "Its energy", "As baked"];
        table(&head, &self.steps.iter().map(row).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_preview_is_told_from_a_picture_as_baked() {
        let gray = |value: f32| Image::filled([4, 4], Vec3::splat(value));
        let paths = LightPaths { image: gray(1.0), noise: 0.0 };
        let step = Step::new(0.1, &paths, &gray(1.02), &gray(1.5)).unwrap();
        assert!((step.preview - 0.02).abs() < 1e-3 && (step.preview_energy - 1.02).abs() < 1e-3);
        assert!((step.as_baked - 0.5).abs() < 1e-3, "negative control");
    }
}
