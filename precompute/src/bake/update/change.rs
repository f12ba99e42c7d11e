//! What an edit changed of a scene.

use glam::Vec3;
use lapidary_core::{bounds::Bounds, mesh::Mesh, opacity::Opacities, scene::Scene};

/// Margin of the boxes, as a share of the scene's diagonal: rays start off surfaces.
const MARGIN: f32 = 1e-4;

/// The boxes of what changed, before and after, and the vertices that moved.
pub struct Change {
    boxes: Vec<Bounds>,
    has_moved: Vec<bool>,
}

impl Change {
    /// Compares two scenes with the same triangles.
    pub fn between(before: &Scene, now: &Scene) -> Self {
        let has_moved: Vec<bool> = (0..now.mesh.positions.len())
            .map(|v| (before.mesh.positions[v], before.mesh.normals[v]) != (now.mesh.positions[v], now.mesh.normals[v]))
            .collect();
        let [opacity_before, opacity_now] = [before, now].map(Opacities::of_scene);
        let is_same_light = opacity_before.agree(&opacity_now, &now.mesh);
        let is_changed = |triangle: usize| {
            now.mesh.triangles[triangle].iter().any(|&v| has_moved[v as usize])
                || !is_same_light && !opacity_before.agree_at(&opacity_now, &now.mesh, triangle as u32)
        };
        let changed: Vec<usize> = (0..now.mesh.triangles.len()).filter(|&triangle| is_changed(triangle)).collect();
        let margin = MARGIN * now.mesh.bounds().diagonal();
        let part = |triangle: usize| (now.mesh.triangle_object[triangle], now.mesh.triangle_material[triangle]);
        let boxes = |mesh: &Mesh| {
            let of_parts = mesh.bounds_by(changed.iter().copied(), part).into_iter();
            of_parts.map(move |bounds| bounds.grown(margin))
        };
        let boxes = boxes(&before.mesh).chain(boxes(&now.mesh)).collect();
        Self { boxes, has_moved }
    }

    /// Whether nothing changed that light meets.
    pub fn is_nothing(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Whether a vertex moved or turned.
    pub fn has_moved(&self, vertex: u32) -> bool {
        self.has_moved[vertex as usize]
    }

    /// Boxes around what changed.
    pub fn boxes(&self) -> &[Bounds] {
        &self.boxes
    }

    /// Whether something that changed was or is around a point.
    pub fn reaches(&self, at: Vec3) -> bool {
        self.boxes.iter().any(|b| b.contains(at))
    }

    /// Only the first or the second half of the boxes: what was before, or what is now.
    #[cfg(test)]
    pub fn half(&self, second: bool) -> Self {
        let half = self.boxes.len() / 2;
        let boxes = if second { self.boxes[half..].to_vec() } else { self.boxes[..half].to_vec() };
        Self { boxes, has_moved: self.has_moved.clone() }
    }
}
