//! Refines the light once nothing moves.

use super::{PictureStage, RenderRequest, Worker};
use lapidary_render::{BackendError, LitScene, Refined};
use std::{sync::atomic::Ordering::SeqCst, time::Instant};

impl Worker {
    /// Whether the light of the picture can be made finer, and nothing moves.
    pub(super) fn may_be_finer(&self) -> bool {
        let is_moving = self.wanted.as_ref().is_none_or(|request| request.moving);
        !is_moving && self.begun.is_some() && self.scene.as_ref().is_some_and(LitScene::is_coarse)
    }

    /// Whether other work needs the cores, or a better picture is coming.
    pub(super) fn must_wait(&self) -> bool {
        self.shared.held.load(SeqCst) || self.shared.is_preview.load(SeqCst)
    }

    /// Refines the light once the full picture is due. Returns whether a picture has begun with it: a full one does not wait for parts
    /// of a step, which take turns with its bands.
    pub(super) fn refine(&mut self, request: &RenderRequest) -> Result<bool, BackendError> {
        let is_due = match self.stage {
            PictureStage::Rest | PictureStage::Full { .. } => true,
            PictureStage::Settle { .. } => self.stage.settled(Instant::now()),
            PictureStage::Begin | PictureStage::Compile | PictureStage::Sketch => false,
        };
        if !is_due || !self.may_be_finer() || self.must_wait() {
            return Ok(false);
        }
        let Some(scene) = &mut self.scene else { return Ok(false) };
        let begins = match scene.refine(&request.look)? {
            Refined::Light => true,
            Refined::Unseen => matches!(self.stage, PictureStage::Settle { .. }),
            Refined::Nothing => false,
        };
        if begins {
            self.begin(request, request.look.view.size, false)?;
        }
        Ok(begins)
    }
}
