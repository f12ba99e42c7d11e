//! Gallery pictures from one bake: the hero, environments, rotations and materials.

use super::pictures::{Picture, StillLife};
use crate::{args::replace_materials, terminal::Steps};
use anyhow::Result;
use glam::Vec3;
use lapidary_core::brdf::GgxParameters;
use lapidary_core::material::Material;
use lapidary_render::{Look, Progress, View};
use serde::Serialize;

/// The pictures.
#[derive(Clone, Debug, Serialize)]
pub struct Gallery {
    /// The largest picture.
    pub hero: Picture,
    /// One for each environment.
    pub environments: Vec<Picture>,
    /// The hero's environment, rotated.
    pub rotations: Vec<Picture>,
    /// Other materials for the whole scene.
    pub materials: Vec<Picture>,
}

/// Rotations of the environment in degrees.
const ROTATIONS: [f32; 3] = [60.0, 160.0, 260.0];

/// Width and height of all pictures but the hero.
const SIZE: [u32; 2] = [400, 300];

/// Total number of pictures, for the progress bar.
const PICTURES: u64 = 10;

/// Renders all pictures.
///
/// # Errors
/// An unwritable folder, or Ctrl-C.
pub fn take<'a>(
    still_life: &mut StillLife,
    environments: impl Iterator<Item = &'a str>,
    steps: &Steps,
) -> Result<Gallery> {
    steps.begin("rendering: environments, rotations and materials, all of one bake");
    let progress = steps.progress("pictures", "pictures");
    let mut taken = 0;
    let hero = hero(still_life);
    let usual = Look { view: View { aa: 2, ..still_life.look("main", "sun-and-sky", SIZE).view }, ..hero.clone() };
    let under = |still_life: &StillLife, environment: &str| Look {
        illumination: still_life.look("main", environment, SIZE).illumination,
        ..usual.clone()
    };
    let mut take = |still_life: &mut StillLife, name: &str, title: &str, look: Look| {
        steps.check()?;
        let (picture, _) = still_life.render(name, title, &look)?;
        taken += 1;
        progress.advanced(taken, PICTURES);
        Ok(picture)
    };
    let gallery = Gallery {
        hero: take(still_life, "hero", "Still life", hero)?,
        environments: environments
            .map(|name| {
                let look = under(still_life, name);
                take(still_life, &format!("environment-{name}"), &spaced(name), look)
            })
            .collect::<Result<_>>()?,
        rotations: ROTATIONS
            .into_iter()
            .map(|degrees| {
                let mut look = under(still_life, "sun-and-sky");
                look.illumination.rotation = degrees.to_radians();
                take(still_life, &format!("rotation-{degrees}"), &format!("turned by {degrees}°"), look)
            })
            .collect::<Result<_>>()?,
        materials: variations()
            .into_iter()
            .map(|(name, title, parameters)| {
                let mut look = under(still_life, "studio");
                replace_materials(
                    &mut look.appearance.materials,
                    None,
                    &Material { parameters: parameters.into(), ..Default::default() },
                );
                take(still_life, &format!("material-{name}"), title, look)
            })
            .collect::<Result<_>>()?,
    };
    progress.finish();
    Ok(gallery)
}

/// A wide close view with smooth edges.
fn hero(still_life: &StillLife) -> Look {
    let mut look = still_life.look("main", "studio", [1024, 576]);
    look.view.camera.fov_y = 27.5_f32.to_radians();
    look.view.aa = 4;
    look
}

/// "sun-and-sky" with spaces.
fn spaced(name: &str) -> String {
    name.replace('-', " ")
}

fn variations() -> [(&'static str, &'static str, GgxParameters); 3] {
    let ggx = |base_color, roughness, metalness| GgxParameters {
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
