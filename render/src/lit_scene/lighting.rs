//! From a look to its light on the renderer: updates the situation, passes its changes to the rigs, and gives new light to the
//! renderer.

use super::{LitLook, LitScene};
use crate::{
    Backend, BackendError, LocalLighting, Look, Marks, Pixels, Redo, Solution, Stale,
    light::{
        bounce::remark_on_widened_lobes,
        situation::{Changes, Gathering},
    },
};

impl<B: Backend + ?Sized> LitScene<B> {
    /// [`Self::light`] with the first step of bounced light. Glossy surfaces of a posed scene reflect toward the eye only if
    /// `toward_eye`, or if they receive other light anyway: a drag of the camera need not wait for them.
    pub(super) fn light_first(&mut self, look: &Look, toward_eye: bool) -> Result<(), BackendError> {
        let redo = self.redo(look, toward_eye);
        self.arrange(look, redo.light)?;
        let (before, changes) = (self.lit.take().map(|lit| lit.local), redo.light);
        self.relight = false;
        let was_unsolved = std::mem::take(&mut self.is_unsolved);
        self.finished &= !redo.renders();
        if changes.poses {
            self.give_pose()?;
        }
        if changes.appearance {
            let remarks = self.backend.set_appearance(&look.appearance)?;
            self.remarks.replace(0, remarks);
        }
        if changes.appearance || redo.shown {
            let sends = look.shown_solution() == Solution::CutsGloss && look.components.indirect;
            let widened = sends.then(|| remark_on_widened_lobes(&self.situation.appearance)).flatten();
            self.remarks.replace(3, widened.into_iter().collect());
        }
        if changes.environment || changes.gathering {
            self.give_environment(look)?;
        }
        let local = match &before {
            Some(local) if !changes.any() && !redo.shown => {
                self.is_unsolved = was_unsolved;
                local.clone()
            }
            Some(local) if changes == (Changes { eye: true, ..Changes::NONE }) && !redo.shown => {
                self.is_unsolved = was_unsolved;
                self.reflect_toward_eye(look, local.clone())?
            }
            _ => self.light_locally(look, redo)?,
        };
        self.stale = self.stale.and(self.reached(redo, before.as_ref(), &local));
        self.lit = Some(LitLook { look: look.clone(), local });
        Ok(())
    }

    /// What the renderer must redo to show a look.
    fn redo(&self, look: &Look, toward_eye: bool) -> Redo {
        let redo = match &self.lit {
            Some(lit) => Redo::between(&lit.look, look),
            None => Redo::ALL,
        };
        let appearance = redo.light.appearance;
        let redo =
            if self.relight { Redo { light: Changes { appearance, ..Changes::ALL }, ..Redo::ALL } } else { redo };
        let eye = toward_eye && self.reflects_elsewhere(look);
        let all = Pixels::all_if(eye);
        let pixels = redo.pixels.and(Stale { environment: all, bounce: all, ..Stale::NOTHING });
        Redo { light: Changes { poses: self.must_pose(&look.poses), eye, ..redo.light }, pixels, ..redo }
    }

    /// Whether glossy surfaces of the posed scene reflect toward another eye than the look's.
    pub(super) fn reflects_elsewhere(&self, look: &Look) -> bool {
        let is_shown = !self.situation.poses.is_empty() && self.pose_rigs.is_glossy();
        is_shown && self.situation.eye != look.view.camera.eye
    }

    /// Updates the situation. If objects cannot be posed this way, it stays unchanged.
    fn arrange(&mut self, look: &Look, changes: Changes) -> Result<(), BackendError> {
        if changes.poses {
            self.situation.scene = self.posed(&look.poses).map_err(BackendError::Pose)?;
            self.situation.poses = look.poses.clone();
            self.is_posed = false;
        }
        let (situation, dataset) = (&mut self.situation, &self.baked.dataset);
        if changes.appearance {
            situation.appearance = look.appearance.fitted(&dataset.scene.materials).0.into();
        }
        if changes.lights {
            situation.lights = look.lights.clone();
        }
        if changes.environment || changes.gathering {
            situation.gathering = Gathering { illum_cut: look.illum_cut, tau: look.tau };
            let light = self.environment_rig.light(&look.illumination, situation.gathering);
            situation.environment = Some(light.into());
            // Suns need an environment with baked visibility.
            let suns = if dataset.settings.mode.environment() { look.illumination.suns() } else { Vec::new() };
            situation.suns = suns.into();
            self.light_revision += 1;
        }
        if changes.any() {
            situation.eye = look.view.camera.eye;
        }
        // Bounced light does not depend on it.
        self.local_rig.note(Changes { eye: false, ..changes });
        self.pose_rigs.note(changes);
        Ok(())
    }

    /// Pixels to redo, including those that bounced light of changed materials reaches.
    fn reached(&mut self, redo: Redo, before: Option<&LocalLighting>, now: &LocalLighting) -> Stale {
        let mut stale = redo.pixels;
        if redo.light.appearance && stale.bounce != Pixels::All && now.shown_bounce().is_some() {
            let is_as_baked = self.situation.poses.is_empty();
            let before = before.filter(|_| self.keeps_unseen && !redo.view && is_as_baked);
            let patches = before.and_then(|b| self.drift.add(&self.baked, b, now));
            let reached = patches.map_or(Pixels::All, |patches| Pixels::Showing(Marks { materials: 0, patches }));
            stale.bounce = stale.bounce.and(reached);
        }
        // Another view is rendered with the current light.
        if redo.view || stale.bounce == Pixels::All {
            self.drift.reset();
        }
        stale
    }

    /// Gives the renderer the environment's light.
    fn give_environment(&mut self, look: &Look) -> Result<(), BackendError> {
        let Some(lighting) = &self.situation.environment else { return Ok(()) };
        let remarks = self.backend.set_light(&look.illumination, lighting)?;
        self.remarks.replace(1, remarks);
        Ok(())
    }

    /// Prepares local lights, bounced light, and the shown components. Hidden bounced light is not computed.
    fn light_locally(&mut self, look: &Look, redo: Redo) -> Result<LocalLighting, BackendError> {
        let (situation, solution) = (&self.situation, look.shown_solution());
        self.is_unsolved = look.components.indirect && self.local_rig.advance(situation, solution);
        let local = self.local_rig.lighting(situation, look.components, solution);
        let local = self.posed_light(look, local);
        let Changes { poses, environment, lights, .. } = redo.light;
        if poses || environment || lights || redo.shown || local.bounce.is_some() || local.posed.is_some() {
            let remarks = self.backend.set_local_lighting(&local)?;
            self.remarks.replace(2, remarks);
        }
        Ok(local)
    }

    /// The same with the light of the posed scene.
    fn posed_light(&mut self, look: &Look, local: LocalLighting) -> LocalLighting {
        let (situation, solution) = (&self.situation, look.shown_solution());
        let rig = self.pose_rigs.used().filter(|_| !situation.poses.is_empty());
        let bounces = if solution.follows_poses() { 0 } else { solution.bounces() };
        let has_glossy_bounces = bounces > 0 && local.sources().is_some();
        let posed = rig.map(|rig| rig.lit(situation).light(bounces, has_glossy_bounces).into());
        local.with_posed(posed, solution)
    }

    /// The same light where glossy surfaces of the posed scene reflect toward the eye.
    fn reflect_toward_eye(&mut self, look: &Look, local: LocalLighting) -> Result<LocalLighting, BackendError> {
        let local = self.posed_light(look, local);
        let remarks = self.backend.set_local_lighting(&local)?;
        self.remarks.replace(2, remarks);
        Ok(local)
    }

    /// Takes the next step of bounced light, and gives the renderer what it changed. Returns whether it changed anything.
    pub(super) fn advance(&mut self) -> Result<bool, BackendError> {
        self.is_unsolved = false;
        let Some(mut lit) = self.lit.take() else { return Ok(false) };
        let solution = lit.look.shown_solution();
        self.is_unsolved = self.local_rig.advance(&self.situation, solution);
        let local = self.local_rig.lighting(&self.situation, lit.look.components, solution);
        let stays = match (&lit.local.bounce, &local.bounce) {
            (Some(before), Some(now)) => before.is_same(now),
            (before, now) => before.is_none() && now.is_none(),
        };
        if stays {
            self.lit = Some(lit);
            return Ok(false);
        }
        let posed = lit.local.posed.take();
        lit.local = local.with_posed(posed, solution);
        let remarks = self.backend.set_local_lighting(&lit.local)?;
        self.remarks.replace(2, remarks);
        self.finished = false;
        self.stale.bounce = Pixels::All;
        self.drift.reset();
        self.lit = Some(lit);
        Ok(true)
    }
}
