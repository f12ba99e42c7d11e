//! The picture behind the scene: read beside the window whenever the document names another one.

use crate::{document::BackgroundKind, workspace::Workspace};
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_render::Backplate;
use lapidary_studies::{
    export::backplate,
    jobs::{guarded, spawn},
};
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, channel},
    },
};

/// The picture behind the scene.
#[derive(Default)]
pub struct BackplateShown {
    asked: Option<PathBuf>,
    reading: Option<Receiver<Result<Backplate, String>>>,
    shown: Option<(Arc<Backplate>, TextureHandle)>,
}

impl BackplateShown {
    /// Reads the document's, if it is another one, and takes it when it is there.
    pub fn follow(&mut self, work: &mut Workspace, ctx: &Context) {
        if self.asked != work.document.view.backplate {
            self.read(work.document.view.backplate.clone(), work);
        }
        let Some(result) = self.reading.as_ref().and_then(|reading| reading.try_recv().ok()) else { return };
        self.reading = None;
        match result {
            Ok(plate) => {
                let texture = ctx.load_texture("backplate", image_of(&plate), TextureOptions::LINEAR);
                self.shown = Some((Arc::new(plate), texture));
            }
            Err(error) => work.messages.error(error),
        }
    }

    /// Reads it again, if it is of this file.
    pub fn reload(&mut self, path: &Path, work: &Workspace) {
        if self.asked.as_deref() == Some(path) {
            let kept = self.shown.take();
            self.read(self.asked.clone(), work);
            self.shown = kept;
        }
    }

    fn read(&mut self, path: Option<PathBuf>, work: &Workspace) {
        self.asked.clone_from(&path);
        (self.reading, self.shown) = (None, None);
        let Some(path) = path else { return };
        let ((sender, receiver), wake) = (channel(), work.wake.clone());
        self.reading = Some(receiver);
        spawn("backplate", move || {
            // Fails only if another one was chosen meanwhile.
            let _ = sender.send(guarded("the background picture", || backplate::read(&path)));
            wake();
        });
    }

    /// Why pictures cannot be written yet: the document shows a picture that is not there.
    pub fn problem(&self, work: &Workspace) -> Option<String> {
        let view = &work.document.view;
        let path = view.backplate.as_ref().filter(|_| view.background == BackgroundKind::Picture)?;
        let text = "the picture behind the scene is not read; try again in a moment, or choose another background";
        self.shown.is_none().then(|| format!("{text} ({})", path.display()))
    }

    /// The picture, for exports.
    pub fn picture(&self) -> Option<Arc<Backplate>> {
        self.shown.as_ref().map(|(plate, _)| plate.clone())
    }

    /// The picture and its texture.
    pub fn texture(&self) -> Option<(&Backplate, &TextureHandle)> {
        self.shown.as_ref().map(|(plate, texture)| (&**plate, texture))
    }
}

fn image_of(plate: &Backplate) -> ColorImage {
    let pixels = plate.pixels().iter().map(|&[r, g, b]| Color32::from_rgb(r, g, b)).collect();
    ColorImage::new(plate.size().map(|side| side as usize), pixels)
}
