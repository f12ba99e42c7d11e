//! The surfels that implicit visibility works on: a quadtree for each object, whose leaves ride on the mesh.
//!
//! The paper (implicit visibility, 4.1) takes the vertices as leaves. Here leaves are spread evenly by area, so that neither
//! their number nor their size depends on how a model is triangulated; 5.1 names that as a limit. Shares of objects are in
//! `shares.rs`, places in `placement.rs`, the shape of the trees in [`quadtrees`].
//!
//! A triangle that is seen from both sides has surfels on each side, which stand for twice its area and face one way each. So a
//! disc always has one side: the walk skips what faces away, and light of one side never shows on the other.

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
    /// Where on the mesh it lies.
    pub place: MeshPlace,
    /// The vertices of its triangle.
    pub corners: [u32; 3],
    /// The area that it stands for in areas of its triangle.
    pub share: f32,
    /// Seen from where the corners are clockwise.
    pub back: bool,
}

impl SurfelForest {
    /// About `surfels` leaves over a mesh: 4,096 to 32,768. They are shared among objects by area, each with at least 64;
    /// where more than half would go to that, with fewer, and at least one. `two_sided` has an entry for each triangle.
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

    /// Takes all of the moved objects to vertex positions in meters; the triangles stay. The same positions give the same bits.
    pub fn update(&mut self, positions: &[Vec3], moved: &dyn Fn(u32) -> bool) {
        let Self { discs, riders } = self;
        discs.update(moved, &|leaf, _| riders[leaf as usize].disc(positions));
    }

    /// The trees over the discs of the surfels.
    pub fn discs(&self) -> &DiscForest {
        &self.discs
    }

    /// Where each leaf rides.
    pub fn riders(&self) -> &[Rider] {
        &self.riders
    }

    /// Where on the mesh each leaf lies, and its posed position and normal.
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

    /// With an area that grows as its triangle does.
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

/// The triangles of each object that have an area.
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
