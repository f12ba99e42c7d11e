//! The editor without a window: files are opened, edited, saved and reopened, and questions appear when they must.

mod actual_window;
mod animations;
mod bounces;
mod brdfs;
mod changed_files;
mod comparison;
mod documents;
mod export;
mod first_look;
mod ground;
mod handles;
mod hands;
mod kept;
mod lights;
mod looks;
mod materials;
mod objects;
mod panels;
mod parts;
mod poses;

use super::state::{Bundled, EditorState, Setup};
use crate::{
    actions::{Action, CameraAction, ExportAction},
    bake::{Asker, BakeOrder, From, panel::BakeStatus},
    jobs::opening::Target,
    paths::Folders,
    preferences::Preferences,
};
use egui::{Key, Modifiers, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use lapidary_core::dataset::BakeSettings;
use lapidary_interchange::{image, import::import};
use lapidary_precompute::{BakeJob, Preset, Silent, bake, resolve};
use lapidary_render::CpuBackend;
use lapidary_studies::args::PathMemory;
use std::{
    cell::Cell,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

/// A floor and a pyramid on it.
const SCENE: &str = "\
o floor\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n\
o pyramid\nv -0.3 0 -0.3\nv 0.3 0 -0.3\nv 0.3 0 0.3\nv -0.3 0 0.3\nv 0 0.6 0\nf 5 9 6\nf 6 9 7\nf 7 9 8\nf 8 9 5\n";

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.obj"), SCENE).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn bake(&self) {
        let scene = import(&self.path("scene.obj")).unwrap().scene;
        let output = self.path("scene.cuts");
        let job = BakeJob::new(resolve(few_lights()).unwrap(), output);
        bake(scene, &job, &Silent).unwrap();
    }

    fn window(&self) -> Window {
        self.window_of(vec2(1100.0, 760.0))
    }

    fn window_of(&self, size: egui::Vec2) -> Window {
        let home = self.path("home");
        let folders = Folders { config: home.join("config"), state: home.join("state"), cache: home.join("cache") };
        // Tests start bakes themselves.
        let quiet = Preferences { bakes_scenes: false, follows_edits: false, ..Preferences::load(&folders.config).0 };
        quiet.save(&folders.config).unwrap();
        let setup = Setup {
            folders,
            bundled: Bundled::default(),
            factory: Arc::new(|| Ok(Box::new(CpuBackend::new()))),
            memory: PathMemory::default(),
            wake: Arc::new(|| ()),
            system_dialogs: false,
        };
        let builder = Harness::builder().with_size(size);
        Window(builder.build_ui_state(|ui, state: &mut EditorState| state.frame(ui), EditorState::new(setup)))
    }
}

/// Traces every light, since boundaries between so few reveal little.
fn few_lights() -> BakeSettings {
    let draft = Preset::Draft.settings();
    BakeSettings { lights: 256, pilot_clusters: 8, max_vertices: None, exhaustive: true, ..draft }
}

struct Window(Harness<'static, EditorState>);

/// How long something may take: far longer than it does, since other tests keep the cores busy.
const PATIENCE: Duration = Duration::from_secs(90);

impl Window {
    fn open(&mut self, path: &Path) {
        self.0.state_mut().open(Target::File(path.to_owned()));
        self.wait("the file", |s| s.opening.is_none());
    }

    /// Runs frames until a condition holds.
    fn wait(&mut self, what: &str, is_so: impl Fn(&EditorState) -> bool) {
        let start = Instant::now();
        self.0.step();
        while !is_so(self.0.state()) {
            assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(5));
            self.0.step();
        }
        self.0.run_steps(2);
    }

    /// Changes a file until the window notices. The watcher runs on a thread of its own, and misses changes before its first look.
    fn wait_for_watch(&mut self, what: &str, change: impl Fn(), is_so: impl Fn(&EditorState) -> bool) {
        const BETWEEN_CHANGES: Duration = Duration::from_secs(5);
        let changed = Cell::new(None::<Instant>);
        self.wait(what, |state| {
            if changed.get().is_none_or(|at| at.elapsed() > BETWEEN_CHANGES) {
                change();
                changed.set(Some(Instant::now()));
            }
            is_so(state)
        });
    }

    /// Begins an automatic bake.
    fn bake_by_itself(&mut self, draft_first: bool) {
        let order = BakeOrder { asked_by: Asker::Nobody, from: From::Beginning, draft_first };
        let state = self.0.state_mut();
        state.baking.bake(&mut state.work, order);
    }

    fn bake_status(&mut self) -> BakeStatus {
        let state = self.0.state_mut();
        state.baking.status(&state.work)
    }

    fn perform(&mut self, action: Action) {
        let ctx = self.0.ctx.clone();
        self.0.state_mut().perform(&ctx, action);
        self.0.run_steps(2);
    }

    fn click(&mut self, label: &str) {
        self.0.get_by_label(label).click();
        self.0.run_steps(3);
    }

    /// Menus have an arrow after their name.
    fn click_containing(&mut self, label: &str) {
        self.0.get_by_label_contains(label).click();
        self.0.run_steps(3);
    }

    fn shows(&self, label: &str) -> bool {
        self.0.query_all_by_label_contains(label).next().is_some()
    }

    fn type_roughness(&mut self, text: &str) {
        let entry = self.0.get_by_label("Roughness value");
        entry.click();
        self.0.run_steps(3);
        self.0.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.0.get_by_label("Roughness value").type_text(text);
        self.0.run_steps(2);
        self.0.key_press(Key::Enter);
        self.0.run_steps(3);
    }

    fn roughness(&self) -> f32 {
        self.0.state().work.document.materials[0].parameters.number("roughness")
    }

    fn drop_file(&mut self, path: PathBuf) {
        self.0.input_mut().dropped_files = vec![Arc::new(Dropped(path))];
        self.0.run_steps(2);
    }

    /// Name of the step that undo would revert.
    fn undo_name(&self) -> Option<String> {
        let state = self.0.state();
        state.work.history.undo_name(&state.work.document)
    }

    fn has_said(&self, text: &str) -> bool {
        self.0.state().work.messages.any_contains(text)
    }
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Ok(Vec::new())
    }
}

#[test]
fn at_rest_nothing_asks_for_another_frame() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("the whole picture", |s| s.picture.shown().is_some_and(|p| p.samples == p.of_samples));
    // The preview ball and other pictures come from threads, and each asks for a frame.
    let start = Instant::now();
    while window.0.try_run().is_err() {
        assert!(start.elapsed() < PATIENCE, "frames go on and on");
    }
}

#[test]
fn the_camera_goes_back_to_where_the_scene_was_first_seen_from() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    let first = window.0.state().work.document.camera.clone();
    window.perform(Action::Camera(CameraAction::To(lapidary_core::camera::Camera {
        eye: glam::Vec3::ONE,
        ..first.clone()
    })));
    window.perform(Action::Camera(CameraAction::FrameAll));
    assert_ne!(window.0.state().work.document.camera, first, "negative control");
    window.0.key_press(Key::Home);
    window.0.run_steps(2);
    assert_eq!(window.0.state().work.document.camera, first);
}

#[test]
fn an_exported_picture_is_that_of_the_window_with_its_wireframe() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window.0.key_press_modifiers(Modifiers::SHIFT, Key::W);
    window.0.run_steps(2);
    let with = exported(&mut window, &place.path("with.png"));
    window.0.key_press_modifiers(Modifiers::SHIFT, Key::W);
    window.0.run_steps(2);
    let without = exported(&mut window, &place.path("without.png"));
    // The lines' color is more blue than red by far.
    let lines = |texels: &[[u8; 4]]| texels.iter().filter(|[r, _, b, _]| b.saturating_sub(*r) > 100).count();
    assert!(lines(&with) > 100 && lines(&without) == 0, "{} and {}", lines(&with), lines(&without));
}

/// Exports the picture on the screen and reads it.
fn exported(window: &mut Window, path: &Path) -> Vec<[u8; 4]> {
    window.perform(Action::Export(ExportAction::Picture(Some(path.to_owned()))));
    window.wait("the file", |_| path.is_file());
    let read = lapidary_interchange::image::decode(&std::fs::read(path).unwrap(), path).unwrap();
    let shown = window.0.state().picture.shown().unwrap();
    assert_eq!((shown.samples, read.size), (shown.of_samples, shown.size));
    let lapidary_core::texture::Texels::U8(texels) = read.texels else { panic!("8 bits per channel") };
    assert_eq!(texels, shown.pixels);
    texels
}

#[test]
fn undoing_is_said_only_in_passing() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.type_roughness("0.1");
    window.perform(Action::Undo);
    assert!(window.shows("Undone: Roughness"));
    window.open(&place.path("gone.obj"));
    assert!(!window.shows("Undone: Roughness"), "an error takes its place");
}

#[test]
fn a_dropped_picture_goes_on_the_selected_material_as_a_step_of_undo() {
    let place = Place::new();
    place.bake();
    let image = lapidary_core::image::Image::filled([3, 3], glam::Vec3::X);
    image::write(&image, &place.path("red.png")).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.drop_file(place.path("red.png"));
    window.wait("the texture", |s| s.work.document.materials[0].maps.get("base_color").is_some());
    window.perform(Action::Undo);
    assert!(window.0.state().work.document.materials[0].maps.get("base_color").is_none());
}

#[test]
fn keys_act_and_a_failed_open_keeps_what_is_open() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.key_press(Key::Num2);
    window.0.run_steps(3);
    assert_eq!(window.0.state().work.document.view.mode, lapidary_render::ViewMode::Normals);
    window.0.key_press(Key::F1);
    window.0.run_steps(3);
    assert!(window.shows("Keyboard and pointer"));
    window.open(&place.path("gone.obj"));
    assert!(window.has_said("gone.obj") && window.0.state().work.scene.shown().is_some());
}

#[test]
fn a_changed_texture_of_the_scene_is_loaded_again() {
    let place = Place::new();
    let write =
        |color| image::write(&lapidary_core::image::Image::filled([2, 2], color), &place.path("paint.png")).unwrap();
    write(glam::Vec3::X);
    std::fs::write(place.path("scene.mtl"), "newmtl paint\nmap_Kd paint.png\n").unwrap();
    let obj = std::fs::read_to_string(place.path("scene.obj")).unwrap();
    std::fs::write(place.path("scene.obj"), format!("mtllib scene.mtl\nusemtl paint\n{obj}")).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("the watch", |s| s.watcher.watched.contains(&place.path("paint.png")));
    let old = window.0.state().work.document.textures[0].texture.clone();
    let repaint =
        || image::write(&lapidary_core::image::Image::filled([4, 2], glam::Vec3::Y), &place.path("paint.png")).unwrap();
    window.wait_for_watch("the new texture", repaint, |s| s.work.document.textures[0].texture.size == [4, 2]);
    assert_eq!((old.size, &*old.name), ([2, 2], "paint.png"));
    assert_eq!(window.0.state().work.document.textures[0].texture.name, "paint.png", "as the scene has it");
    assert!(window.has_said("Reloaded"));
}

#[test]
fn a_changed_texture_is_loaded_again() {
    let place = Place::new();
    place.bake();
    let write =
        |color| image::write(&lapidary_core::image::Image::filled([2, 2], color), &place.path("paint.png")).unwrap();
    write(glam::Vec3::X);
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.drop_file(place.path("paint.png"));
    window.wait("the texture", |s| s.work.document.materials[0].maps.get("base_color").is_some());
    let old = window.0.state().work.document.textures[0].texture.clone();
    window.wait("the watch", |s| !s.watcher.watched.is_empty());
    let repaint =
        || image::write(&lapidary_core::image::Image::filled([4, 2], glam::Vec3::Y), &place.path("paint.png")).unwrap();
    window.wait_for_watch("the new texture", repaint, |s| !Arc::ptr_eq(&s.work.document.textures[0].texture, &old));
    assert!(window.has_said("Reloaded"));
}

#[test]
fn what_is_typed_into_a_field_is_no_command_even_if_enter_comes_in_the_same_frame() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.click("Base color hex");
    let key = |key, pressed| egui::Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: NONE };
    let keys = || [key(Key::Num5, true), egui::Event::Text("5".into()), key(Key::Num5, false), key(Key::Enter, true)];
    window.0.input_mut().events.extend(keys());
    window.0.run_steps(2);
    assert_eq!(window.0.state().work.document.view.mode, lapidary_render::ViewMode::Shaded);
    window.0.input_mut().events.extend(keys());
    window.0.run_steps(2);
    assert_eq!(window.0.state().work.document.view.mode, lapidary_render::ViewMode::VisibilityCut, "negative control");
}

const NONE: Modifiers = Modifiers::NONE;
