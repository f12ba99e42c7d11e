//! Fig. 11: a moved object lit by its bins, glossy and diffuse, beside light paths.

use super::{
    super::{
        Measurement,
        cases::{Bakes, Case},
        notebook::Notebook,
    },
    Dragged,
};
use crate::{
    bounces::light_paths::{Figures, LightPaths},
    report::{figure, text::short},
    sheet::strip,
};
use anyhow::Result;
use lapidary_core::{
    camera::Camera,
    dataset::Dataset,
    material::{BrdfModel, Material},
    scene::pose::Objects,
};
use lapidary_interchange::image;
use lapidary_render::{Baked, CpuBackend, LitScene, Look};
use maud::{Markup, html};
use serde::Serialize;
use std::sync::Arc;

/// Roughness of metal; `None` for a diffuse surface.
const GLOSSES: [Option<f32>; 3] = [None, Some(0.5), Some(0.3)];
/// Height of the picture in radii of the object.
const FRAMED: f32 = 3.0;

/// One material.
#[derive(Serialize)]
struct Shown {
    /// Roughness of metal; `None` for a diffuse surface.
    roughness: Option<f32>,
    #[serde(flatten)]
    figures: Figures,
    /// Error of the picture without the pose.
    as_baked: f64,
    png: String,
    #[serde(skip)]
    size: [u32; 2],
}

/// Renders and traces an object at the end of its drag.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, case: &Case, dragged: &Dragged, notebook: &mut Notebook) -> Result<()> {
    let Some(bakes) = &case.environment else { return Ok(()) };
    let all = GLOSSES.map(|roughness| shown(measurement, bakes, dragged, roughness));
    let all = all.into_iter().collect::<Result<Vec<Shown>>>()?;
    let heading = "Implicit visibility, Fig. 11: glossy objects lit by their bins";
    notebook.record("implicit_fig11", heading, markup(&case.name, dragged, &all), &all)
}

fn shown(measurement: &Measurement, bakes: &Bakes, dragged: &Dragged, roughness: Option<f32>) -> Result<Shown> {
    let dataset = made_of(bakes.mixed(), dragged.object, material(roughness));
    let mut look = measurement.lit_from_afar(&dataset, measurement.scale.view);
    look.view.camera = framing(&dataset, dragged, &look.view.camera);
    let baked = Baked::from(dataset);
    let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone())?;
    let as_baked = scene.show_whole(&look)?.image;
    look = Look { poses: dragged.poses(1.0), ..look };
    let preview = scene.show_whole(&look)?.image;
    let paths: LightPaths = measurement.posed_paths(&baked, &look, 0, measurement.scale.spp)?.into();
    let strip = strip(&paths.image, &[Some(&preview)])?;
    let png = format!("implicit-{}.png", roughness.map_or("diffuse".into(), |roughness| format!("glossy-{roughness}")));
    image::write(&strip, &measurement.out.join(&png))?;
    let (figures, as_baked) = (paths.against(&preview)?, paths.against(&as_baked)?.error);
    Ok(Shown { roughness, figures, as_baked, png, size: strip.size })
}

/// White paint, or metal.
fn material(roughness: Option<f32>) -> Material {
    let mut material = Material { name: "dragged".into(), model: BrdfModel::Ggx, ..Material::default() };
    let parameters = &mut material.parameters;
    match roughness {
        Some(roughness) => {
            parameters.set("metalness", 1.0);
            parameters.set("roughness", roughness);
        }
        None => material.model = BrdfModel::Lambert,
    }
    material.parameters.set("base_color", glam::Vec3::splat(0.8));
    material
}

/// The same bake with another material on an object; visibility does not depend on it.
fn made_of(dataset: &Dataset, object: u32, material: Material) -> Arc<Dataset> {
    let mut dataset = dataset.clone();
    let scene = &mut dataset.scene;
    let number = scene.materials.len() as u32;
    scene.materials.push(material);
    let mesh = &mut scene.mesh;
    let materials = mesh.triangle_material.iter_mut().zip(&mesh.triangle_object);
    materials.filter(|(_, of)| **of == object).for_each(|(material, _)| *material = number);
    dataset.into()
}

/// A camera at another's eye, aimed at the posed object.
fn framing(dataset: &Dataset, dragged: &Dragged, from: &Camera) -> Camera {
    let objects = Objects::of(&dataset.scene);
    let center = objects.center(dragged.object);
    let radius = |&vertex: &u32| dataset.scene.mesh.positions[vertex as usize].distance(center);
    let radius = objects.vertices(dragged.object).iter().map(radius).fold(0.0, f32::max);
    let target = center + dragged.poses(1.0).of(dragged.object).translate;
    let height = 2.0 * (0.5 * FRAMED * radius).atan2(from.eye.distance(target));
    Camera::look_at(from.eye, target, height.to_degrees())
}

fn markup(scene: &str, dragged: &Dragged, all: &[Shown]) -> Markup {
    html! {
        p {
            "“" (dragged.name) "” of the scene “" (scene) "”, moved by half its width, under the environment alone: light paths, \
             the preview, and its error. Its bins become cuts, which its material is shaded with."
        }
        div.grid.three {
            @for shown in all {
                @let name = shown.roughness.map_or("diffuse".into(), |roughness| format!("metal, roughness {roughness}"));
                (figure("", &shown.png, shown.size, &name, html! {
                    b { (name) }
                    "error " (short(shown.figures.error)) ", energy " (short(shown.figures.energy)) br;
                    "as baked " (short(shown.as_baked))
                }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes;

    #[test]
    fn one_object_alone_gets_another_material() {
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let triangles = dataset.scene.mesh.triangles.len();
        dataset.scene.mesh.triangle_object = (0..triangles as u32).collect();
        let made = made_of(&dataset, 0, material(Some(0.3)));
        let number = dataset.scene.materials.len() as u32;
        assert_eq!(made.scene.mesh.triangle_material[0], number);
        assert!(made.scene.mesh.triangle_material[1..].iter().all(|&material| material != number));
        assert_eq!(
            (made.scene.materials[number as usize].model, made.cuts.len()),
            (BrdfModel::Ggx, dataset.cuts.len())
        );
    }
}
