//! The tessellated scene that a bake works on.

use crate::{
    bake::settings::with_room,
    errors::BakeError,
    observer::{Event, Observer},
    vertices::{
        points::BakePoints,
        sidedness::{Sidedness, classify},
        tessellate::{Stored, Wanted, tessellate},
    },
    warning::Warning,
};
use lapidary_core::{dataset::BakeParts, ray::Intersector, scene::Scene, shot::Shot};

/// The tessellated scene with its bake points.
pub struct Geometry {
    pub scene: Scene,
    pub source_vertices: usize,
    pub sides: Sidedness,
    pub intersector: Intersector,
    pub points: BakePoints,
    pub buried: Vec<bool>,
}

impl Geometry {
    pub fn new(
        mut scene: Scene,
        mode: BakeParts,
        budget: Option<usize>,
        shots: &[Shot],
        observer: &dyn Observer,
    ) -> Result<Self, BakeError> {
        let source_vertices = scene.mesh.positions.len();
        let mut sides = classify(&scene);
        let source = Intersector::new(&scene.mesh);
        let intersector = match budget {
            Some(budget) => {
                remark_on_budget(source_vertices, budget, observer);
                let stored = Stored { environment: mode.environment(), bounces: mode.sources() || mode.meshless() };
                let wanted = Wanted { stored, budget, shots };
                tessellate(&mut scene.mesh, &mut sides, &source, wanted, observer)?;
                Intersector::new(&scene.mesh)
            }
            None => source,
        };
        let points = BakePoints::new(&scene.mesh, &sides);
        let buried = points.buried(&intersector, &sides, observer)?;
        Ok(Self { scene, source_vertices, sides, intersector, points, buried })
    }
}

/// Warns of a mesh that already has as many vertices as its budget allows.
fn remark_on_budget(vertices: usize, budget: usize, observer: &dyn Observer) {
    if budget <= vertices {
        let message = Warning::NoRoomForVertices { vertices, enough: with_room(0, vertices) };
        observer.event(Event::Warning { message });
    }
}
