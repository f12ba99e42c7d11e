//! Pictures to look at: the hero, environments, rotations and materials. All of one bake.

use super::{
    data::Environments,
    stage::{Picture, PictureSettings, Stage},
    steps::Steps,
};
use crate::args::replace_materials;
use anyhow::Result;
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    material::{BrdfParameters, Material},
};
use lapidary_render::{Appearance, Progress};
use serde::Serialize;
use std::{path::Path, sync::Arc};

/// The pictures.
#[derive(Clone, Debug, Serialize)]
pub struct Gallery {
    /// The largest.
    pub hero: Picture,
    /// One for each environment.
    pub environments: Vec<Picture>,
    /// The hero's environment, turned.
    pub rotations: Vec<Picture>,
    /// Other materials for the whole scene.
    pub materials: Vec<Picture>,
}

/// How far the environment is turned, in degrees.
const ROTATIONS: [f32; 3] = [60.0, 160.0, 260.0];

/// Pictures in all, for the progress bar.
const PICTURES: u64 = 10;

/// Takes all pictures.
///
/// # Errors
/// A folder that cannot be written, or Ctrl-C.
pub fn take(dataset: &Arc<Dataset>, environments: &Environments, out: &Path, steps: &Steps) -> Result<Gallery> {
    steps.begin("rendering: environments, rotations and materials, all of one bake");
    let progress = steps.progress("pictures", "pictures");
    let mut taken = 0;
    let mut take = |stage: &Stage, name: &str, title: &str, settings: PictureSettings| {
        steps.check()?;
        let (picture, _) = stage.render(name, title, settings)?;
        taken += 1;
        progress.advanced(taken, PICTURES);
        Ok(picture)
    };
    let stage = Stage::new(dataset, environments, out);
    let gallery = Gallery {
        hero: take(&stage, "hero", "Still life", hero_settings())?,
        environments: environments
            .names()
            .map(|name| {
                let settings = PictureSettings { environment: name.into(), ..Default::default() };
                take(&stage, &format!("environment-{name}"), &spaced(name), settings)
            })
            .collect::<Result<_>>()?,
        rotations: ROTATIONS
            .into_iter()
            .map(|degrees| {
                let settings = PictureSettings { rotation_degrees: degrees, ..Default::default() };
                take(&stage, &format!("rotation-{degrees}"), &format!("turned by {degrees}°"), settings)
            })
            .collect::<Result<_>>()?,
        materials: variations()
            .into_iter()
            .map(|(name, title, parameters)| {
                let mut stage = Stage::new(dataset, environments, out);
                let mut appearance = Appearance::of(&dataset.scene);
                replace_materials(&mut appearance.materials, &Material { parameters, ..Default::default() });
                stage.renderer.set_appearance(appearance);
                let settings = PictureSettings { environment: "studio".into(), ..Default::default() };
                take(&stage, &format!("material-{name}"), title, settings)
            })
            .collect::<Result<_>>()?,
    };
    progress.finish();
    Ok(gallery)
}

/// Wide and close, with smooth edges.
fn hero_settings() -> PictureSettings {
    PictureSettings {
        environment: "studio".into(),
        fov_degrees: Some(27.5),
        size: [1024, 576],
        aa: 4,
        ..Default::default()
    }
}

/// "sun-and-sky" as words.
fn spaced(name: &str) -> String {
    name.replace('-', " ")
}

fn variations() -> [(&'static str, &'static str, BrdfParameters); 3] {
    let ggx = |base_color, roughness, metalness| BrdfParameters {
        base_color: Vec3::from_array(base_color),
        roughness,
        metalness,
        ..Default::default()
    };
    [
        ("clay", "clay: roughness 0.9", ggx([0.42, 0.39, 0.36], 0.9, 0.0)),
        ("lacquer", "black lacquer: roughness 0.25", ggx([0.02, 0.02, 0.022], 0.25, 0.0)),
        ("gold", "satin gold: roughness 0.4", ggx([1.0, 0.77, 0.34], 0.4, 1.0)),
    ]
}
