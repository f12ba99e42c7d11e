//! The parts of a bake that bounce light, from one viewpoint.

use super::{geometry::Geometry, meshless::bake_meshless, sources::SourcePhases};
use crate::{
    bake::{checkpoint::Checkpoint, clock::Clock, settings::ResolvedBake},
    errors::BakeError,
    mesh_surface::MeshSurface,
    observer::{Event, Observer},
    sources::viewpoint::{ViewpointSurroundings, find_viewpoint},
    vertices::tracing::Tracing,
    warning::Warning,
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    dataset::{IndirectReport, MeshlessReport},
    light_tree::LightTree,
    meshless::MeshlessBake,
    scene::Scene,
    sources::IndirectBake,
    surfel::Surfel,
};

/// Largest share of directions that may miss the scene around a viewpoint without a warning: in a court without a roof
/// a third miss.
const MOST_OPEN: f32 = 0.4;

/// Mean reflectance of a closed space above which a warning says that bounces hardly lose light. At 0.95 the fourteenth
/// bounce carries half of the first.
const MOST_REFLECTANCE: f32 = 0.95;

/// The parts that bounce light.
#[derive(Default)]
pub struct Bounces {
    pub indirect: Option<IndirectBake>,
    pub report: Option<IndirectReport>,
    pub meshless: Option<MeshlessBake>,
    pub meshless_report: Option<MeshlessReport>,
}

/// Bakes the parts beyond the environment.
pub fn bake_bounces(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &ResolvedBake,
    tracing: Tracing,
    checkpoint: &Checkpoint,
    clock: &mut Clock,
) -> Result<Bounces, BakeError> {
    let mut bounces = Bounces::default();
    if !settings.mode.bounces() {
        return Ok(bounces);
    }
    // Reflectance stays out of everything baked, so that materials remain free to change.
    let black = |_: &_| Vec3::ZERO;
    let surface = MeshSurface::new(&geometry.scene.mesh, &geometry.intersector, &geometry.sides.two_sided, &black);
    let viewpoint = viewpoint(&surface, &geometry.scene, settings, clock.observer)?;
    if settings.mode.sources() {
        let phases = SourcePhases { geometry, surface: &surface, viewpoint, tree, settings, tracing, checkpoint };
        let (indirect, report) = phases.bake_indirect(clock)?;
        (bounces.indirect, bounces.report) = (Some(indirect), Some(report));
    }
    if settings.mode.meshless() {
        let (meshless, report) = bake_meshless(&surface, viewpoint, &settings.meshless, checkpoint, clock)?;
        (bounces.meshless, bounces.meshless_report) = (Some(meshless), Some(report));
    }
    Ok(bounces)
}

/// The viewpoint that was asked for, or the one found, preferably at a shot's camera. Warns if light is lost around it.
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

/// Largest channel of the mean albedo of the surfaces seen, without textures.
fn mean_reflectance(scene: &Scene, seen: &[Surfel]) -> f32 {
    let reflectance = |at: &Surfel| {
        let material = scene.mesh.triangle_material[at.place.triangle as usize];
        scene.materials[material as usize].plain_brdf().as_brdf().albedo()
    };
    seen.iter().map(reflectance).sum::<Vec3>().max_element() / seen.len().max(1) as f32
}
