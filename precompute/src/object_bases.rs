//! The functions of all objects, for light that is solved anew after a move (meshless radiosity, 6).
//!
//! Objects are covered whole, on every side that is seen: what other objects cover as baked may lie open after a move.

use lapidary_core::{
    mesh::Mesh,
    mesh_surface::MeshSurface,
    meshless::{BasisError, ObjectBases, Owner},
    surfel::{GradedGrid, Surfel},
};
use rayon::prelude::*;
use std::collections::BTreeMap;

use crate::sources::disk::DENSITY;

/// Candidates for each point that has room.
const CANDIDATES: f32 = 12.0;
/// Factor of the radius of support relative to the distance of the points, as of the finest level of the meshless basis.
const OVERLAP: f32 = 2.5;

/// Settings of the bases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectBasesSettings {
    /// About how many functions all levels have.
    pub functions: u32,
    /// Number of levels; each has about four times as many functions as the one before.
    pub levels: usize,
    /// The level that sends, from 0.
    pub sender_level: usize,
}

impl Default for ObjectBasesSettings {
    /// The levels of the paper (Table 1).
    fn default() -> Self {
        Self { functions: 150_000, levels: 6, sender_level: 3 }
    }
}

/// Places the functions.
///
/// # Errors
/// [`BasisError`] for a scene without a surface.
pub fn place_object_bases(
    mesh: &Mesh,
    surface: &MeshSurface,
    settings: &ObjectBasesSettings,
) -> Result<ObjectBases, BasisError> {
    let objects = triangles_of_objects(mesh);
    let area: f32 = objects.par_iter().map(|triangles| area_of(surface, triangles)).sum();
    let finest = settings.functions as f32 * 0.75;
    let finest_radius = (DENSITY * area / finest).sqrt();
    let spacing = |level: usize| finest_radius * ((settings.levels - 1 - level) as f32).exp2();
    let of_level = |level: usize| -> Vec<(Surfel, Owner)> {
        let of_object = |(object, triangles): (usize, &Vec<u32>)| {
            placed(surface, triangles, spacing(level), (object * settings.levels + level) as u64)
        };
        objects.par_iter().enumerate().flat_map_iter(of_object).collect()
    };
    let levels: Vec<_> = (0..settings.levels).map(of_level).collect();
    let radii = (0..settings.levels).map(|level| OVERLAP * spacing(level)).collect();
    ObjectBases::new(&levels, radii, settings.sender_level)
}

fn triangles_of_objects(mesh: &Mesh) -> Vec<Vec<u32>> {
    let objects = mesh.triangle_object.iter().max().map_or(0, |&last| last as usize + 1);
    let mut triangles = vec![Vec::new(); objects];
    mesh.triangle_object.iter().enumerate().for_each(|(t, &object)| triangles[object as usize].push(t as u32));
    triangles
}

/// Area in m² of all sides.
fn area_of(surface: &MeshSurface, triangles: &[u32]) -> f32 {
    let (points, area) = surface.points_on(triangles.iter().map(|&t| t as usize), 16, 0);
    points.len() as f32 * area
}

/// Points of an object that are a distance apart, at least one for each owner.
fn placed(surface: &MeshSurface, triangles: &[u32], spacing: f32, seed: u64) -> Vec<(Surfel, Owner)> {
    let room = DENSITY * area_of(surface, triangles) / (spacing * spacing);
    let count = 64 + (CANDIDATES * room) as usize;
    let (mut candidates, _) = surface.points_on(triangles.iter().map(|&t| t as usize), count, seed);
    fastrand::Rng::with_seed(seed).shuffle(&mut candidates);
    let mut grid = GradedGrid::default();
    let mut others: BTreeMap<Owner, Option<Surfel>> = BTreeMap::new();
    for candidate in candidates {
        let owner = surface.owner(&candidate);
        match grid.any_reaching(&candidate, |_, _| true) {
            true => drop(others.entry(owner).or_insert(Some(candidate))),
            false => {
                others.insert(owner, None);
                grid.push(candidate, spacing);
            }
        }
    }
    let points = grid.into_points().into_iter().map(|(point, _)| point);
    points.chain(others.into_values().flatten()).map(|point| (point, surface.owner(&point))).collect()
}

#[cfg(test)]
mod tests;
