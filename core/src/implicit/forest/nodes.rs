//! The nodes of a forest: bounds of the discs below them, four children side by side.

use super::quadtrees::CHILDREN;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::f32::consts::PI;

/// An oriented disc that represents a piece of surface (implicit visibility, 4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disc {
    /// Center in meters.
    pub position: Vec3,
    /// Unit normal on the visible side.
    pub normal: Vec3,
    /// Area in m².
    pub area: f32,
}

impl Disc {
    /// Radius in meters.
    pub fn radius(&self) -> f32 {
        (self.area / PI).sqrt()
    }
}

/// Squared sine below which directions count as one: rounding of a normal must not widen what is flat.
pub(crate) const FLAT: f32 = 1e-6;

/// Bounds and means of the discs below a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// Mean of the centers weighted by area, in meters.
    pub center: Vec3,
    /// Unit mean of the normals weighted by area.
    pub axis: Vec3,
    /// Length of the mean normal before normalization: 1 if all discs face alike, 0 for a closed surface.
    pub coherence: f32,
    /// Total area in m²; 0 for an empty slot.
    pub area: f32,
    /// Radius of the ball around the center that contains all discs, in meters.
    pub radius: f32,
    /// Largest distance of a disc from the plane through the center at right angles to the axis, in meters.
    pub thickness: f32,
    /// Cosine of the half-angle of the cone around the axis that contains all normals; 0 for a half-space or more.
    pub cone_cos: f32,
    /// Sine of that angle; 1 for a half-space or more.
    pub cone_sin: f32,
}

impl Node {
    /// The node of some discs.
    pub fn around(discs: &[Disc]) -> Self {
        let area: f32 = discs.iter().map(|d| d.area).sum();
        if !(area > 0.0) {
            return Self::default();
        }
        let center = discs.iter().map(|d| d.position * d.area).sum::<Vec3>() / area;
        let mean = discs.iter().map(|d| d.normal * d.area).sum::<Vec3>() / area;
        let axis = mean.try_normalize().unwrap_or(discs[0].normal);
        let node = Self { center, axis, coherence: mean.length().min(1.0), area, ..Self::default() };
        let least_cos = discs.iter().map(|d| d.normal.dot(axis)).fold(1.0, f32::min);
        let (cone_cos, cone_sin) = cone(least_cos);
        let reaching = discs.iter().fold(node, |node, disc| node.reaching(disc));
        Self { cone_cos, cone_sin, ..reaching }
    }

    /// The node with radius and thickness extended to contain a disc.
    fn reaching(self, disc: &Disc) -> Self {
        let (offset, radius) = (disc.position - self.center, disc.radius());
        let height = offset.dot(self.axis).abs() + radius * sine(disc.normal.dot(self.axis));
        Self { radius: self.radius.max(offset.length() + radius), thickness: self.thickness.max(height), ..self }
    }
}

/// Cosine and sine of the half-angle of a cone.
fn cone(least_cos: f32) -> (f32, f32) {
    match sine(least_cos) {
        _ if !(least_cos > 0.0) => (0.0, 1.0),
        0.0 => (1.0, 0.0),
        sin => (least_cos, sin),
    }
}

fn sine(cos: f32) -> f32 {
    let sin_sq = 1.0 - cos * cos;
    if sin_sq > FLAT { sin_sq.sqrt() } else { 0.0 }
}

/// Numbers of four nodes.
pub type Four = [f32; CHILDREN];

/// Four children of a node in structure-of-arrays layout: 208 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Block {
    /// x, y, z of [`Node::center`].
    pub center: [Four; 3],
    /// x, y, z of [`Node::axis`].
    pub axis: [Four; 3],
    /// [`Node::coherence`].
    pub coherence: Four,
    /// [`Node::area`].
    pub area: Four,
    /// [`Node::radius`].
    pub radius: Four,
    /// [`Node::thickness`].
    pub thickness: Four,
    /// [`Node::cone_cos`].
    pub cone_cos: Four,
    /// [`Node::cone_sin`].
    pub cone_sin: Four,
    /// The block with the children of each node; 0 for leaves and empty slots, as the first block holds a root.
    pub below: [u32; CHILDREN],
}

impl Block {
    /// Writes a node into a slot.
    pub fn set(&mut self, slot: usize, node: &Node) {
        for i in 0..3 {
            self.center[i][slot] = node.center[i];
            self.axis[i][slot] = node.axis[i];
        }
        self.coherence[slot] = node.coherence;
        self.area[slot] = node.area;
        self.radius[slot] = node.radius;
        self.thickness[slot] = node.thickness;
        self.cone_cos[slot] = node.cone_cos;
        self.cone_sin[slot] = node.cone_sin;
    }

    /// The node in a slot.
    pub fn get(&self, slot: usize) -> Node {
        let vector = |of: &[Four; 3]| Vec3::from_array(of.map(|component| component[slot]));
        Node {
            center: vector(&self.center),
            axis: vector(&self.axis),
            coherence: self.coherence[slot],
            area: self.area[slot],
            radius: self.radius[slot],
            thickness: self.thickness[slot],
            cone_cos: self.cone_cos[slot],
            cone_sin: self.cone_sin[slot],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sphere::frame_around, test_scenes::sphere_points};

    fn sphere(n: usize) -> Vec<Disc> {
        let area = 4.0 * PI / n as f32;
        sphere_points(n, 1.0).iter().map(|s| Disc { position: s.position, normal: s.normal, area }).collect()
    }

    #[test]
    fn a_flat_node_has_no_thickness_and_no_cone_whatever_way_it_faces() {
        for normal in [Vec3::Y, Vec3::new(0.3, -0.5, 0.7).normalize()] {
            let frame = frame_around(normal);
            let disc =
                |i: u32| Disc { position: frame * Vec3::new((i % 8) as f32, (i / 8) as f32, 0.0), normal, area: 1.0 };
            let node = Node::around(&(0..64).map(disc).collect::<Vec<_>>());
            assert!(node.thickness < 1e-5 && node.cone_sin == 0.0 && node.coherence > 0.9999);
            assert!((node.radius - (3.5 * 2.0_f32.sqrt() + PI.sqrt().recip())).abs() < 1e-4 && node.area == 64.0);
        }
    }

    #[test]
    fn a_sphere_faces_nowhere() {
        let node = Node::around(&sphere(1000));
        assert!(node.coherence < 1e-3 && (node.cone_cos, node.cone_sin) == (0.0, 1.0));
        assert!((node.area - 4.0 * PI).abs() < 1e-3 && node.center.length() < 1e-3);
    }

    #[test]
    fn all_that_is_below_a_node_lies_within_its_bounds() {
        let discs: Vec<Disc> = sphere(400).into_iter().filter(|d| d.normal.y > 0.6).collect();
        let node = Node::around(&discs);
        for disc in &discs {
            let offset = disc.position - node.center;
            assert!(offset.length() + disc.radius() <= node.radius * 1.0001);
            assert!(offset.dot(node.axis).abs() <= node.thickness * 1.0001);
            assert!(disc.normal.dot(node.axis) >= node.cone_cos - 1e-5);
        }
        assert!(
            node.thickness < 0.5 && node.radius > 0.7 && node.cone_cos > 0.5,
            "and these are no larger than needed"
        );
    }

    #[test]
    fn blocks_give_back_their_nodes_and_empty_slots_have_no_area() {
        let node = Node::around(&sphere(10));
        let mut block = Block::default();
        block.set(2, &node);
        assert_eq!((block.get(2), block.get(1)), (node, Node::default()));
        assert_eq!(size_of::<Block>(), 208);
    }
}
