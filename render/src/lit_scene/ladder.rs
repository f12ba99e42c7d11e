//! The ladder of a look's light, from a drag's time limit to full quality: steps of the solver of bounced light, then the finest
//! detail of posed objects, and what glossy surfaces reflect toward the eye. Solvers do not check the time; the caller does, between
//! steps.

use super::LitScene;
use crate::{Backend, BackendError, Look, Redo, light::implicit::detail::ImplicitDetail};

/// What a step of the ladder did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refined {
    /// Nothing: no step is left, or its rig is not prepared.
    Nothing,
    /// A part of a step, of which nothing shows yet.
    Unseen,
    /// The light is another, so pixels are stale.
    Light,
}

impl<B: Backend + ?Sized> LitScene<B> {
    /// Sets the detail of posed objects from the next look on; the default is the finest.
    pub fn set_detail(&mut self, detail: ImplicitDetail) {
        self.detail = detail;
    }

    /// The detail of posed objects; `None` if nothing is posed.
    pub fn detail(&self) -> Option<ImplicitDetail> {
        self.pose_rigs.detail().filter(|_| !self.situation.poses.is_empty())
    }

    /// Lights a look by the first step of the ladder. [`Self::refine`] takes the others.
    ///
    /// # Errors
    /// As [`Self::light`].
    pub fn light_soon(&mut self, look: &Look) -> Result<(), BackendError> {
        // Another view needs no new light.
        if !self.is_lit_as(look) {
            self.detail = self.drag_detail;
        }
        self.light_first(look, false)
    }

    fn is_lit_as(&self, look: &Look) -> bool {
        self.lit.as_ref().is_some_and(|lit| {
            let Redo { light, shown, .. } = Redo::between(&lit.look, look);
            !light.any() && !shown
        })
    }

    /// Whether the light can be refined.
    pub fn is_coarse(&self) -> bool {
        let is_elsewhere = || self.lit.as_ref().is_some_and(|lit| self.reflects_elsewhere(&lit.look));
        self.is_unsolved || self.detail().is_some_and(|detail| detail != ImplicitDetail::FINEST) || is_elsewhere()
    }

    /// Whether steps of bounced light remain, which can be taken at once.
    pub fn is_unsolved(&self) -> bool {
        self.is_unsolved
    }

    /// Takes the next step of the ladder for the lit look, if its rig is prepared.
    ///
    /// # Errors
    /// As [`Self::light`].
    pub fn refine(&mut self, look: &Look) -> Result<Refined, BackendError> {
        if self.is_unsolved {
            return Ok(if self.advance()? { Refined::Light } else { Refined::Unseen });
        }
        if !self.is_coarse() || !self.prepare(ImplicitDetail::FINEST) {
            return Ok(Refined::Nothing);
        }
        self.detail = ImplicitDetail::FINEST;
        self.light_first(look, true)?;
        Ok(Refined::Light)
    }

    /// Chooses the detail for the next steps of a drag, from the milliseconds that the last step's light took and may take. The
    /// drag keeps its detail until the new rig is prepared.
    pub fn adapt(&mut self, millis: f64, budget: f64) {
        let Some(wanted) = self.detail().map(|detail| detail.within(millis, budget)) else { return };
        if self.prepare(wanted) {
            self.drag_detail = wanted;
        }
    }

    /// Starts to prepare on a thread for drags, so that they need not wait.
    pub fn prepare_to_drag(&mut self) {
        self.prepare(self.drag_detail);
    }

    /// Whether a drag can start without waiting.
    pub fn is_prepared_to_drag(&mut self) -> bool {
        self.pose_rigs.is_made(self.drag_detail)
    }

    /// Starts to prepare a detail on a thread, unless another is being prepared. Returns whether it is there.
    pub fn prepare(&mut self, detail: ImplicitDetail) -> bool {
        if self.check_objects().is_ok() {
            self.pose_rigs.prepare(detail, &self.baked, &self.situation.compute);
        }
        self.pose_rigs.is_made(detail)
    }
}
