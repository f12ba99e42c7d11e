//! Where the objects of a lit scene are, and how finely they are lit there.

use super::{LitScene, pose_rigs::PoseRigs};
use crate::{
    Backend, BackendError, Baked, Look, Posing, Redo,
    light::implicit::{self, PoseRig, detail::Detail},
};
use lapidary_core::scene::{MeshError, pose::Poses};

impl<B: Backend + ?Sized> LitScene<B> {
    /// Poses the objects of the scene. Returns whether anything changed; where they cannot be posed so, nothing does.
    pub(super) fn pose(&mut self, poses: &Poses) -> Result<bool, BackendError> {
        let is_as_fine = self.pose_rigs.used().is_some_and(|rig| rig.detail() == self.detail);
        if self.poses == *poses && (poses.is_empty() || is_as_fine) {
            return Ok(false);
        }
        let posed = self.posed(poses).map_err(BackendError::Pose)?;
        let lit = self.lit.take();
        self.backend.pose(&posed).inspect_err(|_| self.pose_rigs = PoseRigs::default())?;
        self.local_rig.set_poses(poses);
        self.has_given(posed, poses.clone());
        if let Some(lit) = lit {
            self.give_environment(&lit.look, &lit.environment)?;
            self.lit = Some(lit);
        }
        Ok(true)
    }

    /// The scene as objects are posed. Its rigs light it as it was baked, which the light of the pose rig is added to.
    fn posed(&mut self, poses: &Poses) -> Result<Baked, MeshError> {
        if poses.is_empty() {
            return Ok(self.baked.clone());
        }
        self.check_objects()?;
        let posed = self.posing.get_or_insert_with(|| Posing::new(&self.baked)).posed(poses)?;
        Ok(self.pose_rigs.at(self.detail, &self.baked, || self.backend.sights()).pose(posed, poses))
    }

    fn check_objects(&self) -> Result<(), MeshError> {
        let (found, most) = (self.baked.dataset.scene.objects.len(), implicit::MOST_OBJECTS);
        if found <= most { Ok(()) } else { Err(MeshError::TooManyObjects { found, most }) }
    }

    /// Begins to prepare, on a thread, what poses need at some detail, so that they do not wait.
    pub fn prepare_to_pose(&mut self, detail: Detail) {
        if self.check_objects().is_err() {
            return;
        }
        self.pose_rigs.prepare(detail, &self.baked, || self.backend.sights());
    }

    /// Whether poses do not wait at some detail.
    pub fn is_prepared_to_pose(&mut self, detail: Detail) -> bool {
        self.pose_rigs.is_made(detail)
    }

    /// How finely posed objects are lit from the next look on; the finest if nothing is said.
    pub fn set_detail(&mut self, detail: Detail) {
        self.detail = detail;
    }

    /// Whether a look has the light of the last one, whatever its view.
    pub fn is_lit_as(&self, look: &Look) -> bool {
        self.lit.as_ref().is_some_and(|lit| {
            let Redo { pose, environment, local, appearance, .. } = Redo::between(&lit.look, look);
            !(pose || environment || local || appearance)
        })
    }

    /// How finely posed objects are lit; `None` where nothing is posed.
    pub fn detail(&self) -> Option<Detail> {
        self.pose_rigs.used().filter(|_| !self.poses.is_empty()).map(PoseRig::detail)
    }
}
