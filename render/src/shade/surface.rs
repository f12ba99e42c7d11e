//! The hit of a camera ray: position, frame after bump and normal map, and the BRDF with textured parameters.

use crate::{appearance::ResolvedAppearance, renderer::Renderer, shade::differentials::Differentials};
use glam::{Mat3, Vec2, Vec3};
use lapidary_core::{
    brdf::{Lambert, LightsX8, LobeMomentsX8, Lobes, NO_LOBE, SpreadX8, SurfaceBrdf},
    dataset::Dataset,
    lights::Disc,
    material::{MaterialPoint, ResolvedMaterial, SurfaceAttributes},
    offset,
    ray::{Hit, Intersector},
    simd::{Lanes, Vec3x8},
    sphere::frame_along,
    surfel::MeshPlace,
    texture::UvSet,
};
use std::{borrow::Cow, f32::consts::TAU};
use wide::f32x8;

/// A point of a surface as seen along one ray.
#[derive(Clone, Debug)]
pub struct SurfacePoint {
    /// Index of the material.
    pub material: u32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Vertices of the triangle.
    pub vertices: [u32; 3],
    /// Positions of the vertices.
    pub corners: [Vec3; 3],
    /// Barycentric coordinates.
    pub barycentric: Vec3,
    /// Weights of the vertices' visibility cuts; those of buried vertices are zero.
    pub weights: [f32; 3],
    /// Whether the back of the triangle is visible.
    pub from_behind: bool,
    /// Position in meters.
    pub position: Vec3,
    /// Origin of shadow rays: slightly off the face, on the visible side.
    pub ray_origin: Vec3,
    /// Unit normal of the triangle, on the visible side.
    pub face_normal: Vec3,
    /// Interpolated normal before bump and normal map, on the visible side. The surface receives no light from below it.
    pub smooth_normal: Vec3,
    /// Tangent, bitangent and shading normal as columns.
    pub world_from_local: Mat3,
    /// Direction to the eye in the local frame.
    pub wo: Vec3,
    /// Base color and perceptual roughness after their textures; black and 1 in models without.
    pub base_color: Vec3,
    pub roughness: f32,
    /// Reflectance with the textured parameters.
    pub brdf: SurfaceBrdf,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Twice the covariance of the slopes within the sample, in the local frame, which widens all lobes: xx, xy, yy.
    pub slopes: [f32; 3],
    /// The same along each axis by the cone of a mirror's ray. It blurs the map and lamps, which are small, and makes no lobe less sharp.
    pub by_cone: f32,
    /// Whether it belongs to a ground that catches shadows.
    pub is_catcher: bool,
    /// The ground's own surface there, if it has lobes: sharp ones reflect over the caught background.
    pub ground: Option<Box<SurfacePoint>>,
}

impl SurfacePoint {
    /// Turns the point into one of a ground that catches shadows: flat and diffuse. `reflectance` may exceed 1.
    pub fn catching(self, reflectance: Vec3) -> Self {
        let wo = self.world_from_local * self.wo;
        let world_from_local = frame_along(self.smooth_normal, Vec3::X, 1.0);
        let has_lobes = self.brdf.as_brdf().narrowest_lobe().is_some();
        Self {
            ground: has_lobes.then(|| Box::new(self.clone())),
            world_from_local,
            wo: world_from_local.transpose() * wo,
            base_color: reflectance,
            roughness: 1.0,
            brdf: SurfaceBrdf::Lambert(Lambert::new(reflectance)),
            emission: Vec3::ZERO,
            slopes: [0.0; 3],
            is_catcher: true,
            ..self
        }
    }

    /// Widths of the lobes as in [`lapidary_core::brdf::Brdf::lobes`], widened by the slopes.
    pub fn lobes(&self) -> Lobes {
        let lobes = self.brdf.as_brdf().lobes();
        if self.slopes == [0.0; 3] {
            return lobes;
        }
        // The smallest width of nearby directions along each axis, so no lobe counts as wider than it is.
        let [xx, xy, yy] = self.slopes;
        let [along, across] = [xx, yy].map(|square| (square - xy.abs()).max(0.0));
        let widened = |[x, y]: [f32; 2]| [(x * x + along).sqrt(), (y * y + across).sqrt()];
        lobes.map(|lobe| if lobe == NO_LOBE { NO_LOBE } else { widened(lobe) })
    }

    /// The point with lobes that are widened by the cone.
    pub fn within_cone(&self) -> Cow<'_, Self> {
        match self.by_cone {
            0.0 => Cow::Borrowed(self),
            by_cone => {
                let [xx, xy, yy] = self.slopes;
                Cow::Owned(Self { slopes: [xx + by_cone, xy, yy + by_cone], ..self.clone() })
            }
        }
    }

    /// BRDF times cosine for eight lights in local directions; zero below the horizon.
    #[inline]
    pub fn reflect(&self, wi: Vec3x8, inv_kappa: f32x8) -> Vec3x8 {
        self.brdf.spread_cos_x8(wi, self.wo, inv_kappa, self.slopes)
    }

    /// The point with one random normal of its sample's footprint, from two numbers in [0, 1).
    pub fn with_one_normal(&self, [u, v]: [f32; 2]) -> Self {
        // Normally distributed slopes (Box and Muller), through the root of the covariance (Cholesky).
        let [xx, xy, yy] = self.slopes.map(|twice| 0.5 * twice);
        let (radius, (sin, cos)) = ((-2.0 * (1.0 - u).max(1e-12).ln()).sqrt(), (TAU * v).sin_cos());
        let (x, y) = (xx.sqrt(), (yy - xy * xy / xx.max(1e-12)).max(0.0).sqrt());
        let slope = radius * Vec2::new(x * cos, xy / x.max(1e-6) * cos + y * sin);
        let wo = self.world_from_local * self.wo;
        let normal = facing((self.world_from_local * slope.extend(1.0)).normalize(), wo);
        let handedness = self.world_from_local.determinant();
        let world_from_local = frame_along(normal, self.world_from_local.x_axis, handedness);
        Self { world_from_local, wo: world_from_local.transpose() * wo, slopes: [0.0; 3], ..self.clone() }
    }

    /// Whether any part of a disc may be above the horizons of both normals.
    pub fn may_receive(&self, disc: &Disc) -> bool {
        [self.smooth_normal, self.world_from_local.z_axis].iter().all(|&normal| disc.may_be_above(normal))
    }

    /// Whether light from a direction can be reflected: above the horizons of the shading normal and of the smooth normal.
    #[inline(always)]
    pub fn receives(&self, direction: Vec3) -> bool {
        direction.dot(self.world_from_local.z_axis) > 0.0 && direction.dot(self.smooth_normal) > 0.0
    }
}

/// A surface position before its material: texture coordinates, and the frame that maps tilt.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePlace {
    /// In meters.
    pub position: Vec3,
    /// Unit normal before bump and normal map, on the visible side, facing the eye.
    pub smooth_normal: Vec3,
    /// Direction along which u grows; of any length, and not necessarily in the tangent plane.
    pub tangent: Vec3,
    /// 1, or -1 for mirrored textures, where v increases against `smooth_normal` x `tangent`.
    pub handedness: f32,
    /// What the vertices give the maps.
    pub attributes: SurfaceAttributes,
    /// Gradients of u and v of each set along the surface, per meter, for bump maps; `None` if they are undefined.
    pub slopes: [Option<[Vec3; 2]>; 2],
}

/// Frame and material of a place seen from one direction.
pub(crate) struct PlaceLook {
    /// Tangent, bitangent and shading normal as columns.
    pub world_from_local: Mat3,
    /// Direction to the eye in the local frame.
    pub wo: Vec3,
    /// See [`SurfacePoint::slopes`].
    pub slopes: [f32; 3],
    /// The material after its maps.
    pub material: MaterialPoint,
}

impl SurfacePlace {
    /// Frame and BRDF with `material` of `appearance`, from the world direction `wo`.
    pub(crate) fn under(&self, appearance: &ResolvedAppearance, material: &ResolvedMaterial, wo: Vec3) -> PlaceLook {
        let bumped = self.bumped(appearance, material);
        let world_from_local = frame_along(facing(bumped.normal, wo), self.tangent, self.handedness);
        let (wo, slopes) = (world_from_local.transpose() * wo, bumped.spread(&world_from_local));
        PlaceLook { world_from_local, wo, slopes, material: appearance.material_at(material, &self.attributes) }
    }
}

/// The frame of a point, for eight directions of light at once.
pub struct ReceiverX8<L = f32x8> {
    axes: [Vec3x8<L>; 3],
    smooth_normal: Vec3x8<L>,
    /// Whether the shading normal differs from the smooth normal.
    is_bent: bool,
    slopes: [f32; 3],
}

impl<L: Lanes> ReceiverX8<L> {
    /// Creates the receiver of `point`.
    #[inline(always)]
    pub fn new(point: &SurfacePoint) -> Self {
        let Mat3 { x_axis, y_axis, z_axis } = point.world_from_local;
        let axes = [Vec3x8::splat(x_axis), Vec3x8::splat(y_axis), Vec3x8::splat(z_axis)];
        let is_bent = point.world_from_local.z_axis != point.smooth_normal;
        Self { axes, smooth_normal: Vec3x8::splat(point.smooth_normal), is_bent, slopes: point.slopes }
    }

    /// Directions in the local frame.
    #[inline(always)]
    pub fn local(&self, direction: Vec3x8<L>) -> Vec3x8<L> {
        let [x, y, z] = self.axes;
        Vec3x8 { x: direction.dot(x), y: direction.dot(y), z: direction.dot(z) }
    }

    /// Local directions in world space.
    #[inline(always)]
    pub fn world(&self, local: Vec3x8<L>) -> Vec3x8<L> {
        let [x, y, z] = self.axes;
        x * local.x + y * local.y + z * local.z
    }

    /// Received lights with an extent: their mean cosine is over the light above the horizons of both normals. A vertex's cut value
    /// also excludes light below its horizon.
    #[inline(always)]
    pub fn lights(&self, direction: Vec3x8<L>, inv_kappa: L, moments: &LobeMomentsX8<L>) -> LightsX8<L> {
        let wi = self.local(direction);
        let shading = moments.cosines(wi.z);
        let (mut cosine, mut above) = (shading.above_horizon(), wi.z.simd_gt(L::splat(0.0)) & L::splat(1.0));
        if self.is_bent {
            let to_smooth = direction.dot(self.smooth_normal);
            let seen = moments.cosines(to_smooth).share_above();
            let share = shading.share_above() / seen.at_least(1e-6);
            cosine = cosine * (share.fast_min(L::splat(1.0)) & seen.simd_gt(L::splat(0.0)));
            above = above & to_smooth.simd_gt(L::splat(0.0));
        }
        LightsX8 { wi, spread: SpreadX8::with_slopes(inv_kappa, self.slopes), cosine, above }
    }

    /// Received lights with the cosines of their centers; zero below the horizons.
    #[inline(always)]
    pub fn lights_at_centers(&self, direction: Vec3x8<L>, inv_kappa: L) -> LightsX8<L> {
        let lights = LightsX8::spread(self.local(direction), SpreadX8::with_slopes(inv_kappa, self.slopes));
        let seen = self.receives(direction);
        LightsX8 { cosine: lights.cosine & seen, above: lights.above & seen, ..lights }
    }

    /// Mask of the directions above the horizons of both normals, as [`SurfacePoint::receives`].
    #[inline(always)]
    pub fn receives_by_both(&self, direction: Vec3x8<L>) -> L {
        direction.dot(self.axes[2]).simd_gt(L::splat(0.0)) & self.receives(direction)
    }

    /// Mask of the directions above the smooth normal's horizon.
    #[inline(always)]
    pub fn receives(&self, direction: Vec3x8<L>) -> L {
        direction.dot(self.smooth_normal).simd_gt(L::splat(0.0))
    }
}

/// A one-sided surface seen from behind reflects nothing.
#[derive(Clone, Debug)]
pub enum FirstHit {
    /// No surface.
    Background,
    /// The back of a one-sided surface.
    Back,
    /// A point to shade.
    Surface(Box<SurfacePoint>),
}

/// Looks up surface points of a dataset.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    dataset: &'a Dataset,
    appearance: &'a ResolvedAppearance,
    intersector: &'a Intersector,
    /// Largest offset in meters of shadow ray origins from a surface.
    largest_offset: f32,
    /// Camera rays' footprints, if used.
    differentials: Option<Differentials>,
}

impl<'a> Surfaces<'a> {
    /// Looks up points with the scene's current appearance.
    pub fn of(renderer: &'a Renderer) -> Self {
        Self {
            dataset: &renderer.dataset,
            appearance: &renderer.appearance,
            intersector: renderer.intersector(),
            largest_offset: renderer.largest_offset(),
            differentials: None,
        }
    }

    /// Filters maps within the footprints of camera rays. The default is point lookups.
    pub fn filtered(self, differentials: Differentials) -> Self {
        Self { differentials: Some(differentials), ..self }
    }

    /// The first hit of a ray.
    pub fn seen_along(&self, origin: Vec3, direction: Vec3) -> FirstHit {
        self.seen_at(self.hit_along(origin, direction), direction)
    }

    /// First hits of rays from one origin; see [`Intersector::closest_hits_above`].
    pub fn hits_from(
        &self,
        origin: Vec3,
        directions: &[[Vec3; 8]],
        threshold: impl Fn(usize, u32) -> f32,
    ) -> Vec<[Option<Hit>; 8]> {
        self.intersector.closest_hits_above(origin, directions, threshold)
    }

    /// First hit of a ray; thin surfaces stop it by chance.
    pub fn hit_along(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        self.intersector.closest_hit(origin, direction)
    }

    /// First hit with an opacity above a threshold.
    pub fn hit_above(&self, origin: Vec3, direction: Vec3, threshold: impl Fn(u32) -> f32) -> Option<Hit> {
        self.intersector.closest_above(origin, direction, threshold)
    }

    /// See [`Intersector::past_ground`].
    pub fn past_ground(
        &self,
        hit: Option<Hit>,
        ray: (Vec3, Vec3),
        from_above: bool,
        threshold: impl Fn(u32) -> f32,
    ) -> Option<Hit> {
        self.intersector.past_ground(&self.dataset.scene.mesh, hit, ray, from_above, threshold)
    }

    /// Share of the light that is blocked at a hit.
    pub fn opacity(&self, hit: &Hit) -> f32 {
        self.intersector.opacity_at(MeshPlace { triangle: hit.triangle, barycentric: hit.barycentric })
    }

    /// The first hit along `direction`, from a known hit of a parallel ray. Its distance is not read.
    pub fn seen_at(&self, hit: Option<Hit>, direction: Vec3) -> FirstHit {
        match hit {
            None => FirstHit::Background,
            Some(hit) if self.is_back(&hit) => FirstHit::Back,
            Some(hit) => FirstHit::Surface(Box::new(self.point(&hit, -direction))),
        }
    }

    /// Whether a hit is on the back of a one-sided surface.
    pub fn is_back(&self, hit: &Hit) -> bool {
        hit.back_face && !self.dataset.two_sided[hit.triangle as usize]
    }

    /// Index of a triangle's material.
    pub fn material(&self, triangle: u32) -> u32 {
        self.appearance.material_of(&self.dataset.scene.mesh, triangle as usize)
    }

    /// Corner positions of a triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.dataset.scene.mesh.corners(triangle as usize)
    }

    /// The surface at a ray's hit, seen from direction `wo`.
    pub fn point(&self, hit: &Hit, wo: Vec3) -> SurfacePoint {
        let mesh = &self.dataset.scene.mesh;
        let triangle = hit.triangle as usize;
        let vertices = mesh.triangles[triangle];
        let b = Vec3::new(1.0 - hit.barycentric.x - hit.barycentric.y, hit.barycentric.x, hit.barycentric.y);
        let [p0, p1, p2] = mesh.corners(triangle);
        let side = if hit.back_face { -1.0 } else { 1.0 };
        let face_normal = mesh.area_vector(triangle).normalize_or(wo) * side;
        let normal = vertices.iter().zip(b.to_array()).map(|(&v, w)| mesh.normals[v as usize] * w).sum::<Vec3>() * side;
        let smooth_normal = facing(normal.try_normalize().unwrap_or(face_normal), wo);
        let tangent = vertices.iter().zip(b.to_array()).map(|(&v, w)| mesh.tangents[v as usize].truncate() * w).sum();
        let handedness = mesh.tangents[vertices[0] as usize].w * side;
        let material_index = self.material(hit.triangle);
        let material = self.appearance.material(material_index);
        let edge = (p0.distance(p1) + p1.distance(p2) + p2.distance(p0)) / 3.0;
        let offset = offset::of_shading(edge, self.largest_offset);
        let position = p0 * b.x + p1 * b.y + p2 * b.z;
        let footprint = |set| {
            let uvs = mesh.uv_set(set);
            let uv = vertices.iter().zip(b.to_array()).map(|(&v, w)| uvs[v as usize] * w).sum::<Vec2>();
            let slopes = material.varies().then(|| surface_slopes([p0, p1, p2], vertices.map(|v| uvs[v as usize])));
            match (&self.differentials, slopes.flatten()) {
                (Some(differentials), Some(slopes)) => {
                    (differentials.at(uv, position, face_normal, slopes), Some(slopes))
                }
                (_, slopes) => (uv.into(), slopes),
            }
        };
        let first = footprint(UvSet::First);
        let second = if material.reads_second_uvs() { footprint(UvSet::Second) } else { first };
        let color = if material.reads_vertex_colors() { mesh.color(vertices, b.to_array()) } else { Vec3::ONE };
        let attributes = SurfaceAttributes { uv: [first.0, second.0], color };
        let slopes = [first.1, second.1];
        let place = SurfacePlace { position, smooth_normal, tangent, handedness, attributes, slopes };
        let PlaceLook { world_from_local, wo, slopes, material: look } = place.under(self.appearance, material, wo);
        SurfacePoint {
            material: material_index,
            triangle: hit.triangle,
            vertices,
            corners: [p0, p1, p2],
            barycentric: b,
            weights: self.dataset.interpolation_weights(vertices, hit.barycentric),
            from_behind: hit.back_face,
            position,
            ray_origin: position + face_normal * offset,
            face_normal,
            smooth_normal,
            world_from_local,
            wo,
            base_color: look.base_color,
            roughness: look.roughness,
            brdf: look.brdf,
            emission: look.emission,
            slopes,
            by_cone: 0.0,
            is_catcher: false,
            ground: None,
        }
    }
}

/// Gradients of u and v along a triangle: the surface gradient of a function is `per_u ∂f/∂u + per_v ∂f/∂v`. `None` if the texture
/// coordinates are degenerate.
fn surface_slopes([a, b, c]: [Vec3; 3], uv: [Vec2; 3]) -> Option<[Vec3; 2]> {
    let (e1, e2) = (b - a, c - a);
    let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
    let n = e1.cross(e2);
    let area_sq = n.length_squared();
    if !(area_sq > 0.0) {
        return None;
    }
    // Gradients of the barycentric weights of b and c.
    let (gb, gc) = (e2.cross(n) / area_sq, n.cross(e1) / area_sq);
    let per_u = gb * d1.x + gc * d2.x;
    let per_v = gb * d1.y + gc * d2.y;
    (per_u.is_finite() && per_v.is_finite()).then_some([per_u, per_v])
}

/// The normal, bent just enough to face the eye: interpolation and bump maps can turn it away at silhouettes.
fn facing(normal: Vec3, wo: Vec3) -> Vec3 {
    const LEAST_COS: f32 = 0.02;
    let cos = normal.dot(wo);
    if cos >= LEAST_COS { normal } else { (normal + wo * (LEAST_COS - cos)).normalize() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_invert_the_parametrisation() {
        let corners = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 0.0), Vec3::new(1.0, 0.0, -4.0)];
        let uv = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
        let [per_u, per_v] = surface_slopes(corners, uv).unwrap();
        assert!((per_u - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-6);
        assert!((per_v - Vec3::new(0.0, 0.0, -0.25)).length() < 1e-6);
        assert!(surface_slopes([Vec3::ZERO; 3], uv).is_none());
    }

    #[test]
    fn normals_that_turn_away_are_bent_to_the_eye() {
        let wo = Vec3::Z;
        assert_eq!(facing(Vec3::Z, wo), Vec3::Z);
        let bent = facing(Vec3::new(1.0, 0.0, -0.2).normalize(), wo);
        assert!(bent.dot(wo) > 0.015 && bent.x > 0.99);
    }
}
