//! The foliage: an isosurface of a sampled volume, found by marching through its cells and bisection.

use crate::aggregate::passes;
use glam::{IVec3, Vec3};
use lapidary_core::{
    bounds::Bounds,
    sphere::fibonacci_direction,
    surfel::{MeshPlace, Surface, Surfel},
};

/// Samples along each edge of the volume.
const SIZE: i32 = 56;
/// Density at the surface.
const LEVEL: f32 = 0.5;

/// Where the density of a volume crosses [`LEVEL`].
pub struct Isosurface {
    densities: Vec<f32>,
    bounds: Bounds,
}

impl Isosurface {
    /// Clumps of leaves on a stem.
    pub fn foliage() -> Self {
        let bounds = Bounds { min: Vec3::new(-0.5, 0.55, -0.8), max: Vec3::new(0.5, 1.55, 0.2) };
        let center = Vec3::new(0.0, 1.12, -0.3);
        let clumps: Vec<Vec3> = (0..14).map(|i| center + 0.24 * fibonacci_direction(i, 14)).collect();
        let density = |p: Vec3| {
            let clump = |c: &Vec3| (-p.distance_squared(*c) / 0.006).exp();
            let stem = Vec3::new(p.x, 0.0, p.z + 0.3).length_squared() / 0.001;
            let below = if p.y < center.y { (-stem).exp() } else { 0.0 };
            clumps.iter().map(clump).sum::<f32>() + 1.2 * below
        };
        let at = |i: i32| IVec3::new(i % SIZE, i / SIZE % SIZE, i / SIZE / SIZE).as_vec3() / (SIZE - 1) as f32;
        let extent = bounds.max - bounds.min;
        let densities = (0..SIZE * SIZE * SIZE).map(|i| density(bounds.min + at(i) * extent)).collect();
        Self { densities, bounds }
    }

    /// Trilinear density; zero outside.
    fn density(&self, position: Vec3) -> f32 {
        let cell = (position - self.bounds.min) / (self.bounds.max - self.bounds.min) * (SIZE - 1) as f32;
        let first = cell.floor().as_ivec3();
        let within = cell - first.as_vec3();
        let sample = |corner: IVec3| {
            let at = first + corner;
            let inside = at.min_element() >= 0 && at.max_element() < SIZE;
            if inside { self.densities[(at.x + SIZE * (at.y + SIZE * at.z)) as usize] } else { 0.0 }
        };
        let mut sum = 0.0;
        for i in 0..8 {
            let corner = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
            let weights = Vec3::ONE - (within - corner.as_vec3()).abs();
            sum += sample(corner) * weights.x * weights.y * weights.z;
        }
        sum
    }

    fn cell(&self) -> f32 {
        (self.bounds.max.x - self.bounds.min.x) / (SIZE - 1) as f32
    }

    fn normal(&self, at: Vec3) -> Vec3 {
        let step = self.cell();
        let slope = |axis: Vec3| self.density(at - step * axis) - self.density(at + step * axis);
        Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y)
    }

    /// The part of a ray inside the volume.
    fn stretch(&self, origin: Vec3, direction: Vec3) -> [f32; 2] {
        let [a, b] = [self.bounds.min, self.bounds.max].map(|plane| (plane - origin) / direction);
        [a.min(b).max_element().max(0.0), a.max(b).min_element()]
    }

    /// The crossing between two distances along a ray, the first of which lies outside.
    fn bisect(&self, origin: Vec3, direction: Vec3, mut outside: f32, mut inside: f32) -> Vec3 {
        for _ in 0..16 {
            let middle = 0.5 * (outside + inside);
            if self.density(origin + middle * direction) > LEVEL { inside = middle } else { outside = middle }
        }
        origin + outside * direction
    }
}

impl Surface for Isosurface {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        let [mut distance, end] = self.stretch(origin, direction);
        let step = 0.5 * self.cell();
        while distance < end {
            let next = distance + step;
            if self.density(origin + next * direction) > LEVEL {
                let position = self.bisect(origin, direction, distance, next);
                return Some(Surfel { position, normal: self.normal(position), place: MeshPlace::default() });
            }
            distance = next;
        }
        None
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        passes(self, from, to)
    }

    fn reflectance(&self, _: &Surfel) -> Vec3 {
        Vec3::new(0.2, 0.5, 0.12)
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }
}
