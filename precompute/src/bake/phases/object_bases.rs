//! The phase of the bases of objects.

use super::bounces::Bouncing;
use crate::{
    bake::clock::Clock,
    errors::BakeError,
    object_bases::{finest_spacing, place_object_bases},
    observer::Phase,
};
use lapidary_core::{dataset::ObjectBasesReport, meshless::ObjectBases, scene::pose::check_objects, surfel::Surfel};
use std::collections::BTreeSet;

impl Bouncing<'_> {
    /// Places the functions, timed.
    pub fn bake_object_bases(&self, clock: &mut Clock) -> Result<(ObjectBases, ObjectBasesReport), BakeError> {
        check_objects(&self.geometry.scene).map_err(BakeError::Pose)?;
        let (surface, settings, observer) = (self.surface, &self.settings.object_bases, clock.observer);
        let bases = clock.time(Phase::ObjectBases, u64::from(settings.functions), "functions", || {
            place_object_bases(&self.geometry.scene.mesh, surface, settings, observer)
        })?;
        let report = ObjectBasesReport {
            objects: bases.owners().iter().map(|owner| owner.object).collect::<BTreeSet<_>>().len(),
            functions: (0..bases.levels()).map(|level| bases.level(level).len()).collect(),
            finest_spacing: finest_spacing(&bases),
            bytes_points: (bases.len() * size_of::<Surfel>()) as u64,
        };
        Ok((bases, report))
    }
}
