//! The real window on a virtual display, driven by input events. Its screen is compared with the picture that the document asks
//! for. Positions of controls come from the same interface run without a window.
//!
//! It keeps the cores busy for long, yet may run beside any other test: all of them wait with ample margin.

use super::{Place, Window};
use crate::{
    actions::{Action, FileAction},
    document::Document,
    look::{illumination, view_of},
};
use egui_kittest::kittest::Queryable;
use lapidary_core::{dataset::Dataset, texture::Texels};
use lapidary_interchange::{
    environment,
    image::{self, decode},
};
use lapidary_render::{Backend, CpuBackend, LitScene, Look};
use std::{
    path::{Path, PathBuf},
    process::{Child, Command},
    sync::Arc,
    time::{Duration, Instant},
};

/// Size of the window, and of the screen, in pixels.
const SIZE: [u32; 2] = [1440, 900];
/// Margin of the harness around the interface in points.
const MARGIN: egui::Vec2 = egui::Vec2::splat(8.0);

/// A virtual display with the program on it; both end with it.
struct Screen {
    display: String,
    processes: Vec<Child>,
}

impl Drop for Screen {
    fn drop(&mut self) {
        for process in self.processes.iter_mut().rev() {
            // It may have ended already.
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

impl Screen {
    /// Starts display and program.
    fn start(program: &Path, place: &Place) -> Self {
        let (server, display) = display();
        let editor = Command::new(program)
            .args(["edit", "look.lapidary", "--backend", "cpu"])
            .current_dir(place.folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("LAPIDARY_HOME", place.path("window-home"))
            .spawn()
            .unwrap();
        Self { display, processes: vec![server, editor] }
    }

    /// Sends input in the syntax of `xdotool`.
    fn input(&self, words: &str) {
        let status = Command::new("xdotool").args(words.split(' ')).env("DISPLAY", &self.display).status().unwrap();
        assert!(status.success(), "xdotool {words}");
        std::thread::sleep(Duration::from_millis(60));
    }

    /// Drags from one position of the harness to another, as slowly as a hand does.
    fn drag(&self, [from, to]: [egui::Pos2; 2]) {
        for step in [move_to(from), "mousedown 1".into(), move_to(to), "mouseup 1".into()] {
            self.input(&step);
            std::thread::sleep(Duration::from_millis(140));
        }
    }

    /// Pixels of the screen in a rectangle.
    fn capture(&mut self, rect: egui::Rect) -> Vec<[u8; 4]> {
        assert!(self.processes[1].try_wait().unwrap().is_none(), "the program has ended");
        let picture = Command::new("import").args(["-window", "root", "png:-"]).env("DISPLAY", &self.display).output();
        let texture = decode(&picture.unwrap().stdout, Path::new("screen.png")).unwrap();
        let Texels::U8(texels) = texture.texels else { panic!("8 bits per channel") };
        let [left, top] = [rect.min.x.round() as u32, rect.min.y.round() as u32];
        let [width, height] = [rect.width().round() as u32, rect.height().round() as u32];
        let texel = |x: u32, y: u32| texels[((top + y) * texture.size[0] + left + x) as usize];
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect()
    }

    /// Waits until the screen shows `expected`, to a mean difference of a code value.
    fn wait_for(&mut self, what: &str, rect: egui::Rect, expected: &[[u8; 4]]) {
        if let Err(error) = self.shows(rect, expected, Duration::from_secs(90)) {
            let kept = std::env::temp_dir().join("lapidary-window.png");
            let _ = Command::new("import").args(["-window", "root"]).arg(&kept).env("DISPLAY", &self.display).status();
            panic!("{what} is off by {error} code values; the screen is kept in {}", kept.display());
        }
    }

    /// Whether the screen comes to show `expected` within `patience`; else how far off it is, in code values.
    fn shows(&mut self, rect: egui::Rect, expected: &[[u8; 4]], patience: Duration) -> Result<(), f64> {
        let start = Instant::now();
        loop {
            let error = difference(&self.capture(rect), expected);
            if error < 1.0 {
                return Ok(());
            }
            if start.elapsed() > patience {
                return Err(error);
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

/// A virtual display that answers, and its name. Its number is that of this process, which two runs at once do not share; where
/// another server has it, the next one is tried.
fn display() -> (Child, String) {
    let first = 100 + std::process::id() % 10_000;
    for name in (first..first + 5).map(|number| format!(":{number}")) {
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        // Between two clients it does not start anew.
        let mut server = Command::new("Xvfb").args([&name, "-noreset", "-screen", "0", &screen]).spawn().unwrap();
        if answers(&mut server, &name) {
            return (server, name);
        }
        // It may have ended already.
        let _ = server.kill();
        let _ = server.wait();
    }
    panic!("Xvfb does not start a display; what it said stands above");
}

/// Whether a display comes to answer a client before its server ends.
fn answers(server: &mut Child, name: &str) -> bool {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(20) && server.try_wait().unwrap().is_none() {
        let client = Command::new("xdotool").arg("getdisplaygeometry").env("DISPLAY", name).output().unwrap();
        if client.status.success() {
            // Another server with the same number may have answered while this one ends.
            std::thread::sleep(Duration::from_millis(200));
            return server.try_wait().unwrap().is_none();
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    false
}

fn difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pixel = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| u64::from(a[c].abs_diff(b[c]))).sum::<u64>();
    a.iter().zip(b).map(pixel).sum::<u64>() as f64 / (3 * a.len()) as f64
}

/// The picture that a document asks for.
fn expected(document: &Document, dataset: &Arc<Dataset>, size: [u32; 2]) -> Vec<[u8; 4]> {
    let (environment, _) = environment::from_spec(&document.environment.spec).unwrap();
    let light = illumination(document, environment.into());
    let look = Look {
        appearance: document.appearance(),
        illum_cut: document.view.illum_cut,
        sampling: document.view.sampling,
        post: document.view.post,
        ..Look::under_environment(&dataset.scene, view_of(document, size), light)
    };
    let backend: Box<dyn Backend> = Box::new(CpuBackend::new());
    let mut scene = LitScene::new(backend, dataset.clone().into()).unwrap();
    scene.show_whole(&look).unwrap();
    scene.display(&look.post).unwrap()
}

/// A missing requirement of the test, if any.
fn missing() -> Option<String> {
    let tools = ["Xvfb", "xdotool", "import"];
    let is_there = |tool: &&str| {
        !std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).any(|p| p.join(tool).is_file())
    };
    let missing: Vec<&str> = tools.into_iter().filter(is_there).collect();
    if !missing.is_empty() {
        return Some(format!("{} must be installed", missing.join(", ")));
    }
    (!program().is_file()).then(|| format!("the program is not built ({})", program().display()))
}

/// The program beside the folder of the tests.
fn program() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    tests.parent().and_then(Path::parent).unwrap().join("lapidary")
}

#[test]
fn dragging_roughness_and_turning_the_environment_show_in_the_real_window() {
    if let Some(reason) = missing() {
        assert!(
            std::env::var_os("LAPIDARY_REQUIRE_DISPLAY").is_none(),
            "LAPIDARY_REQUIRE_DISPLAY is set, but {reason}"
        );
        eprintln!("SKIPPED: {reason}");
        return;
    }
    let place = Place::new();
    place.bake();
    let dataset = Arc::new(polished(&place.path("scene.cuts")));
    let mut twin = place.window_of(egui::vec2(SIZE[0] as f32, SIZE[1] as f32) + 2.0 * MARGIN);
    twin.open(&place.path("scene.cuts"));
    // Program, twin and expectation all render large pictures beside other tests, whose work would wait for theirs.
    twin.0.state_mut().work.document.view.aa = 2;
    // A session keeps its camera; a scene's camera is fitted to the viewport, which has no size at first.
    twin.perform(Action::File(FileAction::SaveAs(Some(place.path("look.lapidary")))));
    let viewport = twin.0.get_by_label("Viewport").rect().translate(-MARGIN);
    let size = twin.0.state().work.viewport_size;
    let mut screen = Screen::start(&program(), &place);
    let shown = |document: &Document| expected(document, &dataset, size);
    let before = shown(&twin.0.state().work.document);
    screen.wait_for("the first picture", viewport, &before);

    let slider = drag_roughness(&mut twin);
    let rough = shown(&twin.0.state().work.document);
    let seen = difference(&rough, &before);
    assert!(seen > 2.0, "negative control: roughness is seen: {seen}");
    // Press and release within one frame are no drag, and on a busy machine a frame can be long.
    for patience in [10, 20, 30] {
        screen.drag(slider);
        if screen.shows(viewport, &rough, Duration::from_secs(patience)).is_ok() {
            break;
        }
    }
    screen.wait_for("the picture after roughness was dragged", viewport, &rough);

    turn_environment(&mut twin, &screen, viewport);
    let turned = shown(&twin.0.state().work.document);
    assert!(difference(&turned, &rough) > 2.0, "negative control: the turn is seen");
    screen.wait_for("the picture after the environment was turned", viewport, &turned);
}

/// The dataset with materials of metal, whose roughness is seen everywhere.
fn polished(path: &Path) -> Dataset {
    let mut dataset = Dataset::read(path, image::decode).unwrap();
    for material in &mut dataset.scene.materials {
        material.parameters.set("metalness", 1.0);
    }
    dataset.write(path).unwrap();
    dataset
}

/// Drags the slider in the twin, and returns both ends of the drag.
fn drag_roughness(twin: &mut Window) -> [egui::Pos2; 2] {
    let slider = twin.0.get_by_label("Roughness").rect();
    let (from, to) = (slider.center().round(), slider.lerp_inside(egui::vec2(0.04, 0.5)).round());
    twin.0.drag_at(from);
    twin.0.run_steps(2);
    twin.0.hover_at(to);
    twin.0.run_steps(2);
    twin.0.drop_at(to);
    twin.0.run_steps(4);
    assert!(twin.roughness() < 0.4, "the slider was dragged: {}", twin.roughness());
    [from, to]
}

/// Moves the real pointer to where a position of the harness is in the window.
fn move_to(position: egui::Pos2) -> String {
    let real = position - MARGIN;
    format!("mousemove {} {}", real.x, real.y)
}

/// Turns the environment by the key for it, twelve times.
fn turn_environment(twin: &mut Window, screen: &Screen, viewport: egui::Rect) {
    let over = (viewport.center() + MARGIN).round();
    screen.input(&move_to(over));
    // No window manager gives the window the keys.
    screen.input("search --onlyvisible --name Lapidary windowfocus");
    twin.0.hover_at(over);
    for _ in 0..12 {
        screen.input("key bracketright");
        twin.0.key_press(egui::Key::CloseBracket);
        twin.0.run_steps(2);
    }
    let turned = twin.0.state().work.document.environment.rotation_degrees;
    assert!((turned + 60.0).abs() < 1e-3, "the keys turned it: {turned}");
}
