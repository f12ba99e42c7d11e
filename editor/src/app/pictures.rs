//! What the render thread has made: the picture on the screen, what is known about it, and pictures for files.

use super::state::EditorState;
use crate::{
    document::BackgroundKind,
    jobs::{
        guarded,
        render_thread::{LinearPicture, RenderEvent, RenderedFrame},
        spawn,
    },
};
use anyhow::{Context as _, Result};
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use glam::Vec3;
use lapidary_core::{
    atomic::write_atomically,
    color::linear_from_srgb,
    image::{encode_png, encode_png_with_alpha},
};
use lapidary_render::{Post, ViewMode, display_pixel};
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// How scene-linear pixels are shown.
#[derive(Clone, Copy)]
struct Look {
    mode: ViewMode,
    post: Post,
    count_top: f32,
    /// Nothing lies behind the surfaces.
    transparent: bool,
}

/// The file that a picture was written to, or why it was not.
type Written = Result<PathBuf, String>;

/// Pictures, on the screen and on their way to files.
pub struct Pictures {
    texture: Option<TextureHandle>,
    /// What is known of the picture on the screen; its pixels are in the texture.
    shown: Option<RenderedFrame>,
    exports: Vec<(u64, PathBuf, Look)>,
    exports_asked: u64,
    written: (Sender<Written>, Receiver<Written>),
}

impl Default for Pictures {
    fn default() -> Self {
        Self { texture: None, shown: None, exports: Vec::new(), exports_asked: 0, written: channel() }
    }
}

impl Pictures {
    /// The picture on the screen.
    pub fn texture(&self) -> Option<&TextureHandle> {
        self.texture.as_ref()
    }

    /// What is known about it.
    pub fn shown(&self) -> Option<&RenderedFrame> {
        self.shown.as_ref()
    }

    /// The scene was closed.
    pub fn clear(&mut self) {
        (self.texture, self.shown) = (None, None);
    }

    fn show(&mut self, ctx: &Context, frame: RenderedFrame) {
        let pixels: &[u8] = frame.pixels.as_flattened();
        let image = ColorImage::from_rgba_unmultiplied(frame.size.map(|s| s as usize), pixels);
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => self.texture = Some(ctx.load_texture("picture", image, TextureOptions::LINEAR)),
        }
        self.shown = Some(RenderedFrame { pixels: Vec::new(), ..frame });
    }
}

impl EditorState {
    pub(super) fn collect_pictures(&mut self, ctx: &Context) {
        // A picture of the scene before may still have been on its way.
        if let Some(frame) = self.render.frames()
            && self.scene.shown().is_some_and(|baked| Arc::ptr_eq(&baked.dataset, &frame.dataset))
        {
            self.pictures.show(ctx, frame);
        }
        for event in self.render.events() {
            match event {
                RenderEvent::Remark(text) => self.messages.warning(text),
                RenderEvent::Failed(text) => {
                    self.pictures.clear();
                    self.messages.error(text);
                }
                RenderEvent::Picture { id, result } => self.write_picture(id, result),
            }
        }
        while let Ok(written) = self.pictures.written.1.try_recv() {
            match written {
                Ok(path) => self.messages.note(format!("Picture written ({})", path.display())),
                Err(error) => self.messages.error(error),
            }
        }
    }

    /// Asks for the complete picture, which is written when it is there.
    pub(super) fn export_picture(&mut self, path: PathBuf) {
        if self.scene.shown().is_none() {
            self.messages.error("There is no picture to export; open and bake a scene first");
            return;
        }
        let view = &self.document.view;
        let look = Look {
            mode: view.mode,
            post: view.post,
            count_top: view.mode.count_top(view.illum_cut),
            transparent: view.background == BackgroundKind::Transparent,
        };
        self.pictures.exports_asked += 1;
        let id = self.pictures.exports_asked;
        self.pictures.exports.push((id, path, look));
        self.render.read_picture(id);
        self.messages.note("The picture is written when all its samples are there");
    }

    fn write_picture(&mut self, id: u64, result: Result<LinearPicture, String>) {
        let Some(place) = self.pictures.exports.iter().position(|(other, ..)| *other == id) else { return };
        let (_, path, look) = self.pictures.exports.swap_remove(place);
        let (sender, wake) = (self.pictures.written.0.clone(), self.wake.clone());
        spawn("export", move || {
            let written = result.and_then(|picture| guarded("the export", || write(picture, &path, look)));
            // Nobody is left to tell if the window is gone.
            let _ = sender.send(written.map(|()| path));
            wake();
        });
    }
}

/// A png holds what the window shows but for the wireframe; exr and hdr are scene-linear.
fn write(picture: LinearPicture, path: &Path, look: Look) -> Result<()> {
    let LinearPicture { mut image, coverage } = picture;
    let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if !is_png {
        return Ok(image.write_with(look.transparent.then_some(coverage.as_slice()), path)?);
    }
    for (pixel, &covered) in image.pixels.iter_mut().zip(&coverage) {
        // Alpha says how much of a pixel is covered, so that its colour is that of the surfaces alone.
        let weight = if look.transparent && covered > 0.0 { covered } else { 1.0 };
        let encoded = display_pixel(look.mode, &look.post, look.count_top, *pixel / weight);
        *pixel = Vec3::from_array(encoded.to_array().map(linear_from_srgb));
    }
    let bytes = if look.transparent { encode_png_with_alpha(&image, &coverage) } else { encode_png(&image) };
    write_atomically(path, &bytes)
        .with_context(|| format!("cannot write the picture; check the free space and permissions ({})", path.display()))
}
