//! Opens the window: chooses the renderer and the first document, and explains a missing display.

use super::{
    EditorApp,
    opening::Target,
    state::{Bundled, EditorState, Setup},
};
use crate::{
    document::{absolute, library::maps_in},
    paths::Folders,
    preferences::Preferences,
};
use anyhow::{Result, bail};
use eframe::{NativeOptions, egui_wgpu::WgpuConfiguration};
use egui::{ViewportBuilder, vec2};
use lapidary_studies::jobs::Wake;
use lapidary_studies::{args::BackendOption, bundled::DataFolder};
use std::{path::PathBuf, sync::Arc};

/// How the window begins.
#[derive(Clone, Debug)]
pub struct Launch {
    /// What to open; `None` for the bundled scene.
    pub file: Option<PathBuf>,
    /// The renderer.
    pub backend: BackendOption,
    /// The folder of bundled data; `None` for that of the source tree.
    pub data: Option<PathBuf>,
}

/// Runs the window until it is closed.
///
/// # Errors
/// A folder given that has no data, or no display.
pub fn run(launch: &Launch) -> Result<()> {
    let bundled = bundled(launch)?;
    let folders = Folders::find()?;
    let window = |renderer: eframe::Renderer| {
        let (launch, bundled, folders) = (launch.clone(), bundled.clone(), folders.clone());
        let options = options(renderer, &Preferences::load(&folders.config).0);
        eframe::run_native(
            "Lapidary",
            options,
            Box::new(move |context| Ok(Box::new(app(&context.egui_ctx, &launch, bundled, folders)))),
        )
    };
    // Without an adapter for the window itself, OpenGL may still do; pictures come from the CPU then.
    let Err(first) = window(eframe::Renderer::Wgpu) else { return Ok(()) };
    if is_display_missing() {
        bail!(
            "there is no display to open a window on; set DISPLAY or WAYLAND_DISPLAY, or make pictures without a \
             window: lapidary render --help"
        );
    }
    match window(eframe::Renderer::Glow) {
        Ok(()) => Ok(()),
        Err(second) => bail!(
            "no window can be opened, neither by the graphics adapter ({first}) nor by OpenGL ({second}); install a Vulkan or \
             OpenGL driver (Mesa has one for any machine), or make pictures without a window: lapidary render --help"
        ),
    }
}

fn is_display_missing() -> bool {
    let unset = |name| std::env::var_os(name).is_none_or(|value| value.is_empty());
    cfg!(all(unix, not(target_os = "macos"))) && unset("DISPLAY") && unset("WAYLAND_DISPLAY") && unset("WAYLAND_SOCKET")
}

/// The data are required if they were asked for by name; otherwise the window opens without them.
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
        ..NativeOptions::default()
    }
}

fn app(ctx: &egui::Context, launch: &Launch, bundled: Bundled, folders: Folders) -> EditorApp {
    let wake: Wake = {
        let ctx = ctx.clone();
        Arc::new(move || ctx.request_repaint())
    };
    let backend = launch.backend;
    // Called on the thread that renders, and again when a device is lost.
    let factory = Arc::new(move || backend.open());
    let mut state = EditorState::new(Setup { folders, bundled, factory, wake, system_dialogs: true });
    match &launch.file {
        Some(file) => state.open(Target::File(file.clone())),
        None => state.open_bundled(0),
    }
    EditorApp::new(state)
}
