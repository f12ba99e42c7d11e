//! The bases of objects: where functions lie, whether every side has some, and light that they send against rays.

use super::{
    Again,
    meshless::{by_rays, smooth_light},
};
use lapidary_core::{
    mesh::Mesh,
    meshless::{FunctionTree, ObjectBases, Owner},
    surfel::Surfel,
};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;

/// Points at which light is compared.
const POINTS: usize = 128;
/// Largest relative error of the light's energy. Its error at a point tells how coarse the senders are, which is no fault.
const MOST_LOSS: f64 = 0.05;

/// Results of a verification of the bases of objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectBasesVerification {
    /// Functions whose place was computed again.
    pub object_functions: usize,
    /// Number of these functions that are not where their triangle is.
    pub misplaced_functions: usize,
    /// Sides of parts that have no function on some level.
    pub bare_parts: usize,
    /// Points at which a bounce was compared with rays.
    pub object_points: usize,
    /// Relative root mean square error of its irradiance. The light varies smoothly over the scene.
    pub object_error: f64,
    /// Its mean irradiance relative to the rays' mean.
    pub object_energy: f64,
}

impl ObjectBasesVerification {
    /// `None` without bases of objects.
    pub(super) fn of(again: &Again) -> Option<Self> {
        let bases = again.dataset.object_bases.as_deref()?;
        let mut random = again.random();
        let picked = random.choose_multiple(0..bases.len(), again.count.min(bases.len()));
        let at: Vec<(Surfel, u64)> =
            random.choose_multiple(bases.points().iter().copied(), POINTS).into_iter().zip(0..).collect();
        let pairs = compared(again, bases, &at);
        let shown = again.dataset.scene.shown_mesh();
        let sum = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
        Some(Self {
            object_functions: picked.len(),
            misplaced_functions: picked.into_iter().filter(|&i| is_misplaced(&shown, &bases.points()[i])).count(),
            bare_parts: bare_parts(again, bases),
            object_points: pairs.len(),
            object_error: (sum(&|(rays, sent)| (rays - sent).powi(2)) / sum(&|(rays, _)| rays * rays).max(1e-30))
                .sqrt(),
            object_energy: sum(&|p| p.1) / sum(&|p| p.0).max(1e-30),
        })
    }

    /// Whether functions lie where they should, everywhere, and send the right light.
    pub(super) fn agrees(&self) -> bool {
        let is_lit = (self.object_energy - 1.0).abs() < MOST_LOSS || self.object_energy == 0.0;
        self.misplaced_functions + self.bare_parts == 0 && is_lit
    }

    /// The result in sentences, one per line.
    pub(super) fn text(&self) -> String {
        let Self { object_functions, misplaced_functions, bare_parts, object_points, object_error, object_energy } =
            self;
        format!(
            "placed {object_functions} functions of objects again: {misplaced_functions} differ; {bare_parts} sides have none; a \
             smooth light at {object_points} points: {:.1} % error against rays, {object_energy:.3} of the energy\n",
            100.0 * object_error
        )
    }
}

/// Whether a function is not where its triangle is.
fn is_misplaced(mesh: &Mesh, at: &Surfel) -> bool {
    let placed = mesh.surfel(at.place.triangle, at.place.barycentric, Owner::on(mesh, at).back);
    let distance = placed.position.distance(at.position);
    distance > 1e-5 * mesh.bounds().diagonal() || placed.normal.dot(at.normal) < 0.999
}

/// Number of visible sides without a function on some level.
fn bare_parts(again: &Again, bases: &ObjectBases) -> usize {
    let (mesh, two_sided) = (&again.dataset.scene.mesh, &again.dataset.two_sided);
    let has_area = |t: &usize| mesh.area_vector(*t).length() > 0.0 && !mesh.is_far_ground(*t as u32, mesh.bounds());
    let sides = (0..mesh.triangles.len()).filter(has_area).flat_map(|t| {
        let side = move |back| Owner { object: mesh.triangle_object[t], material: mesh.triangle_material[t], back };
        [side(false), side(true)].into_iter().take(1 + usize::from(two_sided[t]))
    });
    let sides: BTreeSet<Owner> = sides.collect();
    let bare = |level| {
        let covered: BTreeSet<Owner> = bases.level(level).map(|function| bases.owners()[function]).collect();
        sides.difference(&covered).copied().collect::<Vec<_>>()
    };
    (0..bases.levels()).flat_map(bare).collect::<BTreeSet<_>>().len()
}

/// Irradiance by rays from surfaces, and from the functions that stand for them.
fn compared(again: &Again, bases: &ObjectBases, at: &[(Surfel, u64)]) -> Vec<(f64, f64)> {
    let (surface, tree, radiance) = (&again.surface, FunctionTree::new(bases), smooth_light(&again.surface));
    let sent = |at: &Surfel| {
        tree.find(surface.owner(at), at).map_or(0.0, |function| radiance(&bases.points()[function as usize]))
    };
    let pair = |(at, seed): &(Surfel, u64)| {
        [by_rays(surface, at, &radiance, *seed), by_rays(surface, at, sent, *seed)].map(f64::from).into()
    };
    at.par_iter().map(pair).collect()
}
