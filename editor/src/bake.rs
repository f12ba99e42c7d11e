//! The bake: begun, followed and shown, with its panel. The driver itself is in [`lapidary_studies::jobs::bake`].

mod begin;
mod edited;
mod follow;
mod ground;
mod kept;
pub mod panel;
mod parts;
mod perform;
mod stale;
mod state;

pub use stale::stale_now;
pub use state::{Asker, BakeOrder, Baking, From};

use crate::{actions::Action, workspace::Workspace};
use egui::Ui;
use panel::{BakeContext, BakeStatus, SceneStats};

impl Baking {
    /// Shows the tab.
    pub fn show(&mut self, ui: &mut Ui, work: &Workspace, actions: &mut Vec<Action>) {
        let status = self.status(work);
        let source = work.scene.source.as_ref();
        let report = source.map(|source| &source.report);
        let (may_try, mode) = (!matches!(status, BakeStatus::Running { .. }), work.document.bake.mode);
        let bounces = mode.bounces();
        let context = BakeContext {
            document: &work.document,
            dataset: work.scene.baked.as_ref().map(|b| &*b.dataset),
            status: &status,
            reasons: &stale_now(work),
            scene_stats: report.map(|r| SceneStats { vertices: r.vertices, triangles: r.triangles }),
            trial: source.and_then(|source| source.trial(may_try)),
            bounce_trial: source.filter(|_| bounces).and_then(|source| source.bounce_trial(may_try)),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
        };
        panel::show(ui, &context, actions);
    }
}
