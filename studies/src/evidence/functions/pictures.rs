//! Pictures of functions: their places, their levels, one of them, and the light in them.

use super::super::{Measurement, cases::Case, implicit::Dragged, notebook::Notebook};
use crate::{
    report::figure,
    sheet::{exposure, side_by_side},
};
use anyhow::Result;
use glam::Vec2;
use lapidary_core::{dataset::Dataset, image::Image, meshless::Functions};
use lapidary_interchange::image;
use lapidary_render::{Baked, BasisView, Components, Look, Solution, ViewMode};
use maud::{Markup, html};
use serde::Serialize;
use std::sync::Arc;

/// Levels of the picture of one function.
const LEVELS_OF_A_FUNCTION: usize = 4;

/// A picture and what it shows.
#[derive(Serialize)]
struct Shown {
    figure: &'static str,
    what: &'static str,
    png: String,
    #[serde(skip)]
    size: [u32; 2],
}

/// Fig. 1, 3, 4 and 7 of the meshless paper.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record_basis(
    measurement: &Measurement,
    case: &Case,
    dataset: &Arc<Dataset>,
    notebook: &mut Notebook,
) -> Result<()> {
    let Some(bake) = dataset.meshless.as_deref() else { return Ok(()) };
    let look = measurement.in_a_large_picture(dataset, Solution::Meshless);
    let levels = bake.basis.levels();
    let functions = near_the_middle(dataset, &look, bake.basis.functions());
    let bounced = measurement.picture(dataset, &look)?;
    let all = [
        measurement.shown(
            "Fig. 1",
            "functions with light, by level",
            &[measurement.basis_view(dataset, &look, ViewMode::BasisCoefficients, 0, 0)?],
        )?,
        measurement.shown("Fig. 3", "the light of each level, and their sum", &{
            let of_level = |level: u32| measurement.basis_view(dataset, &look, ViewMode::BasisLevel, level, 0);
            let mut parts = (0..levels as u32).map(of_level).collect::<Result<Vec<_>>>()?;
            parts.push(bounced.clone());
            parts.into_iter().map(|part| part.scaled(exposure(&bounced))).collect::<Vec<_>>()
        })?,
        measurement.shown("Fig. 4", "one function of each level", &{
            let of = |&function: &u32| measurement.basis_view(dataset, &look, ViewMode::BasisFunction, 0, function);
            functions.iter().map(of).collect::<Result<Vec<_>>>()?
        })?,
        measurement.lit("Fig. 7", "direct light, and all bounces", dataset, &look)?,
    ];
    let heading = "Meshless basis, Fig. 1, 3, 4 and 7: functions and their light";
    notebook.record("meshless_pictures", heading, markup(&case.name, &all), &all)
}

/// Fig. 1, 5 and 6 of meshless radiosity.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record_radiosity(
    measurement: &Measurement,
    case: &Case,
    dataset: &Arc<Dataset>,
    notebook: &mut Notebook,
) -> Result<()> {
    let look = measurement.in_a_large_picture(dataset, Solution::Radiosity);
    let mut all = vec![measurement.shown(
        "Radiosity, Fig. 1",
        "functions of all objects, by level",
        &[measurement.basis_view(dataset, &look, ViewMode::BasisCoefficients, 0, 0)?],
    )?];
    if let Some(dragged) = Dragged::of(&dataset.scene) {
        let at = |share: f32| {
            let components = Components { environment: false, ..Components::ALL };
            let look = Look { poses: dragged.poses(share), components, ..look.clone() };
            measurement.picture(dataset, &look)
        };
        let places = [0.0, 0.5, 1.0].map(at).into_iter().collect::<Result<Vec<_>>>()?;
        let exposure = exposure(&places[0]);
        let places: Vec<Image> = places.iter().map(|image| image.scaled(exposure)).collect();
        all.push(measurement.shown("Radiosity, Fig. 5", "an object in three places", &places)?);
    }
    all.push(measurement.lit("Radiosity, Fig. 6", "direct, indirect and all light", dataset, &look)?);
    let heading = "Meshless radiosity, Fig. 1, 5 and 6: functions that go with objects";
    notebook.record("radiosity_pictures", heading, markup(&case.name, &all), &all)
}

impl Measurement<'_> {
    /// The look of bounced light, in a picture to look at.
    fn in_a_large_picture(&self, dataset: &Arc<Dataset>, solution: Solution) -> Look {
        let mut look = self.bounced(dataset, solution);
        look.view.size = self.scale.frame;
        look
    }

    fn basis_view(
        &self,
        dataset: &Arc<Dataset>,
        look: &Look,
        mode: ViewMode,
        level: u32,
        function: u32,
    ) -> Result<Image> {
        let mut look = look.clone();
        (look.view.mode, look.view.basis) = (mode, BasisView { level, function });
        self.picture(dataset, &look)
    }

    /// Direct, bounced and all light of local lights.
    fn lit(&self, name: &'static str, what: &'static str, dataset: &Arc<Dataset>, look: &Look) -> Result<Shown> {
        let bounced = self.picture(dataset, look)?;
        let of = |components| self.picture(dataset, &Look { components, ..look.clone() });
        let direct = of(Components { direct: true, ..Components::NONE })?;
        let all = of(Components { environment: false, ..Components::ALL })?;
        let exposure = exposure(&all);
        self.shown(name, what, &[direct, bounced, all].map(|image| image.scaled(exposure)))
    }

    /// Writes pictures side by side.
    fn shown(&self, name: &'static str, what: &'static str, pictures: &[Image]) -> Result<Shown> {
        let strip = side_by_side(pictures);
        let words = name.to_lowercase().replace([' ', ',', '.'], "");
        let png = format!("functions-{words}.png");
        image::write(&strip, &self.out.join(&png))?;
        Ok(Shown { figure: name, what, png, size: strip.size })
    }
}

/// A function of each of the first levels, near the middle of the picture.
fn near_the_middle(dataset: &Arc<Dataset>, look: &Look, functions: &Functions) -> Vec<u32> {
    let (camera, size) = (&look.view.camera, look.view.size);
    let middle = Vec2::new(size[0] as f32, size[1] as f32) * 0.5;
    let direction = camera.direction_through(middle, size);
    let hit = Baked::from(dataset.clone()).intersector().closest_hit(camera.eye, direction);
    let at = camera.eye + direction * hit.map_or(0.0, |hit| hit.distance);
    let distance = |function: &usize| functions.points()[*function].position.distance_squared(at);
    let faces = |function: &usize| functions.points()[*function].normal.dot(direction) < 0.0;
    let nearest =
        |level: usize| functions.level(level).filter(faces).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    (0..functions.levels().min(LEVELS_OF_A_FUNCTION)).filter_map(nearest).map(|function| function as u32).collect()
}

fn markup(scene: &str, all: &[Shown]) -> Markup {
    html! {
        p { "Light of the lamps of the scene “" (scene) "”. The tables have its errors." }
        @for shown in all {
            (figure("", &shown.png, shown.size, shown.what, html! {
                b { (shown.figure) } ": " (shown.what)
            }))
        }
    }
}
