//! The measured scenes: read, tessellated and baked once for all figures.

use super::{
    Measurement, Paper,
    variants::{Variant, VariantBaker},
};
use anyhow::{Context, Result};
use glam::Vec3;
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeParts, BakeSettings, Dataset, IndirectSettings},
    light_tree::TreeKind,
    ray::OPEN,
    scene::Scene,
    sphere::fibonacci_directions,
};
use lapidary_interchange::import::{ImportOptions, Imported, import_with};
use lapidary_precompute::{self as precompute, BakeJob, Preset};
use lapidary_render::{Background, Components, Illumination, Look, Solution, View};
use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Least mean share of the sky that a scene's points must see to be measured under it: less is a closed box.
const LEAST_SKY: f64 = 0.005;
/// Points and directions for this test.
const SKY_POINTS: usize = 256;
const SKY_DIRECTIONS: usize = 1024;

/// Trees of Fig. 5 and 6b, by increasing weight of the geometric metric.
pub const TREES: [(TreeKind, f32); 3] =
    [(TreeKind::DataDriven, 0.0), (TreeKind::Mixed, 0.5), (TreeKind::Geometric, 1.0)];

/// Vertex limit of a scene: `most`, or more if the mesh already has as many. Large triangles need added vertices for shadows.
fn room_in(scene: &Scene, most: usize) -> usize {
    precompute::with_room(most, scene.mesh.positions.len())
}

/// An imported scene.
pub struct Plan {
    /// The file's name without extension.
    pub name: String,
    path: PathBuf,
    scene: Scene,
    warnings: Vec<String>,
}

impl Plan {
    /// Reads a scene early, so that errors appear before anything is baked.
    ///
    /// # Errors
    /// See [`import_with`].
    pub fn read(path: &Path, options: &ImportOptions) -> Result<Self> {
        let Imported { scene, report } = import_with(path, options)?;
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, path: path.into(), scene, warnings: report.warnings })
    }
}

/// Numbers scenes with the same name, whose pictures would overwrite each other.
pub fn named_apart(mut plans: Vec<Plan>) -> Vec<Plan> {
    let mut taken = HashSet::new();
    for plan in &mut plans {
        let own = plan.name.clone();
        let mut number = 1;
        while !taken.insert(plan.name.clone()) {
            number += 1;
            plan.name = format!("{own}-{number}");
        }
    }
    plans
}

/// A scene and its bakes.
pub struct Case {
    /// Name in all figures.
    pub name: String,
    /// The imported scene.
    pub scene: Scene,
    /// Its bakes for distant light, unless it is closed or no paper needs them.
    pub environment: Option<Bakes>,
    /// Its bake for the bounce of its local lights, if it has any and a paper needs it.
    pub bounces: Option<Arc<Dataset>>,
    /// Its bake for their bounces in functions, of the scene and of its objects.
    pub functions: Option<Arc<Dataset>>,
}

/// Bakes of one scene over trees of different metrics.
pub struct Bakes {
    /// The tessellated scene.
    pub baker: VariantBaker,
    /// One for each of [`TREES`].
    pub datasets: [Arc<Dataset>; 3],
}

impl Bakes {
    /// The default tree of bakes.
    pub fn mixed(&self) -> &Arc<Dataset> {
        &self.datasets[1]
    }

    /// The tree of geometric distances alone.
    pub fn geometric(&self) -> &Arc<Dataset> {
        &self.datasets[2]
    }
}

impl Measurement<'_> {
    /// Bakes for the kinds of light that a scene has and the papers measure.
    ///
    /// # Errors
    /// A failed bake, or Ctrl-C.
    pub fn bake(&self, plan: Plan) -> Result<Case> {
        self.steps.begin(&format!("baking {}", plan.name));
        let context = || format!("cannot measure the scene {}", plan.path.display());
        let has_cuts = self.has(&[Paper::Cuts, Paper::Implicit]);
        let environment = if has_cuts { self.environment_bakes(&plan.scene).with_context(context)? } else { None };
        let is_lit = !plan.scene.lights.is_empty();
        let has_functions = is_lit && self.has(&[Paper::Meshless, Paper::Wavelet]);
        let of = |mode: BakeParts, name: &str| self.bounce_bake(&plan, mode, name).with_context(context);
        let bounces = (is_lit && has_cuts).then(|| of(BakeParts::INDIRECT, "bounces")).transpose()?;
        let in_functions = BakeParts::MESHLESS.with(BakeParts::RADIOSITY);
        let functions = has_functions.then(|| of(in_functions, "functions")).transpose()?;
        self.steps.reporter.finish();
        Ok(Case { name: plan.name, scene: plan.scene, environment, bounces, functions })
    }

    fn environment_bakes(&self, scene: &Scene) -> Result<Option<Bakes>> {
        let reporter = &self.steps.reporter;
        let baker = VariantBaker::new(scene.clone(), Some(room_in(scene, self.scale.max_vertices)), reporter)?;
        let directions = fibonacci_directions(SKY_DIRECTIONS);
        let some = baker.some_points(SKY_POINTS);
        let seen = |visible: &[u8]| visible.iter().map(|&v| f64::from(v) / f64::from(OPEN)).sum::<f64>();
        let seen: f64 = baker.visibility(&directions, &some, reporter, seen)?.iter().sum();
        if seen < LEAST_SKY * (some.len() * SKY_DIRECTIONS) as f64 {
            return Ok(None);
        }
        let variants = TREES.map(|(tree, beta)| Variant { tree, beta, criterion: self.criterion(self.scale.lights) });
        let all = baker.some_points(usize::MAX);
        let (lights, clusters) = (self.scale.lights, self.scale.pilot_clusters);
        let datasets = baker.bake(lights, clusters, &variants, &all, reporter)?;
        let datasets: Vec<Arc<Dataset>> = datasets.into_iter().map(Arc::new).collect();
        let datasets = datasets.try_into().map_err(|_| anyhow::anyhow!("a dataset for each tree"))?;
        Ok(Some(Bakes { baker, datasets }))
    }

    /// The paper's sigma, whatever the number of lights.
    pub fn criterion(&self, lights: usize) -> CutCriterion {
        CutCriterion { sigma: super::MeasurementScale::sigma_for(lights), ..Default::default() }
    }

    fn bounce_bake(&self, plan: &Plan, mode: BakeParts, name: &str) -> Result<Arc<Dataset>> {
        let normal = Preset::Normal.settings();
        let job = BakeJob {
            settings: precompute::resolve(BakeSettings {
                lights: self.scale.lights,
                max_vertices: Some(room_in(&plan.scene, self.scale.bounce_vertices)),
                mode,
                indirect: IndirectSettings { sources: self.scale.sources, ..normal.indirect },
                meshless: self.scale.meshless_settings(),
                object_bases: self.scale.object_bases,
                pilot_clusters: self.scale.pilot_clusters,
                ..normal
            })?,
            poses: Default::default(),
            clip_time: None,
            output: self.out.join(format!("{}-{name}.cuts", plan.name)),
            inputs: Vec::new(),
            chunks: None,
            resume: false,
            import_secs: 0.0,
            warnings: plan.warnings.clone(),
        };
        Ok(precompute::bake(plan.scene.clone(), &job, &self.steps.reporter)?.into())
    }

    /// The look of a scene under the environment alone, on black.
    pub fn lit_from_afar(&self, dataset: &Arc<Dataset>, size: [u32; 2]) -> Look {
        let environment = self.environment.clone();
        let light = Illumination { environment, rotation: 0.0, intensity: 1.0, sun: None };
        Look::under_environment(&dataset.scene, view(&dataset.scene, size), light)
    }

    /// The look of a scene under its local lights and their bounce.
    pub fn lit_by_lamps(&self, dataset: &Arc<Dataset>, size: [u32; 2]) -> Look {
        Look {
            lights: dataset.scene.lights.clone().into(),
            components: Components { environment: false, ..Components::ALL },
            solution: Solution::Cuts,
            ..self.lit_from_afar(dataset, size)
        }
    }

    /// The look of bounced light alone, of local lights.
    pub fn bounced(&self, dataset: &Arc<Dataset>, solution: Solution) -> Look {
        let mut look = self.lit_by_lamps(dataset, self.scale.view);
        (look.solution, look.components) = (solution, Components { indirect: true, ..Components::NONE });
        look.illumination.intensity = 0.0;
        look
    }
}

/// The scene's first camera, or a view of the whole scene. The background is black, so errors are on surfaces alone.
pub fn view(scene: &Scene, size: [u32; 2]) -> View {
    View { background: Background::Flat(Vec3::ZERO), ..View::new(scene.first_view(), size) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_of_one_name_are_numbered() {
        let plan = |name: &str| Plan {
            name: name.into(),
            path: PathBuf::new(),
            scene: Scene::default(),
            warnings: Vec::new(),
        };
        let names: Vec<String> =
            named_apart(["a", "b", "a", "a"].map(plan).into()).into_iter().map(|plan| plan.name).collect();
        assert_eq!(names, ["a", "b", "a-2", "a-3"]);
    }
}
