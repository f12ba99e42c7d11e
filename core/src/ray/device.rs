//! Rays traced on other devices than this machine's CPU.

use super::{BoundarySet, HalfSpace, HierarchyNumber, Hit, Intersector, veils::any_threshold};
use glam::{Mat3, Vec3};

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

/// Unit directions of rays, and how visibility in them is found.
#[derive(Clone, Copy)]
pub enum RayDirections<'a> {
    /// By a ray in each direction that counts.
    All(&'a [Vec3]),
    /// Along boundaries.
    Along(&'a BoundarySet),
}

/// Unblocked directions from some origins.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenRays {
    /// For each origin a row of 32-bit words, as many as the directions need: the bit of a direction is set if it counts and seems
    /// unblocked.
    pub rows: Vec<u32>,
    /// Number of rays traced from each origin.
    pub counts: Vec<u32>,
}

/// A scene and a set of directions on a device.
pub trait RayDevice: Sync {
    /// The unblocked directions from origins, in their order. Equals [`Intersector::trace_batch`], or
    /// [`BoundaryTracer::trace`](super::BoundaryTracer::trace) along boundaries, except for rays along edges, where a device may
    /// round differently.
    ///
    /// # Errors
    /// A description of the device's failure.
    fn open(&self, origins: &[RayOrigin]) -> Result<OpenRays, String>;
}

/// A provider of ray tracing devices.
pub trait RayDevices: Sync {
    /// Uploads a scene and directions to a device; `None` leaves the rays to the CPU.
    ///
    /// # Errors
    /// A description of the failure, such as a scene that is too large.
    fn device(&self, scene: &Intersector, directions: RayDirections) -> Result<Option<Box<dyn RayDevice>>, String>;

    /// Uploads a scene and the unit directions of a fan, one or more, to a device; `None` leaves the rays to the CPU.
    ///
    /// # Errors
    /// As [`Self::device`].
    fn fans(&self, scene: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn FanDevice>>, String>;
}

/// Rays of one origin: the directions of a fan, turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// Place in meters, off any surface.
    pub origin: Vec3,
    /// From the fan to the world.
    pub frame: Mat3,
}

impl Fan {
    /// Eight of its directions in the world.
    pub fn turned(&self, directions: &[Vec3; 8]) -> [Vec3; 8] {
        directions.map(|direction| self.frame * direction)
    }
}

/// A scene and the directions of a fan on a device.
pub trait FanDevice: Sync {
    /// The first hits of the rays of fans on surfaces that let no light through, fan by fan and direction by direction. Equals
    /// [`Intersector::closest_hits`] except for rays along edges and at faces that coincide, where a device may choose another.
    ///
    /// # Errors
    /// A description of the device's failure.
    fn first_hits(&self, fans: &[Fan]) -> Result<Vec<Option<Hit>>, String>;
}

impl Intersector {
    /// The number of its hierarchy.
    pub fn number(&self) -> HierarchyNumber {
        self.number
    }

    /// The triangles of the mesh in the order of the leaves, as in [`Self::hierarchy`].
    pub fn leaf_triangle_ids(&self) -> &[u32] {
        &self.leaf_ids
    }

    /// The first hit of a ray, from that on surfaces that let no light through: thin ones before it stop the ray by chance.
    pub fn with_thin_surfaces(&self, hit: Option<Hit>, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let distance = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let nearer = self.nearer_veil(origin, direction, distance, any_threshold(origin, direction));
        nearer.map(|(of, leaf, hit)| Hit { triangle: of.leaf_ids[leaf], ..hit }).or(hit)
    }

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
