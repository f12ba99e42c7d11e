//! What mirrors show: light of all kinds of the surfaces along a ray, and the map where there is none.
//!
//! Each sample of a picture has a ray, drawn from the sharp lobes, and a second for surfaces where wider lobes need one, see
//! [`RayLobes`]. The picture's samples together show the lobes' width. What rays of neighboring samples meet may lie far apart: the
//! lobes there are widened by the [cone] of each.

pub(crate) mod cone;

use crate::{
    light::mirrored_map::MirroredMap,
    shade::{
        merge::SharpLight,
        mirror::{
            Mirror,
            rays::{RayLobes, up_to},
        },
        seen_scene::SeenScene,
        surface::{FirstHit, SurfacePoint},
    },
};
use cone::{CameraCones, RayCone, curvature};
use glam::{Vec2, Vec3};
use lapidary_core::opacity::chance;

/// Mirrors that a ray may meet one after the other: the last shows light as baked.
pub(crate) const DEEPEST: u32 = 2;

/// Step between the numbers of one mirror and of a mirror in it.
const OF_NEXT: Vec2 = Vec2::new(0.618_034, 0.381_966);

/// Step between the numbers of the first ray and of the second.
const OF_SECOND: Vec2 = Vec2::new(0.381_966, 0.618_034);

/// Light of all kinds from a point toward a mirror, with the numbers that choose its rays.
type Light<'l> = dyn FnMut(&SurfacePoint, SharpLight, Vec2) -> Vec3 + 'l;

/// The scene that mirrors show.
#[derive(Clone, Copy)]
pub(crate) struct Mirrors<'a> {
    pub scene: SeenScene<'a>,
    /// The map around the scene, if it is shown.
    pub map: Option<&'a MirroredMap>,
    /// Solid angle of a light sample in steradians, which decides what is sharp.
    pub leaf_solid_angle: f32,
    /// Most light of a surface that rays of wider lobes show, as a luminance.
    pub brightest: f32,
    /// Of the camera's rays.
    pub cones: CameraCones,
}

impl Mirrors<'_> {
    /// Light that does not come along these rays.
    pub fn sharp(&self) -> SharpLight {
        SharpLight::Rays { leaf_solid_angle: self.leaf_solid_angle, of_surfaces: true, brightest: self.brightest }
    }

    /// What sharp lobes at a point show along a ray, which `shift` chooses. `light` gives light of all kinds from a point, where
    /// [`SharpLight::Rays`] leaves out what mirrors show there.
    pub fn shown(&self, point: &SurfacePoint, shift: Vec2, light: &mut Light) -> Vec3 {
        let [reflected, hidden] = self.over_ground(point, shift, light);
        let shown = self.shown_within(0, (point, self.cones.to(point.position)), shift, light);
        shown + self.by_second_ray(point, shift, light) + reflected - hidden
    }

    /// What wider lobes show of surfaces, whose light is as baked.
    fn by_second_ray(&self, point: &SurfacePoint, shift: Vec2, light: &mut Light) -> Vec3 {
        let lobes = RayLobes::at(point, self.leaf_solid_angle);
        let numbers = (shift + OF_SECOND).fract();
        let Some((direction, weight)) = lobes.and_then(|lobes| lobes.second_ray(point, numbers.to_array())) else {
            return Vec3::ZERO;
        };
        let width = lobes.map_or(0.0, |lobes| lobes.width());
        let seen = (point, self.cones.to(point.position));
        match self.met(seen, width, direction, numbers).0 {
            FirstHit::Surface(shown) => weight * up_to(self.brightest, light(&shown, SharpLight::Map, shift)),
            FirstHit::Back | FirstHit::Background => Vec3::ZERO,
        }
    }

    /// Light that a ground that catches shadows reflects of the scene, and the light there that this reflection hides.
    pub fn over_ground(&self, point: &SurfacePoint, shift: Vec2, light: &mut Light) -> [Vec3; 2] {
        let ground = point.ground.as_deref().map(|ground| (ground, self.cones.to(point.position)));
        match ground.and_then(|seen| self.ray(seen, shift)) {
            Some(Ray { weight, meets: FirstHit::Surface(shown), cone, .. }) => {
                let hidden = weight.min(Vec3::ONE) * light(point, SharpLight::Map, shift);
                [weight * self.light_of_surface(1, (&shown, cone), shift, light), hidden]
            }
            _ => [Vec3::ZERO; 2],
        }
    }

    /// What mirrors show within a number of mirrors, of a point that a ray with this cone meets.
    fn shown_within(&self, mirrors: u32, seen: Seen, shift: Vec2, light: &mut Light) -> Vec3 {
        let Some(Ray { mirror, weight, meets, cone }) = self.ray(seen, shift) else { return Vec3::ZERO };
        match meets {
            FirstHit::Background => self.map.map_or(Vec3::ZERO, |map| mirror.of_map(seen.0, map)),
            FirstHit::Back => Vec3::ZERO,
            FirstHit::Surface(shown) => weight * self.light_of_surface(mirrors + 1, (&shown, cone), shift, light),
        }
    }

    /// Light of a surface within a number of mirrors, with what its own mirrors show.
    fn light_of_surface(&self, mirrors: u32, seen: Seen, shift: Vec2, light: &mut Light) -> Vec3 {
        if mirrors == DEEPEST {
            return light(seen.0, SharpLight::Map, shift);
        }
        let next = (shift + OF_NEXT).fract();
        light(seen.0, self.sharp().of_environment(), shift) + self.shown_within(mirrors, seen, next, light)
    }

    /// A ray along the sharp lobes of a point, if there are any.
    fn ray(&self, seen: Seen, shift: Vec2) -> Option<Ray> {
        let mirror = Mirror::at(seen.0, self.leaf_solid_angle)?;
        let (direction, weight) = mirror.ray(seen.0, shift.to_array())?;
        let (meets, cone) = self.met(seen, mirror.width(), direction, shift);
        Some(Ray { mirror, weight, meets, cone })
    }

    /// What a ray from a point meets, from a lobe of this width, and its cone there; the numbers choose which thin surfaces it passes.
    fn met(&self, (point, cone): Seen, lobe: f32, direction: Vec3, numbers: Vec2) -> (FirstHit, RayCone) {
        let ray = (point.ray_origin, above(point.face_normal, direction));
        let [x, y] = numbers.to_array().map(f32::to_bits);
        let mut meets = self.scene.mirrored(ray, |triangle| chance(&[x, y, triangle]));
        let FirstHit::Surface(shown) = &mut meets else { return (meets, cone) };
        let mesh = self.scene.mesh;
        let cone = cone.mirrored(curvature(mesh, point), lobe, point.position.distance(shown.position));
        if !shown.is_catcher {
            shown.by_cone = cone.slopes(curvature(mesh, shown));
        }
        (meets, cone)
    }
}

/// A point, and the cone of the ray that meets it.
type Seen<'s> = (&'s SurfacePoint, RayCone);

/// A ray of a mirror.
struct Ray {
    mirror: Mirror,
    /// Weight of the light along it.
    weight: Vec3,
    meets: FirstHit,
    /// Where it meets a surface.
    cone: RayCone,
}

/// A direction, bent just enough to leave a face: interpolated normals mirror some directions into it.
fn above(face_normal: Vec3, direction: Vec3) -> Vec3 {
    const LEAST_COS: f32 = 1e-3;
    let cos = direction.dot(face_normal);
    if cos >= LEAST_COS { direction } else { (direction + face_normal * (LEAST_COS - cos)).normalize() }
}

#[cfg(test)]
mod tests;
