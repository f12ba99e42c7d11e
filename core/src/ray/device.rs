//! Rays traced on other devices than this machine's CPU.

use super::{HalfSpace, Intersector};
use glam::Vec3;

/// A node of the hierarchy of boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxNode {
    /// Smallest corner of its box in meters, slightly widened.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
    /// First triangle of a leaf, or first of two children side by side.
    pub first: u32,
    /// Triangles of a leaf; 0 for other nodes.
    pub triangles: u32,
}

/// Origin of rays, and their directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayOrigin {
    /// Place in meters, off any surface.
    pub origin: Vec3,
    /// The half-space of directions that count.
    pub half: HalfSpace,
}

/// A scene and a set of directions on a device.
pub trait RayDevice: Sync {
    /// For each origin a row of 32-bit words: the bit of a direction is set if it counts and is unblocked. Equals
    /// [`Intersector::trace_batch`] except for rays along edges, where a device may round differently.
    ///
    /// # Errors
    /// A description of the device's failure.
    fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String>;
}

/// A provider of ray tracing devices.
pub trait RayDevices: Sync {
    /// Uploads a scene and unit directions to a device; `None` leaves the rays to the CPU.
    ///
    /// # Errors
    /// A description of the failure, such as a scene that is too large.
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
