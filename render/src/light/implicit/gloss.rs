//! What glossy leaves reflect toward the eye: their BRDFs over their bins (implicit visibility, Eq. 2 to 5).

use crate::{
    appearance::{Appearance, ResolvedAppearance},
    light::bounce::LitPoints,
};
use glam::{Vec3, Vec3A};
use lapidary_core::{
    brdf::SurfaceBrdf,
    implicit::{BinLayout, EMPTY, Views, disc_forest::DiscForest},
    scene::Mesh,
    simd::Vec3x8,
    sphere::SPHERE,
    surfel::Surfel,
};
use rayon::prelude::*;
use std::f32::consts::PI;
use wide::f32x8;

/// Least albedo of a channel whose gloss is compared with diffuse light.
const LEAST_ALBEDO: f32 = 1e-4;

/// Leaves whose materials have lobes, under some materials.
#[derive(Default)]
pub struct Gloss {
    leaves: Vec<GlossyLeaf>,
}

struct GlossyLeaf {
    leaf: u32,
    brdf: SurfaceBrdf,
    albedo: Vec3,
}

/// What leaves see, from where they are looked at.
pub struct SeenLeaves<'a> {
    pub forest: &'a DiscForest,
    pub views: &'a Views,
    pub mesh: &'a Mesh,
    /// The leaves on the mesh.
    pub surfels: &'a [Surfel],
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Radiance that each node of the forest sends, if glossy leaves reflect it too.
    pub sent: Option<&'a [Vec3A]>,
}

/// Irradiance of the leaves in W/m².
pub struct Received<'a> {
    pub from_sky: &'a mut [Vec3],
    pub from_leaves: &'a mut [Vec3],
}

/// What a leaf reflects toward the eye, as radiance in W/(m² sr).
#[derive(Default)]
struct Reflected {
    sky: Vec3,
    leaves: Vec3,
    /// Irradiance from the leaves that it sees.
    irradiance: Vec3,
}

impl Gloss {
    /// The glossy ones among the leaves.
    pub fn new(appearance: &Appearance, leaves: &LitPoints) -> Self {
        let appearance = ResolvedAppearance::from(appearance.clone());
        let glossy = |(leaf, surfel): (usize, &Surfel)| {
            let brdf = appearance.at_place(leaves.mesh(), surfel.place).brdf;
            let albedo = brdf.as_brdf().albedo();
            brdf.as_brdf().narrowest_lobe().map(|_| GlossyLeaf { leaf: leaf as u32, brdf, albedo })
        };
        Self { leaves: leaves.points().par_iter().enumerate().filter_map(glossy).collect() }
    }

    /// Whether no leaf is glossy.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// The first to the last glossy leaf; empty without any.
    pub fn span(&self) -> std::ops::Range<u32> {
        match (self.leaves.first(), self.leaves.last()) {
            (Some(first), Some(last)) => first.leaf..last.leaf + 1,
            _ => 0..0,
        }
    }

    /// Replaces the irradiance of glossy leaves by that with which a diffuse leaf of the same albedo would reflect as much toward
    /// the eye. Leaves that face away from the eye keep theirs.
    pub fn toward_eye(&self, seen: &SeenLeaves, sky: impl Fn(Vec3) -> Vec3 + Sync, received: Received) {
        let cells = Cells::of(seen.views.layout());
        let of = |glossy: &GlossyLeaf| glossy.reflected(seen, &cells, &sky);
        let all: Vec<Option<Reflected>> = self.leaves.par_iter().with_min_len(64).map(of).collect();
        for (reflected, glossy) in all.into_iter().zip(&self.leaves) {
            let Some(reflected) = reflected else { continue };
            let leaf = glossy.leaf as usize;
            let (from_sky, from_leaves) = (&mut received.from_sky[leaf], &mut received.from_leaves[leaf]);
            *from_sky = glossy.irradiance(reflected.sky, *from_sky);
            // Nodes send the light of one bounce more than leaves received: it gives the share alone.
            let share = glossy.irradiance(reflected.leaves, reflected.irradiance);
            *from_leaves = Vec3::select(
                reflected.irradiance.cmpgt(Vec3::ZERO),
                *from_leaves * share / reflected.irradiance,
                *from_leaves,
            );
        }
    }
}

impl GlossyLeaf {
    /// The irradiance of a diffuse leaf that reflects so much; `otherwise` in channels that reflect nothing.
    fn irradiance(&self, reflected: Vec3, otherwise: Vec3) -> Vec3 {
        let least = Vec3::splat(LEAST_ALBEDO);
        Vec3::select(self.albedo.cmpge(least), PI * reflected / self.albedo.max(least), otherwise)
    }

    /// What it reflects; `None` if it faces away.
    fn reflected(&self, seen: &SeenLeaves, cells: &Cells, sky: &(impl Fn(Vec3) -> Vec3 + Sync)) -> Option<Reflected> {
        let surfel = &seen.surfels[self.leaf as usize];
        let shading = seen.mesh.frame(surfel);
        let wo = shading.transpose() * (seen.eye - surfel.position).normalize_or_zero();
        if wo.z <= 0.0 {
            return None;
        }
        let bins = seen.views.layout().frame_of(&seen.forest.discs()[self.leaf as usize]);
        let local = shading.transpose() * bins;
        let nodes = seen.views.of_leaf(self.leaf);
        let mut sum = Reflected::default();
        for (block, nodes) in cells.blocks.iter().zip(nodes.chunks(8)) {
            if seen.sent.is_none() && nodes.iter().all(|&node| node != EMPTY) {
                continue;
            }
            let wi = Vec3x8::from_array(block.directions.map(|direction| local * direction));
            let value = self.brdf.spread_cos_x8(wi, wo, block.inv_kappa, [0.0; 3]);
            for (i, &node) in nodes.iter().enumerate() {
                let value = value.lane(i) * block.solid_angles[i];
                match (node, seen.sent) {
                    (EMPTY, _) => sum.sky += value * sky(bins * block.directions[i]),
                    (node, Some(sent)) => {
                        let sent = Vec3::from(sent[node as usize]);
                        sum.leaves += value * sent;
                        sum.irradiance += cells.weight * sent;
                    }
                    (_, None) => {}
                }
            }
        }
        Some(sum)
    }
}

/// The cells of bins, eight at a time.
struct Cells {
    blocks: Vec<Block>,
    /// Integral of the cosine over a cell, in steradians.
    weight: f32,
}

struct Block {
    directions: [Vec3; 8],
    /// Spread of the cells, so that no lobe falls between them.
    inv_kappa: f32x8,
    solid_angles: [f32; 8],
}

impl Cells {
    fn of(layout: BinLayout) -> Self {
        let cells = layout.cells;
        let block = |first: usize| {
            let directions = std::array::from_fn(|i| cells.direction_of((first + i).min(cells.len() - 1)));
            let solid_angles = directions.map(|direction: Vec3| cells.weight() / direction.z);
            Block { directions, inv_kappa: f32x8::new(solid_angles) / f32x8::splat(SPHERE), solid_angles }
        };
        Self { blocks: (0..cells.len()).step_by(8).map(block).collect(), weight: cells.weight() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        baked::Baked,
        light::implicit::tests::{blocked, posed},
        test_scenes::glossy,
    };
    use lapidary_core::{
        brdf::GgxParameters,
        implicit::{Bins, forest::SurfelForest},
        material::BrdfModel,
        scene::pose::Pose,
        sphere::uniform_direction,
    };

    #[test]
    fn a_leaf_reflects_as_much_of_the_open_sky_as_the_integral_of_its_brdf() {
        let floor = GgxParameters { base_color: Vec3::new(0.5, 0.3, 0.0), ..glossy(0.5) };
        let mut dataset = blocked(floor, 4);
        dataset.scene.materials[0].model = BrdfModel::Ggx;
        let away = posed(Pose { translate: Vec3::Y * 1000.0, ..Pose::AS_BAKED });
        let baked = Baked::from(dataset).posed(&away).unwrap();
        let (mesh, materials) = (&baked.dataset.scene.mesh, Appearance::of(&baked.dataset.scene));
        let forest = SurfelForest::new(mesh, &baked.dataset.two_sided, 256);
        let gloss = Gloss::new(&materials, &LitPoints::new(&baked, forest.surfels().collect(), 1));
        let views = Bins::walk(forest.discs(), BinLayout::FINEST, &|_| true).views();
        let surfels: Vec<Surfel> = forest.surfels().collect();
        let leaf = surfels.iter().position(|s| s.normal.y > 0.99 && s.position.length() < 1.0).unwrap();
        let sky = |direction: Vec3| Vec3::new(1.0, 1.0 + direction.x, direction.z.abs());
        let brdf = &gloss.leaves[leaf].brdf;
        let mut rng = fastrand::Rng::with_seed(1);
        let all: Vec<Vec3> = (0..200_000).map(|_| uniform_direction(rng.f32(), rng.f32())).collect();
        for eye in [Vec3::new(0.0, 3.0, 0.5), Vec3::new(2.0, 1.0, 0.0), Vec3::new(-2.0, 1.0, 0.0)] {
            let frame = mesh.frame(&surfels[leaf]);
            let wo = frame.transpose() * (eye - surfels[leaf].position).normalize();
            let known: Vec3 = all.iter().map(|&wi| brdf.as_brdf().brdf_cos(wi, wo) * sky(frame * wi)).sum();
            let known = known * SPHERE / all.len() as f32;
            let [mut found, mut none] = [(); 2].map(|()| vec![Vec3::ZERO; surfels.len()]);
            let seen = SeenLeaves { forest: forest.discs(), views: &views, mesh, surfels: &surfels, eye, sent: None };
            gloss.toward_eye(&seen, sky, Received { from_sky: &mut found, from_leaves: &mut none });
            let radiance = found[leaf] * gloss.leaves[leaf].albedo / PI;
            assert!((radiance / known - 1.0).abs().max_element() < 0.08, "{radiance} {known}");
            let swapped = |direction: Vec3| sky(Vec3::new(-direction.x, direction.y, direction.z));
            gloss.toward_eye(&seen, swapped, Received { from_sky: &mut found, from_leaves: &mut none });
            let other = found[leaf] * gloss.leaves[leaf].albedo / PI;
            assert!(eye.x == 0.0 || (other.y / known.y - 1.0).abs() > 0.2, "negative control: {other} {known}");
        }
        let below = SeenLeaves {
            forest: forest.discs(),
            views: &views,
            mesh,
            surfels: &surfels,
            eye: Vec3::new(0.0, -1.0, 0.0),
            sent: None,
        };
        let [mut kept, mut none] = [(); 2].map(|()| vec![Vec3::ONE; surfels.len()]);
        gloss.toward_eye(&below, sky, Received { from_sky: &mut kept, from_leaves: &mut none });
        assert_eq!(kept[leaf], Vec3::ONE, "it faces away");
    }
}
