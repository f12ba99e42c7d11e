//! The ladder of a look's light, from what a drag has time for to all there is: the steps of the solver of bounced light, then the
//! finest detail of posed objects. Solvers know no clock; whoever shows pictures between the steps does.

use super::LitScene;
use crate::{Backend, BackendError, Look, Redo, light::implicit::detail::ImplicitDetail};

impl<B: Backend + ?Sized> LitScene<B> {
    /// Sets the detail of posed objects from the next look on; the finest if nothing is set.
    pub fn set_detail(&mut self, detail: ImplicitDetail) {
        self.detail = detail;
    }

    /// The detail of posed objects; `None` where nothing is posed.
    pub fn detail(&self) -> Option<ImplicitDetail> {
        self.pose_rigs.detail().filter(|_| !self.situation.poses.is_empty())
    }

    /// Lights a look by the first step of the ladder. [`Self::refine`] takes the next ones.
    ///
    /// # Errors
    /// As [`Self::light`].
    pub fn light_soon(&mut self, look: &Look) -> Result<(), BackendError> {
        // Another view needs no other light.
        if !self.is_lit_as(look) {
            self.detail = self.drag_detail;
        }
        self.light_first(look)
    }

    fn is_lit_as(&self, look: &Look) -> bool {
        self.lit.as_ref().is_some_and(|lit| {
            let Redo { light, shown, .. } = Redo::between(&lit.look, look);
            !light.any() && !shown
        })
    }

    /// Whether the light can be made finer.
    pub fn is_coarse(&self) -> bool {
        self.is_unsolved || self.detail().is_some_and(|detail| detail != ImplicitDetail::FINEST)
    }

    /// Takes the next step of the ladder for the look that is lit, if what it needs is prepared. Returns whether it did; pixels are
    /// stale then.
    ///
    /// # Errors
    /// As [`Self::light`].
    pub fn refine(&mut self, look: &Look) -> Result<bool, BackendError> {
        if self.is_unsolved {
            self.advance()?;
            return Ok(true);
        }
        let is_prepared = self.is_coarse() && self.prepare(ImplicitDetail::FINEST);
        if is_prepared {
            self.detail = ImplicitDetail::FINEST;
            self.light_first(look)?;
        }
        Ok(is_prepared)
    }

    /// Chooses the detail of the next steps of a drag, by the milliseconds that the light of the last one took and may take. The
    /// drag goes on as it is until what that needs is prepared.
    pub fn adapt(&mut self, millis: f64, budget: f64) {
        let Some(wanted) = self.detail().map(|detail| detail.within(millis, budget)) else { return };
        if self.prepare(wanted) {
            self.drag_detail = wanted;
        }
    }

    /// Begins to prepare, on a thread, what a drag needs, so that it does not wait.
    pub fn prepare_to_drag(&mut self) {
        self.prepare(self.drag_detail);
    }

    /// Whether a drag does not wait.
    pub fn is_prepared_to_drag(&mut self) -> bool {
        self.pose_rigs.is_made(self.drag_detail)
    }

    fn prepare(&mut self, detail: ImplicitDetail) -> bool {
        if self.check_objects().is_ok() {
            self.pose_rigs.prepare(detail, &self.baked, || self.backend.compute());
        }
        self.pose_rigs.is_made(detail)
    }
}
