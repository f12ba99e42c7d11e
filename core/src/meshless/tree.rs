//! Range queries: a tree over the boxes of the functions' supports finds the functions of a level that reach a point.

use super::distance::{SQUASH, kernel, same_layer};
use crate::surfel::Surfel;
use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
};

/// Factor of the squared height above a point's plane that is added to its squared distance.
const STRETCH: f32 = (1.0 + SQUASH) * (1.0 + SQUASH) - 1.0;

/// Range queries over the functions of one level.
#[derive(Clone)]
pub(super) struct LevelTree {
    bvh: Bvh2,
    /// Functions in the order of the leaves.
    functions: Vec<Function>,
    radius: f32,
}

#[derive(Clone, Copy)]
struct Function {
    position: Vec3,
    index: u32,
    normal: Vec3,
}

impl LevelTree {
    /// A tree over `points`, the first of which is function `first` of the basis.
    pub fn new(points: &[Surfel], first: u32, radius: f32) -> Self {
        let boxes: Vec<Aabb> = points.iter().map(|p| support_box(p, radius)).collect();
        let bvh = match boxes.is_empty() {
            true => Bvh2::default(),
            false => build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut std::time::Duration::default()),
        };
        let function = |&i: &u32| {
            let point = &points[i as usize];
            Function { position: point.position, index: first + i, normal: point.normal }
        };
        let functions = bvh.primitive_indices.iter().map(function).collect();
        Self { bvh, functions, radius }
    }

    /// Appends all functions whose weight at a point is not zero, with that weight (meshless paper, Eq. 8 and 9,
    /// reduced between layers).
    #[inline]
    pub fn weights(&self, position: Vec3, normal: Vec3, out: &mut Vec<(u32, f32)>) {
        self.bvh.point_traverse(position.into(), |bvh, node| {
            let node = &bvh.nodes[node as usize];
            let first = node.first_index as usize;
            for function in &self.functions[first..first + node.prim_count as usize] {
                let (facing, offset) = (normal.dot(function.normal), position - function.position);
                let height = offset.dot(function.normal);
                // Eq. 10, squared: most functions of a leaf are rejected here, without a square root.
                let distance_sq = offset.length_squared() + STRETCH * height * height;
                if facing > 0.0 && distance_sq < self.radius * self.radius {
                    let near = kernel(distance_sq.sqrt() / self.radius);
                    let layer = same_layer(offset, normal + function.normal, self.radius);
                    let weight = near * layer * facing * facing;
                    if weight > 0.0 {
                        out.push((function.index, weight));
                    }
                }
            }
            true
        });
    }
}

/// The box around the ellipsoid that a function reaches, enlarged by more than rounding.
fn support_box(point: &Surfel, radius: f32) -> Aabb {
    const SLACK: f32 = 1e-4;
    let along = point.normal * point.normal;
    let thinness = (1.0 + SQUASH).powi(-2);
    let squares = (Vec3::ONE - along).max(Vec3::ZERO) + along * thinness;
    let half = Vec3A::from(squares.to_array().map(f32::sqrt)) * radius + radius * SLACK;
    let center = Vec3A::from(point.position);
    Aabb::new(center - half, center + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sphere::uniform_direction, test_scenes::sphere_points};

    #[test]
    fn the_tree_finds_what_brute_force_finds() {
        let points = sphere_points(500, 1.0);
        let tree = LevelTree::new(&points, 7, 0.4);
        let mut random = fastrand::Rng::with_seed(1);
        let mut seen = 0;
        for _ in 0..500 {
            let normal = uniform_direction(random.f32(), random.f32());
            let position = normal * (0.85 + 0.3 * random.f32());
            let mut found = Vec::new();
            tree.weights(position, normal, &mut found);
            for (i, p) in points.iter().enumerate() {
                let offset = position - p.position;
                let distance = (offset + SQUASH * offset.dot(p.normal) * p.normal).length();
                let step = 4.0 * offset.dot(p.normal + normal).abs() / 0.4;
                let weight =
                    kernel(distance / 0.4) * (0.02 + 0.98 * kernel(step)) * normal.dot(p.normal).max(0.0).powi(2);
                let in_tree = found.iter().find(|f| f.0 == i as u32 + 7).map_or(0.0, |f| f.1);
                assert!((weight - in_tree).abs() < 1e-5, "{weight} and {in_tree} at {position}");
                seen += usize::from(weight > 1e-4);
            }
        }
        assert!(seen > 1000);
    }

    #[test]
    fn layers_close_behind_each_other_hardly_mix_and_a_lone_one_reaches_as_far_as_before() {
        let layer = |y: f32| Surfel { position: Vec3::Y * y, ..Default::default() };
        let share_of_back = |gap: f32| {
            let tree = LevelTree::new(&[layer(0.0), layer(-gap)], 0, 1.0);
            let mut found = Vec::new();
            tree.weights(Vec3::X * 0.2, Vec3::Y, &mut found);
            let sum: f32 = found.iter().map(|f| f.1).sum();
            found.iter().find(|f| f.0 == 1).map_or(0.0, |f| f.1 / sum)
        };
        assert!(share_of_back(0.15) < 0.02 && share_of_back(0.005) > 0.45, "{}", share_of_back(0.15));
        assert!(
            kernel((0.04_f32 + 0.15 * 0.15 * 9.0).sqrt()) / kernel(0.2) > 0.5,
            "negative control: it is within reach"
        );
        let mut reached = Vec::new();
        LevelTree::new(&[layer(0.0)], 0, 1.0).weights(Vec3::Y * 0.3, Vec3::Y, &mut reached);
        assert!(reached.len() == 1 && reached[0].1 > 0.0);
    }

    #[test]
    fn an_empty_level_reaches_nothing() {
        let mut found = Vec::new();
        LevelTree::new(&[], 0, 1.0).weights(Vec3::ZERO, Vec3::Y, &mut found);
        assert!(found.is_empty());
    }
}
