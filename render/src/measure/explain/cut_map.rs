//! A merged cut drawn on the map of directions around a point: the light that the renderer uses from each direction, and the traced
//! light.
//!
//! All pictures are latitude-longitude maps in world space, as for environments, with +Z in the middle. Directions keep their
//! position when an environment is rotated.

use super::{PixelExplanation, leaves_below};
use crate::{
    light::{bounce::SourceLighting, environment::SceneLighting},
    measure::cut_light::CutLight,
    reference::samples::distant::trace_lights,
    renderer::Renderer,
    shade::surface::SurfacePoint,
};
use glam::Vec3;
use lapidary_core::{
    environment::texel_direction,
    image::Image,
    light_tree::NearestLeaf,
    ray::{DirectionSet, OPEN},
    sources::owners,
    surfel::GradedGrid,
};
use rayon::prelude::*;

/// Pictures of a merged cut; scene-linear, of one size.
#[derive(Clone, Debug)]
pub struct CutMap {
    /// Every cluster filled with its mean radiance times interpolated visibility, dark where the surface receives no light. Without
    /// borders.
    pub cut: Image,
    /// The light of each sample that rays find visible.
    pub traced: Image,
    /// Interpolated and traced visibility of the samples whose light is received. Gray where both agree, from hidden to visible;
    /// red where the renderer passes blocked light; blue where it blocks visible light. `None` for surface sources, because their
    /// cuts hold solid angles instead of visibility.
    pub visibility: Option<Image>,
    /// The cluster of each pixel, a heap index; 0 where no light comes from.
    pub cluster: Vec<u32>,
}

/// Linear grays of borders on bright and on dark clusters.
const BORDERS: [Vec3; 2] = [Vec3::splat(0.02), Vec3::splat(0.35)];
/// Factor of light from below the horizon, which the vertices' cuts contain and the pixel does not receive.
const NOT_RECEIVED: f32 = 0.1;
/// Distance in diagonals of the scene within which rays look for sources.
const FAR: f32 = 2.0;

impl CutMap {
    /// [`Self::cut`] with the borders between clusters, radiance scaled by `exposure`.
    pub fn with_borders(&self, exposure: f32) -> Image {
        let [width, height] = self.cut.size.map(|n| n as usize);
        let differs = |i: usize, j: usize| self.cluster[i] != self.cluster[j];
        let is_border = |i: usize| {
            let (x, y) = (i % width, i / width);
            differs(i, y * width + (x + 1) % width) || (y + 1 < height && differs(i, i + width))
        };
        let border = |shown: Vec3| if shown.max_element() > 0.15 { BORDERS[0] } else { BORDERS[1] };
        let pixel = |(i, &value): (usize, &Vec3)| {
            let shown = value * exposure;
            if is_border(i) { border(shown) } else { shown }
        };
        Image { size: self.cut.size, pixels: self.cut.pixels.iter().enumerate().map(pixel).collect() }
    }

    /// A scale that brings all but the brightest twentieth of the light in both pictures below white.
    pub fn exposure(&self) -> f32 {
        const IN_RANGE: f32 = 0.95;
        let lit = self.cut.pixels.iter().chain(&self.traced.pixels).map(|p| p.max_element()).filter(|&v| v > 0.0);
        let mut lit: Vec<f32> = lit.collect();
        lit.sort_unstable_by(f32::total_cmp);
        lit.get((IN_RANGE * lit.len() as f32) as usize).map_or(1.0, |bright| 0.8 / bright)
    }
}

impl Renderer {
    /// Draws the merged cut of an explained pixel, `width` pixels wide and half as high. `light` must be the explained light.
    ///
    /// # Panics
    /// If `light` is on the other tree.
    pub fn cut_map(&self, explanation: &PixelExplanation, light: CutLight, width: u32) -> CutMap {
        assert_eq!(explanation.tree, light.tree(), "the light must be the explained one");
        let size = [width.max(2), width.max(2) / 2];
        match light {
            CutLight::Environment(lighting) => self.environment_map(explanation, lighting, size),
            CutLight::Sources(lighting) => self.source_map(explanation, lighting, size),
        }
    }

    fn environment_map(&self, explanation: &PixelExplanation, lighting: &SceneLighting, size: [u32; 2]) -> CutMap {
        let tree = &self.dataset.tree;
        let (point, leaves) = (&*explanation.point, tree.len());
        let nearest = NearestLeaf::new(tree);
        let leaf_of = directions(size).map(|d| nearest.leaf(d)).collect::<Vec<usize>>();
        let mut traced = vec![0; leaves];
        trace_lights(self, &DirectionSet::new(tree.leaf_directions()), point, &mut traced);
        let share = |leaf: usize| f32::from(traced[leaf]) / f32::from(OPEN);
        let shown = Shown::of(explanation, leaves);
        let image = |f: &dyn Fn(usize) -> Vec3| Image { size, pixels: leaf_of.iter().map(|&leaf| f(leaf)).collect() };
        let received = |leaf: usize| point.receives(tree.leaf_directions()[leaf]);
        let agreement = |leaf| visibility_color(received(leaf).then(|| (shown.visibility[leaf], share(leaf))));
        CutMap {
            cut: image(&|leaf| shown.light[leaf] * if received(leaf) { 1.0 } else { NOT_RECEIVED }),
            traced: image(&|leaf| lighting.nodes.radiance[leaves + leaf] * share(leaf)),
            visibility: Some(image(&agreement)),
            cluster: leaf_of.iter().map(|&leaf| shown.cluster[leaf]).collect(),
        }
    }

    fn source_map(&self, explanation: &PixelExplanation, lighting: &SourceLighting, size: [u32; 2]) -> CutMap {
        let leaves = lighting.lights.len();
        let around = SourcesAround::new(self, lighting);
        let points: Vec<Vec3> = directions(size).collect();
        let source_of: Vec<Option<usize>> = points.par_iter().map(|&d| around.along(&explanation.point, d)).collect();
        let shown = Shown::of(explanation, leaves);
        let image = |f: &dyn Fn(usize) -> Vec3| Image {
            size,
            pixels: source_of.iter().map(|leaf| leaf.map_or(Vec3::ZERO, f)).collect(),
        };
        CutMap {
            cut: image(&|leaf| shown.light[leaf]),
            traced: image(&|leaf| lighting.nodes.radiance[leaves + leaf]),
            visibility: None,
            cluster: source_of.iter().map(|leaf| leaf.map_or(0, |leaf| shown.cluster[leaf])).collect(),
        }
    }
}

/// Directions of the texels of a map, row by row.
fn directions(size: [u32; 2]) -> impl Iterator<Item = Vec3> {
    (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| texel_direction(x, y, size)))
}

/// Light and cluster of every leaf under the merged cut.
struct Shown {
    /// Mean radiance times visibility.
    light: Vec<Vec3>,
    visibility: Vec<f32>,
    /// Heap index of the node.
    cluster: Vec<u32>,
}

impl Shown {
    fn of(explanation: &PixelExplanation, leaves: usize) -> Self {
        let mut shown =
            Self { light: vec![Vec3::ZERO; leaves], visibility: vec![0.0; leaves], cluster: vec![0; leaves] };
        for node in &explanation.nodes {
            let below = leaves_below(node.heap_index, leaves);
            shown.light[below.clone()].fill(node.radiance * node.visibility);
            shown.visibility[below.clone()].fill(node.visibility);
            shown.cluster[below].fill(node.heap_index);
        }
        for &node in &explanation.dark_nodes {
            shown.cluster[leaves_below(node, leaves)].fill(node);
        }
        shown
    }
}

/// Interpolated and traced visibility in one color; almost black for light that is not received.
fn visibility_color(pair: Option<(f32, f32)>) -> Vec3 {
    let Some((interpolated, traced)) = pair else { return Vec3::new(0.0, 0.004, 0.01) };
    let both = Vec3::splat(0.03 + 0.5 * interpolated.min(traced));
    let leak = (interpolated - traced).max(0.0);
    let loss = (traced - interpolated).max(0.0);
    both + Vec3::new(0.9, 0.08, 0.02) * leak + Vec3::new(0.02, 0.12, 0.9) * loss
}

/// Finds the sources near a ray's hit.
struct SourcesAround<'a> {
    renderer: &'a Renderer,
    owners: GradedGrid,
    /// Source index of each point in the grid.
    members: Vec<u32>,
    far: f32,
}

impl<'a> SourcesAround<'a> {
    fn new(renderer: &'a Renderer, lighting: &SourceLighting) -> Self {
        let (members, owners) = owners(lighting.lights.sources());
        let far = FAR * renderer.dataset.scene.mesh.bounds().diagonal();
        Self { renderer, owners, members, far }
    }

    fn along(&self, point: &SurfacePoint, direction: Vec3) -> Option<usize> {
        let met = self.renderer.intersector().surfel_before(point.ray_origin, direction, self.far)?;
        Some(self.members[self.owners.nearest(&met)?] as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_tell_leaks_from_losses() {
        let color = |interpolated, traced| visibility_color(Some((interpolated, traced)));
        let [agree, leak, loss] = [color(1.0, 1.0), color(1.0, 0.0), color(0.0, 1.0)];
        assert!(agree.x == agree.y && agree.y == agree.z);
        assert!(leak.x > 4.0 * leak.z && loss.z > 4.0 * loss.x);
        assert!(color(0.0, 0.0).max_element() < 0.1 && visibility_color(None) != color(0.0, 0.0));
    }
}
