//! Small pictures of looks, rendered one after another on a thread.

use super::{Maps, PictureOfDocument};
use crate::{
    document::looks::{LookState, NamedLook},
    widgets::texture_of,
};
use egui::{Context, TextureHandle, TextureOptions};
use lapidary_core::{camera::Camera, dataset::Dataset, scene::pose::Poses};
use lapidary_render::{BackendFactory, Baked};
use lapidary_studies::{
    export::Studio,
    jobs::{Wake, guarded, spawn},
    sheet::DisplayPicture,
};
use std::{
    ptr,
    sync::{
        Arc, Weak,
        mpsc::{Receiver, Sender, channel},
    },
};

/// Pixels of a thumbnail, and its samples per pixel.
pub const SIZE: [u32; 2] = [160, 100];
const SAMPLES: u32 = 4;

/// A small picture, or why there is none, and what it shows.
struct Made {
    of: Shown,
    picture: Result<TextureHandle, String>,
}

/// What a picture shows.
#[derive(Clone)]
struct Shown {
    state: LookState,
    poses: Poses,
    /// Weak, so that a picture does not keep a bake.
    dataset: Weak<Dataset>,
}

impl Shown {
    fn is_by(&self, baked: &Baked, poses: &Poses) -> bool {
        ptr::eq(self.dataset.as_ptr(), Arc::as_ptr(&baked.dataset)) && self.poses == *poses
    }
}

/// The thread, which has a renderer of its own for one bake.
struct Worker {
    asked: Sender<PictureOfDocument>,
    made: Receiver<Result<DisplayPicture, String>>,
    dataset: Weak<Dataset>,
}

/// The pictures.
#[derive(Default)]
pub struct LookThumbnails {
    worker: Option<Worker>,
    made: Vec<Made>,
    /// What the thread works at.
    asked: Option<Shown>,
}

impl LookThumbnails {
    /// Takes the picture that is ready, and forgets those of looks that are gone, and the thread of another bake.
    pub fn collect(&mut self, ctx: &Context, looks: &[NamedLook], baked: Option<&Baked>) {
        let ready = self.worker.as_ref().and_then(|worker| worker.made.try_recv().ok());
        if let Some((ready, of)) = ready.and_then(|ready| Some((ready, self.asked.take()?))) {
            let picture = ready.map(|shown| texture_of(ctx, "look", None, &shown, TextureOptions::LINEAR));
            self.made.retain(|made| made.of.state != of.state);
            self.made.push(Made { of, picture });
        }
        self.made.retain(|made| looks.iter().any(|look| look.state == made.of.state));
        let is_of = |worker: &Worker| {
            !looks.is_empty()
                && baked.is_some_and(|baked| ptr::eq(worker.dataset.as_ptr(), Arc::as_ptr(&baked.dataset)))
        };
        if self.worker.take_if(|worker| !is_of(worker)).is_some() {
            self.asked = None;
        }
    }

    /// The picture of a look, also that by an earlier bake, or why there is none.
    pub fn of(&self, look: &LookState) -> Option<Result<&TextureHandle, &str>> {
        let made = self.made.iter().find(|made| made.of.state == *look)?;
        Some(made.picture.as_ref().map_err(String::as_str))
    }

    /// The first look whose picture by this bake is missing, unless one is being made.
    pub fn missing<'a>(&self, looks: &'a [NamedLook], baked: &Baked, poses: &Poses) -> Option<&'a LookState> {
        let is_made =
            |look: &&NamedLook| self.made.iter().any(|made| made.of.state == look.state && made.of.is_by(baked, poses));
        looks.iter().find(|look| !is_made(look)).filter(|_| self.asked.is_none()).map(|look| &look.state)
    }

    /// Asks for the picture of a look.
    pub fn ask(&mut self, look: &LookState, shown: PictureOfDocument, factory: &BackendFactory, wake: &Wake) {
        let [width, height] = shown.size;
        if width == 0 || height == 0 {
            return;
        }
        let dataset = Arc::downgrade(&shown.baked.dataset);
        self.asked = Some(Shown { state: look.clone(), poses: shown.poses.clone(), dataset: dataset.clone() });
        let mut picture = PictureOfDocument { size: SIZE, aa: Some(SAMPLES), ..shown }.with_look(look);
        fit_width(&mut picture.document.camera, [width, height]);
        let worker = self.worker.get_or_insert_with(|| Worker::start(dataset, factory.clone(), wake.clone()));
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
    fn start(dataset: Weak<Dataset>, factory: BackendFactory, wake: Wake) -> Self {
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
        Self { asked, made, dataset }
    }
}

fn drawn(
    studio: &mut Option<Studio>,
    maps: &mut Maps,
    factory: &BackendFactory,
    picture: &PictureOfDocument,
) -> anyhow::Result<DisplayPicture> {
    let mut taking = match studio.take() {
        Some(known) => known,
        None => Studio::new(factory()?, picture.baked.clone())?,
    };
    let shown = taking.take(&picture.look(maps)?, &|| false)?.shown;
    *studio = Some(taking);
    Ok(shown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_thumbnail_is_as_wide_as_the_picture() {
        let width =
            |camera: &Camera, [width, height]: [u32; 2]| (0.5 * camera.fov_y).tan() * width as f32 / height as f32;
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, 40.0);
        for shown in [[100, 100], [300, 400]] {
            let mut fitted = camera.clone();
            fit_width(&mut fitted, shown);
            assert!((width(&fitted, SIZE) / width(&camera, shown) - 1.0).abs() < 1e-5, "{shown:?}");
        }
        let mut wide = camera.clone();
        fit_width(&mut wide, [400, 100]);
        assert!((wide.fov_y - camera.fov_y).abs() < 1e-6, "as high as a picture that is wider");
    }
}
