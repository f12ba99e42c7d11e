//! Eight vectors at once, for evaluating BRDFs on the nodes of a merged cut.

use glam::Vec3;
use std::ops::{Add, Mul, Sub};
use wide::f32x8;

/// Eight 3D vectors, component by component.
#[derive(Clone, Copy, Debug)]
pub struct Vec3x8 {
    /// X components.
    pub x: f32x8,
    /// Y components.
    pub y: f32x8,
    /// Z components.
    pub z: f32x8,
}

impl Vec3x8 {
    /// The same vector eight times.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: f32x8::splat(v.x), y: f32x8::splat(v.y), z: f32x8::splat(v.z) }
    }

    /// Eight vectors.
    #[inline(always)]
    pub fn from_array(v: [Vec3; 8]) -> Self {
        Self { x: f32x8::new(v.map(|v| v.x)), y: f32x8::new(v.map(|v| v.y)), z: f32x8::new(v.map(|v| v.z)) }
    }

    /// One of the eight.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Vec3 {
        Vec3::new(self.x.to_array()[i], self.y.to_array()[i], self.z.to_array()[i])
    }

    /// Dot products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Cross products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Component-wise product, as for colours.
    #[inline(always)]
    pub fn scale(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// The sum of the eight.
    #[inline(always)]
    pub fn reduce_add(self) -> Vec3 {
        Vec3::new(self.x.reduce_add(), self.y.reduce_add(), self.z.reduce_add())
    }
}

impl Add for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Mul<f32x8> for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32x8) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
