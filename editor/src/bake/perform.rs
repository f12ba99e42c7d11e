//! Performs the actions of bakes.

use super::{
    begin::wants_draft,
    state::{Asker, BakeOrder, Baking, From},
};
use crate::{
    actions::BakeAction,
    document::Edit,
    workspace::{Inspector, Workspace},
};
use lapidary_core::{
    camera::Camera,
    dataset::{BakeParts, BakeSettings},
    shot::Shot,
};

impl Baking {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, action: BakeAction) {
        match action {
            BakeAction::Begin { resume } => {
                let from = if resume { From::Checkpoint } else { From::Beginning };
                self.bake(work, BakeOrder { asked_by: Asker::User, from, draft_first: wants_draft(work) });
            }
            BakeAction::Cancel => self.cancel_for_good(),
            BakeAction::Choose(mode) => choose(work, mode),
            BakeAction::ForViews(cameras) => bake_for_views(work, cameras),
        }
    }
}

fn choose(work: &mut Workspace, mode: BakeParts) {
    work.tabs.show_inspector(Inspector::Bake);
    work.do_step(Edit::Bake(Box::new(BakeSettings { mode, ..work.document.bake.clone() })), "Bake type");
}

fn bake_for_views(work: &mut Workspace, cameras: Vec<Camera>) {
    let aspect = work.aspect();
    let shots = cameras.into_iter().map(|camera| Shot { camera, aspect }).collect();
    work.do_step(Edit::Bake(Box::new(BakeSettings { shots, ..work.document.bake.clone() })), "Views of the bake");
}
