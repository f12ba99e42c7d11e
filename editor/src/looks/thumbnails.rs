//! Small pictures of looks, rendered one after another on a thread.

use super::{Maps, PictureOfDocument};
use crate::{
    document::looks::{LookState, NamedLook},
    widgets::texture_of,
};
use egui::{Context, TextureHandle, TextureOptions};
use lapidary_core::camera::Camera;
use lapidary_render::{BackendFactory, Baked};
use lapidary_studies::{
    export::Studio,
    jobs::{Wake, guarded, spawn},
    sheet::DisplayPicture,
};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Pixels of a thumbnail, and its samples per pixel.
pub const SIZE: [u32; 2] = [160, 100];
const SAMPLES: u32 = 4;

/// A small picture, or nothing if there can be none, and what it shows.
struct Made {
    state: LookState,
    baked: Baked,
    picture: Option<TextureHandle>,
}

/// The thread, which has a renderer of its own.
struct Worker {
    asked: Sender<PictureOfDocument>,
    made: Receiver<Result<DisplayPicture, String>>,
}

/// The pictures.
#[derive(Default)]
pub struct LookThumbnails {
    worker: Option<Worker>,
    made: Vec<Made>,
    /// What the thread works at.
    asked: Option<(LookState, Baked)>,
}

impl LookThumbnails {
    /// Takes the picture that is ready, and forgets those of looks that are gone.
    pub fn collect(&mut self, ctx: &Context, looks: &[NamedLook]) {
        let ready = self.worker.as_ref().and_then(|worker| worker.made.try_recv().ok());
        if let Some((ready, (state, baked))) = ready.and_then(|ready| Some((ready, self.asked.take()?))) {
            let picture = ready.ok().map(|shown| texture_of(ctx, "look", None, &shown, TextureOptions::LINEAR));
            self.made.retain(|made| made.state != state);
            self.made.push(Made { state, baked, picture });
        }
        self.made.retain(|made| looks.iter().any(|look| look.state == made.state));
    }

    /// The picture of a look, also that by an earlier bake.
    pub fn of(&self, look: &LookState) -> Option<&TextureHandle> {
        self.made.iter().find(|made| made.state == *look)?.picture.as_ref()
    }

    /// Asks for the first picture that is missing, by this bake, unless one is being made.
    pub fn ask(&mut self, looks: &[NamedLook], shown: &PictureOfDocument, factory: &BackendFactory, wake: &Wake) {
        let is_made = |look: &&NamedLook| {
            self.made.iter().any(|made| made.state == look.state && made.baked.is_same(&shown.baked))
        };
        let Some(missing) = looks.iter().find(|look| !is_made(look)).filter(|_| self.asked.is_none()) else { return };
        let mut picture =
            PictureOfDocument { size: SIZE, aa: Some(SAMPLES), ..shown.clone() }.with_look(&missing.state);
        fit_width(&mut picture.document.camera, shown.size);
        let worker = self.worker.get_or_insert_with(|| Worker::start(factory.clone(), wake.clone()));
        self.asked = Some((missing.state.clone(), shown.baked.clone()));
        // The thread ends only with its handle.
        let _ = worker.asked.send(picture);
    }
}

/// Narrows the view to what a picture of `shown` pixels has from left to right.
fn fit_width(camera: &mut Camera, shown: [u32; 2]) {
    let aspect = |[width, height]: [u32; 2]| width as f32 / height.max(1) as f32;
    let narrower = (aspect(shown) / aspect(SIZE)).min(1.0);
    camera.fov_y = 2.0 * (narrower * (0.5 * camera.fov_y).tan()).atan();
}

impl Worker {
    fn start(factory: BackendFactory, wake: Wake) -> Self {
        let (asked, inbox) = channel::<PictureOfDocument>();
        let (sender, made) = channel();
        spawn("looks", move || {
            let (mut studio, mut maps) = (None, Maps::default());
            for picture in inbox {
                let made = guarded("the picture of a look", || drawn(&mut studio, &mut maps, &factory, &picture));
                if sender.send(made).is_err() {
                    return;
                }
                wake();
            }
        });
        Self { asked, made }
    }
}

fn drawn(
    studio: &mut Option<Studio>,
    maps: &mut Maps,
    factory: &BackendFactory,
    picture: &PictureOfDocument,
) -> anyhow::Result<DisplayPicture> {
    let known = studio.take().filter(|studio| studio.baked().is_same(&picture.baked));
    let mut taking = match known {
        Some(known) => known,
        None => Studio::new(factory()?, picture.baked.clone())?,
    };
    let shown = taking.take(&picture.look(maps)?, &|| false)?.shown;
    *studio = Some(taking);
    Ok(shown)
}
