//! The bundled scenes of the suite: what is baked, under which light they are seen, and which material is edited.

use super::{Scale, meter::Meter};
use crate::{bundled::DataFolder, terminal::Console};
use anyhow::{Context, Result};
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, IndirectSettings},
    environment::Environment,
    import::{Imported, import},
    scene::Scene,
};
use lapidary_precompute::{BakeJob, Preset, bake, resolve};
use lapidary_render::{Baked, Components, Illumination, Look, View};
use std::{path::Path, sync::Arc, time::Instant};

/// A bundled scene and what is measured of it.
pub struct Plan {
    /// Name of its folder and file.
    pub name: &'static str,
    /// Bundled environment; of a scene without one, only local lights are seen.
    environment: Option<&'static str>,
    /// What is baked.
    mode: BakeParts,
    /// The material that is edited.
    edited: &'static str,
}

/// The still life under the studio; the interior by day, with its lamps and one bounce; the colour box with its spot and
/// one bounce.
pub const PLANS: [Plan; 3] = [
    Plan { name: "still-life", environment: Some("studio"), mode: BakeParts::ENVIRONMENT, edited: "Copper" },
    Plan { name: "interior", environment: Some("sun-and-sky"), mode: BakeParts::CUTS, edited: "Upholstery" },
    Plan { name: "color-box", environment: None, mode: BakeParts::INDIRECT, edited: "Red paint" },
];

/// A baked scene with its light.
pub struct Case {
    /// Name of the scene.
    pub name: &'static str,
    /// The scene.
    pub baked: Baked,
    /// Its picture.
    pub look: Look,
    /// Index of the material that is edited.
    pub edited: usize,
}

impl Plan {
    /// Bakes the scene, which is the first figure of it.
    ///
    /// # Errors
    /// Data that cannot be read, a folder that cannot be written to, or Ctrl-C.
    pub fn bake(&self, data: &DataFolder, folder: &Path, scale: &Scale, meter: &mut Meter) -> Result<Case> {
        let path = data.scene(self.name);
        let Imported { scene, report } = import(&path)?;
        let job = BakeJob {
            settings: resolve(self.settings(scene.mesh.positions.len(), scale.lights))?,
            poses: Default::default(),
            clip_time: None,
            output: folder.join(self.name).with_extension("cuts"),
            inputs: report.files,
            chunks: None,
            resume: false,
            import_secs: 0.0,
            warnings: report.warnings,
        };
        let (mut dataset, reporter) = (None, &meter.steps().reporter);
        meter.measure_once(format!("{}: bake", self.name), || {
            let scene = scene.clone();
            let start = Instant::now();
            dataset = Some(bake(scene, &job, reporter)?);
            let time = start.elapsed();
            reporter.finish();
            Ok([time])
        })?;
        let dataset = Arc::new(dataset.context("one run bakes")?);
        let named = dataset.scene.materials.iter().position(|material| material.name == self.edited);
        let edited = named.with_context(|| {
            format!("the bundled scene has no material {}; generate the data anew ({})", self.edited, path.display())
        })?;
        let look = self.look(&dataset.scene, data, scale.size)?;
        Ok(Case { name: self.name, baked: dataset.into(), look, edited })
    }

    /// Those of a draft, with room for some more vertices than the mesh has.
    fn settings(&self, mesh_vertices: usize, lights: Option<usize>) -> BakeSettings {
        let draft = Preset::Draft.settings_for(mesh_vertices);
        let sources = lights.unwrap_or(draft.indirect.sources);
        BakeSettings {
            lights: lights.unwrap_or(draft.lights),
            pilot_clusters: lights.map_or(draft.pilot_clusters, |lights| lights.min(draft.pilot_clusters)),
            max_vertices: draft.max_vertices.filter(|_| lights.is_none()),
            mode: self.mode,
            indirect: IndirectSettings { sources, ..draft.indirect },
            ..draft
        }
    }

    fn look(&self, scene: &Scene, data: &DataFolder, size: [u32; 2]) -> Result<Look> {
        let environment = match self.environment {
            Some(name) => data.environment(name, Console { quiet: true })?,
            None => Environment::from_spec("constant:0,0,0")?.0,
        };
        let light = Illumination { environment: environment.into(), rotation: 0.0, intensity: 1.0, sun: None };
        let view = View::new(scene.first_view(), size);
        let components = Components {
            environment: self.environment.is_some(),
            direct: !scene.lights.is_empty(),
            indirect: self.mode.sources(),
        };
        Ok(Look { lights: scene.lights.clone().into(), components, ..Look::under_environment(scene, view, light) })
    }
}
