//! The parts of a bake that bounce light, for one viewpoint.

use super::geometry::Geometry;
use crate::{
    bake::{
        checkpoint::Checkpoint,
        clock::Clock,
        parts::{self, Put, wavelet::Quads},
        settings::ResolvedBake,
    },
    errors::BakeError,
    observer::{Event, Observer},
    sources::viewpoint::{ViewpointSurroundings, find_viewpoint},
    vertices::tracing::Tracing,
    warning::Warning,
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera, dataset::BakeParts, light_tree::LightTree, mesh_surface::MeshSurface, scene::Scene, surfel::Surfel,
};

/// Largest share of directions around a viewpoint that may miss the scene without a warning: in a court without a roof a third do.
const MOST_OPEN: f32 = 0.4;

/// Mean reflectance of a closed space above which a warning says that bounces hardly lose light. At 0.95 the fourteenth bounce has
/// half the light of the first.
const MOST_REFLECTANCE: f32 = 0.95;

/// Inputs of the parts that bounce light.
pub struct Bouncing<'a> {
    pub geometry: &'a Geometry,
    pub quads: &'a Quads,
    pub surface: &'a MeshSurface<'a>,
    /// See [`find_viewpoint`]; the origin if no part asks for one.
    pub viewpoint: Vec3,
    pub tree: &'a LightTree,
    pub settings: &'a ResolvedBake,
    pub tracing: Tracing<'a>,
    pub checkpoint: &'a Checkpoint,
}

/// Bakes the parts beyond the environment.
pub fn bake_bounces(
    geometry: &Geometry,
    quads: &Quads,
    tree: &LightTree,
    settings: &ResolvedBake,
    tracing: Tracing,
    checkpoint: &Checkpoint,
    clock: &mut Clock,
) -> Result<Vec<Put>, BakeError> {
    if !settings.mode.bounces() {
        return Ok(Vec::new());
    }
    // Reflectance is not baked, so that materials can change.
    let black = |_: &_| Vec3::ZERO;
    let surface = MeshSurface::new(&geometry.scene.mesh, &geometry.intersector, &geometry.sides.two_sided, &black);
    // Quads are lit wherever they are.
    let has_viewpoint = settings.mode.without(BakeParts::ENVIRONMENT.with(BakeParts::WAVELET)) != BakeParts::NONE;
    let viewpoint = match has_viewpoint {
        true => viewpoint(&surface, &geometry.scene, settings, clock.observer)?,
        false => Vec3::ZERO,
    };
    let bouncing = Bouncing { geometry, quads, surface: &surface, viewpoint, tree, settings, tracing, checkpoint };
    parts::of(settings.mode).map(|part| part.bake(&bouncing, clock)).collect()
}

/// The requested or found viewpoint, preferably at a shot's camera. Warns if light is lost around it.
fn viewpoint(
    surface: &MeshSurface,
    scene: &Scene,
    settings: &ResolvedBake,
    observer: &dyn Observer,
) -> Result<Vec3, BakeError> {
    let shots = settings.shots.iter().map(|shot| &shot.camera);
    let cameras: Vec<Camera> = shots.chain(&scene.cameras).cloned().collect();
    let viewpoint = find_viewpoint(surface, settings.indirect.viewpoint, &cameras, &scene.lights)?;
    let ViewpointSurroundings { open, closed, seen } = ViewpointSurroundings::of(surface, viewpoint);
    if open > MOST_OPEN {
        observer.event(Event::Warning { message: Warning::OpenViewpoint { viewpoint, open } });
    }
    if closed && mean_reflectance(scene, &seen) > MOST_REFLECTANCE {
        observer.event(Event::Warning { message: Warning::EndlessBounces });
    }
    Ok(viewpoint)
}

/// Largest channel of the mean albedo of the visible surfaces, without textures.
fn mean_reflectance(scene: &Scene, seen: &[Surfel]) -> f32 {
    let reflectance = |at: &Surfel| {
        let material = scene.mesh.triangle_material[at.place.triangle as usize];
        scene.materials[material as usize].plain_brdf().as_brdf().albedo()
    };
    seen.iter().map(reflectance).sum::<Vec3>().max_element() / seen.len().max(1) as f32
}
