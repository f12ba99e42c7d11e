//! Local lights: their panel, and their edits as steps of undo.

mod edits;
pub mod panel;

pub use edits::light_bounds;
pub use panel::{LightsPanel, add_menu};

use crate::{actions::Action, picture::Picture, workspace::Workspace};
use egui::Ui;
use lapidary_core::lights::Light;
use lapidary_render::Baked;
use panel::LightsContext;

/// Shows the tab; `suns` are the environment's, and `posed` is the scene with its objects where they are.
pub fn show(
    ui: &mut Ui,
    panel: &mut LightsPanel,
    work: &Workspace,
    posed: Option<&Baked>,
    picture: &Picture,
    suns: &[Light],
    actions: &mut Vec<Action>,
) {
    let scene = work.scene.rendered();
    let context = LightsContext {
        suns,
        document: &work.document,
        selected: work.selected_light(),
        bounces: scene.map(|baked| baked.dataset.bounces()),
        baked: work.scene.baked_parts(),
        energy: picture.shown().and_then(|shown| shown.local.energy),
        scene: posed,
        size: work.viewport_size,
        can_bake: work.scene.source.is_some(),
    };
    panel::show(ui, panel, &context, actions);
}

/// Hints on the environment tab if the bake has no environment.
pub fn environment_hint(ui: &mut Ui, work: &Workspace, actions: &mut Vec<Action>) {
    let (baked, can_bake) = (work.scene.baked_parts(), work.scene.source.is_some());
    panel::environment_hint(ui, baked, work.document.bake.mode, can_bake, actions);
}
