//! Error of the picture by bake setting: weight of the metrics, error bound of cuts, number of lights, number of vertices. Only
//! points in the picture are baked, and they are traced once for all trees and bounds.

use super::{
    Measurement,
    cases::{Bakes, Case, view},
    notebook::Notebook,
    variants::{Variant, VariantBaker},
};
use crate::{
    args::DeviceArgs,
    bounces::light_paths::LightPaths,
    ladder::{Cuts, Settings, Truth, climb},
    report::{
        chart::{self, Chart, Line},
        table,
        text::short,
    },
    terminal::Interrupted,
};
use anyhow::Result;
use lapidary_core::{
    cut::CutCriterion, dataset::Dataset, image::Image, light_tree::TreeKind, ray::Intersector, scene::Scene,
};
use lapidary_precompute::Geometry;
use lapidary_render::{LitScene, PathSettings, Quiet, Renderer, View};
use maud::{Markup, html};
use serde::Serialize;
use std::sync::Arc;

/// One point of a sweep.
#[derive(Serialize)]
struct Point {
    /// Value of the swept setting.
    value: f64,
    /// Error against the sweep's reference, without the reference's noise if it has any.
    rel_rmse: f64,
    /// Mean over the points in the picture.
    mean_cut: f64,
    /// Error of their stored visibility.
    rms_visibility: f64,
    vertices: usize,
}

/// One sweep.
#[derive(Serialize)]
struct Sweep {
    scene: String,
    swept: &'static str,
    reference: String,
    /// Relative RMSE of the reference itself.
    reference_noise: f64,
    points: Vec<Point>,
}

/// Measures all sweeps of one scene; each is written when complete. `truth` is the picture by all light samples, if known.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(
    measurement: &Measurement,
    case: &Case,
    bakes: &Bakes,
    truth: Option<&Truth>,
    notebook: &mut Notebook,
) -> Result<()> {
    let truth = truth.cloned().map_or_else(|| traced(measurement, bakes.mixed()), Ok)?;
    let sweeper = Sweeper { measurement, case, truth };
    let [beta, sigma] = sweeper.beta_and_sigma(bakes)?;
    for (key, heading, text, sweep) in
        [("error_by_beta", "Error against beta", BETA, beta), ("error_by_sigma", "Error against sigma", SIGMA, sigma)]
    {
        notebook.record(key, heading, sweep.markup(text), &sweep)?;
    }
    let lights = sweeper.lights(bakes)?;
    notebook.record("error_by_lights", "Error against the number of lights", lights.markup(LIGHTS), &lights)?;
    let vertices = sweeper.vertices()?;
    notebook.record("error_by_vertices", "Error against tessellation", vertices.markup(VERTICES), &vertices)
}

const BETA: &str = "Weight of the geometric metric; 0 clusters by visibility alone.";
const SIGMA: &str = "Bound of a node’s error (Eq. 5), over the mixed tree.";
const LIGHTS: &str = "Samples of the environment, each with its own tree, and sigma in proportion to the root of their number, so \
                      that it bounds the same solid angle. Against light paths of the continuous environment, whose noise is \
                      taken off.";
const VERTICES: &str = "Vertices after tessellation, from the mesh as it is: linear interpolation of visibility needs them where \
                        shadows fall. Each against its own surfaces, for splits also turn the normals between vertices a little.";

/// Traces all light samples on the surfaces of a dataset.
fn traced(measurement: &Measurement, dataset: &Arc<Dataset>) -> Result<Truth> {
    let progress = measurement.steps.progress("reference", "pixels");
    let look = measurement.lit_from_afar(dataset, measurement.scale.view);
    let truth = Truth::trace(&dataset.clone().into(), &look, &progress)?;
    progress.finish();
    measurement.steps.check()?;
    Ok(truth)
}

struct Sweeper<'a> {
    measurement: &'a Measurement<'a>,
    case: &'a Case,
    truth: Truth,
}

impl Sweeper<'_> {
    fn beta_and_sigma(&self, bakes: &Bakes) -> Result<[Sweep; 2]> {
        let scale = self.measurement.scale;
        let usual = self.measurement.criterion(scale.lights);
        let betas = scale.betas.iter().map(|&beta| Variant { criterion: usual, ..weighted(beta) });
        let sigma = |&sigma: &f32| Variant { criterion: CutCriterion { sigma, ..usual }, ..weighted(0.5) };
        let variants: Vec<Variant> = betas.chain(scale.sigmas.iter().map(sigma)).collect();
        let made = self.bake(&bakes.baker, scale.lights, &variants)?;
        let (by_beta, by_sigma) = made.split_at(scale.betas.len());
        Ok([
            self.sweep("beta", self.points(scale.betas, by_beta)?),
            self.sweep("sigma", self.points(scale.sigmas, by_sigma)?),
        ])
    }

    fn vertices(&self) -> Result<Sweep> {
        let scale = self.measurement.scale;
        let usual = Variant { criterion: self.measurement.criterion(scale.lights), ..weighted(0.5) };
        let mut points = Vec::new();
        for &budget in scale.vertex_budgets {
            let scene = self.case.scene.clone();
            let vertices = (budget * scene.mesh.positions.len() as f64) as usize;
            let baker = VariantBaker::new(scene, (budget > 1.0).then_some(vertices), &self.measurement.steps.reporter)?;
            for dataset in self.bake(&baker, scale.lights, &[usual])? {
                let error = self.picture(&dataset, &traced(self.measurement, &dataset)?)?.1;
                points.push(Point::new(dataset.report.vertices as f64, error, &dataset));
            }
        }
        Ok(self.sweep("vertices", points))
    }

    fn lights(&self, bakes: &Bakes) -> Result<Sweep> {
        let (scale, steps) = (self.measurement.scale, self.measurement.steps);
        let look = self.measurement.lit_from_afar(bakes.mixed(), scale.view);
        let renderer = Renderer::new(bakes.mixed().clone());
        let progress = steps.progress("light paths", "passes");
        let settings = PathSettings::direct(scale.spp);
        let paths = renderer.path_picture(&look.view, &look.illumination, &[], settings, &progress);
        let paths = LightPaths::from(paths);
        progress.finish();
        steps.check()?;
        let mut points = Vec::new();
        for &lights in scale.light_counts {
            let variant = Variant { criterion: self.measurement.criterion(lights), ..weighted(0.5) };
            for dataset in self.bake(&bakes.baker, lights, &[variant])? {
                let error = paths.against(&self.picture(&dataset, &self.truth)?.0)?.error;
                points.push(Point::new(lights as f64, error, &dataset));
            }
        }
        Ok(Sweep {
            scene: self.case.name.clone(),
            swept: "lights",
            reference: format!("{} light paths per pixel", scale.spp),
            reference_noise: paths.noise,
            points,
        })
    }

    /// Datasets with cuts for the points in the picture.
    fn bake(&self, baker: &VariantBaker, lights: usize, variants: &[Variant]) -> Result<Vec<Arc<Dataset>>> {
        let Measurement { scale, steps, .. } = self.measurement;
        let Geometry { scene, intersector, .. } = &baker.geometry;
        let shown = shown_vertices(scene, intersector, &view(scene, scale.view));
        let points = baker.points_of(shown);
        let made = baker.bake(lights, scale.sweep_pilot_clusters, variants, &points, &steps.reporter)?;
        steps.reporter.finish();
        Ok(made.into_iter().map(Arc::new).collect())
    }

    /// Errors of datasets that differ in one value and have the same surfaces.
    fn points(&self, values: &[f32], datasets: &[Arc<Dataset>]) -> Result<Vec<Point>> {
        let point = |(&value, dataset): (&f32, &Arc<Dataset>)| {
            Ok(Point::new(value.into(), self.picture(dataset, &self.truth)?.1, dataset))
        };
        values.iter().zip(datasets).map(point).collect()
    }

    fn sweep(&self, swept: &'static str, points: Vec<Point>) -> Sweep {
        let (scene, reference) = (self.case.name.clone(), self.truth.what.clone());
        Sweep { scene, swept, reference, reference_noise: 0.0, points }
    }

    /// The picture of a dataset, and its relative RMSE against all light samples.
    fn picture(&self, dataset: &Arc<Dataset>, truth: &Truth) -> Result<(Image, f64)> {
        self.measurement.steps.check()?;
        let scale = self.measurement.scale;
        let look = self.measurement.lit_from_afar(dataset, scale.view);
        let settings = Settings { cuts: vec![Cuts::Refine(scale.sweep_cut)], frames: 1 };
        let mut scene = LitScene::new(DeviceArgs::CPU.open()?, dataset.clone().into())?;
        let known = Some(truth.clone());
        let ladder = climb(&mut scene, &look, &settings, known, &Quiet, &mut |_| Ok(()))?;
        let step = ladder.and_then(|ladder| ladder.steps.into_iter().next()).ok_or(Interrupted)?;
        Ok((step.rung.image, step.metrics.rel_rmse))
    }
}

/// The tree with this weight; at the ends of the range it is not mixed.
fn weighted(beta: f32) -> Variant {
    let tree = match beta {
        0.0 => TreeKind::DataDriven,
        1.0 => TreeKind::Geometric,
        _ => TreeKind::Mixed,
    };
    Variant { tree, beta, criterion: CutCriterion::default() }
}

/// Triangle corners in a picture with one sample per pixel.
fn shown_vertices(scene: &Scene, intersector: &Intersector, view: &View) -> Vec<u32> {
    let [width, height] = view.size;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let projection = view.projection();
    let hit = |[x, y]: [u32; 2]| {
        let center = glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let (origin, direction) = projection.ray(center);
        intersector.closest_hit(origin, direction)
    };
    let mut vertices: Vec<u32> =
        pixels.filter_map(hit).flat_map(|h| scene.mesh.triangles[h.triangle as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

impl Point {
    fn new(value: f64, rel_rmse: f64, dataset: &Dataset) -> Self {
        let report = &dataset.report;
        let (mean_cut, rms_visibility, vertices) = (report.mean_cut, report.rms_visibility, report.vertices);
        Self { value, rel_rmse, mean_cut, rms_visibility, vertices }
    }
}

impl Sweep {
    fn markup(&self, text: &str) -> Markup {
        let line = |name: &str, y: fn(&Point) -> f64| Line {
            name: name.into(),
            points: self.points.iter().map(|p| (p.value, y(p))).collect(),
        };
        let scale =
            if matches!(self.swept, "lights" | "vertices") { chart::AxisScale::Log } else { chart::AxisScale::Linear };
        let lines = [line("rel. RMSE", |p| p.rel_rmse), line("visibility", |p| p.rms_visibility)];
        let title = "Error of picture and of visibility";
        let chart = Chart { title, x_label: self.swept, x: scale, y: chart::AxisScale::Linear, lines: &lines };
        let row = |p: &Point| {
            let sizes = [format!("{:.1}", p.mean_cut), p.vertices.to_string()];
            [short(p.value), short(p.rel_rmse), short(p.rms_visibility)].into_iter().chain(sizes).collect()
        };
        let rows: Vec<Vec<String>> = self.points.iter().map(row).collect();
        let head = [self.swept, "Rel. RMSE", "RMS of visibility", "Mean cut", "Vertices"];
        html! {
            p {
                (text) " Scene “" (self.scene) "”; reference: " (self.reference) "."
                @if self.reference_noise > 0.0 { " Noise of the reference: " (short(self.reference_noise)) "." }
                " Mean cut and visibility are of the points that the picture shows."
            }
            div.grid.two { (chart.svg()) (table(&head, &rows)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::{camera::Camera, test_scenes};

    #[test]
    fn only_what_is_in_the_picture_is_baked() {
        let scene = test_scenes::dataset(&["a"], &[]).scene;
        let intersector = Intersector::new(&scene.mesh);
        let toward = |target: Vec3| View::new(Camera::look_at(Vec3::new(0.3, 2.0, 0.2), target, 30.0), [8, 8]);
        assert_eq!(shown_vertices(&scene, &intersector, &toward(Vec3::new(0.3, 0.0, 0.2))), [0, 1, 2]);
        assert!(shown_vertices(&scene, &intersector, &toward(Vec3::new(0.3, 9.0, 0.2))).is_empty());
        assert_eq!(
            [0.0, 0.5, 1.0].map(|b| weighted(b).tree),
            [TreeKind::DataDriven, TreeKind::Mixed, TreeKind::Geometric]
        );
    }
}
