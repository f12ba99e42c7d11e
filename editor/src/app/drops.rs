//! Hands files dropped on the window to their features.

use super::{files::as_base_color, layout::Laid, state::EditorState};
use crate::{
    actions::{Action, EnvironmentAction, FileAction, LightAction, MaterialAction},
    jobs::load::{Kind, foreign, kind_of},
    viewport::pick,
};
use egui::Context;
use glam::Vec2;
use std::path::PathBuf;

impl EditorState {
    /// Takes the files that no panel has taken.
    pub(super) fn take_drops(&mut self, ctx: &Context, laid: &Laid, actions: &mut Vec<Action>) {
        let dropped: Vec<PathBuf> =
            ctx.input_mut(|i| std::mem::take(&mut i.raw.dropped_files)).iter().map(|f| f.path().to_owned()).collect();
        if dropped.is_empty() {
            return;
        }
        let mut opened = false;
        for path in dropped {
            match kind_of(&path) {
                Kind::Scene | Kind::Dataset | Kind::Session if opened => {
                    self.work
                        .messages
                        .warning(format!("Only one scene can be open; this one was skipped ({})", path.display()));
                }
                Kind::Scene | Kind::Dataset | Kind::Session => {
                    opened = true;
                    actions.push(Action::File(FileAction::Open(Some(path))));
                }
                Kind::Environment => actions.push(Action::Environment(EnvironmentAction::Load(Some(path)))),
                Kind::Texture => self.drop_on_material(ctx, laid, path, actions, as_base_color),
                Kind::Material => self.drop_on_material(ctx, laid, path, actions, |material, path| {
                    Action::Material(MaterialAction::Load { material, path: Some(path) })
                }),
                Kind::Brdf => self.drop_on_material(ctx, laid, path, actions, |material, path| {
                    Action::Material(MaterialAction::LoadBrdf { material, path: Some(path) })
                }),
                Kind::Lights => actions.push(Action::Light(LightAction::Load(Some(path)))),
                Kind::Unknown => self.work.messages.error(foreign(&path)),
            }
        }
    }

    /// Gives a file to the material under the pointer, else to the selected one.
    fn drop_on_material(
        &mut self,
        ctx: &Context,
        laid: &Laid,
        path: PathBuf,
        actions: &mut Vec<Action>,
        action: impl FnOnce(usize, PathBuf) -> Action,
    ) {
        match self.material_under_pointer(ctx, laid).or(self.work.selection.material) {
            Some(material) => {
                self.work.selection.material = Some(material);
                actions.push(action(material, path));
            }
            None => self
                .work
                .messages
                .error(format!("Drop it on an object, or select a material first ({})", path.display())),
        }
    }

    fn material_under_pointer(&self, ctx: &Context, laid: &Laid) -> Option<usize> {
        let rect = laid.viewport.rect;
        // Some systems report no position while files are dragged: it is missing, or old and outside.
        let pointer = ctx.input(|i| i.pointer.latest_pos()).filter(|p| rect.contains(*p))?;
        let baked = self.pose.posed_at_rest(&self.work)?;
        let size = laid.viewport.size_px;
        let share = (pointer - rect.min) / rect.size();
        let pixel = Vec2::new(share.x * size[0] as f32, share.y * size[1] as f32);
        let mesh = &baked.dataset.scene.mesh;
        let (scene, document) = ((mesh, baked.intersector_if_ready()?), &self.work.document);
        pick::pick(scene, document.bake.ground, &document.camera, pixel, size)
            .map(|picked| document.material_of(picked.part()))
    }
}
