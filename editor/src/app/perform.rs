//! Performs actions: the one place where requests of the interface meet the document, its history and the jobs.

use super::{opening::Target, state::EditorState, theme};
use crate::{
    actions::Action,
    app::{dialogs::Purpose, keys::Command},
    bake::{Asker, BakeOrder, From, wants_draft},
    document::{Edit, EnvironmentSettings, ViewSettings, folder_of, session},
    jobs::load::{Source, Topic},
    navigation::axis_view,
    preferences::{FileUse, Preferences},
    workspace::Inspector,
};
use egui::{Context, ViewportCommand};
use lapidary_core::{
    camera::Camera,
    dataset::{BakeParts, BakeSettings},
    shot::Shot,
};
use std::path::{Path, PathBuf};

impl EditorState {
    /// Does what was asked for; a path that is missing is asked for by a dialog.
    pub(super) fn perform(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::Edit { edit, label } => self.work.edit(edit, label),
            Action::EndGesture => self.work.history.end_gesture(),
            Action::Undo => self.work.undo(),
            Action::Redo => self.work.redo(),
            Action::ClipTime(time) => self.work.document.clip_time = time,
            Action::Play => self.toggle_playing(),
            Action::Camera(camera) => self.work.document.camera = camera,
            Action::FrameSelection => self.frame_selection(),
            Action::FrameAll => self.frame_all(),
            Action::ResetCamera => self.reset_camera(),
            Action::SelectObject(object) => self.work.select_object(object),
            Action::ToggleObject(object) => self.work.toggle_object(object),
            Action::SelectMaterial(material) => self.work.select_material(material),
            Action::SelectPart(part) => self.work.selection.part = Some(part),
            Action::Assign { part, material } => self.assign(part, material),
            Action::MakeUnique { part, material } => self.make_unique(part, material.map(|material| *material)),
            Action::ChooseVariant(variant) => self.choose_variant(variant),
            Action::SelectLight(light) => self.select_light(light),
            Action::AddLight(kind) => self.add_light(kind),
            Action::DuplicateLight(index) => self.duplicate_light(index),
            Action::DeleteLight(index) => self.delete_light(index),
            Action::AimLight(place) => self.aim_light(place),
            Action::LoadLights(Some(path)) => self.load_lights(&path),
            Action::SaveLights(Some(path)) => self.save_lights(&path),
            Action::ChooseBake(mode) => self.choose_bake(mode),
            Action::BakeForViews(cameras) => self.bake_for_views(cameras),
            Action::CopyCamera => self.copy_camera(ctx),
            Action::PasteCamera => self.ask_for_camera(ctx),
            Action::Preferences(preferences) => self.work.prefer(preferences),
            Action::ToggleKeys => self.interface.keys_open = !self.interface.keys_open,
            Action::Bake { resume } => {
                let from = if resume { From::Checkpoint } else { From::Beginning };
                let order = BakeOrder { asked_by: Asker::User, from, draft_first: wants_draft(&self.work) };
                self.baking.bake(&mut self.work, order);
            }
            Action::CancelBake => self.baking.cancel_for_good(),
            Action::LoadEnvironment(Some(path)) => self.use_environment(&path.to_string_lossy()),
            Action::Open(Some(path)) => self.open(Target::File(path)),
            Action::OpenBundled(index) => self.open_bundled(index),
            Action::Quit => self.quit(ctx),
            Action::Save => self.save(ctx),
            Action::SaveAs(Some(path)) => self.save_to(ctx, &path),
            Action::ExportPicture(Some(path)) => self.export_picture(path),
            Action::ExportLayers(Some(path)) => self.export_layers(path),
            Action::ExportMaterials(Some(path)) => self.export_materials(path),
            Action::DescribeSequence => self.describe_sequence(),
            Action::SequenceFolder(Some(folder)) => self.choose_sequence_folder(&folder),
            Action::CancelExport => self.cancel_export(),
            Action::LoadTexture { material, map, path: Some(path) } => {
                self.load(Topic::Map { material, map }, Source::Texture(path.clone()), path);
            }
            Action::LoadBrdf { material, path: Some(path) } => {
                self.load(Topic::Brdf(material), Source::Brdf(path.clone()), path);
            }
            Action::LoadMaterial { material, path: Some(path) } => self.load_material(material, path),
            Action::SaveMaterial { material, path: Some(path) } => self.save_material(material, &path),
            Action::AddToLibrary(Some(path)) => self.add_to_library(path),
            Action::Relink(Some(folder)) => self.relink(folder),
            Action::ChooseReference(Some(path)) => self.choose_reference(path),
            Action::PauseReference(paused) => self.comparison.pause(paused),
            Action::ExplainPixel(pixel) => self.explain_pixel(pixel),
            Action::StartLadder => self.start_ladder(),
            Action::UseCuts(cuts) => self.use_cuts(cuts),
            Action::ToggleComparison => self.toggle_comparison(),
            Action::Open(None)
            | Action::SaveAs(None)
            | Action::ExportPicture(None)
            | Action::ExportLayers(None)
            | Action::ExportMaterials(None)
            | Action::SequenceFolder(None)
            | Action::LoadTexture { path: None, .. }
            | Action::LoadBrdf { path: None, .. }
            | Action::LoadMaterial { path: None, .. }
            | Action::SaveMaterial { path: None, .. }
            | Action::LoadLights(None)
            | Action::SaveLights(None)
            | Action::LoadEnvironment(None)
            | Action::AddToLibrary(None)
            | Action::ChooseReference(None)
            | Action::Relink(None) => self.ask_for_path(action),
        }
    }

    fn choose_bake(&mut self, mode: BakeParts) {
        self.work.tabs.show_inspector(Inspector::Bake);
        self.work.do_step(Edit::Bake(Box::new(BakeSettings { mode, ..self.work.document.bake.clone() })), "Bake of");
    }

    fn bake_for_views(&mut self, cameras: Vec<Camera>) {
        let aspect = self.work.aspect();
        let shots = cameras.into_iter().map(|camera| Shot { camera, aspect }).collect();
        self.work.do_step(
            Edit::Bake(Box::new(BakeSettings { shots, ..self.work.document.bake.clone() })),
            "Views of the bake",
        );
    }

    /// The clipboard comes as an event, some frames later.
    fn ask_for_camera(&mut self, ctx: &Context) {
        self.interface.pasting_camera = 2;
        ctx.send_viewport_cmd(ViewportCommand::RequestPaste);
    }

    pub(super) fn load_material(&mut self, material: usize, path: PathBuf) {
        let allow_outside = self.work.preferences.outside.allow(&path);
        let textures = self.work.document.shared_textures();
        self.load(Topic::Material(material), Source::Material { path: path.clone(), textures, allow_outside }, path);
    }

    /// Does what a menu or key asks for.
    pub(super) fn command(&mut self, command: Command, actions: &mut Vec<Action>) {
        let is_step = matches!(command, Command::Mode(_) | Command::Wireframe);
        let view = |change: &dyn Fn(&mut ViewSettings)| {
            let mut settings = self.work.document.view.clone();
            change(&mut settings);
            Edit::View(settings)
        };
        actions.push(match command {
            Command::Open => Action::Open(None),
            Command::Save => Action::Save,
            Command::SaveAs => Action::SaveAs(None),
            Command::ExportPicture => Action::ExportPicture(None),
            Command::Quit => Action::Quit,
            Command::Undo => Action::Undo,
            Command::Redo => Action::Redo,
            Command::SelectNothing => Action::SelectObject(None),
            Command::FrameSelection => Action::FrameSelection,
            Command::FrameAll => Action::FrameAll,
            Command::ResetCamera => Action::ResetCamera,
            Command::Along(axis) => Action::Camera(axis_view(&self.work.document.camera, axis)),
            Command::CopyCamera => Action::CopyCamera,
            Command::PasteCamera => Action::PasteCamera,
            Command::DuplicateLight | Command::DeleteLight => {
                let Some(index) = self.work.selected_light() else { return };
                let is_copy = command == Command::DuplicateLight;
                if is_copy { Action::DuplicateLight(index) } else { Action::DeleteLight(index) }
            }
            Command::Compare => Action::ToggleComparison,
            Command::Bake => Action::Bake { resume: false },
            Command::Keys => Action::ToggleKeys,
            Command::Mode(mode) => Action::Edit { edit: view(&|v| v.mode = mode), label: "View mode" },
            Command::Wireframe => Action::Edit { edit: view(&|v| v.wireframe = !v.wireframe), label: "Wireframe" },
            Command::LargerInterface => Action::Preferences(self.scaled(1)),
            Command::SmallerInterface => Action::Preferences(self.scaled(-1)),
            Command::DefaultInterface => {
                Action::Preferences(Preferences { ui_scale: 1.0, ..self.work.preferences.clone() })
            }
            Command::Tool(tool) => {
                self.interface.tool = tool;
                return;
            }
            Command::Play => Action::Play,
            Command::TogglePanels => {
                self.work.tabs.panels_hidden = !self.work.tabs.panels_hidden;
                return;
            }
        });
        if is_step {
            actions.push(Action::EndGesture);
        }
    }

    fn scaled(&self, steps: i32) -> Preferences {
        Preferences { ui_scale: theme::scaled(self.work.preferences.ui_scale, steps), ..self.work.preferences.clone() }
    }

    /// Lights the scene by a map or formula, as a step of undo.
    pub(super) fn use_environment(&mut self, spec: &str) {
        let environment = EnvironmentSettings { spec: spec.into(), ..self.work.document.environment.clone() };
        self.work.do_step(Edit::Environment(environment), "Environment");
    }

    fn add_to_library(&mut self, path: PathBuf) {
        match self.library.add(&[path]) {
            Ok(0) => self.work.messages.note("It is in the library already"),
            Ok(count) => self.work.messages.note(format!("Added to the library: {count}")),
            Err(error) => self.work.messages.error(format!("{error:#}")),
        }
    }

    pub(super) fn ask_for_path(&mut self, action: Action) {
        let document = &self.work.document;
        let path = self.work.scene.session.as_deref().or(document.scene.as_deref()).or(document.dataset.as_deref());
        let stem = path.and_then(Path::file_stem).map_or("untitled".into(), |s| s.to_string_lossy().into_owned());
        let name = match &action {
            Action::SaveAs(_) => Some(format!("{stem}.{}", session::EXTENSION)),
            Action::ExportPicture(_) => Some(format!("{stem}.png")),
            Action::ExportLayers(_) => Some(format!("{stem}-layers.exr")),
            Action::ExportMaterials(_) => Some(format!("{stem}-materials.mtlx")),
            Action::SaveLights(_) => Some(format!("{stem}-lights.json")),
            Action::SaveMaterial { material, .. } => {
                self.work.document.materials.get(*material).map(|m| format!("{}.json", m.name))
            }
            _ => None,
        };
        let of_document = path.map(folder_of);
        let folder = match Purpose::of(&action).map(|purpose| purpose.files_for) {
            Some(FileUse::Environment) => self.folder_of_environments().or(of_document),
            _ => of_document,
        };
        self.dialogs.ask(action, &self.work.preferences.folders, folder, name);
    }

    /// Where the map in use lies, or else those that came with the program.
    fn folder_of_environments(&self) -> Option<PathBuf> {
        self.work.document.environment.file().or(self.bundled.environments.first().map(PathBuf::as_path)).map(folder_of)
    }
}
