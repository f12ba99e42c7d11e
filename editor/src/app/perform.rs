//! Performs actions: hands each to its feature, and asks for paths.

use super::{state::EditorState, theme};
use crate::{
    actions::{
        Action, BakeAction, CameraAction, CompareAction, ExportAction, FileAction, LightAction, LookAction,
        MaterialAction, PoseAction, SelectAction,
    },
    app::{dialogs::Purpose, keys::Command},
    document::{BackgroundKind, Edit, ViewSettings, folder_of, looks::LookPart, session},
    export::Exported,
    jobs::opening::Target,
    looks::{add_look, show_look},
    materials,
    navigation::axis_view,
    preferences::{FileUse, Preferences},
    scene,
    view::lens::focused,
    workspace::Side,
};
use egui::{Context, ViewportCommand};
use glam::Vec3;
use std::path::{Path, PathBuf};

impl EditorState {
    /// Performs an action; a dialog asks for a missing path.
    pub(super) fn perform(&mut self, ctx: &Context, mut action: Action) {
        if action.path().is_some_and(|path| path.is_none()) {
            return self.ask_for_path(action);
        }
        match action {
            Action::Edit { edit, label } => self.work.edit(edit, label),
            Action::EndGesture => self.work.history.end_gesture(),
            Action::Undo => self.work.undo(),
            Action::Redo => self.work.redo(),
            Action::Preferences(preferences) => self.work.prefer(*preferences),
            Action::ToggleKeys => self.interface.keys_open = !self.interface.keys_open,
            Action::Quit => self.quit(ctx),
            Action::File(action) => self.perform_file(ctx, action),
            Action::Camera(action) => self.perform_camera(ctx, action),
            Action::Look(action) => self.perform_look(ctx, action),
            Action::Select(action) => self.work.perform_select(action),
            Action::Pose(action) => {
                if matches!(action, PoseAction::AskForPivot) {
                    let placing = self.pose.placing_pivot;
                    self.stop_waiting_for_clicks();
                    self.pose.placing_pivot = placing;
                }
                self.pose.perform(&mut self.work, action);
            }
            Action::Material(action) => materials::perform(&mut self.work, &mut self.loader, action),
            Action::Light(action) => self.lights.perform(&mut self.work, action),
            Action::Environment(action) => self.environments.perform(&mut self.work, action),
            Action::Bake(action) => self.baking.perform(&mut self.work, action),
            Action::Compare(action) => self.comparison.perform(&mut self.work, &self.picture, action),
            Action::ExplainPixel(pixel) => self.explain.explain(&self.work, &self.picture, pixel),
            Action::Ladder(action) => {
                self.ladder.perform(&mut self.work, &self.picture, action);
                self.hold_for_ladder();
            }
            Action::Export(action) => self.perform_export(action),
        }
    }

    fn perform_file(&mut self, ctx: &Context, action: FileAction) {
        match action {
            FileAction::Open(Some(path)) => self.open(Target::File(path)),
            FileAction::OpenSceneIn(scene) => {
                if let Some(path) = self.work.document.scene.clone() {
                    self.open(match scene {
                        Some(scene) => Target::SceneIn { path, scene },
                        None => Target::File(path),
                    });
                }
            }
            FileAction::OpenBundled(index) => self.open_bundled(index),
            FileAction::Save => self.save(ctx),
            FileAction::SaveAs(Some(path)) => self.save_to(ctx, &path),
            FileAction::Relink(Some(folder)) => self.relink(folder),
            FileAction::Open(None) | FileAction::SaveAs(None) | FileAction::Relink(None) => {}
        }
    }

    fn perform_camera(&mut self, ctx: &Context, action: CameraAction) {
        match action {
            CameraAction::To(camera) => self.work.document.camera = camera,
            CameraAction::Backplate(path) => {
                let backplate = path.or_else(|| self.work.document.view.backplate.clone());
                let view =
                    ViewSettings { background: BackgroundKind::Picture, backplate, ..self.work.document.view.clone() };
                self.work.do_step(Edit::View(view), "Background picture");
            }
            CameraAction::AskForFocus => {
                let focusing = !self.interface.focusing;
                self.stop_waiting_for_clicks();
                self.interface.focusing = focusing;
            }
            CameraAction::Focus(point) => self.focus(point),
            CameraAction::FrameSelection => self.frame_selection(),
            CameraAction::FrameAll => self.frame_all(),
            CameraAction::Reset => self.reset_camera(),
            CameraAction::Copy => self.copy_camera(ctx),
            CameraAction::Paste => self.ask_for_camera(ctx),
        }
    }

    /// No click is waited for any more.
    pub(super) fn stop_waiting_for_clicks(&mut self) {
        (self.interface.focusing, self.pose.placing_pivot, self.lights.aiming) = (false, false, false);
    }

    /// Focuses a point before the camera.
    fn focus(&mut self, point: Option<Vec3>) {
        self.interface.focusing = false;
        let camera = &self.work.document.camera;
        let depth = point.map(|point| camera.projection(self.work.viewport_size).depth(point));
        if let Some(depth) = depth.filter(|depth| *depth > 0.0) {
            self.work.document.camera = focused(camera, depth);
        }
    }

    fn perform_look(&mut self, ctx: &Context, action: LookAction) {
        match action {
            LookAction::Show(look) => {
                let actions = show_look(&self.work.document, look, LookPart::All);
                if actions.is_empty() {
                    self.work.messages.remark(format!("There is no look {}", look + 1));
                }
                actions.into_iter().for_each(|action| self.perform(ctx, action));
            }
            LookAction::Describe => self.describe_pictures(),
        }
    }

    /// Opens the dialog for pictures of looks.
    fn describe_pictures(&mut self) {
        let Some(shown) = self.shown_document(self.work.viewport_size) else { return };
        self.exporting.describe_pictures(&self.work, &shown);
    }

    fn perform_export(&mut self, action: ExportAction) {
        match action {
            ExportAction::Picture(Some(path)) => self.picture.export(&mut self.work, path),
            action => {
                let is_picture = matches!(action, ExportAction::DescribeSequence | ExportAction::Layers(_));
                if let Some(problem) = self.picture.backplate.problem(&self.work).filter(|_| is_picture) {
                    return self.work.messages.error(problem);
                }
                let exported = self.exported();
                self.exporting.perform(&mut self.work, exported, action);
            }
        }
    }

    /// The look and scene to export; `None` without a picture.
    pub(super) fn exported(&self) -> Option<Exported> {
        let baked = self.work.scene.rendered()?.clone();
        let look = self.look(self.work.viewport_size)?;
        Some(Exported { look, baked, selected: self.pose.spin(&self.work) })
    }

    /// Requests the clipboard, which comes as an event some frames later.
    fn ask_for_camera(&mut self, ctx: &Context) {
        self.interface.pasting_camera = 2;
        ctx.send_viewport_cmd(ViewportCommand::RequestPaste);
    }

    /// Performs the command of a menu or key.
    pub(super) fn command(&mut self, command: Command, actions: &mut Vec<Action>) {
        let is_step = matches!(command, Command::Mode(_) | Command::Wireframe);
        let view = |change: &dyn Fn(&mut ViewSettings)| {
            let mut settings = self.work.document.view.clone();
            change(&mut settings);
            Edit::View(settings)
        };
        actions.push(match command {
            Command::Open => Action::File(FileAction::Open(None)),
            Command::Save => Action::File(FileAction::Save),
            Command::SaveAs => Action::File(FileAction::SaveAs(None)),
            Command::ExportPicture => Action::Export(ExportAction::Picture(None)),
            Command::Quit => Action::Quit,
            Command::Undo => Action::Undo,
            Command::Redo => Action::Redo,
            Command::SelectNothing => Action::Select(SelectAction::Object(None)),
            Command::HideSelection | Command::ShowAll => {
                actions.extend(self.hide_or_show(command));
                return;
            }
            Command::Isolate => Action::Pose(PoseAction::Isolate(self.selected_objects())),
            Command::FrameSelection => Action::Camera(CameraAction::FrameSelection),
            Command::FrameAll => Action::Camera(CameraAction::FrameAll),
            Command::ResetCamera => Action::Camera(CameraAction::Reset),
            Command::Along(axis) => Action::Camera(CameraAction::To(axis_view(&self.work.document.camera, axis))),
            Command::CopyCamera => Action::Camera(CameraAction::Copy),
            Command::PasteCamera => Action::Camera(CameraAction::Paste),
            Command::DuplicateLight | Command::DeleteLight => {
                let Some(index) = self.work.selected_light() else { return };
                let is_copy = command == Command::DuplicateLight;
                if is_copy {
                    Action::Light(LightAction::Duplicate(index))
                } else {
                    Action::Light(LightAction::Delete(index))
                }
            }
            Command::Compare => Action::Compare(CompareAction::Toggle),
            Command::Bake => Action::Bake(BakeAction::Begin { resume: false }),
            Command::Keys => Action::ToggleKeys,
            Command::Mode(mode) => Action::Edit { edit: view(&|v| v.mode = mode), label: "View mode" },
            Command::Wireframe => Action::Edit { edit: view(&|v| v.wireframe = !v.wireframe), label: "Wireframe" },
            Command::LargerInterface => Action::prefer(self.scaled(1)),
            Command::SmallerInterface => Action::prefer(self.scaled(-1)),
            Command::DefaultInterface => Action::prefer(Preferences { ui_scale: 1.0, ..self.work.preferences.clone() }),
            Command::Tool(tool) => {
                self.pose.tool = tool;
                return;
            }
            Command::Look(look) => Action::Look(LookAction::Show(look)),
            Command::AddLook => {
                if self.work.scene.rendered().is_some() {
                    self.work.tabs.side = Side::Looks;
                    self.work.messages.remark(format!("Added: {}", self.work.document.free_look_name()));
                    actions.extend(add_look(&self.work.document));
                }
                return;
            }
            Command::Play => Action::Pose(PoseAction::Play),
            Command::TogglePanels => {
                self.work.tabs.panels_hidden = !self.work.tabs.panels_hidden;
                return;
            }
        });
        if is_step {
            actions.push(Action::EndGesture);
        }
    }

    /// Hides or shows the selected objects, or shows all; nothing without such objects, or while a light is selected.
    fn hide_or_show(&self, command: Command) -> Vec<Action> {
        let document = &self.work.document;
        let (objects, hides): (Vec<u32>, bool) = match command {
            Command::ShowAll => (document.poses.hidden().collect(), false),
            _ => {
                let selected = self.selected_objects();
                let is_shown = selected.first().is_some_and(|&active| !document.poses.of(active).hidden);
                (selected, is_shown)
            }
        };
        if objects.is_empty() { Vec::new() } else { scene::hide(document, objects, hides).into() }
    }

    /// The selected objects other than the ground, the active one first; none while a light is selected.
    pub(super) fn selected_objects(&self) -> Vec<u32> {
        let ground = self.work.scene.ground_object();
        let is_free = self.work.selected_light().is_none();
        self.work.selection.objects().filter(|&object| is_free && Some(object) != ground).collect()
    }

    fn scaled(&self, steps: i32) -> Preferences {
        Preferences { ui_scale: theme::scaled(self.work.preferences.ui_scale, steps), ..self.work.preferences.clone() }
    }

    pub(super) fn ask_for_path(&mut self, action: Action) {
        let path = self.work.file();
        let stem = path.and_then(Path::file_stem).map_or("untitled".into(), |s| s.to_string_lossy().into_owned());
        let name = match &action {
            Action::File(FileAction::SaveAs(_)) => Some(format!("{stem}.{}", session::EXTENSION)),
            Action::Export(ExportAction::Picture(_)) => Some(format!("{stem}.png")),
            Action::Export(ExportAction::Layers(_)) => Some(format!("{stem}-layers.exr")),
            Action::Export(ExportAction::Materials(_)) => Some(format!("{stem}-materials.mtlx")),
            Action::Light(LightAction::Save(_)) => Some(format!("{stem}-lights.json")),
            Action::Material(MaterialAction::Save { material, .. }) => {
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

    /// The folder of the map in use, else of the bundled maps.
    fn folder_of_environments(&self) -> Option<PathBuf> {
        self.work.document.environment.file().or(self.bundled.environments.first().map(PathBuf::as_path)).map(folder_of)
    }
}
