//! The normal after normal map and bump map, and the spread of the normals within a sample's footprint.
//!
//! A map seen from afar has many normals in a sample. Their covariance widens the lobes of every model, as a light's spread does
//! (Olano and Baker 2010): facet normals combine the map's normals with the model's. Twin of `shaders/bumps.wgsl`.

use super::surface::SurfacePlace;
use crate::appearance::Appearance;
use glam::{Mat2, Mat3, Vec2, Vec3};
use lapidary_core::{
    material::ResolvedMaterial,
    sphere::frame_along,
    texture::{ColorSpace, SlopeMoments, TextureSlot, UvFootprint, covariance_mapped},
};

/// Slopes that tilt a normal: their covariance as xx, xy, yy, and the normal's change with each.
#[derive(Clone, Copy, Default)]
struct Moving {
    covariance: [f32; 3],
    axes: [Vec3; 2],
}

/// The mean normal and the slopes that tilt it.
pub(crate) struct Bumped {
    pub normal: Vec3,
    moving: [Moving; 2],
}

impl SurfacePlace {
    /// Mean normal after normal map and bump map.
    pub(super) fn bumped(&self, appearance: &Appearance, material: &ResolvedMaterial) -> Bumped {
        let smooth = frame_along(self.smooth_normal, self.tangent, self.handedness);
        let mut bumped = Bumped { normal: smooth.z_axis, moving: [Moving::default(); 2] };
        if let Some(slot) = material.normal_map() {
            match appearance.normal_moments(slot, self.attributes.uv_of(slot)) {
                None => {
                    let n = slot.tangent_normal(appearance.encoded_normal(slot, self.attributes.uv_of(slot)));
                    bumped.normal = (smooth * n).try_normalize().unwrap_or(bumped.normal);
                }
                Some(moments) => {
                    let length = (1.0 + moments.mean.length_squared()).sqrt();
                    bumped.normal = smooth * moments.mean.extend(1.0) / length;
                    let axes = [smooth.x_axis / length, smooth.y_axis / length];
                    bumped.moving[0] = Moving { covariance: moments.covariance(), axes };
                }
            }
        }
        let bump = material.bump_map().and_then(|slot| Some((slot, self.slopes[slot.uv_set as usize]?)));
        if let Some((slot, [per_u, per_v])) = bump {
            let moments = appearance.height_moments(slot, self.attributes.uv_of(slot));
            // The gradient along the surface tilts the normal of the raised surface against it (Blinn 1978).
            let tilted = bumped.normal - per_u * moments.mean.x - per_v * moments.mean.y;
            if let Some(normal) = tilted.try_normalize() {
                let shorter = tilted.length().recip();
                bumped.normal = normal;
                bumped.moving[0].axes = bumped.moving[0].axes.map(|axis| axis * shorter);
                bumped.moving[1] =
                    Moving { covariance: moments.covariance(), axes: [per_u * shorter, per_v * shorter] };
            }
        }
        bumped
    }
}

impl Appearance {
    /// See [`lapidary_core::texture::Texture::normal_moments`]. A procedural pattern returns unfiltered normals.
    fn normal_moments(&self, slot: &TextureSlot, uv: &UvFootprint) -> Option<SlopeMoments> {
        self.textures[slot.image()?].normal_moments(uv, slot)
    }

    fn encoded_normal(&self, slot: &TextureSlot, uv: &UvFootprint) -> Vec3 {
        let texel = match slot.image() {
            Some(image) => self.textures[image].sample(slot.transform(uv.uv), ColorSpace::Linear, slot.wrap),
            None => self.sample(slot, uv),
        };
        texel.truncate()
    }

    fn height_moments(&self, slot: &TextureSlot, uv: &UvFootprint) -> SlopeMoments {
        match &slot.procedural {
            Some(pattern) => slot.pattern_moments(pattern, uv),
            None => self.textures[slot.texture as usize].height_moments(uv, slot),
        }
    }
}

impl Bumped {
    /// Twice the covariance of the slopes in a frame around the normal: xx, xy, yy.
    pub fn spread(&self, world_from_local: &Mat3) -> [f32; 3] {
        let mut spread = [0.0; 3];
        for Moving { covariance, axes } in self.moving.iter().filter(|moving| moving.covariance != [0.0; 3]) {
            let local =
                axes.map(|axis| Vec2::new(world_from_local.x_axis.dot(axis), world_from_local.y_axis.dot(axis)));
            let there = covariance_mapped(*covariance, Mat2::from_cols(local[0], local[1]));
            spread.iter_mut().zip(there).for_each(|(sum, own)| *sum += 2.0 * own);
        }
        spread
    }
}

#[cfg(test)]
mod tests;
