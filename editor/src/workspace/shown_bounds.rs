//! Bounds of the shown scene, kept between frames.

use crate::bounds::object_bounds;
use lapidary_core::{
    bounds::Bounds,
    parts::{Part, parts_of},
    scene::Mesh,
};
use lapidary_render::Baked;
use std::sync::Arc;

/// Bounds and parts of the mesh, computed when it changes: a pass over the mesh takes longer than a frame should.
#[derive(Default)]
pub struct ShownBounds {
    /// Address of the dataset, and the selected objects.
    of: Option<(usize, Vec<u32>)>,
    /// Bounds of the whole scene.
    pub scene: Option<Bounds>,
    /// Bounds of each selected object.
    pub selection: Vec<Bounds>,
    /// All parts.
    pub parts: Vec<Part>,
}

impl ShownBounds {
    /// Follows the shown scene and the selection.
    pub fn update(&mut self, shown: Option<&Baked>, selected: impl Iterator<Item = u32>) {
        let of = shown.map(|baked| (Arc::as_ptr(&baked.dataset) as usize, selected.collect::<Vec<_>>()));
        if of != self.of {
            let mesh = shown.map(|baked| &baked.dataset.scene.mesh);
            let dataset = |of: &Option<(usize, _)>| of.as_ref().map(|(dataset, _)| *dataset);
            if dataset(&of) != dataset(&self.of) {
                self.parts = mesh.map(parts_of).unwrap_or_default();
            }
            let selected = of.iter().flat_map(|(_, objects)| objects);
            let bounds_in = |mesh| selected.filter_map(|&object| object_bounds(mesh, object)).collect();
            self.selection = mesh.map(bounds_in).unwrap_or_default();
            self.scene = mesh.map(Mesh::bounds);
            self.of = of;
        }
    }
}
