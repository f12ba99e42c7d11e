//! Why is this pixel wrong? A click in the viewport explains it, in a window of its own.

use super::state::{EditorState, explain::ExplainWindow};
use crate::panels::explain::{self, ExplainContext, ExplainRequest};
use egui::{Context, ScrollArea, Window};
use lapidary_core::image::Region;
use lapidary_render::{Baked, GatheredLight, Redo, TreeOf};
use lapidary_studies::jobs::explain::{ExplainJob, ExplainedPicture};

/// Size of the window in points at first.
const SIZE: egui::Vec2 = egui::vec2(320.0, 640.0);
/// Where it opens, from the upper right corner: over the inspector, so that the picture stays free.
const PLACE: egui::Vec2 = egui::vec2(-338.0, 66.0);
/// Side in pixels of the square around the pixel whose error is split, where no region was drawn.
const AROUND: u32 = 48;

impl EditorState {
    /// Explains a pixel of the live picture.
    pub(super) fn explain_pixel(&mut self, pixel: [u32; 2]) {
        self.explain.open = true;
        self.explain.pixel = Some(pixel);
        (self.explain.split, self.explain.splitting) = (None, None);
        (self.explain.explained, self.explain.job, self.explain.message) = (None, None, None);
        self.explain.picture = self.picture_to_explain();
        match self.explain.picture.clone() {
            Some(picture) => self.explain.job = Some(ExplainJob::pixel(picture, pixel, self.work.wake.clone())),
            None => self.explain.message = Some("The picture has no light that is gathered by cuts".into()),
        }
    }

    /// The picture on the screen, with its light.
    fn picture_to_explain(&self) -> Option<ExplainedPicture> {
        let (picture, shown) = (self.requests.last_sent()?, self.pictures.shown()?);
        // The cuts of what moved are not those of the bake.
        let baked = picture.baked.clone().filter(|_| picture.look.poses.is_empty())?;
        let mode = baked.dataset.settings.mode;
        let environment = mode.environment().then(|| GatheredLight::Environment(shown.lighting.clone()));
        let sources = shown.local.sources().cloned().map(GatheredLight::Sources);
        let gathered = match self.explain.tree {
            Some(TreeOf::Sources) => sources.or(environment),
            _ => environment.or(sources),
        }?;
        Some(ExplainedPicture { baked, look: picture.look.clone(), gathered })
    }

    /// Whether the picture on the screen is another than the one that is explained.
    fn explanation_is_outdated(&self) -> bool {
        let (then, now) = (self.explain.picture.as_ref(), self.requests.last_sent());
        then.zip(now).is_some_and(|(then, now)| {
            !Baked::are_same(Some(&then.baked), now.baked.as_ref()) || Redo::between(&then.look, &now.look).renders()
        })
    }

    fn split_error(&mut self) {
        let Some((picture, pixel)) = self.explain.picture.clone().zip(self.explain.pixel) else { return };
        self.explain.message = None;
        let size = picture.look.view.size;
        let drawn = self.interface.comparison.region_of(size);
        let region = drawn.unwrap_or_else(|| Region::around(pixel, AROUND, size));
        self.explain.splitting = Some(ExplainJob::split(picture, region, self.work.wake.clone()));
    }

    /// Shows the window, while it is open. Closing it ends the work.
    pub(super) fn show_explanation(&mut self, ctx: &Context) {
        self.explain.take();
        if !self.explain.open {
            if self.explain.pixel.is_some() {
                self.explain = ExplainWindow::default();
            }
            return;
        }
        let has_both = self.pictures.shown().is_some_and(|shown| shown.local.sources().is_some())
            && self.work.scene.rendered().is_some_and(|baked| baked.dataset.settings.mode.environment());
        let outdated = self.explanation_is_outdated();
        let window = &mut self.explain;
        let before = window.tree;
        let mut open = true;
        let place = ctx.content_rect().right_top() + PLACE;
        let shown = Window::new("Why is this pixel wrong?").open(&mut open).default_pos(place).default_size(SIZE);
        let asked = shown.vscroll(false).show(ctx, |ui| {
            if has_both {
                ui.horizontal(|ui| {
                    ui.selectable_value(&mut window.tree, Some(TreeOf::Environment), "Environment");
                    ui.selectable_value(&mut window.tree, Some(TreeOf::Sources), "Bounced light");
                });
            }
            let explained = window.explained.as_ref();
            let context = ExplainContext {
                explanation: explained.map(|e| &e.explanation),
                map: explained.map(|e| &e.map),
                split: window.split.as_ref(),
                progress: window.splitting.as_ref().map(ExplainJob::progress),
                message: window.message.as_deref(),
                outdated,
            };
            ScrollArea::vertical().show(ui, |ui| explain::show(ui, &mut window.panel, &context)).inner
        });
        window.open = open;
        let asked = asked.and_then(|response| response.inner.flatten());
        let again = window.tree != before || asked == Some(ExplainRequest::Again);
        let changed = again.then_some(window.pixel).flatten();
        match asked {
            Some(ExplainRequest::Split) => self.split_error(),
            Some(ExplainRequest::CancelSplit) => self.explain.splitting = None,
            Some(ExplainRequest::Again) | None => {}
        }
        if let Some(pixel) = changed {
            self.explain_pixel(pixel);
        }
    }
}
