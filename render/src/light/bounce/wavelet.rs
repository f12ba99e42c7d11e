//! Bounced light by wavelet transport: light of lamps on quads, all bounces by two sparse products, and textures of the radiance
//! that arrives (Kontkanen et al. 2006, section 5).

use crate::{
    baked::Baked,
    light::situation::{Changes, Relight, Situation},
    shade::surface::SurfacePoint,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    offset,
    simd::Vec3x8,
    sphere::{concentric::HemisphereCells, inv_kappa_of},
    wavelet::{
        WaveletTransport,
        direct::DirectProjection,
        patch::{Patch, patch_of_triangles},
        picture::{PatchTexture, neighbors},
    },
};
use std::sync::Arc;
use wide::f32x8;

/// Halvings of a quad at most, where lamps light it.
const DIRECT_LEVELS: u32 = 5;
/// Smallest cosine of an incident direction, against a division by zero at the horizon.
const LEAST_COSINE: f32 = 1e-4;
/// Least cells along an edge of the hemisphere over which a BRDF is evaluated. A quad of the bake may have fewer.
const LEAST_SIDE: usize = 8;

/// The quads of a scene, which of them continue each other, and on which each triangle lies.
#[derive(Clone, Debug)]
pub struct Quads {
    /// The quads.
    pub patches: Vec<Patch>,
    /// See [`neighbors`].
    neighbors: Vec<Vec<u32>>,
    /// The quad of each triangle, if any.
    pub of_triangles: Vec<Option<u32>>,
}

/// Radiance that arrives at the quads.
#[derive(Clone, Debug)]
pub struct PatchLight {
    quads: Arc<Quads>,
    textures: Vec<PatchTexture>,
}

impl PatchLight {
    /// The quads.
    pub fn quads(&self) -> &Arc<Quads> {
        &self.quads
    }

    /// A texture for each quad.
    pub fn textures(&self) -> &[PatchTexture] {
        &self.textures
    }

    /// Radiance that a surface point reflects to the eye. Backs of quads get no light.
    ///
    /// The cells of directions are those of the quad's frame. The BRDF lives in the frame of the bumps, so its lobe turns with
    /// them. Lobes are as wide as cells at least, for the material of now may be sharper than that of the bake.
    pub(crate) fn reflected(&self, point: &SurfacePoint) -> Vec3 {
        let quad = self.quads.of_triangles[point.triangle as usize].filter(|_| !point.from_behind);
        let Some(quad) = quad.map(|quad| quad as usize) else { return Vec3::ZERO };
        let (patch, texture) = (&self.quads.patches[quad], &self.textures[quad]);
        let arriving = texture.at(patch.square_of(point.position).clamp(Vec2::ZERO, Vec2::ONE));
        let (cells, patch_from_local) = (texture.cells(), patch.frame.transpose() * point.world_from_local);
        let looked_at = HemisphereCells { side: cells.side.max(LEAST_SIDE) };
        let mut sum = Vec3::ZERO;
        for first in (0..looked_at.len()).step_by(8) {
            let directions: [Vec3; 8] = std::array::from_fn(|lane| looked_at.direction_of(first + lane));
            let spread = directions.map(|wi| inv_kappa_of(looked_at.weight() / wi.z.max(LEAST_COSINE)));
            let reflected = point.reflect(Vec3x8::from_array(directions), f32x8::new(spread));
            for (lane, wi) in directions.iter().enumerate() {
                let from = patch_from_local * *wi;
                if from.z > 0.0 {
                    sum += arriving[cells.cell_of(from)] * reflected.lane(lane) / wi.z.max(LEAST_COSINE);
                }
            }
        }
        // Compressed light may be below zero.
        (sum * looked_at.weight()).max(Vec3::ZERO)
    }
}

/// Lights the quads of a dataset.
pub struct WaveletRig {
    baked: Baked,
    transport: Arc<WaveletTransport>,
    quads: Arc<Quads>,
    /// Radiance after one bounce or more, in the basis.
    indirect: Vec<Vec3>,
}

impl WaveletRig {
    /// Starts without light; `None` if the dataset has no wavelet transport.
    pub fn new(baked: &Baked) -> Option<Self> {
        let transport = baked.dataset.wavelet.clone()?;
        let patches: Vec<Patch> = transport.patches.iter().map(|reflecting| reflecting.patch).collect();
        let of_triangles = patch_of_triangles(&baked.dataset.scene.mesh, &patches);
        let (indirect, offset) = (vec![Vec3::ZERO; transport.basis.functions().len()], offset_in(baked));
        let neighbors = neighbors(&transport.patches, &transport.basis, baked.intersector(), offset);
        let quads = Quads { patches, neighbors, of_triangles }.into();
        Some(Self { baked: baked.clone(), transport, quads, indirect })
    }

    /// Light after one bounce or more.
    pub fn light(&self) -> PatchLight {
        let WaveletTransport { patches, basis, .. } = &*self.transport;
        let textures = PatchTexture::all(patches, &self.quads.neighbors, basis, &self.indirect);
        PatchLight { quads: self.quads.clone(), textures }
    }
}

/// Distance of the ends of rays from surfaces, in meters.
fn offset_in(baked: &Baked) -> f32 {
    offset::TRANSPORT * baked.dataset.scene.mesh.bounds().diagonal()
}

impl Relight for WaveletRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        if changes.lights || changes.environment {
            let (transport, rays) = (&self.transport, self.baked.intersector());
            let offset = offset_in(&self.baked);
            let projection = DirectProjection { patches: &transport.patches, rays, offset, levels: DIRECT_LEVELS };
            self.indirect = transport.indirect(&projection.project(&situation.bouncing(), &transport.basis));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Renderer,
        test_scenes::{dataset, from_above, mesh, surface_at},
    };
    use glam::Mat3;
    use lapidary_core::{
        brdf::GgxParameters,
        material::BrdfModel,
        wavelet::{
            operator::{Operator, RadianceFunction, TransportCoefficient},
            reflecting::ReflectingPatch,
            square::Function,
        },
    };
    use std::f32::consts::PI;

    /// Radiance of one from everywhere on a floor, as a material with a metal's roughness reflects it upward, and its albedo.
    fn reflected(side: usize, model: BrdfModel, roughness: f32) -> [f32; 2] {
        let metal = GgxParameters { base_color: Vec3::splat(0.8), roughness, metalness: 1.0, ..Default::default() };
        let mut dataset = dataset(mesh(8, false), metal);
        dataset.scene.materials[0].model = model;
        let edges = [Vec3::Z * 4.0, Vec3::X * 4.0];
        let frame = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
        let floor = Patch { corner: Vec3::new(-2.0, 0.0, -2.0), edges, frame, area: 16.0, material: 0, object: 0 };
        let mut patches = ReflectingPatch::all(vec![floor], &dataset.scene.materials);
        patches[0].cells = HemisphereCells { side };
        let function = RadianceFunction { patch: 0, space: Function::CONSTANT, angle: Function::CONSTANT };
        let coefficient = TransportCoefficient { receiver: function, sender: function, value: Vec3::ONE };
        let basis = Operator::of(vec![coefficient]).0;
        let textures = PatchTexture::all(&patches, &[Vec::new()], &basis, &[Vec3::splat((16.0 * PI).sqrt())]);
        let of_triangles = patch_of_triangles(&dataset.scene.mesh, &[floor]);
        let quads = Quads { patches: vec![floor], neighbors: vec![Vec::new()], of_triangles }.into();
        let point = surface_at(&Renderer::new(dataset), &from_above(8));
        let light = PatchLight { quads, textures };
        assert_eq!(light.reflected(&SurfacePoint { from_behind: true, ..point.clone() }), Vec3::ZERO, "the back");
        [light.reflected(&point).x, point.brdf.as_brdf().albedo().x]
    }

    #[test]
    fn light_from_everywhere_is_reflected_by_the_albedo_whatever_the_bake_knew() {
        let [white, albedo] = reflected(8, BrdfModel::Lambert, 1.0);
        assert!((white / albedo - 1.0).abs() < 1e-4, "{white} {albedo}");
        let off = |side, roughness| {
            let [found, albedo] = reflected(side, BrdfModel::Ggx, roughness);
            found / albedo - 1.0
        };
        for (side, roughness) in [(1, 1.0), (8, 0.6), (16, 0.6)] {
            assert!(off(side, roughness).abs() < 0.05, "{side} {roughness}: {}", off(side, roughness));
        }
        // Sharper than the cells, it has no bright spots.
        for (side, roughness) in [(1, 0.2), (8, 0.2), (8, 0.1), (16, 0.1)] {
            assert!(off(side, roughness).abs() < 0.25, "{side} {roughness}: {}", off(side, roughness));
        }
    }
}
