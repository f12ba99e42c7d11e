//! Light samples and illumination cut over a picture of the environment.
//!
//! Samples are fixed in the world, like the tree; the map turns under them.

use super::thumbnail::{adapted, display_color};
use egui::{Color32, Context, Mesh, Painter, Pos2, Rect, Shape, Stroke, Vec2, ecolor::Hsva, vec2};
use glam::Vec3;
use lapidary_core::{
    color::luminance,
    cut::packed,
    environment::uv_from_direction,
    light_tree::LightTree,
    sphere::{GOLDEN_TURN, SPHERE},
};
use lapidary_render::{EnvironmentLight, SceneLighting};
use lapidary_studies::jobs::spawn;
use std::{f32::consts::TAU, ops::Range, sync::Arc};

/// Half the side of a sample's dot in points.
const SAMPLE: f32 = 0.75;
/// Smallest and largest dot of a cut's node in points.
const DOTS: [f32; 2] = [1.5, 24.0];
/// How near the pointer must come to a small dot, in points.
const REACH: f32 = 5.0;

/// The overlays of the picture, with cached drawing.
pub struct Overlay {
    /// Shows the light samples.
    pub samples: bool,
    /// Depth of the subtrees by which samples are colored.
    pub subtree_depth: u32,
    /// Shows the nodes of the illumination cut.
    pub cut: bool,
    sample_mesh: Option<(SampleKey, Arc<Mesh>)>,
    marks: Option<(u64, Vec<Mark>)>,
    /// The revision whose light a thread computes.
    awaited: Option<u64>,
}

impl Default for Overlay {
    fn default() -> Self {
        Self { samples: false, subtree_depth: 3, cut: false, sample_mesh: None, marks: None, awaited: None }
    }
}

/// Inputs of the drawn samples.
type SampleKey = (u64, usize, u32, Rect);

/// One node of the illumination cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Depth below the root.
    pub depth: u32,
    /// Its leaves.
    pub leaves: Range<usize>,
    /// Mean radiance of the leaves.
    pub radiance: Vec3,
    /// Solid angle of the leaves together, in steradians.
    pub solid_angle: f32,
    /// Position of its direction in the picture, 0 to 1.
    place: Vec2,
    color: Color32,
}

impl Mark {
    fn center(&self, picture: Rect) -> Pos2 {
        picture.min + self.place * picture.size()
    }

    /// Radius of the dot: of a cap of the node's solid angle at the horizon.
    fn dot(&self, picture: Rect) -> f32 {
        let cap = (1.0 - self.solid_angle / (0.5 * SPHERE)).clamp(-1.0, 1.0).acos();
        (cap * picture.width() / TAU).clamp(DOTS[0], DOTS[1])
    }
}

impl Overlay {
    /// Draws the samples of `tree`.
    pub fn draw_samples(&mut self, painter: &Painter, picture: Rect, tree: &LightTree, revision: u64) {
        let key = (revision, tree.len(), self.subtree_depth, picture);
        let known = self.sample_mesh.take().filter(|(k, _)| *k == key);
        let build = || (key, Arc::new(sample_mesh(tree, self.subtree_depth, picture)));
        let (_, mesh) = self.sample_mesh.insert(known.unwrap_or_else(build));
        painter.add(Shape::Mesh(mesh.clone()));
    }

    /// Draws the nodes of the illumination cut; returns the one under the pointer. While a thread computes the light, those of before stay.
    pub fn draw_cut(
        &mut self,
        painter: &Painter,
        picture: Rect,
        lighting: &Arc<EnvironmentLight>,
        revision: u64,
        pointer: Option<Pos2>,
    ) -> Option<Mark> {
        self.take_marks(painter.ctx(), lighting, revision);
        let (_, marks) = self.marks.as_ref()?;
        let outline = Stroke::new(1.0, Color32::from_black_alpha(160));
        for mark in marks {
            painter.circle(mark.center(picture), mark.dot(picture), mark.color.gamma_multiply(0.8), outline);
        }
        let hovered = pointer.and_then(|p| mark_at(marks, picture, p))?;
        let stroke = Stroke::new(2.0, Color32::WHITE);
        painter.circle_stroke(hovered.center(picture), hovered.dot(picture) + 1.0, stroke);
        Some(hovered.clone())
    }

    fn take_marks(&mut self, ctx: &Context, lighting: &Arc<EnvironmentLight>, revision: u64) {
        if self.marks.as_ref().is_some_and(|(known, _)| *known == revision) {
            return;
        }
        if let Some(computed) = lighting.computed() {
            self.marks = Some((revision, cut_marks(computed)));
        } else if self.awaited != Some(revision) {
            self.awaited = Some(revision);
            let (ctx, lighting) = (ctx.clone(), lighting.clone());
            spawn("light of the map", move || {
                lighting.compute();
                ctx.request_repaint();
            });
        }
    }
}

/// Draws the leaves of one node.
pub fn draw_leaves(painter: &Painter, picture: Rect, tree: &LightTree, leaves: Range<usize>) {
    let mut mesh = Mesh::default();
    for &direction in tree.leaf_directions().get(leaves).unwrap_or_default() {
        mesh.add_colored_rect(dot_rect(picture, direction), Color32::WHITE);
    }
    painter.add(Shape::mesh(mesh));
}

fn dot_rect(picture: Rect, direction: Vec3) -> Rect {
    Rect::from_center_size(picture.min + place(direction) * picture.size(), Vec2::splat(2.0 * SAMPLE))
}

/// Position of a world direction in the picture, 0 to 1.
fn place(direction: Vec3) -> Vec2 {
    let uv = uv_from_direction(direction);
    vec2(uv.x, uv.y)
}

fn sample_mesh(tree: &LightTree, subtree_depth: u32, picture: Rect) -> Mesh {
    let below = tree.height().saturating_sub(subtree_depth);
    let mut mesh = Mesh::default();
    mesh.reserve_vertices(4 * tree.len());
    mesh.reserve_triangles(2 * tree.len());
    for (leaf, &direction) in tree.leaf_directions().iter().enumerate() {
        mesh.add_colored_rect(dot_rect(picture, direction), subtree_color(leaf >> below));
    }
    mesh
}

/// Hues a golden angle apart: neighboring subtrees differ.
fn subtree_color(subtree: usize) -> Color32 {
    Hsva::new((subtree as f32 * GOLDEN_TURN).fract(), 0.65, 1.0, 1.0).into()
}

/// The nodes of an illumination cut, left to right.
fn cut_marks(lighting: &SceneLighting) -> Vec<Mark> {
    let count = lighting.leaves();
    let height = count.ilog2();
    let mut first = 0;
    let mut nodes = Vec::with_capacity(lighting.cut.len());
    for depth in lighting.cut.iter().map(|&n| packed::depth(n)) {
        if first >= count || depth > height {
            break;
        }
        let leaves = first..first + (count >> depth);
        first = leaves.end;
        nodes.push((depth, (count + leaves.start) >> (height - depth), leaves));
    }
    let weighted = nodes.iter().map(|(_, n, leaves)| (luminance(lighting.nodes.radiance[*n]), leaves.len() as f32));
    let post = adapted(weighted);
    let mark = |(depth, node, leaves): (u32, usize, Range<usize>)| {
        let radiance: Vec3 = lighting.nodes.radiance[node];
        let solid_angle = leaves.len() as f32 * lighting.lights.leaf_solid_angle;
        let place = place(lighting.nodes.place[node]);
        Mark { depth, leaves, radiance, solid_angle, place, color: display_color(&post, radiance) }
    };
    nodes.into_iter().map(mark).collect()
}

/// The node whose dot the pointer is on, the nearest of several.
fn mark_at(marks: &[Mark], picture: Rect, pointer: Pos2) -> Option<&Mark> {
    let distance = |mark: &Mark| mark.center(picture).distance(pointer);
    let touched = marks.iter().filter(|m| distance(m) <= m.dot(picture).max(REACH));
    touched.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    const PICTURE: Rect = Rect { min: pos2(10.0, 20.0), max: pos2(310.0, 170.0) };

    fn lit(budget: u32) -> (LightTree, SceneLighting) {
        let tree = LightTree::geometric(1024).unwrap();
        // One bright leaf makes the nodes around it small.
        let bright = |i: usize| Vec3::splat(if i == 300 { 500.0 } else { 0.2 });
        let leaves: Vec<Vec3> = (0..1024).map(bright).collect();
        let lighting = SceneLighting::new(&tree, &leaves, budget);
        (tree, lighting)
    }

    #[test]
    fn marks_partition_the_leaves_and_the_sphere() {
        for budget in [1, 7, 128, 1024] {
            let marks = cut_marks(&lit(budget).1);
            assert!(!marks.is_empty() && marks.len() <= budget as usize);
            assert!(marks.windows(2).all(|m| m[0].leaves.end == m[1].leaves.start));
            assert_eq!((marks[0].leaves.start, marks.last().unwrap().leaves.end), (0, 1024));
            let sphere: f32 = marks.iter().map(|m| m.solid_angle).sum();
            assert!((sphere - SPHERE).abs() < 1e-3, "{sphere}");
        }
    }

    #[test]
    fn the_bright_leaf_has_a_small_bright_dot_where_it_lies() {
        let (tree, lighting) = lit(64);
        let marks = cut_marks(&lighting);
        let lamp = marks.iter().find(|m| m.leaves.contains(&300)).unwrap();
        assert_eq!(lamp.leaves, 300..301);
        assert!(marks.iter().all(|m| m == lamp || m.color.r() < lamp.color.r()));
        let expected = PICTURE.min + place(tree.leaf_directions()[300]) * PICTURE.size();
        assert!(lamp.center(PICTURE).distance(expected) < 0.1);
        assert_eq!(mark_at(&marks, PICTURE, expected), Some(lamp));
        assert_eq!(mark_at(&marks, PICTURE, pos2(2000.0, 0.0)), None, "negative control");
    }

    #[test]
    fn samples_have_as_many_colours_as_subtrees() {
        let (tree, _) = lit(1);
        for depth in [0, 2, 4] {
            let mesh = sample_mesh(&tree, depth, PICTURE);
            let colors: std::collections::HashSet<Color32> = mesh.vertices.iter().map(|v| v.color).collect();
            assert_eq!((mesh.vertices.len(), colors.len()), (4096, 1 << depth));
        }
    }
}
