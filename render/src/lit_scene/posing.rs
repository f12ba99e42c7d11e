//! Poses of the objects in a lit scene.

use super::{LitScene, pose_rigs::PoseRigs};
use crate::{Backend, BackendError, Baked, Posing};
use lapidary_core::scene::{
    MeshError,
    pose::{Poses, check_objects},
};

impl<B: Backend + ?Sized> LitScene<B> {
    /// Whether the look poses objects differently, or needs another detail.
    pub(super) fn must_pose(&self, poses: &Poses) -> bool {
        let is_as_fine = self.pose_rigs.detail() == Some(self.detail);
        !self.is_posed || self.situation.poses != *poses || !poses.is_empty() && !is_as_fine
    }

    /// The scene in these poses.
    pub(super) fn posed(&mut self, poses: &Poses) -> Result<Baked, MeshError> {
        if poses.is_empty() {
            return Ok(self.baked.clone());
        }
        self.check_objects()?;
        self.posing.get_or_insert_with(|| Posing::new(&self.baked)).posed(poses)
    }

    /// Gives the renderer the posed scene, with cuts for vertices that moved or were covered. Rigs light the scene as baked, and the
    /// pose rig's light is added.
    pub(super) fn give_pose(&mut self) -> Result<(), BackendError> {
        let situation = &self.situation;
        let (posed, cuts) = match situation.poses.is_empty() {
            true => (situation.scene.clone(), None),
            false => {
                let rig = self.pose_rigs.at(self.detail, &self.baked, &situation.compute);
                rig.lit(situation).with_cuts(&situation.scene)
            }
        };
        self.backend.pose(&posed, cuts.as_ref()).inspect_err(|_| self.pose_rigs = PoseRigs::default())?;
        self.is_posed = true;
        self.forget_pictures();
        Ok(())
    }

    pub(super) fn check_objects(&self) -> Result<(), MeshError> {
        check_objects(&self.baked.dataset.scene)
    }
}
