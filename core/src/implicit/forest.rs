//! The surfels of implicit visibility: a quadtree per object, whose leaves move with the mesh.
//!
//! The paper (implicit visibility, 4.1) takes the vertices as leaves. Here leaves are spread evenly by area, so their
//! number and size are independent of the triangulation, a limit that 5.1 names. `shares.rs` distributes surfels among
//! objects, `placement.rs` places them, and [`quadtrees`] shapes the trees.
//!
//! A two-sided triangle has surfels on each side. They stand for twice its area and face one way each. So a disc is
//! always one-sided: the walk skips discs that face away, and light of one side never shows on the other.

pub mod nodes;
mod placement;
pub mod quadtrees;
mod shares;

use super::disc_forest::DiscForest;
use crate::{
    mesh::Mesh,
    surfel::{MeshPlace, Surfel},
};
use glam::Vec3;
use nodes::Disc;
use placement::{Carried, Sides};
use rayon::prelude::*;

/// Quadtrees of surfels over a mesh, one for each object.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfelForest {
    discs: DiscForest,
    riders: Vec<Rider>,
}

/// A leaf on its triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rider {
    /// Place on the mesh.
    pub place: MeshPlace,
    /// The vertices of its triangle.
    pub corners: [u32; 3],
    /// Its area in areas of its triangle.
    pub share: f32,
    /// On the side from which the corners are clockwise.
    pub back: bool,
}

impl SurfelForest {
    /// About `surfels` leaves over a mesh: 4,096 to 32,768. Objects share them by area with at least 64 each. If that
    /// takes more than half, the minimum shrinks, down to one. `two_sided` has an entry per triangle.
    pub fn new(mesh: &Mesh, two_sided: &[bool], surfels: u32) -> Self {
        let sides = Sides::new(mesh, two_sided);
        let objects = triangles_of_objects(mesh, &sides);
        let areas: Vec<f64> = objects.iter().map(|all| all.iter().map(|&t| sides.weight(t)).sum()).collect();
        let counts = shares::shares(&areas, surfels);
        let jobs: Vec<_> = objects.iter().zip(&counts).enumerate().filter(|(_, (_, count))| **count > 0).collect();
        let placed = jobs.par_iter().map(|(object, (all, count))| sides.surfels(all, **count, *object as u64));
        let riders: Vec<Rider> = placed.flatten_iter().map(|carried| Rider::new(mesh, &carried)).collect();
        let discs = riders.iter().map(|rider| rider.disc(&mesh.positions)).collect();
        Self { discs: DiscForest::new(&counts, discs), riders }
    }

    /// Moves the objects for which `moved` holds to vertex positions in meters; the triangles stay. Equal positions
    /// give equal bits.
    pub fn update(&mut self, positions: &[Vec3], moved: &dyn Fn(u32) -> bool) {
        let Self { discs, riders } = self;
        discs.update(moved, &|leaf, _| riders[leaf as usize].disc(positions));
    }

    /// The trees over the discs of the surfels.
    pub fn discs(&self) -> &DiscForest {
        &self.discs
    }

    /// The place of each leaf.
    pub fn riders(&self) -> &[Rider] {
        &self.riders
    }

    /// The posed place, position and normal of each leaf.
    pub fn surfels(&self) -> impl ExactSizeIterator<Item = Surfel> {
        let surfel = |(rider, disc): (&Rider, &Disc)| Surfel {
            position: disc.position,
            normal: disc.normal,
            place: rider.place,
        };
        self.riders.iter().zip(self.discs.discs()).map(surfel)
    }
}

impl Rider {
    fn new(mesh: &Mesh, carried: &Carried) -> Self {
        let place = carried.surfel.place;
        let front = mesh.area_vector(place.triangle as usize);
        Self {
            place,
            corners: mesh.triangles[place.triangle as usize],
            share: carried.share,
            back: front.dot(carried.surfel.normal) < 0.0,
        }
    }

    /// The disc at posed vertices; its area scales with its triangle.
    fn disc(&self, positions: &[Vec3]) -> Disc {
        let [a, b, c] = self.corners.map(|vertex| positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let area_vector = ab.cross(ac);
        let front = area_vector.normalize_or(Vec3::Y);
        let weights = self.place.barycentric;
        Disc {
            position: a + ab * weights.x + ac * weights.y,
            normal: if self.back { -front } else { front },
            area: 0.5 * area_vector.length() * self.share,
        }
    }
}

/// The triangles with an area of each object.
fn triangles_of_objects(mesh: &Mesh, sides: &Sides) -> Vec<Vec<u32>> {
    let objects = mesh.triangle_object.iter().max().map_or(0, |&last| last as usize + 1);
    let mut triangles = vec![Vec::new(); objects];
    for (triangle, &object) in mesh.triangle_object.iter().enumerate() {
        if sides.weight(triangle as u32) > 0.0 {
            triangles[object as usize].push(triangle as u32);
        }
    }
    triangles
}

#[cfg(test)]
mod tests;
