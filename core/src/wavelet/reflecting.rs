//! Patches with their reflectance, by cells of incident directions (wavelet paper, 4.3.2 and 5.3).

use super::{
    patch::{NotAQuad, Patch, patches},
    square::Node,
};
use crate::{
    brdf::SurfaceBrdf,
    material::{Material, ResolvedMaterial},
    scene::Scene,
    simd::Vec3x8,
    sphere::concentric::HemisphereCells,
};
use glam::{Vec2, Vec3, Vec4};
use wide::f32x8;

/// A patch with its reflectance.
#[derive(Clone, Debug)]
pub struct ReflectingPatch {
    /// The quad.
    pub patch: Patch,
    /// Cells of incident directions that resolve its BRDF. A diffuse surface has one.
    pub cells: HemisphereCells,
    pub(super) brdf: SurfaceBrdf,
}

/// Largest relative error of a BRDF that is taken as constant in cells of directions, as root mean square. So 8 x 8 cells hold lobes from
/// a GGX alpha of 0.2 on (0.42). With 0.25, alpha 0.3 had 16 x 16, and one bounce of a glossy room took minutes.
const CELL_ERROR: f32 = 0.45;
/// Cosines of the directions toward the eye at which a BRDF is examined.
const EXAMINED: [f32; 3] = [0.95, 0.7, 0.45];
/// Smallest cosine of an incident direction, against a division by zero at the horizon.
const LEAST_COSINE: f32 = 1e-4;

impl ReflectingPatch {
    /// Most cells along an edge of the square of directions.
    pub const MOST_CELLS_ALONG: usize = 16;

    /// A patch with a BRDF in its frame.
    pub fn new(patch: Patch, brdf: SurfaceBrdf) -> Self {
        let cells = resolving(&brdf);
        Self { patch, cells, brdf }
    }

    /// The patches of a scene with the materials of their first triangles. Maps are not read.
    ///
    /// # Errors
    /// A triangle that is no half of a quad.
    pub fn of_scene(scene: &Scene) -> Result<Vec<Self>, NotAQuad> {
        Ok(Self::all(patches(&scene.mesh)?, &scene.materials))
    }

    /// Patches with their materials.
    pub fn all(patches: Vec<Patch>, materials: &[Material]) -> Vec<Self> {
        let brdf = |material: &ResolvedMaterial| material.at(Vec3::ONE, |_| Vec4::ONE).brdf;
        let brdfs: Vec<SurfaceBrdf> = ResolvedMaterial::all(materials).iter().map(brdf).collect();
        patches.into_iter().map(|patch| Self::new(patch, brdfs[patch.material as usize].clone())).collect()
    }

    /// Mean BRDF over each cell of incident directions, toward a direction in the world. `place` tells where in each cell it is
    /// sampled.
    pub fn reflected(&self, toward: Vec3, place: Vec2) -> Vec<Vec3> {
        by_cells(&self.brdf, self.cells, self.patch.frame.transpose() * toward, place)
    }

    /// Reflected radiance toward a direction in the world, for the mean radiance that arrives in each cell (5.3).
    ///
    /// # Panics
    /// If there is not one radiance for each cell.
    pub fn outgoing(&self, arriving: &[Vec3], toward: Vec3) -> Vec3 {
        assert_eq!(arriving.len(), self.cells.len(), "one radiance for each cell");
        let reflected = self.reflected(toward, Vec2::splat(0.5));
        arriving.iter().zip(reflected).map(|(radiance, reflected)| *radiance * reflected).sum::<Vec3>()
            * self.cells.weight()
    }

    /// Halvings of the square of directions.
    pub fn angle_level(&self) -> u32 {
        self.cells.side.ilog2()
    }

    /// The nodes of its cells of directions.
    pub fn angles(&self) -> impl Iterator<Item = Node> {
        Node::all(self.angle_level())
    }
}

fn by_cells(brdf: &SurfaceBrdf, cells: HemisphereCells, wo: Vec3, place: Vec2) -> Vec<Vec3> {
    let mut means = Vec::with_capacity(cells.len());
    for first in (0..cells.len()).step_by(8) {
        let directions: [Vec3; 8] =
            std::array::from_fn(|lane| cells.direction_within((first + lane).min(cells.len() - 1), place));
        let reflected = brdf.as_brdf().brdf_cos_x8(Vec3x8::from_array(directions), wo, f32x8::ZERO);
        let lanes = directions.iter().enumerate().take(cells.len() - first);
        means.extend(lanes.map(|(lane, wi)| reflected.lane(lane) / wi.z.max(LEAST_COSINE)));
    }
    means
}

/// The fewest cells with at most [`CELL_ERROR`].
fn resolving(brdf: &SurfaceBrdf) -> HemisphereCells {
    let finest = HemisphereCells { side: ReflectingPatch::MOST_CELLS_ALONG };
    let values = EXAMINED.map(|cosine| {
        let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        by_cells(brdf, finest, wo, Vec2::splat(0.5))
    });
    let is_resolved = |side: usize| values.iter().all(|values| error_in_cells(values, side) <= CELL_ERROR);
    let side = (0..ReflectingPatch::MOST_CELLS_ALONG.ilog2())
        .map(|level| 1 << level)
        .find(|&side| is_resolved(side))
        .unwrap_or(ReflectingPatch::MOST_CELLS_ALONG);
    HemisphereCells { side }
}

/// Relative root mean square error of values on the finest grid, if each is replaced by the mean over its cell of a grid of `side`.
fn error_in_cells(values: &[Vec3], side: usize) -> f32 {
    let size = ReflectingPatch::MOST_CELLS_ALONG / side;
    let cell =
        |i: usize| (i / ReflectingPatch::MOST_CELLS_ALONG / size) * side + i % ReflectingPatch::MOST_CELLS_ALONG / size;
    let mut means = vec![Vec3::ZERO; side * side];
    values.iter().enumerate().for_each(|(i, value)| means[cell(i)] += *value / (size * size) as f32);
    let squared = |value: Vec3| value.length_squared();
    let errors: f32 = values.iter().enumerate().map(|(i, value)| squared(*value - means[cell(i)])).sum();
    (errors / values.iter().copied().map(squared).sum::<f32>().max(f32::MIN_POSITIVE)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        brdf::BrdfModel,
        material::Material,
        test_scenes::{floor, scene_of},
    };

    fn patch(model: BrdfModel, parameters: &[(&'static str, f32)], color: f32) -> ReflectingPatch {
        let mut material = Material { model, ..Material::default() };
        material.parameters.set("base_color", Vec3::splat(color));
        parameters.iter().for_each(|&(name, value)| material.parameters.set(name, value));
        let mut scene = scene_of(&floor(1.0, 0.0));
        scene.materials = vec![material];
        ReflectingPatch::of_scene(&scene).unwrap().remove(0)
    }

    #[test]
    fn cells_are_as_many_as_the_brdf_needs() {
        let side = |model, parameters: &[_]| patch(model, parameters, 0.7).cells.side;
        assert_eq!(side(BrdfModel::Lambert, &[]), 1);
        assert_eq!(side(BrdfModel::Ggx, &[("roughness", 1.0), ("metalness", 0.0)]), 1, "rough paint");
        assert_eq!(side(BrdfModel::Ggx, &[("roughness", 0.15), ("metalness", 1.0)]), ReflectingPatch::MOST_CELLS_ALONG);
        let between = side(BrdfModel::Ggx, &[("roughness", 0.55), ("metalness", 1.0)]);
        assert_eq!(between, 8, "alpha 0.3");
    }

    #[test]
    fn light_from_everywhere_is_reflected_by_the_albedo() {
        let gray = patch(BrdfModel::Lambert, &[], 0.5);
        let toward = gray.patch.direction(Vec2::new(0.3, 0.6));
        assert!((gray.outgoing(&[Vec3::ONE], toward).x - 0.5).abs() < 1e-5);
        let metal = patch(BrdfModel::Ggx, &[("roughness", 0.6), ("metalness", 1.0)], 0.9);
        let all = vec![Vec3::ONE; metal.cells.len()];
        let straight = metal.patch.normal();
        let expected = metal.brdf.as_brdf().albedo().x;
        let found = metal.outgoing(&all, straight).x;
        assert!((found / expected - 1.0).abs() < 0.05, "{found} for {expected}");
        let mut half = all.clone();
        half[..all.len() / 2].fill(Vec3::ZERO);
        assert!(metal.outgoing(&half, straight).x < 0.7 * found, "negative control: half of the light");
    }
}
