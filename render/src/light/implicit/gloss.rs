//! What glossy leaves reflect toward the eye: their BRDFs over their bins (implicit visibility, Eq. 2 to 5).

use crate::{
    appearance::{Appearance, ResolvedAppearance},
    device::{LeafLobes, ModelSet, SeenLight},
    light::bounce::LitPoints,
};
use glam::{Mat3, Vec3, Vec3A, Vec4};
use lapidary_core::{
    brdf::{SurfaceBrdf, Values},
    implicit::{BinLayout, EMPTY, Lighting, Sky, Views, disc_forest::DiscForest},
    material::ResolvedMaterial,
    scene::Mesh,
    simd::Vec3x8,
    sphere::SPHERE,
    surfel::Surfel,
};
use rayon::prelude::*;
use std::{
    collections::HashMap,
    f32::consts::{FRAC_1_PI, PI},
    sync::Arc,
};
use wide::f32x8;

/// Least albedo of a channel whose gloss is compared with diffuse light.
pub(crate) const LEAST_GLOSSY_ALBEDO: f32 = 1e-4;

/// Leaves whose materials have lobes, under some materials. Copies share them.
#[derive(Clone, Default)]
pub struct Gloss {
    leaves: Arc<[GlossyLeaf]>,
    appearance: Arc<ResolvedAppearance>,
}

struct GlossyLeaf {
    leaf: u32,
    brdf: SurfaceBrdf,
    albedo: Vec3,
}

/// Leaves, and from where they are looked at.
pub struct SeenLeaves<'a> {
    pub forest: &'a DiscForest,
    pub mesh: &'a Mesh,
    /// The leaves on the mesh.
    pub surfels: &'a [Surfel],
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Radiance that each node of the forest sends, if glossy leaves reflect it too.
    pub sent: Option<&'a [Vec3A]>,
    pub sky: Sky<'a>,
}

/// What a leaf reflects toward the eye, as radiance in W/(m² sr).
#[derive(Clone, Copy, Debug, Default)]
pub struct ReflectedLight {
    /// Of the sky.
    pub sky: Vec3,
    /// Of the leaves that it sees.
    pub leaves: Vec3,
    /// Irradiance from these leaves, in W/m².
    pub irradiance: Vec3,
}

/// Irradiance of the leaves in W/m².
pub struct Received<'a> {
    pub from_sky: &'a mut [Vec3],
    pub from_leaves: &'a mut [Vec3],
}

/// Radiance in W/(m² sr) that the nodes of a forest send into the picture. The twin on an adapter is `implicit_pull_kernel.wgsl`.
pub(crate) fn sent_by(
    forest: &DiscForest,
    lighting: &Lighting,
    SeenLight { direct, bounced, .. }: &SeenLight,
) -> Vec<Vec3A> {
    let arriving = lighting.received.iter().zip(direct.iter().zip(bounced));
    let arriving = arriving.map(|(received, (direct, bounced))| *received + *direct + *bounced);
    let surfaces = lighting.reflectance.iter().zip(lighting.emitted);
    let sent = arriving.zip(surfaces).map(|(e, (albedo, emission))| (e * *albedo * FRAC_1_PI + *emission).into());
    forest.pull(&sent.collect::<Vec<Vec3A>>())
}

impl Gloss {
    /// The glossy ones among the leaves.
    pub(crate) fn new(appearance: &Appearance, leaves: &LitPoints) -> Self {
        let appearance = ResolvedAppearance::from(appearance.clone());
        let glossy = |(leaf, surfel): (usize, &Surfel)| {
            let brdf = appearance.at_place(leaves.mesh(), surfel.place).brdf;
            let albedo = brdf.as_brdf().albedo();
            brdf.as_brdf().narrowest_lobe().map(|_| GlossyLeaf { leaf: leaf as u32, brdf, albedo })
        };
        let found: Vec<GlossyLeaf> = leaves.points().par_iter().enumerate().filter_map(glossy).collect();
        Self { leaves: found.into(), appearance: appearance.into() }
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

    /// Whether both are the same leaves under the same materials.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.leaves, &other.leaves)
    }

    /// The models of the scene; `None` if a BRDF comes from a file, which kernels of leaves do not read.
    pub fn models(&self) -> Option<ModelSet> {
        let has_file = self.appearance.materials.iter().any(|material| material.model.has_file());
        (!has_file).then(|| ModelSet::of(&self.appearance).without_maps())
    }

    /// The leaves as an adapter takes them, and the values of their models' parameters. Leaves of a material without maps share these.
    pub fn packed(&self, mesh: &Mesh, surfels: &[Surfel]) -> (Vec<LeafLobes>, Vec<Vec4>) {
        let own = |glossy: &GlossyLeaf| {
            let place = surfels[glossy.leaf as usize].place;
            let material = self.appearance.material_there(mesh, place);
            (material, (!material.is_constant()).then(|| self.appearance.values_there(mesh, place)))
        };
        let own: Vec<(&ResolvedMaterial, Option<Values>)> = self.leaves.par_iter().map(own).collect();
        let (mut all, mut of_materials) = (Vec::new(), HashMap::new());
        let mut push = |material: &ResolvedMaterial, values: &Values| {
            let first = all.len() as u32;
            all.extend(values.each(material.model().own_parameters()).map(|value| value.color().extend(0.0)));
            first
        };
        let lobes = own.iter().zip(&*self.leaves).map(|((material, own), &GlossyLeaf { leaf, .. })| {
            let first = match own {
                Some(values) => push(material, values),
                None => {
                    let shared = || push(material, material.plain_values());
                    *of_materials.entry(std::ptr::from_ref(*material)).or_insert_with(shared)
                }
            };
            LeafLobes { leaf, model: material.model(), first }
        });
        (lobes.collect(), all)
    }

    /// The shading frames of the leaves.
    pub fn frames(&self, mesh: &Mesh, surfels: &[Surfel]) -> Vec<Mat3> {
        self.leaves.par_iter().map(|glossy| mesh.frame(&surfels[glossy.leaf as usize])).collect()
    }

    /// What the leaves reflect toward the eye, by what they see; `None` for those that face away. The twin on an adapter is
    /// `GpuForest::gloss`.
    pub fn reflected(&self, seen: &SeenLeaves, views: &Views) -> Vec<Option<ReflectedLight>> {
        let cells = Cells::of(views.layout());
        self.leaves.par_iter().with_min_len(64).map(|glossy| glossy.reflected(seen, views, &cells)).collect()
    }

    /// Replaces the irradiance of glossy leaves by that with which a diffuse leaf of the same albedo would reflect as much toward
    /// the eye. Leaves that face away from the eye keep theirs.
    pub fn toward_eye(&self, reflected: &[Option<ReflectedLight>], received: Received) {
        for (reflected, glossy) in reflected.iter().zip(&*self.leaves) {
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
        let least = Vec3::splat(LEAST_GLOSSY_ALBEDO);
        Vec3::select(self.albedo.cmpge(least), PI * reflected / self.albedo.max(least), otherwise)
    }

    /// What it reflects; `None` if it faces away.
    fn reflected(&self, seen: &SeenLeaves, views: &Views, cells: &Cells) -> Option<ReflectedLight> {
        let surfel = &seen.surfels[self.leaf as usize];
        let shading = seen.mesh.frame(surfel);
        let wo = shading.transpose() * (seen.eye - surfel.position).normalize_or_zero();
        if wo.z <= 0.0 {
            return None;
        }
        let bins = views.layout().frame_of(&seen.forest.discs()[self.leaf as usize]);
        let local = shading.transpose() * bins;
        let nodes = views.of_leaf(self.leaf);
        let mut sum = ReflectedLight::default();
        for (block, nodes) in cells.blocks.iter().zip(nodes.chunks(8)) {
            if seen.sent.is_none() && nodes.iter().all(|&node| node != EMPTY) {
                continue;
            }
            let wi = Vec3x8::from_array(block.directions.map(|direction| local * direction));
            let value = self.brdf.spread_cos_x8(wi, wo, block.inv_kappa, [0.0; 3]);
            for (i, &node) in nodes.iter().enumerate() {
                let value = value.lane(i) * block.solid_angles[i];
                match (node, seen.sent) {
                    (EMPTY, _) => sum.sky += value * (seen.sky)(bins * block.directions[i]),
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
            let mut look = |sky: Sky, found: &mut [Vec3]| {
                let seen = SeenLeaves { forest: forest.discs(), mesh, surfels: &surfels, eye, sent: None, sky };
                let reflected = gloss.reflected(&seen, &views);
                gloss.toward_eye(&reflected, Received { from_sky: found, from_leaves: &mut none });
            };
            look(&sky, &mut found);
            let radiance = found[leaf] * gloss.leaves[leaf].albedo / PI;
            assert!((radiance / known - 1.0).abs().max_element() < 0.08, "{radiance} {known}");
            let swapped = |direction: Vec3| sky(Vec3::new(-direction.x, direction.y, direction.z));
            look(&swapped, &mut found);
            let other = found[leaf] * gloss.leaves[leaf].albedo / PI;
            assert!(eye.x == 0.0 || (other.y / known.y - 1.0).abs() > 0.2, "negative control: {other} {known}");
        }
        let eye = Vec3::new(0.0, -1.0, 0.0);
        let below = SeenLeaves { forest: forest.discs(), mesh, surfels: &surfels, eye, sent: None, sky: &sky };
        let [mut kept, mut none] = [(); 2].map(|()| vec![Vec3::ONE; surfels.len()]);
        gloss.toward_eye(&gloss.reflected(&below, &views), Received { from_sky: &mut kept, from_leaves: &mut none });
        assert_eq!(kept[leaf], Vec3::ONE, "it faces away");
    }
}
