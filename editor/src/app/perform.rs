//! Actions, done: the one place where what the interface asks for meets the document, its history and the jobs.

use super::{
    first_view::FirstView,
    layout::Inspector,
    opening::{Opened, Ready, Target},
    prompts::{Prompt, Then},
    state::{EditorState, OpenScene, Selection},
    theme,
};
use crate::{
    actions::Action,
    app::{dialogs::Purpose, keys::Command},
    document::{Document, Edit, History, ViewSettings, folder_of, library::maps_in, session},
    jobs::load::{Source, Topic},
    preferences::{FileUse, Preferences},
    viewport::{camera_text, navigation, pick},
};
use egui::{Context, ViewportCommand};
use lapidary_core::{camera::Camera, dataset::BakeSettings, scene::Bounds};
use lapidary_precompute::Leftover;
use std::path::{Path, PathBuf};

impl EditorState {
    /// Does what was asked for; a path that is missing is asked for by a dialog.
    pub(super) fn perform(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::Edit { edit, label } => self.edit(edit, label),
            Action::EndGesture => self.history.end_gesture(),
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
            Action::Camera(camera) => self.document.camera = camera,
            Action::FrameSelection => self.frame_selection(),
            Action::FrameAll => self.frame_all(),
            Action::ResetCamera => self.reset_camera(),
            Action::SelectObject(object) => self.select_object(object),
            Action::SelectMaterial(material) => {
                self.selection.material = material;
                if material.is_some() {
                    self.interface.inspector = Inspector::Material;
                }
            }
            Action::SelectLight(light) => self.select_light(light),
            Action::AddLight(kind) => self.add_light(kind),
            Action::DuplicateLight(index) => self.duplicate_light(index),
            Action::DeleteLight(index) => self.delete_light(index),
            Action::AimLight(place) => self.aim_light(place),
            Action::LoadLights(Some(path)) => self.load_lights(&path),
            Action::SaveLights(Some(path)) => self.save_lights(&path),
            Action::ChooseBake(mode) => {
                self.interface.inspector = Inspector::Bake;
                self.do_step(Edit::Bake(Box::new(BakeSettings { mode, ..self.document.bake.clone() })), "Bake of");
            }
            Action::CopyCamera => self.copy_camera(ctx),
            Action::PasteCamera => {
                self.interface.pasting_camera = 2;
                ctx.send_viewport_cmd(ViewportCommand::RequestPaste);
            }
            Action::Preferences(preferences) => self.prefer(preferences),
            Action::ToggleKeys => self.interface.keys_open = !self.interface.keys_open,
            Action::Bake { resume } => self.start_bake(resume, self.wants_draft()),
            Action::CancelBake => self.cancel_bake(),
            Action::LoadEnvironment(Some(path)) => self.use_environment(&path.to_string_lossy()),
            Action::Open(Some(path)) => self.open(Target::File(path)),
            Action::OpenBundled(index) => self.open_bundled(index),
            Action::Quit => self.quit(ctx),
            Action::Save => self.save(ctx),
            Action::SaveAs(Some(path)) => self.save_to(ctx, &path),
            Action::ExportPicture(Some(path)) => self.export_picture(path),
            Action::LoadTexture { material, map, path: Some(path) } => {
                self.load(Topic::Map { material, map }, Source::Texture(path.clone()), path);
            }
            Action::LoadMaterial { material, path: Some(path) } => {
                let textures = self.document.textures.iter().map(|t| t.texture.clone()).collect();
                self.load(Topic::Material(material), Source::Material { path: path.clone(), textures }, path);
            }
            Action::SaveMaterial { material, path: Some(path) } => self.save_material(material, &path),
            Action::AddToLibrary(Some(path)) => self.add_to_library(path),
            Action::Relink(Some(folder)) => self.relink(folder),
            Action::Open(None)
            | Action::SaveAs(None)
            | Action::ExportPicture(None)
            | Action::LoadTexture { path: None, .. }
            | Action::LoadMaterial { path: None, .. }
            | Action::SaveMaterial { path: None, .. }
            | Action::LoadLights(None)
            | Action::SaveLights(None)
            | Action::LoadEnvironment(None)
            | Action::AddToLibrary(None)
            | Action::Relink(None) => self.ask_for_path(action),
        }
    }

    /// Does what a menu or key asks for.
    pub(super) fn command(&mut self, command: Command, actions: &mut Vec<Action>) {
        let is_step = matches!(command, Command::Mode(_) | Command::Wireframe);
        let view = |change: &dyn Fn(&mut ViewSettings)| {
            let mut settings = self.document.view.clone();
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
            Command::FrameSelection => Action::FrameSelection,
            Command::FrameAll => Action::FrameAll,
            Command::ResetCamera => Action::ResetCamera,
            Command::CopyCamera => Action::CopyCamera,
            Command::PasteCamera => Action::PasteCamera,
            Command::DuplicateLight | Command::DeleteLight => {
                let Some(index) = self.selected_light() else { return };
                let is_copy = command == Command::DuplicateLight;
                if is_copy { Action::DuplicateLight(index) } else { Action::DeleteLight(index) }
            }
            Command::Bake => Action::Bake { resume: false },
            Command::Keys => Action::ToggleKeys,
            Command::Mode(mode) => Action::Edit { edit: view(&|v| v.mode = mode), label: "View mode" },
            Command::Wireframe => Action::Edit { edit: view(&|v| v.wireframe = !v.wireframe), label: "Wireframe" },
            Command::LargerInterface => Action::Preferences(self.scaled(1)),
            Command::SmallerInterface => Action::Preferences(self.scaled(-1)),
            Command::DefaultInterface => Action::Preferences(Preferences { ui_scale: 1.0, ..self.preferences.clone() }),
            Command::TogglePanels => {
                self.interface.panels_hidden = !self.interface.panels_hidden;
                return;
            }
        });
        if is_step {
            actions.push(Action::EndGesture);
        }
    }

    fn scaled(&self, steps: i32) -> Preferences {
        Preferences { ui_scale: theme::scaled(self.preferences.ui_scale, steps), ..self.preferences.clone() }
    }

    fn edit(&mut self, edit: Edit, label: &'static str) {
        self.history.apply(&mut self.document, edit, label);
    }

    fn undo(&mut self) {
        if let Some(label) = self.history.undo(&mut self.document) {
            self.messages.remark(format!("Undone: {label}"));
        }
    }

    fn redo(&mut self) {
        if let Some(label) = self.history.redo(&mut self.document) {
            self.messages.remark(format!("Redone: {label}"));
        }
    }

    /// Lights the scene by a map or formula, as a step of undo.
    pub(super) fn use_environment(&mut self, spec: &str) {
        let environment =
            crate::document::EnvironmentSettings { spec: spec.into(), ..self.document.environment.clone() };
        self.history.end_gesture();
        self.edit(Edit::Environment(environment), "Environment");
        self.history.end_gesture();
    }

    fn frame_selection(&mut self) {
        if let Some(bounds) = self.light_bounds() {
            self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect());
            return;
        }
        let bounds = self.scene.shown().zip(self.selection.object);
        match bounds.and_then(|(baked, object)| pick::object_bounds(&baked.dataset.scene.mesh, object)) {
            Some(bounds) => self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect()),
            None => self.frame_all(),
        }
    }

    fn frame_all(&mut self) {
        if let Some(bounds) = self.scene_bounds() {
            self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect());
        }
    }

    /// Goes back to where the document was first seen from.
    fn reset_camera(&mut self) {
        if let Some(view) = &self.scene.first_view {
            self.document.camera = view.fitted(self.scene_bounds(), self.aspect());
        }
    }

    pub(super) fn scene_bounds(&self) -> Option<Bounds> {
        let baked = self.scene.baked.as_ref().map(|baked| &baked.dataset.scene);
        let scene = baked.or(self.scene.source.as_ref().map(|source| &*source.scene));
        scene.map(|scene| scene.mesh.bounds())
    }

    fn aspect(&self) -> f32 {
        let [width, height] = self.interface.viewport_size;
        width as f32 / height.max(1) as f32
    }

    /// Selects an object, and with it the material of its first triangle.
    fn select_object(&mut self, object: Option<u32>) {
        self.selection.object = object;
        self.selection.light = None;
        let Some((object, baked)) = object.zip(self.scene.baked.as_ref()) else { return };
        let mesh = &baked.dataset.scene.mesh;
        if let Some(triangle) = mesh.triangle_object.iter().position(|&o| o == object) {
            self.selection.material = Some(mesh.triangle_material[triangle] as usize);
            self.interface.inspector = Inspector::Material;
        }
    }

    fn copy_camera(&mut self, ctx: &Context) {
        ctx.copy_text(camera_text::text(&self.document.camera));
        self.messages.note("The camera is on the clipboard, as options of lapidary render");
    }

    /// Moves the camera to what a text on the clipboard says.
    pub(super) fn paste_camera(&mut self, text: &str) {
        match camera_text::parse(text) {
            Ok(camera) => self.document.camera = Camera { name: self.document.camera.name.clone(), ..camera },
            Err(error) => self.messages.error(format!("The clipboard holds no camera: {error:#}")),
        }
    }

    fn prefer(&mut self, preferences: Preferences) {
        self.preferences = preferences.clamped();
        if let Err(error) = self.preferences.save(&self.folders.config) {
            self.messages.warning(format!("{error:#}"));
        }
    }

    fn add_to_library(&mut self, path: PathBuf) {
        match self.library.add(&[path]) {
            Ok(0) => self.messages.note("It is in the library already"),
            Ok(count) => self.messages.note(format!("Added to the library: {count}")),
            Err(error) => self.messages.error(format!("{error:#}")),
        }
    }

    fn ask_for_path(&mut self, action: Action) {
        let document = &self.document;
        let path = self.scene.session.as_deref().or(document.scene.as_deref()).or(document.dataset.as_deref());
        let stem = path.and_then(Path::file_stem).map_or("untitled".into(), |s| s.to_string_lossy().into_owned());
        let name = match &action {
            Action::SaveAs(_) => Some(format!("{stem}.{}", session::EXTENSION)),
            Action::ExportPicture(_) => Some(format!("{stem}.png")),
            Action::SaveLights(_) => Some(format!("{stem}-lights.json")),
            Action::SaveMaterial { material, .. } => {
                self.document.materials.get(*material).map(|m| format!("{}.json", m.name))
            }
            _ => None,
        };
        let of_document = path.map(folder_of);
        let folder = match Purpose::of(&action).map(|purpose| purpose.files_for) {
            Some(FileUse::Environment) => self.folder_of_environments().or(of_document),
            _ => of_document,
        };
        self.dialogs.ask(action, &self.preferences.folders, folder, name);
    }

    /// Where the map in use lies, or else those that came with the program.
    fn folder_of_environments(&self) -> Option<PathBuf> {
        self.document.environment.file().or(self.bundled.environments.first().map(PathBuf::as_path)).map(folder_of)
    }

    /// The window closes, after changes were asked about.
    fn quit(&mut self, ctx: &Context) {
        if self.history.is_modified() {
            self.ask(Prompt::Unsaved { then: Then::Quit });
        } else {
            self.leave_now(ctx, Then::Quit);
        }
    }

    /// Asks a question, after those that wait. Of two about leaving the document the later counts.
    pub(super) fn ask(&mut self, prompt: Prompt) {
        if let Prompt::Unsaved { .. } = prompt {
            self.prompts.retain(|waiting| !matches!(waiting, Prompt::Unsaved { .. }));
        }
        self.prompts.push_back(prompt);
    }

    /// Goes on without asking.
    pub(super) fn leave_now(&mut self, ctx: &Context, then: Then) {
        match then {
            Then::Show(ready) => self.take_document(*ready),
            Then::Quit => {
                self.may_close = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    /// Opens one of the scenes that come with the program.
    pub fn open_bundled(&mut self, index: usize) {
        match self.bundled.scenes.get(index).cloned() {
            Some(scene) => self.open(Target::Bundled { scene, bakes: self.folders.cache.join("bakes") }),
            None => self.messages.error(
                "The bundled scene is not there; start with --data DIR or set LAPIDARY_DATA, or open a scene of your own",
            ),
        }
    }

    fn save(&mut self, ctx: &Context) {
        match self.scene.session.clone() {
            Some(path) => self.save_to(ctx, &path),
            None => self.ask_for_path(Action::SaveAs(None)),
        }
    }

    fn save_to(&mut self, ctx: &Context, path: &Path) {
        if let Err(error) = session::save(&self.document, &self.scene.unknown, path) {
            self.after_save = None;
            return self.messages.error(error.to_string());
        }
        self.history.mark_saved();
        self.forget_autosave();
        self.forget_recovered();
        self.scene.session = Some(path.to_owned());
        self.remember(path);
        self.messages.note(format!("Saved ({})", path.display()));
        if let Some(then) = self.after_save.take() {
            self.leave_now(ctx, then);
        }
    }

    pub(super) fn remember(&mut self, path: &Path) {
        if let Err(error) = self.recent.add(path) {
            self.messages.warning(format!("{error:#}"));
        }
    }

    pub(super) fn forget_recent(&mut self, path: &Path) {
        self.messages
            .warning(format!("The file is not there any more; it was taken off the list ({})", path.display()));
        if let Err(error) = self.recent.remove(path) {
            self.messages.warning(format!("{error:#}"));
        }
    }

    pub(super) fn collect_opened(&mut self) {
        let Some(result) = self.opening.as_ref().and_then(|opening| opening.poll()) else { return };
        self.opening = None;
        match result {
            Ok(Opened::Ready(ready)) if self.history.is_modified() => {
                self.ask(Prompt::Unsaved { then: Then::Show(ready) });
            }
            Ok(Opened::Ready(ready)) => self.take_document(*ready),
            Ok(Opened::Missing { loaded, path, recovery, found }) => {
                if let Some(found) = found {
                    let missing = loaded.missing.len();
                    self.messages.note(format!("Found {found} of the missing files; {missing} are still missing"));
                }
                self.ask(Prompt::Missing { loaded, path, recovery });
            }
            Err(error) => self.messages.error(error),
        }
    }

    fn take_document(&mut self, ready: Ready) {
        let Ready { document, unknown, session, recovery, baked, source, bake_output, bake_now, warnings, recent } =
            ready;
        self.forget_autosave();
        self.baking.clear();
        self.loader.forget_document();
        self.loading.clear();
        self.document = document;
        self.history = if recovery.is_some() { History::unsaved() } else { History::new() };
        self.recovered = recovery;
        // The cameras of sessions and of recovered work are as they were left.
        let is_kept = session.is_some() || self.recovered.is_some();
        let first_view = Some(FirstView::of(&self.document, is_kept));
        self.scene = OpenScene { baked, source, bake_output, show_stale: false, session, unknown, first_view };
        self.interface.lights.forget_document();
        self.selection =
            Selection { object: None, light: None, material: (!self.document.materials.is_empty()).then_some(0) };
        self.reset_camera();
        self.pictures.clear();
        self.requests.forget();
        let name = self.title();
        self.messages.warnings(&name, &warnings);
        recent.into_iter().for_each(|path| self.remember(&path));
        if bake_now {
            let (has_draft, has_chunks) = (self.scene.baked.is_some(), self.leftover() != Leftover::Nothing);
            self.bake_bundled(has_draft && has_chunks, !has_draft);
        }
    }

    /// Looks for the missing files of the session that waits for it.
    fn relink(&mut self, folder: PathBuf) {
        match self.prompts.pop_front() {
            Some(Prompt::Missing { loaded, path, recovery }) => {
                self.open(Target::Session { loaded, path, recovery, look_in: Some(folder) });
            }
            other => {
                other.into_iter().for_each(|prompt| self.prompts.push_front(prompt));
                self.relink_library(&folder);
            }
        }
    }

    /// Looks for the maps of the library that are not where they were.
    fn relink_library(&mut self, folder: &Path) {
        let maps = maps_in(folder);
        let mut found = 0;
        for entry in self.library.entries().into_iter().filter(|entry| entry.missing && !entry.bundled) {
            let Some(map) = maps.iter().find(|map| map.file_name() == entry.path.file_name()) else { continue };
            let moved = self.library.remove(&entry.path).and_then(|()| self.library.add(std::slice::from_ref(map)));
            match moved {
                Ok(_) => found += 1,
                Err(error) => self.messages.error(format!("{error:#}")),
            }
        }
        self.messages.note(format!("Found {found} of the missing maps ({})", folder.display()));
    }

    /// What the window is called.
    pub fn title(&self) -> String {
        let Document { scene, dataset, .. } = &self.document;
        let path = self.scene.session.as_ref().or(scene.as_ref()).or(dataset.as_ref());
        path.and_then(|p| p.file_name()).map_or("Untitled".into(), |name| name.to_string_lossy().into_owned())
    }
}
