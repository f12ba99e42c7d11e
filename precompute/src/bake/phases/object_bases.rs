//! The phase of the bases of objects.

use super::bounces::Bouncing;
use crate::{
    bake::clock::Clock,
    errors::BakeError,
    object_bases::{place_object_bases, report_of},
    observer::Phase,
};
use lapidary_core::{dataset::ObjectBasesReport, meshless::ObjectBases, scene::pose::check_objects};

impl Bouncing<'_> {
    /// Places the functions, timed.
    pub fn bake_object_bases(&self, clock: &mut Clock) -> Result<(ObjectBases, ObjectBasesReport), BakeError> {
        check_objects(&self.geometry.scene).map_err(BakeError::Pose)?;
        let (surface, settings, observer) = (self.surface, &self.settings.object_bases, clock.observer);
        let bases = clock.time(Phase::ObjectBases, u64::from(settings.functions), "functions", || {
            place_object_bases(&self.geometry.scene.mesh, surface, settings, observer)
        })?;
        let report = report_of(&bases);
        Ok((bases, report))
    }
}
