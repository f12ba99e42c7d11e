//! How finely posed objects are lit: as there is time for in a drag, and as finely as can be at rest.

use super::{PictureStage, RenderRequest, Worker};
use lapidary_render::{BackendError, Detail, LitScene};
use std::{sync::atomic::Ordering::SeqCst, time::Instant};

impl Worker {
    /// Chooses how finely the next steps of a drag are lit, by the milliseconds that the light of the last one took and may take. What
    /// they need is made while the drag goes on as it is.
    pub(super) fn adapt_detail(&mut self, millis: f64, budget: f64) {
        let Some((scene, detail)) = self.scene.as_mut().and_then(|scene| scene.detail().map(|d| (scene, d))) else {
            return;
        };
        let wanted = detail.within(millis, budget);
        scene.prepare_to_pose(wanted);
        if scene.is_prepared_to_pose(wanted) {
            self.drag_detail = wanted;
        }
    }

    /// Whether posed objects are lit less finely than can be, and nothing moves.
    pub(super) fn may_be_finer(&self) -> bool {
        let is_moving = self.wanted.as_ref().is_none_or(|request| request.moving);
        let is_coarse = self.scene.as_ref().and_then(LitScene::detail).is_some_and(|detail| detail != Detail::FINEST);
        is_coarse && !is_moving
    }

    /// Whether other work needs the cores, or a better picture is on its way.
    pub(super) fn must_wait(&self) -> bool {
        self.shared.held.load(SeqCst) || self.shared.is_preview.load(SeqCst)
    }

    /// Lights posed objects as finely as can be once the full picture is due. Returns whether it has begun so.
    pub(super) fn refine(&mut self, request: &RenderRequest) -> Result<bool, BackendError> {
        let is_due = match self.stage {
            PictureStage::Rest | PictureStage::Full { .. } => self.begun.is_some(),
            PictureStage::Settle { .. } => self.stage.settled(Instant::now()),
            PictureStage::Begin | PictureStage::Sketch => false,
        };
        if !is_due || !self.may_be_finer() || self.must_wait() {
            return Ok(false);
        }
        let Some(scene) = &mut self.scene else { return Ok(false) };
        scene.prepare_to_pose(Detail::FINEST);
        if !scene.is_prepared_to_pose(Detail::FINEST) {
            return Ok(false);
        }
        scene.set_detail(Detail::FINEST);
        scene.light(&request.look)?;
        self.begin(request, request.look.view.size)?;
        Ok(true)
    }
}
