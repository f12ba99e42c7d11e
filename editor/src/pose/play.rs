//! Plays the document's animation, and finds the poses at its time.

use super::Posing;
use crate::{actions::PoseAction, workspace::Workspace};
use egui::Context;
use lapidary_core::{animation::Animation, scene::pose::Poses};
use lapidary_render::Baked;
use std::sync::Arc;

impl Posing {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, action: PoseAction) {
        match action {
            PoseAction::ClipTime(time) => work.document.clip_time = time,
            PoseAction::Play => self.toggle(work),
            PoseAction::AskForPivot => self.placing_pivot = !self.placing_pivot,
            PoseAction::PlacePivot(pivot) => self.place_pivot(work, pivot),
            PoseAction::Isolate(objects) => self.isolate(work, &objects),
        }
    }

    /// Poses of the document relative to a bake: its own, and those of its animation at its time. Objects without a pose at that
    /// time stay as baked.
    pub fn poses_since(&self, work: &Workspace, baked: &Baked) -> Poses {
        self.cache.poses_since(&work.document, work.scene.animation(), baked)
    }

    /// Why the animation cannot pose the shown scene, in words.
    pub fn trouble_in_time(&self, work: &Workspace) -> Option<String> {
        let (animation, baked) = work.scene.animation().zip(work.scene.rendered())?;
        let in_time = || self.cache.in_time(&work.document, Some(animation), baked);
        self.cache.bound(animation, baked).map(drop).and_then(|()| in_time().map(drop)).err()
    }

    /// The posed shown scene, for picking. While something moves it is the previous one.
    pub fn posed(&self, work: &Workspace, ctx: &Context) -> Option<Baked> {
        self.posed_while(work, self.timeline.playing || ctx.input(|input| input.pointer.any_down()))
    }

    /// The same, as if nothing moved.
    pub fn posed_at_rest(&self, work: &Workspace) -> Option<Baked> {
        self.posed_while(work, false)
    }

    fn posed_while(&self, work: &Workspace, is_held: bool) -> Option<Baked> {
        let baked = work.scene.rendered()?;
        Some(self.cache.posed(self.poses_since(work, baked), baked, is_held))
    }

    /// Plays the animation, or stops.
    fn toggle(&mut self, work: &mut Workspace) {
        let Some(animation) = work.scene.animation().cloned() else { return };
        self.timeline.toggle(&mut work.document.clip_time, &animation.clips);
    }

    /// Advances the time of a playing animation. Stops without one that poses the shown scene.
    pub fn play(&mut self, work: &mut Workspace, ctx: &Context) {
        if !self.timeline.playing {
            return;
        }
        let stopped = match self.playable(work) {
            Some(animation) => {
                let passed = ctx.input(|input| input.stable_dt);
                self.timeline.advance(&mut work.document.clip_time, &animation.clips, passed)
            }
            None => true,
        };
        self.timeline.playing = !stopped;
        ctx.request_repaint();
    }

    fn playable(&self, work: &Workspace) -> Option<Arc<Animation>> {
        let (animation, baked) = work.scene.animation().zip(work.scene.rendered())?;
        self.cache.bound(animation, baked).ok().map(|_| animation.clone())
    }
}
