//! What the vertices' visibility cuts tell of a distant light: where all of it is seen, or nothing, no ray is needed.
//!
//! A cut knows which light samples a vertex sees. If it sees all samples in and around the light, or none of them, and the other
//! vertices of the triangle do as well, then so does the whole triangle. Edges of shadows lie where vertices differ, or where the
//! samples around the light do. Shadows that fit between vertices are missed, so that only triangles of some pixels are asked.

use crate::shade::surface::SurfacePoint;
use glam::Vec3;
use lapidary_core::{
    cut::packed::{VALUE_MAX, depth},
    dataset::Dataset,
    lights::{Emission, Light},
    sphere::SPHERE,
};
use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};

/// How far around a light samples are looked at, in distances between samples.
const MARGIN: f32 = 1.0;
/// Longest edge in pixels of a triangle whose vertices are asked: a shadow that fits between them is as small.
const LONGEST: f32 = 8.0;

/// What vertices see of distant lights, as far as their cuts tell it.
#[derive(Debug, Default)]
pub(crate) struct DistantSights(Vec<DistantSight>);

impl DistantSights {
    /// Of all that are distant and have an extent among `lights`. What is known stays.
    pub fn update(&mut self, dataset: &Arc<Dataset>, lights: &[Light]) {
        let mut known = std::mem::take(&mut self.0);
        let sights = lights.iter().filter(|light| !light.is_delta()).filter_map(|light| {
            let known_at = known.iter().position(|sight| Arc::ptr_eq(&sight.dataset, dataset) && sight.is_of(light));
            known_at.map(|at| known.swap_remove(at)).or_else(|| DistantSight::new(dataset, light))
        });
        self.0 = sights.collect();
    }

    /// Whether the triangle of a point sees all of a light, or nothing; `None` where only rays can tell. `pixel` is the size of a
    /// pixel there, in metres.
    #[inline]
    pub fn sees(&self, point: &SurfacePoint, pixel: f32, light: &Light) -> Option<bool> {
        let sight = self.0.iter().find(|sight| sight.is_of(light))?;
        let [a, b, c] = point.corners;
        let longest_sq = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        if !(longest_sq <= (LONGEST * pixel).powi(2)) {
            return None;
        }
        sight.sees(point.vertices)
    }
}

/// What vertices see of one distant light; each is asked when it is first needed.
#[derive(Debug)]
struct DistantSight {
    dataset: Arc<Dataset>,
    forward: Vec3,
    angle_degrees: f32,
    /// The samples in and around it, from left to right in the tree.
    leaves: Vec<u32>,
    /// [`UNKNOWN`] and so on, of each vertex.
    seen: Vec<AtomicU8>,
}

const UNKNOWN: u8 = 0;
const NOTHING: u8 = 1;
const ALL: u8 = 2;
const SOME: u8 = NOTHING | ALL;

impl DistantSight {
    /// `None` of a light that is near, or without cuts.
    fn new(dataset: &Arc<Dataset>, light: &Light) -> Option<Self> {
        let Emission::Directional { angle_degrees } = light.emission else { return None };
        let (forward, tree) = (light.forward()?, &dataset.tree);
        if dataset.cuts.is_empty() {
            return None;
        }
        let spacing = (SPHERE / tree.len() as f32).sqrt();
        let least = (0.5 * angle_degrees.to_radians() + MARGIN * spacing).cos();
        let is_near = |&(_, direction): &(u32, &Vec3)| -direction.dot(forward) >= least;
        let leaves = (0..).zip(tree.leaf_directions()).filter(is_near).map(|(leaf, _)| leaf).collect();
        let seen = (0..dataset.cuts.len()).map(|_| AtomicU8::new(UNKNOWN)).collect();
        Some(Self { dataset: dataset.clone(), forward, angle_degrees, leaves, seen })
    }

    fn is_of(&self, light: &Light) -> bool {
        light.emission == Emission::Directional { angle_degrees: self.angle_degrees }
            && light.forward() == Some(self.forward)
    }

    #[inline]
    fn sees(&self, vertices: [u32; 3]) -> Option<bool> {
        let seen = vertices.into_iter().fold(UNKNOWN, |seen, vertex| seen | self.seen_by(vertex));
        match seen {
            ALL => Some(true),
            NOTHING => Some(false),
            _ => None,
        }
    }

    #[inline]
    fn seen_by(&self, vertex: u32) -> u8 {
        let (known, is_valid) = (&self.seen[vertex as usize], self.dataset.vertex_valid[vertex as usize]);
        match known.load(Ordering::Relaxed) {
            UNKNOWN => {
                let seen = if is_valid { self.looked_up(vertex) } else { SOME };
                known.store(seen, Ordering::Relaxed);
                seen
            }
            known => known,
        }
    }

    /// What the cut of a vertex tells.
    fn looked_up(&self, vertex: u32) -> u8 {
        let height = self.dataset.tree.height();
        let mut nodes = self.dataset.cuts.nodes_from(vertex).iter();
        let (mut seen, mut end, mut of_node) = (UNKNOWN, 0, UNKNOWN);
        for &leaf in &self.leaves {
            while end <= leaf {
                let &node = nodes.next().expect("a cut covers all leaves");
                end += 1 << (height - depth(node));
                of_node = match node & VALUE_MAX {
                    0 => NOTHING,
                    VALUE_MAX => ALL,
                    _ => SOME,
                };
            }
            seen |= of_node;
        }
        seen
    }
}

#[cfg(test)]
mod tests;
