//! State of the ladder of cut sizes.

use super::panel::{LadderResult, LadderTile, LadderTruth};
use crate::widgets::texture_of;
use egui::{Context, TextureOptions};
use lapidary_studies::jobs::ladder::{LadderEvent, LadderJob};

/// The ladder, while its window is open.
#[derive(Default)]
pub struct LadderWindow {
    pub job: Option<LadderJob>,
    pub result: LadderResult,
    pub open: bool,
}

impl LadderWindow {
    /// Whether cuts are being tried.
    pub fn is_climbing(&self) -> bool {
        self.job.is_some()
    }

    pub fn take(&mut self, ctx: &Context, event: LadderEvent) {
        match event {
            LadderEvent::Picture { cuts, shown } => {
                let texture = texture_of(ctx, "ladder", None, &shown, TextureOptions::LINEAR);
                self.result.tiles.push(LadderTile { cuts, texture, figures: None });
            }
            LadderEvent::Truth { shown, seconds, what } => {
                self.result.truth = Some(LadderTruth {
                    texture: texture_of(ctx, "ladder", None, &shown, TextureOptions::LINEAR),
                    seconds,
                    what,
                });
            }
            LadderEvent::Step(figures) => {
                let tile = self.result.tiles.iter_mut().find(|tile| tile.cuts == figures.cuts);
                tile.into_iter().for_each(|tile| tile.figures = Some(figures));
            }
            LadderEvent::Ended(result) => {
                self.job = None;
                self.result.problem = result.err();
            }
        }
    }
}
