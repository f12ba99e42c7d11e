//! The time of an animation that the document shows, and where objects are then.

use super::state::EditorState;
use egui::Context;
use lapidary_core::{animation::Animation, scene::pose::Poses};
use lapidary_render::Baked;
use std::sync::Arc;

impl EditorState {
    /// Where the document has objects, relative to a bake: by themselves, and at its time of an animation. What cannot be posed in
    /// time stays as it was baked.
    pub(super) fn poses_since(&self, baked: &Baked) -> Poses {
        let in_time = self.requests.in_time(&self.work.document, self.work.scene.animation(), baked);
        in_time.unwrap_or_else(|_| baked.dataset.scene.poses_since_baked(&self.work.document.poses))
    }

    /// Why the scene that is seen cannot be posed as its animation says, in words.
    pub(super) fn trouble_in_time(&self) -> Option<String> {
        let (animation, baked) = self.work.scene.animation().zip(self.work.scene.rendered())?;
        let in_time = || self.requests.in_time(&self.work.document, Some(animation), baked);
        self.requests.bound(animation, baked).map(drop).and_then(|()| in_time().map(drop)).err()
    }

    /// The scene that is seen where its objects are, to be pointed at. While something moves it is that of before.
    pub(super) fn posed(&self, ctx: &Context) -> Option<Baked> {
        let baked = self.work.scene.rendered()?;
        let is_held = self.interface.timeline.playing || ctx.input(|input| input.pointer.any_down());
        Some(self.requests.posed(self.poses_since(baked), baked, is_held))
    }

    /// Plays the animation, or stops.
    pub(super) fn toggle_playing(&mut self) {
        let Some(animation) = self.work.scene.animation().cloned() else { return };
        self.interface.timeline.toggle(&mut self.work.document.clip_time, animation.clips());
    }

    /// Goes on in time where the animation plays. Nothing plays without one that poses the scene that is seen.
    pub(super) fn play(&mut self, ctx: &Context) {
        if !self.interface.timeline.playing {
            return;
        }
        let stopped = match self.playable() {
            Some(animation) => {
                let passed = ctx.input(|input| input.stable_dt);
                self.interface.timeline.advance(&mut self.work.document.clip_time, animation.clips(), passed)
            }
            None => true,
        };
        self.interface.timeline.playing = !stopped;
        ctx.request_repaint();
    }

    fn playable(&self) -> Option<Arc<Animation>> {
        let (animation, baked) = self.work.scene.animation().zip(self.work.scene.rendered())?;
        self.requests.bound(animation, baked).ok().map(|_| animation.clone())
    }
}
