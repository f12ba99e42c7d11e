//! A set of directions arranged for batches: packets of 64 in groups of 8, each bounded by planes through the origin.

use crate::simd::Vec3x8;
use glam::{Vec2, Vec3};

/// Rays in one SIMD group.
pub(super) const GROUP: usize = 8;
/// Groups in one packet.
pub(super) const GROUPS: usize = 8;
/// Rays in one packet.
pub(super) const PACKET: usize = GROUP * GROUPS;
/// Bounding planes of a group, a square along its axis.
pub(super) const GROUP_PLANES: usize = 4;
/// Bounding planes of a packet, an octagon along its axis.
pub(super) const PACKET_PLANES: usize = 8;

/// 64 nearby directions. Unused lanes repeat the last direction.
#[derive(Clone)]
pub(super) struct Packet {
    /// Mean direction; near boxes along it are visited first.
    pub axis: Vec3,
    /// Squared sine of the half-angle of the cone around `axis` that contains all rays; 1 if there is no such cone.
    pub sin_sq: f32,
    /// Outward normals of the bounding planes of the whole packet, one per lane.
    pub planes: Vec3x8,
    /// Outward normals of the bounding planes of the groups: `group_planes[k]` has the `k`-th plane of each group.
    pub group_planes: [Vec3x8; GROUP_PLANES],
    /// The directions of each group.
    pub rays: [Vec3x8; GROUPS],
    /// Inverses of the components of the directions, for slab tests; finite.
    pub inverse_rays: [Vec3x8; GROUPS],
    /// Position of each ray in the caller's order; lanes past `count` are unused.
    pub targets: [u32; PACKET],
    /// Number of rays in use.
    pub count: usize,
}

/// Directions above or below a plane through the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Unit normal of the plane.
    pub normal: Vec3,
    /// Cosine to the normal that separates the two sides.
    pub height: f32,
    /// Whether the set has the directions of greater cosine, or the others.
    pub is_above: bool,
}

impl HalfSpace {
    /// Whether it contains a direction.
    #[inline]
    pub fn has(&self, direction: Vec3) -> bool {
        (direction.dot(self.normal) > self.height) == self.is_above
    }
}

/// Directions traced together from one origin after another.
#[derive(Clone)]
pub struct DirectionSet {
    pub(super) packets: Vec<Packet>,
    len: usize,
}

impl DirectionSet {
    /// Arranges unit `directions` into packets. Results are in the order of `directions`.
    pub fn new(directions: &[Vec3]) -> Self {
        let packets = spatial_order(directions).chunks(PACKET).map(|chunk| Packet::new(chunk, directions)).collect();
        Self { packets, len: directions.len() }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Calls `each` with all directions and their indices.
    pub(super) fn each(&self, mut each: impl FnMut(usize, Vec3)) {
        for packet in &self.packets {
            (0..packet.count).for_each(|i| each(packet.targets[i] as usize, packet.rays[i / GROUP].lane(i % GROUP)));
        }
    }

    /// Whether there are no directions.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

/// Directions in eights, in order. The last direction fills up the last eight.
pub fn in_eights(directions: impl IntoIterator<Item = Vec3>) -> Vec<[Vec3; GROUP]> {
    let directions: Vec<Vec3> = directions.into_iter().collect();
    let eight = |chunk: &[Vec3]| std::array::from_fn(|lane| chunk[lane.min(chunk.len() - 1)]);
    directions.chunks(GROUP).map(eight).collect()
}

/// The directions in an order where each run of eight and of 64 from the start lies close together.
pub fn spatial_order(directions: &[Vec3]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..directions.len() as u32).collect();
    sort_spatially(&mut order, directions);
    order
}

/// Halves the set across its widest axis until groups are reached, so that neighbors in order are neighbors in space.
fn sort_spatially(order: &mut [u32], directions: &[Vec3]) {
    if order.len() <= GROUP {
        return;
    }
    let (min, max) = order.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &i| {
        (lo.min(directions[i as usize]), hi.max(directions[i as usize]))
    });
    let axis = (max - min).max_position();
    // Halves are whole packets (or whole groups inside one), so no packet straddles a split.
    let unit = if order.len() > PACKET { PACKET } else { GROUP };
    let middle = (order.len() / 2).next_multiple_of(unit).min(order.len() - 1);
    order.select_nth_unstable_by(middle, |&a, &b| {
        let (da, db) = (directions[a as usize][axis], directions[b as usize][axis]);
        da.total_cmp(&db).then(a.cmp(&b))
    });
    let (left, right) = order.split_at_mut(middle);
    sort_spatially(left, directions);
    sort_spatially(right, directions);
}

impl Packet {
    /// A packet of segments from one origin, bounded by their directions; its rays have the segments' lengths.
    pub(super) fn of_segments(members: &[u32], segments: &[Vec3], directions: &[Vec3]) -> Self {
        let mut packet = Self::new(members, directions);
        for g in 0..GROUPS {
            let segment = |lane: usize| segments[packet.targets[g * GROUP + lane] as usize];
            packet.rays[g] = Vec3x8::from_array(std::array::from_fn(segment));
            packet.inverse_rays[g] = Vec3x8::from_array(std::array::from_fn(|lane| inverse(segment(lane))));
        }
        packet
    }

    fn new(members: &[u32], directions: &[Vec3]) -> Self {
        let member = |i: usize| members[i.min(members.len() - 1)];
        let mut packet = Self {
            axis: Vec3::ZERO,
            sin_sq: 1.0,
            planes: Vec3x8::splat(Vec3::ZERO),
            group_planes: [Vec3x8::splat(Vec3::ZERO); GROUP_PLANES],
            rays: [Vec3x8::splat(Vec3::ZERO); GROUPS],
            inverse_rays: [Vec3x8::splat(Vec3::ZERO); GROUPS],
            targets: std::array::from_fn(member),
            count: members.len(),
        };
        let all: [Vec3; PACKET] = std::array::from_fn(|i| directions[member(i) as usize]);
        packet.axis = all.iter().sum::<Vec3>().normalize_or(Vec3::Y);
        packet.sin_sq = cone_sin_sq(packet.axis, &all);
        packet.planes = Vec3x8::from_array(bounding_planes::<PACKET_PLANES>(&all));
        let groups: [&[Vec3]; GROUPS] = std::array::from_fn(|g| &all[g * GROUP..(g + 1) * GROUP]);
        packet.rays = groups.map(|rays| Vec3x8::from_array(std::array::from_fn(|lane| rays[lane])));
        packet.inverse_rays = groups.map(|rays| Vec3x8::from_array(std::array::from_fn(|lane| inverse(rays[lane]))));
        let planes = groups.map(bounding_planes::<GROUP_PLANES>);
        packet.group_planes = std::array::from_fn(|k| Vec3x8::from_array(planes.map(|p| p[k])));
        packet
    }
}

/// Squared sine of the half-angle of the cone around `axis` that contains all directions, widened by more than rounding.
pub(super) fn cone_sin_sq(axis: Vec3, directions: &[Vec3]) -> f32 {
    let cos = directions.iter().map(|d| d.dot(axis)).fold(1.0, f32::min);
    if cos > 0.2 { (1.0 - cos * cos + 1e-4).min(1.0) } else { 1.0 }
}

/// One over each component, kept finite so that zero times it is zero.
pub(super) fn inverse(v: Vec3) -> Vec3 {
    Vec3::from_array(v.to_array().map(|c| 1.0 / if c.abs() < 1e-18 { 1e-18_f32.copysign(c) } else { c }))
}

/// Outward normals of `K` planes through the origin that together enclose all `directions`, at most a packet.
/// Directions too far apart for a cone give null normals, which exclude nothing.
fn bounding_planes<const K: usize>(directions: &[Vec3]) -> [Vec3; K] {
    let axis = directions.iter().sum::<Vec3>().normalize_or_zero();
    if !(directions.iter().all(|d| d.dot(axis) > 0.2)) {
        return [Vec3::ZERO; K];
    }
    // Exceeds the rounding of any box test: a test must never exclude a ray that is in the box.
    const SLACK: f32 = 1e-5;
    let (u, v) = principal_axes(directions, axis);
    // Intersection of each direction with the plane at distance one along the axis.
    let mut meets = [Vec2::ZERO; PACKET];
    let meets = &mut meets[..directions.len()];
    for (at, d) in meets.iter_mut().zip(directions) {
        *at = Vec2::new(d.dot(u), d.dot(v)) / d.dot(axis);
    }
    std::array::from_fn(|k| {
        let (sin, cos) = (std::f32::consts::TAU * k as f32 / K as f32).sin_cos();
        let mut slope = f32::NEG_INFINITY;
        for at in meets.iter() {
            let s = cos * at.x + sin * at.y;
            slope = if s > slope { s } else { slope };
        }
        (cos * u + sin * v - (slope + SLACK) * axis).normalize()
    })
}

/// Two axes perpendicular to `axis`, along and across the longest extent of the directions.
fn principal_axes(directions: &[Vec3], axis: Vec3) -> (Vec3, Vec3) {
    let (s, t) = axis.any_orthonormal_pair();
    let (mut ss, mut st, mut tt) = (0.0, 0.0, 0.0);
    for d in directions {
        let (x, y) = (d.dot(s), d.dot(t));
        (ss, st, tt) = (ss + x * x, st + x * y, tt + y * y);
    }
    let angle = 0.5 * f32::atan2(2.0 * st, ss - tt);
    let u = angle.cos() * s + angle.sin() * t;
    (u, axis.cross(u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn every_direction_is_in_exactly_one_packet_and_inside_its_planes() {
        for n in [1, 7, 64, 100, 4096] {
            let directions = fibonacci_directions(n);
            let set = DirectionSet::new(&directions);
            let mut seen = vec![0; n];
            for packet in &set.packets {
                for i in 0..packet.count {
                    seen[packet.targets[i] as usize] += 1;
                    let d = packet.rays[i / GROUP].lane(i % GROUP);
                    assert_eq!(d, directions[packet.targets[i] as usize]);
                    assert!((0..PACKET_PLANES).all(|k| packet.planes.lane(k).dot(d) <= 0.0));
                    assert!(packet.group_planes.iter().all(|p| p.lane(i / GROUP).dot(d) <= 0.0));
                }
            }
            assert!(seen.iter().all(|&s| s == 1));
        }
    }

    #[test]
    fn planes_exclude_directions_far_from_the_packet() {
        let set = DirectionSet::new(&fibonacci_directions(4096));
        let excluded = |p: &Packet| (0..PACKET_PLANES).any(|k| p.planes.lane(k).dot(-p.axis) > 0.0);
        assert!(set.packets.iter().all(excluded));
    }
}
