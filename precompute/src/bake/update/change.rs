//! What an edit changed of a scene.

use glam::Vec3;
use lapidary_core::{bounds::Bounds, mesh::Mesh, opacity::Opacities, scene::Scene};

/// Margin of the boxes, as a share of the scene's diagonal: rays start off surfaces.
const MARGIN: f32 = 1e-4;

/// What changed between two scenes with the same triangles.
pub struct Change {
    /// Boxes of what changed, before and after, by object and material: what rays may meet.
    boxes: Vec<Bounds>,
    /// The same by object: what points may be inside of.
    around: Vec<Bounds>,
    /// Triangles with another opacity.
    other_opacity: Vec<usize>,
}

impl Change {
    /// Compares two scenes.
    pub fn between(before: &Scene, now: &Scene) -> Self {
        let [opacity_before, opacity_now] = [before, now].map(Opacities::of_scene);
        let is_same_light = opacity_before.agree(&opacity_now, &now.mesh);
        let lets_through_otherwise =
            |triangle: &usize| !is_same_light && !opacity_before.agree_at(&opacity_now, &now.mesh, *triangle as u32);
        let has_moved = |vertex: &u32| {
            let v = *vertex as usize;
            (before.mesh.positions[v], before.mesh.normals[v]) != (now.mesh.positions[v], now.mesh.normals[v])
        };
        let all = || 0..now.mesh.triangles.len();
        let other_opacity: Vec<usize> = all().filter(lets_through_otherwise).collect();
        let moved = all().filter(|&triangle| now.mesh.triangles[triangle].iter().any(has_moved));
        let changed: Vec<usize> = moved.chain(other_opacity.iter().copied()).collect();
        let margin = MARGIN * now.mesh.bounds().diagonal();
        let object = |triangle: usize| now.mesh.triangle_object[triangle];
        let part = |triangle: usize| (object(triangle), now.mesh.triangle_material[triangle]);
        let meshes = [&before.mesh, &now.mesh];
        let grown = |boxes: Vec<Bounds>| boxes.into_iter().map(|bounds| bounds.grown(margin)).collect::<Vec<_>>();
        let of_parts = |mesh: &Mesh| grown(mesh.bounds_by(changed.iter().copied(), part));
        let of_objects = |mesh: &Mesh| grown(mesh.bounds_by(changed.iter().copied(), object));
        let (boxes, around) = (meshes.map(of_parts).concat(), meshes.map(of_objects).concat());
        Self { boxes, around, other_opacity }
    }

    /// Whether nothing changed that light meets.
    pub fn is_nothing(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Boxes around what changed.
    pub fn boxes(&self) -> &[Bounds] {
        &self.boxes
    }

    /// Whether a point is or was within the box of an object that changed.
    pub fn is_around(&self, at: Vec3) -> bool {
        self.around.iter().any(|b| b.contains(at))
    }

    /// Triangles that let other light through.
    pub fn other_opacity(&self) -> &[usize] {
        &self.other_opacity
    }

    /// Only the first or the second half of the boxes: what was before, or what is now.
    #[cfg(test)]
    pub fn half(mut self, second: bool) -> Self {
        let half = self.boxes.len() / 2;
        self.boxes = if second { self.boxes.split_off(half) } else { self.boxes[..half].to_vec() };
        self
    }
}
