//! The functions of all objects, for light that is solved anew after a move (meshless radiosity, 6).
//!
//! Objects are covered whole, on every side that is seen: what other objects cover as baked may lie open after a move.

use lapidary_core::{
    dataset::{ObjectBasesReport, ObjectBasesSettings},
    mesh::Mesh,
    mesh_surface::MeshSurface,
    meshless::{ObjectBases, Owner},
    surfel::{GradedGrid, Surfel},
};
use rayon::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicU64, Ordering},
};

use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    sources::disk::DENSITY,
};

/// Candidates for each point that has room.
const CANDIDATES: f32 = 12.0;
/// Factor of the radius of support relative to the distance of the points, as of the finest level of the meshless basis.
const OVERLAP: f32 = 2.5;

/// Places the functions.
///
/// # Errors
/// [`BakeError`] for a scene without a surface, and if the observer cancels.
pub fn place_object_bases(
    mesh: &Mesh,
    surface: &MeshSurface,
    settings: &ObjectBasesSettings,
    observer: &dyn Observer,
) -> Result<ObjectBases, BakeError> {
    let objects = triangles_of_objects(mesh);
    let area: f32 = objects.par_iter().map(|triangles| area_of(surface, triangles)).sum();
    let finest = settings.functions as f32 * 0.75;
    let finest_radius = (DENSITY * area / finest).sqrt();
    let spacing = |level: usize| finest_radius * ((settings.levels - 1 - level) as f32).exp2();
    let done = AtomicU64::new(0);
    let of_level = |level: usize| -> Result<Vec<(Surfel, Owner)>, BakeError> {
        let of_object = |(object, triangles): (usize, &Vec<u32>)| {
            cancelled(observer)?;
            let points = placed(surface, triangles, spacing(level), (object * settings.levels + level) as u64);
            let done = done.fetch_add(points.len() as u64, Ordering::Relaxed) + points.len() as u64;
            observer.event(Event::Advanced { done });
            Ok(points)
        };
        let points = objects.par_iter().enumerate().map(of_object).collect::<Result<Vec<_>, BakeError>>()?;
        Ok(points.concat())
    };
    let levels = (0..settings.levels).map(of_level).collect::<Result<Vec<_>, _>>()?;
    let radii = (0..settings.levels).map(|level| OVERLAP * spacing(level)).collect();
    Ok(ObjectBases::new(&levels, radii, settings.sender_level)?)
}

/// The report of some bases.
pub fn report_of(bases: &ObjectBases) -> ObjectBasesReport {
    ObjectBasesReport {
        objects: bases.owners().iter().map(|owner| owner.object).collect::<BTreeSet<_>>().len(),
        functions: (0..bases.levels()).map(|level| bases.level(level).len()).collect(),
        finest_spacing: bases.radii()[bases.levels() - 1] / OVERLAP,
        bytes_points: (bases.len() * size_of::<Surfel>()) as u64,
    }
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
