//! The bins of the paper: texels of a cube around a node, fixed to the world (implicit visibility, 4.2.2).

use glam::{Vec2, Vec3};

/// Six faces of `side` x `side` texels. The paper takes 8, 12 and 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CubeBins {
    /// Texels along an edge.
    pub side: usize,
}

impl CubeBins {
    /// Number of texels.
    pub const fn len(self) -> usize {
        6 * self.side * self.side
    }

    /// Whether there are no texels.
    pub const fn is_empty(self) -> bool {
        self.side == 0
    }

    /// The texel of a direction that is not zero: +X, -X, +Y, -Y, +Z, -Z, row by row.
    pub fn texel_of(self, direction: Vec3) -> usize {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let across = Vec2::new(direction[(axis + 1) % 3], direction[(axis + 2) % 3]) / size[axis];
        let place = ((0.5 + 0.5 * across) * self.side as f32).as_uvec2().min(glam::UVec2::splat(self.side as u32 - 1));
        let face = 2 * axis + usize::from(direction[axis] < 0.0);
        (face * self.side + place.y as usize) * self.side + place.x as usize
    }

    /// The unit direction at the middle of a texel.
    pub fn direction_of(self, texel: usize) -> Vec3 {
        self.middle(texel).normalize()
    }

    /// Solid angle of a texel in steradians, from its middle.
    pub fn solid_angle(self, texel: usize) -> f32 {
        let step = 2.0 / self.side as f32;
        step * step / self.middle(texel).length().powi(3)
    }

    /// Center of a texel on the cube of half-width 1.
    fn middle(self, texel: usize) -> Vec3 {
        let (face, row, column) = (texel / (self.side * self.side), texel / self.side % self.side, texel % self.side);
        let across = |i: usize| (2 * i + 1) as f32 / self.side as f32 - 1.0;
        let axis = face / 2;
        let mut place = Vec3::ZERO;
        place[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
        place[(axis + 1) % 3] = across(column);
        place[(axis + 2) % 3] = across(row);
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::{SPHERE, uniform_direction};

    #[test]
    fn texels_share_the_sphere() {
        for side in [8, 12, 16] {
            let bins = CubeBins { side };
            assert!((0..bins.len()).all(|texel| bins.texel_of(bins.direction_of(texel)) == texel));
            let whole: f32 = (0..bins.len()).map(|texel| bins.solid_angle(texel)).sum();
            assert!((whole / SPHERE - 1.0).abs() < 5e-3, "{whole}");
            let [middle, corner] = [Vec3::new(1.0, 0.01, 0.01), Vec3::splat(1.0) - Vec3::Y * 1e-3];
            let ratio = bins.solid_angle(bins.texel_of(middle)) / bins.solid_angle(bins.texel_of(corner));
            assert!(ratio > 3.0, "uneven, as 5.1 says: {ratio}");
        }
    }

    #[test]
    fn a_direction_lies_near_the_middle_of_its_texel() {
        let bins = CubeBins { side: 12 };
        let mut rng = fastrand::Rng::with_seed(1);
        for _ in 0..1000 {
            let direction = uniform_direction(rng.f32(), rng.f32());
            assert!(bins.direction_of(bins.texel_of(direction)).distance(direction) < 0.13);
        }
    }
}
