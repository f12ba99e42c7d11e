//! Rays that are traced elsewhere than on the cores of this machine.

use super::{HalfSpace, Intersector};
use glam::Vec3;

/// A node of the hierarchy of boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxNode {
    /// Smallest corner of its box in meters, a little widened.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
    /// First triangle of a leaf, or first of two children side by side.
    pub first: u32,
    /// Triangles of a leaf; 0 for other nodes.
    pub triangles: u32,
}

/// Where rays start, and in which directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayOrigin {
    /// Place in meters, off any surface.
    pub origin: Vec3,
    /// The directions that count.
    pub half: HalfSpace,
}

/// A scene and a set of directions on some device.
pub trait RayDevice: Sync {
    /// For each origin a row of words of 32 bits: the bit of a direction is set if it counts and meets nothing. The same as
    /// [`Intersector::trace_batch`] but for rays along edges, where a device may round otherwise.
    ///
    /// # Errors
    /// What is wrong with the device, in words.
    fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String>;
}

/// Something that can trace rays.
pub trait RayDevices: Sync {
    /// Takes a scene and unit directions to the device; `None` leaves them to the cores.
    ///
    /// # Errors
    /// What is too large or wrong, in words.
    fn device(&self, scene: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn RayDevice>>, String>;
}

impl Intersector {
    /// The hierarchy, its root first, and the corners of the triangles in the order of its leaves.
    pub fn hierarchy(&self) -> (Vec<BoxNode>, &[[Vec3; 3]]) {
        let node = |node: &obvhs::bvh2::node::Bvh2Node| BoxNode {
            min: node.aabb.min.into(),
            max: node.aabb.max.into(),
            first: node.first_index,
            triangles: node.prim_count,
        };
        (self.bvh.nodes.iter().map(node).collect(), &self.leaf_triangles)
    }
}
