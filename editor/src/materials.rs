//! Materials: their inspector, their files, and their assignment to parts of the scene.

mod files;
pub mod panel;
mod parts;

pub use files::{use_brdf, use_material, use_texture};
pub use panel::MaterialPanel;

use crate::{
    actions::{Action, MaterialAction},
    document::Component,
    jobs::{
        load::{Loader, Source, Topic},
        render_thread::RenderedFrame,
    },
    picture::Picture,
    workspace::Workspace,
};
use egui::Ui;
use lapidary_core::dataset::BakeParts;
use panel::MaterialContext;
use std::path::PathBuf;

/// Performs an action.
pub fn perform(work: &mut Workspace, loader: &mut Loader, action: MaterialAction) {
    match action {
        MaterialAction::Assign { part, material } => parts::assign(work, part, material),
        MaterialAction::MakeUnique { part, material } => parts::make_unique(work, part, material.map(|it| *it)),
        MaterialAction::ChooseVariant(variant) => parts::choose_variant(work, variant),
        MaterialAction::LoadTexture { material, map, path: Some(path) } => {
            loader.load(Topic::Map { material, map }, Source::Texture(path));
        }
        MaterialAction::LoadBrdf { material, path: Some(path) } => {
            loader.load(Topic::Brdf(material), Source::Brdf(path));
        }
        MaterialAction::Load { material, path: Some(path) } => load(work, loader, material, path),
        MaterialAction::Save { material, path: Some(path) } => files::save_material(work, material, &path),
        // The path is asked for first.
        MaterialAction::LoadTexture { path: None, .. }
        | MaterialAction::LoadBrdf { path: None, .. }
        | MaterialAction::Load { path: None, .. }
        | MaterialAction::Save { path: None, .. } => {}
    }
}

/// Begins to read a material file.
pub fn load(work: &Workspace, loader: &mut Loader, material: usize, path: PathBuf) {
    let allow_outside = work.preferences.outside.allow(&path);
    let textures = work.document.shared_textures();
    loader.load(Topic::Material(material), Source::Material { path, textures, allow_outside });
}

/// Shows the inspector.
pub fn show(ui: &mut Ui, panel: &mut MaterialPanel, work: &Workspace, picture: &Picture, actions: &mut Vec<Action>) {
    let has_environment = work.document.components.shows(Component::Environment)
        && work.scene.baked_parts().is_some_and(BakeParts::environment);
    let is_lit = |s: &&RenderedFrame| has_environment && s.lighting.shines();
    let shown = picture.shown().filter(is_lit);
    let [has_second_uvs, has_vertex_colors] = work.scene.has_second_uvs_and_colors();
    let context = MaterialContext {
        document: &work.document,
        selected: work.selection.material,
        part: work.selection.part,
        parts: &work.bounds.parts,
        ground: work.scene.ground_material(),
        has_second_uvs,
        has_vertex_colors,
        lighting: shown.map(|s| &s.lighting),
        light_revision: shown.map_or(0, |s| s.light_revision),
    };
    panel::show(ui, panel, &context, actions);
}
