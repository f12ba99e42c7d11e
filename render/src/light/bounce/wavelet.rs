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
    wavelet::{
        WaveletTransport,
        direct::DirectProjection,
        patch::{Patch, patch_of_triangles},
        picture::PatchTexture,
    },
};
use std::sync::Arc;
use wide::f32x8;

/// Halvings of a quad at most, where lamps light it.
const DIRECT_LEVELS: u32 = 5;
/// Smallest cosine of an incident direction, against a division by zero at the horizon.
const LEAST_COSINE: f32 = 1e-4;

/// The quads of a scene, and which of them each triangle lies on.
#[derive(Clone, Debug)]
pub struct Quads {
    /// The quads.
    pub patches: Vec<Patch>,
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
    /// them.
    pub(crate) fn reflected(&self, point: &SurfacePoint) -> Vec3 {
        let quad = self.quads.of_triangles[point.triangle as usize].filter(|_| !point.from_behind);
        let Some(quad) = quad.map(|quad| quad as usize) else { return Vec3::ZERO };
        let (patch, texture) = (&self.quads.patches[quad], &self.textures[quad]);
        let arriving = texture.at(patch.square_of(point.position).clamp(Vec2::ZERO, Vec2::ONE));
        let (cells, patch_from_local) = (texture.cells(), patch.frame.transpose() * point.world_from_local);
        let mut sum = Vec3::ZERO;
        for first in (0..cells.len()).step_by(8) {
            let directions: [Vec3; 8] =
                std::array::from_fn(|lane| cells.direction_of((first + lane).min(cells.len() - 1)));
            let reflected = point.reflect(Vec3x8::from_array(directions), f32x8::ZERO);
            for (lane, wi) in directions.iter().enumerate().take(cells.len() - first) {
                let from = patch_from_local * *wi;
                if from.z > 0.0 {
                    sum += arriving[cells.cell_of(from)] * reflected.lane(lane) / wi.z.max(LEAST_COSINE);
                }
            }
        }
        sum * cells.weight()
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
        let indirect = vec![Vec3::ZERO; transport.basis.functions().len()];
        Some(Self { baked: baked.clone(), transport, quads: Quads { patches, of_triangles }.into(), indirect })
    }

    /// Light after one bounce or more.
    pub fn light(&self) -> PatchLight {
        let WaveletTransport { patches, basis, .. } = &*self.transport;
        PatchLight { quads: self.quads.clone(), textures: PatchTexture::all(patches, basis, &self.indirect) }
    }
}

impl Relight for WaveletRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        if changes.lights || changes.environment {
            let (transport, rays) = (&self.transport, self.baked.intersector());
            let offset = offset::TRANSPORT * self.baked.dataset.scene.mesh.bounds().diagonal();
            let projection = DirectProjection { patches: &transport.patches, rays, offset, levels: DIRECT_LEVELS };
            self.indirect = transport.indirect(&projection.project(&situation.bouncing(), &transport.basis));
        }
    }
}
