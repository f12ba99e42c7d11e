//! Opens the window: chooses the renderer and the first document, and explains a missing display.

use super::{
    EditorApp,
    pacing::Pacing,
    state::{Bundled, EditorState, Setup},
};
use crate::{
    document::{absolute, library::maps_in},
    jobs::opening::Target,
    paths::Folders,
    preferences::Preferences,
};
use anyhow::{Result, bail};
use eframe::{NativeOptions, egui_wgpu::WgpuConfiguration};
use egui::{ViewportBuilder, vec2};
use lapidary_studies::{
    args::{AdapterMemory, DeviceArgs, PathMemory},
    bundled::DataFolder,
    jobs::Wake,
};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex},
    time::Duration,
};

/// How the window begins.
#[derive(Clone, Debug)]
pub struct Launch {
    /// File to open; `None` for the bundled scene.
    pub file: Option<PathBuf>,
    /// The renderer.
    pub device: DeviceArgs,
    /// The folder of bundled data; `None` for the source tree's.
    pub data: Option<PathBuf>,
}

/// Runs the window until it is closed.
///
/// # Errors
/// A data folder without data, or no display.
pub fn run(launch: &Launch) -> Result<()> {
    let bundled = bundled(launch)?;
    let folders = Folders::find()?;
    if is_display_missing() {
        bail!(
            "there is no display to open a window on; set DISPLAY or WAYLAND_DISPLAY, or make pictures without a \
             window: lapidary render --help"
        );
    }
    let is_emulated = !lapidary_render::gpu::has_hardware();
    let pacing = move || is_emulated.then(Pacing::new);
    let window = |renderer: eframe::Renderer| {
        let (launch, bundled, folders) = (launch.clone(), bundled.clone(), folders.clone());
        let options = options(renderer, &Preferences::load(&folders.config).0);
        eframe::run_native(
            "Lapidary",
            options,
            Box::new(move |context| Ok(Box::new(app(&context.egui_ctx, &launch, bundled, folders, pacing())))),
        )
    };
    let [first, second] = drawers(is_emulated);
    let Err(error) = window(first) else { return Ok(()) };
    let Err(other) = window(second) else { return Ok(()) };
    bail!(
        "no window can be opened, neither by {} ({error}) nor by {} ({other}); install a Vulkan or OpenGL driver (Mesa \
         has one for any machine), or make pictures without a window: lapidary render --help",
        drawer_name(first),
        drawer_name(second)
    )
}

/// First and second choice for drawing the window. Where graphics are emulated, OpenGL comes first: the window's wgpu shader takes
/// seven times as long there, at the renderer's cost.
fn drawers(is_emulated: bool) -> [eframe::Renderer; 2] {
    let (wgpu, opengl) = (eframe::Renderer::Wgpu, eframe::Renderer::Glow);
    if is_emulated { [opengl, wgpu] } else { [wgpu, opengl] }
}

fn drawer_name(drawer: eframe::Renderer) -> &'static str {
    match drawer {
        eframe::Renderer::Wgpu => "the graphics adapter",
        eframe::Renderer::Glow => "OpenGL",
    }
}

fn is_display_missing() -> bool {
    let unset = |name| std::env::var_os(name).is_none_or(|value| value.is_empty());
    cfg!(all(unix, not(target_os = "macos"))) && unset("DISPLAY") && unset("WAYLAND_DISPLAY") && unset("WAYLAND_SOCKET")
}

/// Bundled data. They are required if their folder was given; otherwise the window opens without them.
fn bundled(launch: &Launch) -> Result<Bundled> {
    match DataFolder::find(launch.data.as_deref()) {
        Ok(data) => Ok(Bundled {
            scenes: data.scenes().iter().map(|scene| absolute(scene)).collect(),
            environments: maps_in(&absolute(&data.environment_folder())),
        }),
        Err(error) if launch.data.is_some() => Err(error),
        Err(_) => Ok(Bundled::default()),
    }
}

fn options(renderer: eframe::Renderer, preferences: &Preferences) -> NativeOptions {
    NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Lapidary")
            .with_app_id("lapidary")
            .with_inner_size(preferences.window_size)
            .with_min_inner_size(vec2(800.0, 500.0))
            .with_drag_and_drop(true),
        renderer,
        wgpu_options: WgpuConfiguration::default(),
        // Pictures come in the colors of the screen.
        dithering: false,
        ..NativeOptions::default()
    }
}

fn app(ctx: &egui::Context, launch: &Launch, bundled: Bundled, folders: Folders, pacing: Option<Pacing>) -> EditorApp {
    let wake: Wake = {
        let ctx = ctx.clone();
        // A request without delay would draw the window twice, for widgets that settle; results of other threads do not need that.
        Arc::new(move || ctx.request_repaint_after(Duration::from_millis(1)))
    };
    let device = launch.device;
    let memory = PathMemory::new(Mutex::new(Preferences::load(&folders.config).0.gpu_path));
    let known = AdapterMemory { path: memory.clone(), pipelines: Some(folders.pipelines()) };
    // Called on the thread that renders, and again when a device is lost.
    let factory = Arc::new(move || device.open_with(&known));
    let mut state = EditorState::new(Setup { folders, bundled, factory, memory, wake, system_dialogs: true });
    match &launch.file {
        Some(file) => state.open(Target::File(file.clone())),
        None => state.open_bundled(0),
    }
    EditorApp::new(state, pacing)
}
