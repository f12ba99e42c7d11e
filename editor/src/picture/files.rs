//! Takes results of the render thread: the picture for the screen, and pictures for files.

use super::state::{Export, Picture};
use crate::{
    document::BackgroundKind,
    jobs::render_thread::{LinearPicture, RenderEvent},
    workspace::{Workspace, Written},
};
use anyhow::Result;
use egui::Context;
use lapidary_interchange::image;
use lapidary_render::Background;
use lapidary_studies::{
    jobs::{guarded, spawn},
    sheet::DisplayPicture,
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

impl Picture {
    /// Takes results of the render thread.
    pub fn collect(&mut self, work: &mut Workspace, ctx: &Context) {
        // Before the frames, so that an awaited picture is on the screen when its event is handled.
        let events = self.render.events();
        // A picture of the previous scene may arrive late.
        if let Some(frame) = self.render.frames()
            && work.scene.rendered().is_some_and(|baked| Arc::ptr_eq(&baked.dataset, &frame.dataset))
        {
            self.show(ctx, frame);
        }
        for event in events {
            match event {
                RenderEvent::Remark(text) => work.messages.warning(text),
                RenderEvent::Failed(text) => {
                    self.clear();
                    work.messages.error(text);
                }
                RenderEvent::Picture { id, result } => self.write(work, id, result),
            }
        }
        while let Ok(written) = self.written.1.try_recv() {
            match written {
                Ok(path) => work.messages.note(format!("Picture written ({})", path.display())),
                Err(error) => work.messages.error(error),
            }
        }
    }

    /// Requests the complete picture, and writes it when ready.
    pub fn export(&mut self, work: &mut Workspace, path: PathBuf) {
        if work.scene.rendered().is_none() {
            work.messages.error("There is no picture to export; open and bake a scene first");
            return;
        }
        if let Some(problem) = self.backplate.problem(work) {
            work.messages.error(problem);
            return;
        }
        if !work.may_write(&path, Written::Other) {
            return;
        }
        let transparent = work.document.view.background() == Background::Transparent;
        let is_over_picture = work.document.view.background == BackgroundKind::Picture;
        let backplate = self.backplate.picture().filter(|_| is_over_picture);
        self.exports_asked += 1;
        let id = self.exports_asked;
        self.exports.push(Export { id, path, transparent, backplate });
        self.render.read_picture(id);
        work.messages.note("The picture will be written once all samples are done");
    }

    fn write(&mut self, work: &Workspace, id: u64, result: Result<LinearPicture, String>) {
        let Some(place) = self.exports.iter().position(|export| export.id == id) else { return };
        let shown = self.shown.as_ref().filter(|s| s.full_size && s.samples == s.of_samples);
        let is_png = self.exports[place].is_png();
        if is_png && result.is_ok() && shown.is_none() {
            // Waits for the next one, which was requested already.
            return self.render.read_picture(id);
        }
        let shown = shown.filter(|_| is_png).map(|shown| (shown.pixels.clone(), shown.size));
        let Export { path, transparent, backplate, .. } = self.exports.swap_remove(place);
        let (sender, wake) = (self.written.0.clone(), work.wake.clone());
        spawn("export", move || {
            let write = |picture: LinearPicture| match shown {
                Some((pixels, size)) => {
                    let mut pixels = pixels.to_vec();
                    backplate.iter().for_each(|plate| plate.behind(&mut pixels, size));
                    write_png(&pixels, size, transparent, &path)
                }
                None => write_linear(&picture, transparent, &path),
            };
            let written = result.and_then(|picture| guarded("the export", || write(picture)));
            // Fails only if the window is gone.
            let _ = sender.send(written.map(|()| path));
            wake();
        });
    }
}

fn write_linear(picture: &LinearPicture, transparent: bool, path: &Path) -> Result<()> {
    Ok(image::write_with(&picture.image, transparent.then_some(picture.coverage.as_slice()), path)?)
}

/// Writes display values. Alpha is the coverage of a pixel; its color is of the surfaces alone.
fn write_png(pixels: &[[u8; 4]], size: [u32; 2], transparent: bool, path: &Path) -> Result<()> {
    let alpha = |alpha| if transparent { alpha } else { 255 };
    let pixels = pixels.iter().map(|&[r, g, b, a]| [r, g, b, alpha(a)]).collect();
    DisplayPicture { size, pixels }.write_png(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::texture::Texels;
    use lapidary_interchange::image::decode;

    #[test]
    fn a_png_holds_every_value_that_is_shown() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let pixels: Vec<[u8; 4]> = (0..=255).map(|v| [v, 255 - v, v / 2, v]).collect();
        for transparent in [true, false] {
            write_png(&pixels, [16, 16], transparent, &path).unwrap();
            let read = decode(&std::fs::read(&path).unwrap(), &path).unwrap();
            let Texels::U8(texels) = read.texels else { panic!("8 bits per channel") };
            let alpha = |pixel: &[u8; 4]| if transparent { pixel[3] } else { 255 };
            let expected: Vec<[u8; 4]> = pixels.iter().map(|p| [p[0], p[1], p[2], alpha(p)]).collect();
            assert_eq!(texels, expected);
        }
    }
}
