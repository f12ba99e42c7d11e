//! A ball of the material under the light of the scene, for judging it apart from the scene's shadows.
//!
//! The ball is convex and alone, so every node above the horizon is visible: the sum over the illumination cut is direct,
//! with nodes halved where the BRDF needs it, as in the renderer. The camera looks from +Z, a little from above.

use glam::{Mat3, Vec2, Vec3, Vec4};
use lapidary_core::{
    brdf::SurfaceBrdf,
    cut::packed,
    material::{BrdfParameters, MapKind, Material},
    simd::Vec3x8,
    texture::{Texture, TextureSlot},
};
use lapidary_render::{Refinement, SceneLighting};
use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

/// Radius in metres: what a bump map's height is relative to.
const RADIUS: f32 = 0.1;
/// Unit squares of texture coordinates around the equator and from pole to pole, about 16 cm each.
const TILES: Vec2 = Vec2::new(4.0, 2.0);
/// The picture's half width in radii.
pub const MARGIN: f32 = 1.06;

/// A material and the light on it.
#[derive(Clone, Debug)]
pub struct Ball {
    /// The material; its maps refer to `textures`.
    pub material: Material,
    /// As many as the material's maps refer to.
    pub textures: Vec<Arc<Texture>>,
    /// The light.
    pub lighting: Arc<SceneLighting>,
}

/// A pixel of the ball: scene-linear radiance and how much of the pixel the ball covers.
pub type BallPixel = (Vec3, f32);

impl Ball {
    /// A square picture of `size` pixels, row by row from the top.
    pub fn render(&self, size: u32) -> Vec<BallPixel> {
        let cut = cut_nodes(&self.lighting);
        let view = View::new();
        let mut terms = Vec::new();
        let pixels = (0..size * size).map(|i| {
            let at = (Vec2::new((i % size) as f32, (i / size) as f32) + 0.5) / size as f32 * 2.0 - 1.0;
            let disc = Vec2::new(at.x, -at.y) * MARGIN;
            let coverage = ((1.0 - disc.length()) * size as f32 / (2.0 * MARGIN) + 0.5).clamp(0.0, 1.0);
            if coverage == 0.0 {
                return (Vec3::ZERO, 0.0);
            }
            let point = self.point(view.normal_at(disc), view.wo);
            (point.radiance(&self.lighting, &cut, &mut terms), coverage)
        });
        pixels.collect()
    }

    /// The point of the ball with this normal.
    fn point(&self, normal: Vec3, wo: Vec3) -> BallPoint {
        let place = Place::of(normal);
        let bent = facing(self.bumped_normal(&place), wo);
        let tangent = (place.tangent - bent * bent.dot(place.tangent)).normalize_or(bent.any_orthonormal_vector());
        let world_from_local = Mat3::from_cols(tangent, bent.cross(tangent), bent);
        BallPoint {
            smooth_normal: normal,
            world_from_local,
            wo: world_from_local.transpose() * wo,
            brdf: SurfaceBrdf::new(self.material.model, self.parameters(place.uv)),
        }
    }

    fn texture(&self, slot: &TextureSlot) -> Option<&Texture> {
        self.textures.get(slot.texture as usize).map(|t| &**t)
    }

    /// The material's values after its maps.
    fn parameters(&self, uv: Vec2) -> BrdfParameters {
        self.material.modulated(|slot| self.texture(slot).map_or(Vec4::ONE, |texture| texture.sample_slot(uv, slot)))
    }

    /// The normal after normal map and bump map.
    fn bumped_normal(&self, place: &Place) -> Vec3 {
        let frame = Mat3::from_cols(place.tangent, place.normal.cross(place.tangent), place.normal);
        let maps = &self.material.maps;
        let texture_of = |slot: &Option<TextureSlot>| slot.as_ref().and_then(|s| Some((s.clone(), self.texture(s)?)));
        let mut normal = place.normal;
        if let Some((slot, texture)) = texture_of(&maps[MapKind::Normal]) {
            let texel = texture.sample_slot(place.uv, &slot).truncate();
            normal = (frame * slot.tangent_normal(texel)).try_normalize().unwrap_or(normal);
        }
        if let Some((slot, texture)) = texture_of(&maps[MapKind::Bump]) {
            let [du, dv] = texture.height_slopes(place.uv, &slot);
            normal = (normal - place.per_u * du - place.per_v * dv).try_normalize().unwrap_or(normal);
        }
        normal
    }
}

/// The camera: parallel rays.
struct View {
    wo: Vec3,
    up: Vec3,
}

impl View {
    fn new() -> Self {
        let wo = Vec3::new(0.0, 0.25, 1.0).normalize();
        Self { wo, up: wo.cross(Vec3::X) }
    }

    /// Normal of the unit ball at a point of the picture, at the rim for points outside.
    fn normal_at(&self, disc: Vec2) -> Vec3 {
        let disc = disc.clamp_length_max(0.998);
        let toward = (1.0 - disc.length_squared()).sqrt();
        (Vec3::X * disc.x + self.up * disc.y + self.wo * toward).normalize()
    }
}

/// A place on the ball without bumps.
struct Place {
    normal: Vec3,
    uv: Vec2,
    tangent: Vec3,
    /// Gradients of u and v along the surface, per metre.
    per_u: Vec3,
    per_v: Vec3,
}

impl Place {
    /// Longitude from +Z toward +X, colatitude from +Y.
    fn of(normal: Vec3) -> Self {
        let (longitude, colatitude) = (normal.x.atan2(normal.z), normal.y.clamp(-1.0, 1.0).acos());
        let (sin, cos) = longitude.sin_cos();
        let tangent = Vec3::new(cos, 0.0, -sin);
        let down = tangent.cross(normal);
        // The coordinates crowd at the poles; a bump there is cut off rather than endless.
        let circle = TAU * RADIUS * colatitude.sin().max(0.05);
        Self {
            normal,
            uv: Vec2::new(longitude / TAU, colatitude / PI) * TILES,
            tangent,
            per_u: tangent * (TILES.x / circle),
            per_v: down * (TILES.y / (PI * RADIUS)),
        }
    }
}

/// A point to shade.
struct BallPoint {
    smooth_normal: Vec3,
    world_from_local: Mat3,
    wo: Vec3,
    brdf: SurfaceBrdf,
}

impl BallPoint {
    /// Reflected radiance toward the eye; `terms` is a buffer.
    fn radiance(&self, lighting: &SceneLighting, cut: &[u32], terms: &mut Vec<u32>) -> Vec3 {
        self.refine(lighting, cut, terms);
        let leaves = lighting.nodes.radiance.len() / 2;
        let local_from_world = self.world_from_local.transpose();
        let (nodes, brdf) = (&lighting.nodes, self.brdf.as_brdf());
        let mut sum = Vec3::ZERO;
        for eight in terms.chunks(8) {
            // The last group is filled up with entry 0, which has no light.
            let index: [usize; 8] = std::array::from_fn(|i| eight.get(i).map_or(0, |&n| n as usize));
            let wi = Vec3x8::from_array(index.map(|n| local_from_world * nodes.direction[n]));
            let inv_kappa = Vec3x8::from_array(index.map(|n| Vec3::splat(nodes.inv_kappa[n]))).x;
            let light = Vec3x8::from_array(index.map(|n| match n {
                0 => Vec3::ZERO,
                _ if nodes.direction[n].dot(self.smooth_normal) > 0.0 => {
                    nodes.radiance[n] * (leaves >> n.ilog2()) as f32
                }
                _ => Vec3::ZERO,
            }));
            sum += brdf.brdf_cos_x8(wi, self.wo, inv_kappa).scale(light).reduce_add();
        }
        sum * lighting.leaf_solid_angle
    }

    /// Fills `terms` with the nodes of the cut, halved where the BRDF needs it.
    fn refine(&self, lighting: &SceneLighting, cut: &[u32], terms: &mut Vec<u32>) {
        let leaves = lighting.nodes.radiance.len() / 2;
        let refinement = Refinement::new(self.brdf.as_brdf().lobe(), self.wo);
        let local_from_world = self.world_from_local.transpose();
        terms.clear();
        let mut open: Vec<u32> = cut.to_vec();
        while let Some(node) = open.pop() {
            let wi = local_from_world * lighting.nodes.direction[node as usize];
            if (node as usize) < leaves && refinement.wants_halves(lighting, node as usize, wi) {
                open.extend([2 * node, 2 * node + 1]);
            } else {
                terms.push(node);
            }
        }
    }
}

/// Heap indices of the illumination cut's nodes.
fn cut_nodes(lighting: &SceneLighting) -> Vec<u32> {
    let leaves = (lighting.nodes.radiance.len() / 2) as u32;
    let mut first = 0;
    let heap_index = |&node: &u16| {
        let size = leaves >> packed::depth(node);
        let index = (leaves + first) / size;
        first += size;
        index
    };
    lighting.cut.iter().map(heap_index).collect()
}

/// The normal, bent just enough to face the eye.
fn facing(normal: Vec3, wo: Vec3) -> Vec3 {
    const LEAST_COS: f32 = 0.02;
    let cos = normal.dot(wo);
    if cos >= LEAST_COS { normal } else { (normal + wo * (LEAST_COS - cos)).normalize() }
}

#[cfg(test)]
mod tests;
