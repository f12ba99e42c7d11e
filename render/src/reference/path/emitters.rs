//! Emissive surfaces, sampled by the power of their materials' constants.

use crate::{
    appearance::Appearance,
    shade::surface::{FirstHit, Surfaces},
};
use glam::{Vec2, Vec3};
use lapidary_core::{brdf::SurfaceParameters, color::luminance, ray::Hit, scene::Mesh};

/// Emissive triangles of a scene.
pub struct Emitters {
    triangles: Vec<u32>,
    /// Running sums of area times luminance.
    running: Vec<f64>,
    /// Luminance of each material's constants.
    luminance: Vec<f32>,
}

/// A point of an emissive surface, seen from another point.
pub struct EmitterSample {
    /// Unit direction to it.
    pub direction: Vec3,
    /// Distance in meters.
    pub distance: f32,
    /// Radiance toward the other point.
    pub radiance: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
}

impl Emitters {
    /// Finds the emitters of a mesh with the materials of `appearance`.
    pub fn new(mesh: &Mesh, appearance: &Appearance) -> Self {
        let of = |parameters| luminance(SurfaceParameters::from(parameters).emission());
        let luminance: Vec<f32> = appearance.materials.iter().map(|m| of(&m.parameters)).collect();
        let (mut triangles, mut running, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for triangle in 0..mesh.triangles.len() {
            let material = appearance.material_of(mesh, triangle);
            let area = 0.5 * mesh.area_vector(triangle).length();
            let power = f64::from(area * luminance[material as usize]);
            if power > 0.0 {
                sum += power;
                triangles.push(triangle as u32);
                running.push(sum);
            }
        }
        Self { triangles, running, luminance }
    }

    /// Whether there are no emitters.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A point from three numbers in [0, 1), seen from `origin`; `None` if it sends no light there.
    pub fn sample(&self, surfaces: &Surfaces, mesh: &Mesh, origin: Vec3, u: Vec3) -> Option<EmitterSample> {
        let target = f64::from(u.x) * self.running.last()?;
        let chosen = self.running.partition_point(|&sum| sum <= target).min(self.triangles.len() - 1);
        let triangle = self.triangles[chosen];
        let root = u.y.sqrt();
        let barycentric = Vec2::new(root * (1.0 - u.z), root * u.z);
        let [a, b, c] = mesh.corners(triangle as usize);
        let position = a + (b - a) * barycentric.x + (c - a) * barycentric.y;
        let to_light = position - origin;
        let distance = to_light.length();
        let direction = to_light / distance;
        let normal = mesh.area_vector(triangle as usize).normalize_or_zero();
        let hit = Hit { triangle, distance, barycentric, back_face: normal.dot(direction) > 0.0 };
        let FirstHit::Surface(point) = surfaces.seen_at(Some(hit), direction) else { return None };
        let pdf = self.pdf(point.material, distance, normal.dot(direction));
        (pdf > 0.0 && pdf.is_finite()).then_some(EmitterSample {
            direction,
            distance,
            radiance: point.emission * surfaces.opacity(&hit),
            pdf,
        })
    }

    /// Density per solid angle of [`Self::sample`], for a point of a material at this distance in meters, with this cosine between
    /// normal and direction.
    pub fn pdf(&self, material: u32, distance: f32, cosine: f32) -> f32 {
        let per_area = self.luminance[material as usize] / self.running.last().map_or(1.0, |&sum| sum as f32);
        per_area * distance * distance / cosine.abs()
    }
}
