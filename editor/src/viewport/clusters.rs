//! The clusters of bounced light over the picture: a dot for each visible surface source, in the color of its node in the
//! illumination cut.

use super::gizmo::Projection;
use egui::{Color32, Mesh, Rect, Shape, Ui, ecolor::Hsva, vec2};
use lapidary_core::{camera::Camera, cut::packed, ray::Intersector, sphere::GOLDEN_TURN};
use lapidary_render::SourceLighting;
use std::sync::Arc;

/// Most dots: each takes a ray when something has moved.
const MOST_DOTS: usize = 8192;
/// Side of a dot in points.
const DOT: f32 = 3.0;
/// A surface this much nearer than a source, as a share of its distance, hides it.
const IN_FRONT: f32 = 2e-3;

/// The dots drawn last, and their inputs.
#[derive(Default)]
pub struct Clusters {
    drawn: Option<(Arc<SourceLighting>, Camera, Rect, Arc<Mesh>)>,
}

impl Clusters {
    /// Draws the dots; rays are cast only when the camera, the viewport or the light has changed.
    pub fn paint(
        &mut self,
        ui: &Ui,
        rect: Rect,
        camera: &Camera,
        intersector: &Intersector,
        lighting: &Arc<SourceLighting>,
    ) {
        let is_same = |(l, c, r, _): &(Arc<SourceLighting>, Camera, Rect, Arc<Mesh>)| {
            Arc::ptr_eq(l, lighting) && c == camera && *r == rect
        };
        let known = self.drawn.take().filter(is_same);
        let draw = || {
            let mesh = dots(&Projection::new(camera, rect), rect, intersector, lighting);
            (lighting.clone(), camera.clone(), rect, Arc::new(mesh))
        };
        let (.., mesh) = self.drawn.insert(known.unwrap_or_else(draw));
        ui.painter_at(rect).add(Shape::Mesh(mesh.clone()));
    }
}

fn dots(projection: &Projection, rect: Rect, intersector: &Intersector, lighting: &SourceLighting) -> Mesh {
    let (sources, nodes) = (lighting.lights.sources(), node_of_each(lighting));
    let eye = projection.eye();
    let mut mesh = Mesh::default();
    for (source, node) in sources.iter().zip(nodes).step_by(sources.len().div_ceil(MOST_DOTS)) {
        let surfel = source.surfel;
        let to_eye = eye - surfel.position;
        let distance = to_eye.length();
        let Some(at) = projection.point(surfel.position).filter(|at| rect.contains(*at)) else { continue };
        if to_eye.dot(surfel.normal) <= 0.0 {
            continue;
        }
        let hit = intersector.closest_hit(eye, -to_eye / distance);
        if hit.is_none_or(|hit| hit.distance >= distance * (1.0 - IN_FRONT)) {
            mesh.add_colored_rect(Rect::from_center_size(at, vec2(DOT, DOT)), node_color(node));
        }
    }
    mesh
}

/// The index of each source's node in the illumination cut.
fn node_of_each(lighting: &SourceLighting) -> impl Iterator<Item = usize> + '_ {
    let leaves = lighting.lights.len();
    let of_node = move |(number, node): (usize, &u16)| std::iter::repeat_n(number, leaves >> packed::depth(*node));
    lighting.cut.iter().enumerate().flat_map(of_node)
}

fn node_color(number: usize) -> Color32 {
    let hue = (number as f32 * GOLDEN_TURN).fract();
    let value = if number.is_multiple_of(2) { 1.0 } else { 0.75 };
    Hsva::new(hue, 0.75, value, 1.0).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::row_of_sources;
    use egui::{Pos2, pos2};
    use glam::Vec3;
    use lapidary_core::scene::Mesh as SceneMesh;

    fn triangle(z: f32) -> Intersector {
        let positions = [[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]].map(Vec3::from_array).to_vec();
        Intersector::new(&SceneMesh { positions, triangles: vec![[0, 1, 2]], ..SceneMesh::default() })
    }

    fn drawn(eye: Vec3, wall: f32, illum_cut: u32) -> Vec<(Pos2, Color32)> {
        let rect = Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0));
        let projection = Projection::new(&Camera::look_at(eye, Vec3::ZERO, 40.0), rect);
        let mesh = dots(&projection, rect, &triangle(wall), &row_of_sources(illum_cut));
        mesh.vertices.chunks(4).map(|dot| (dot[0].pos, dot[0].color)).collect()
    }

    #[test]
    fn sources_of_one_node_have_one_colour_and_others_another() {
        let eye = Vec3::new(0.0, 0.0, 8.0);
        let colors = |illum_cut| drawn(eye, 0.0, illum_cut).into_iter().map(|(_, color)| color).collect::<Vec<_>>();
        let [root, all] = [1, 4].map(colors);
        assert_eq!(root, [node_color(0); 4]);
        assert_eq!(all, [0, 1, 2, 3].map(node_color));
        let three = colors(3);
        assert_eq!(three, [0, 1, 2, 2].map(node_color), "the brighter half is resolved");
        assert_ne!(three[0], three[1]);
        assert!(drawn(eye, 0.0, 1).windows(2).all(|dots| dots[0].0.x < dots[1].0.x && dots[0].0.y == dots[1].0.y));
        assert!(drawn(eye, 0.0, 1).iter().all(|(at, _)| (at.distance(pos2(100.0, 50.0))) < 100.0));
    }

    #[test]
    fn what_is_hidden_or_faces_away_is_not_drawn() {
        assert_eq!(drawn(Vec3::new(0.0, 0.0, 8.0), 1.0, 4), [], "behind a wall");
        assert_eq!(drawn(Vec3::new(0.0, 0.0, 8.0), -1.0, 4).len(), 4, "negative control: the wall is behind them");
        assert_eq!(drawn(Vec3::new(0.0, 0.0, -8.0), 1.0, 4), [], "seen from behind");
    }
}
