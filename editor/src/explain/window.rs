//! The window that explains a pixel clicked in the viewport.

use super::{
    panel::{self, ExplainContext, ExplainRequest},
    state::ExplainWindow,
};
use crate::{compare::panel::ComparisonPanel, picture::Picture, workspace::Workspace};
use egui::{Context, ScrollArea, Window};
use lapidary_core::{dataset::BakeParts, image::Region};
use lapidary_render::{Baked, GatheredLight, Redo, TreeOf};
use lapidary_studies::jobs::explain::{ExplainJob, ExplainedPicture};

/// Size of the window in points at first.
const SIZE: egui::Vec2 = egui::vec2(320.0, 640.0);
/// Where it opens, from the upper right corner: over the inspector, so that the picture stays free.
const PLACE: egui::Vec2 = egui::vec2(-338.0, 66.0);
/// Side in pixels of the square around the pixel whose error is split, where no region was drawn.
const AROUND: u32 = 48;

impl ExplainWindow {
    /// Explains a pixel of the live picture.
    pub fn explain(&mut self, work: &Workspace, picture: &Picture, pixel: [u32; 2]) {
        self.open = true;
        self.pixel = Some(pixel);
        (self.split, self.splitting) = (None, None);
        (self.explained, self.job, self.message) = (None, None, None);
        self.picture = self.picture_to_explain(picture);
        match self.picture.clone() {
            Some(picture) => self.job = Some(ExplainJob::pixel(picture, pixel, work.wake.clone())),
            None => self.message = Some("No light in the picture is gathered by cuts".into()),
        }
    }

    /// The picture on the screen, with its light.
    fn picture_to_explain(&self, picture: &Picture) -> Option<ExplainedPicture> {
        let (picture, shown) = (picture.requests.last_sent()?, picture.shown()?);
        // Moved objects have other cuts than the bake.
        let baked = picture.baked.clone().filter(|_| picture.look.poses.is_empty())?;
        let mode = baked.dataset.settings.mode;
        let environment = mode.environment().then(|| GatheredLight::Environment(shown.lighting.clone()));
        let sources = shown.local.sources().cloned().map(GatheredLight::Sources);
        let gathered = match self.tree {
            Some(TreeOf::Sources) => sources.or(environment),
            _ => environment.or(sources),
        }?;
        Some(ExplainedPicture { baked, look: picture.look.clone(), gathered })
    }

    /// Whether the picture on the screen differs from the explained one.
    fn is_outdated(&self, picture: &Picture) -> bool {
        let (then, now) = (self.picture.as_ref(), picture.requests.last_sent());
        then.zip(now).is_some_and(|(then, now)| {
            !Baked::are_same(Some(&then.baked), now.baked.as_ref()) || Redo::between(&then.look, &now.look).renders()
        })
    }

    fn split_error(&mut self, work: &Workspace, compared: &ComparisonPanel) {
        let Some((picture, pixel)) = self.picture.clone().zip(self.pixel) else { return };
        self.message = None;
        let size = picture.look.view.size;
        let drawn = compared.region_of(size);
        let region = drawn.unwrap_or_else(|| Region::around(pixel, AROUND, size));
        self.splitting = Some(ExplainJob::split(picture, region, work.wake.clone()));
    }

    /// Shows the window, while it is open. Closing it ends the work.
    pub fn show(&mut self, ctx: &Context, work: &Workspace, picture: &Picture, compared: &ComparisonPanel) {
        self.take();
        if !self.open {
            if self.pixel.is_some() {
                *self = Self::default();
            }
            return;
        }
        let has_both = picture.shown().is_some_and(|shown| shown.local.sources().is_some())
            && work.scene.baked_parts().is_some_and(BakeParts::environment);
        let outdated = self.is_outdated(picture);
        let window = &mut *self;
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
            ScrollArea::vertical().show(ui, |ui| panel::show(ui, &mut window.panel, &context)).inner
        });
        window.open = open;
        let asked = asked.and_then(|response| response.inner.flatten());
        let again = window.tree != before || asked == Some(ExplainRequest::Again);
        let changed = again.then_some(window.pixel).flatten();
        match asked {
            Some(ExplainRequest::Split) => self.split_error(work, compared),
            Some(ExplainRequest::CancelSplit) => self.splitting = None,
            Some(ExplainRequest::Again) | None => {}
        }
        if let Some(pixel) = changed {
            self.explain(work, picture, pixel);
        }
    }
}
