//! Renders preview balls on its own thread. The latest request wins; the last picture of a material stays until its
//! next one is ready.

use super::preview_ball::{Ball, BallPixel};
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_core::{color::codes, material::Material};
use lapidary_render::Post;
use std::{
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
    thread,
};

/// A picture to make.
struct Request {
    /// Counts opened documents.
    document: u64,
    /// Index of the document's material.
    index: usize,
    ball: Ball,
    post: Post,
    size: u32,
    context: Context,
}

/// The worker and its last picture.
pub struct Preview {
    requests: Sender<Request>,
    pictures: Receiver<Made>,
    document: u64,
    asked: Option<Asked>,
    /// The last picture, and its material.
    shown: Option<(usize, TextureHandle)>,
}

/// A picture, its document and its material.
struct Made {
    document: u64,
    index: usize,
    image: ColorImage,
}

/// The last request.
#[derive(Clone, PartialEq)]
struct Asked {
    index: usize,
    material: Material,
    textures: Vec<usize>,
    light_revision: u64,
    lighting: usize,
    post: Post,
    size: u32,
}

impl Asked {
    fn new(index: usize, ball: &Ball, light_revision: u64, post: Post, size: u32) -> Self {
        // The name has no effect.
        let material = Material { name: String::new(), ..ball.material.clone() };
        let textures = ball.textures.iter().map(|t| Arc::as_ptr(t) as usize).collect();
        let lighting = Arc::as_ptr(&ball.lighting) as usize;
        Self { index, material, textures, light_revision, lighting, post, size }
    }
}

impl Default for Preview {
    fn default() -> Self {
        let (requests, incoming) = channel();
        let (outgoing, pictures) = channel();
        // It ends when the panel is dropped and the channel with it.
        thread::spawn(move || work(&incoming, &outgoing));
        Self { requests, pictures, document: 0, asked: None, shown: None }
    }
}

impl Preview {
    /// The latest picture of the material at `index`, `size` pixels across: of `ball`, or of its state before an edit; `None` while
    /// there are only pictures of other materials. Asks for a new one if anything changed.
    pub fn picture(
        &mut self,
        context: &Context,
        index: usize,
        ball: Ball,
        light_revision: u64,
        post: Post,
        size: u32,
    ) -> Option<&TextureHandle> {
        let wanted = Asked::new(index, &ball, light_revision, post, size);
        if self.asked.as_ref() != Some(&wanted) {
            self.asked = Some(wanted);
            // Without a worker the last picture stays.
            let (document, context) = (self.document, context.clone());
            let _ = self.requests.send(Request { document, index, ball, post, size, context });
        }
        let made = self.pictures.try_iter().last().filter(|made| made.document == self.document);
        if let Some(Made { index, image, .. }) = made {
            self.shown = Some((index, context.load_texture("material preview", image, TextureOptions::LINEAR)));
        }
        self.shown.as_ref().filter(|(shown, _)| *shown == index).map(|(_, picture)| picture)
    }

    /// Another document is open: drops all pictures, even the one being made.
    pub fn forget(&mut self) {
        self.document += 1;
        (self.asked, self.shown) = (None, None);
    }

    /// Whether there is a picture.
    #[cfg(test)]
    pub fn has_picture(&self) -> bool {
        self.shown.is_some()
    }
}

fn work(requests: &Receiver<Request>, pictures: &Sender<Made>) {
    while let Ok(first) = requests.recv() {
        let request = requests.try_iter().last().unwrap_or(first);
        let image = displayed(&request.ball.render(request.size), &request.post, request.size);
        if pictures.send(Made { document: request.document, index: request.index, image }).is_err() {
            return;
        }
        request.context.request_repaint();
    }
}

/// Radiance as a display shows it.
pub fn displayed(pixels: &[BallPixel], post: &Post, size: u32) -> ColorImage {
    let color = |&(radiance, coverage): &BallPixel| {
        let [r, g, b] = codes(post.display(radiance));
        Color32::from_rgba_unmultiplied(r, g, b, (coverage * 255.0 + 0.5) as u8)
    };
    ColorImage::new([size as usize; 2], pixels.iter().map(color).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::light_tree::LightTree;
    use lapidary_render::SceneLighting;
    use std::time::{Duration, Instant};

    fn ball() -> Ball {
        let tree = LightTree::geometric(64).unwrap();
        let lighting = SceneLighting::new(&tree, &[Vec3::ONE; 64], 16).into();
        Ball { material: Material::default(), textures: Vec::new(), lighting }
    }

    #[test]
    fn what_shows_is_asked_for_and_a_new_name_is_not() {
        let ball = ball();
        let asked_for = |ball: &Ball, revision, post| Asked::new(0, ball, revision, post, 64);
        let asked = asked_for(&ball, 1, Post::default());
        let renamed = Ball { material: Material { name: "x".into(), ..Default::default() }, ..ball.clone() };
        assert!(asked == asked_for(&renamed, 1, Post::default()));
        let two_sided = Ball { material: Material { double_sided: true, ..Default::default() }, ..ball.clone() };
        assert!(asked != asked_for(&two_sided, 1, Post::default()));
        assert!(asked != asked_for(&ball, 2, Post::default()));
        assert!(asked != asked_for(&ball, 1, Post { exposure: 1.0, ..Post::default() }));
    }

    #[test]
    fn a_picture_comes_from_the_worker() {
        let (mut preview, context, ball, start) = (Preview::default(), Context::default(), ball(), Instant::now());
        while preview.picture(&context, 0, ball.clone(), 1, Post::default(), 8).is_none() {
            assert!(start.elapsed() < Duration::from_secs(90), "no picture came");
            thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_picture_stays_while_another_of_its_material_is_made_and_is_not_shown_for_another() {
        let (mut preview, context, ball) = (Preview::default(), Context::default(), ball());
        // A real worker's pictures would arrive at random times.
        let (outgoing, pictures) = channel();
        preview.pictures = pictures;
        let made = |index| Made { document: 0, index, image: ColorImage::filled([8, 8], Color32::RED) };
        let mut picture =
            |index, revision| preview.picture(&context, index, ball.clone(), revision, Post::default(), 8).is_some();
        outgoing.send(made(0)).unwrap();
        assert!(picture(0, 1));
        assert!(picture(0, 2), "the last picture stays");
        assert!(!picture(1, 2), "it is of another material");
        outgoing.send(made(1)).unwrap();
        assert!(picture(1, 2));
    }

    #[test]
    fn another_document_shows_no_picture_of_the_one_before() {
        let (mut preview, context, ball) = (Preview::default(), Context::default(), ball());
        let (outgoing, pictures) = channel();
        preview.pictures = pictures;
        let made = |document| Made { document, index: 0, image: ColorImage::filled([8, 8], Color32::RED) };
        let shows = |preview: &mut Preview| preview.picture(&context, 0, ball.clone(), 1, Post::default(), 8).is_some();
        outgoing.send(made(0)).unwrap();
        assert!(shows(&mut preview), "negative control");
        preview.forget();
        assert!(!shows(&mut preview));
        outgoing.send(made(0)).unwrap();
        assert!(!shows(&mut preview), "it was under way");
        outgoing.send(made(1)).unwrap();
        assert!(shows(&mut preview));
    }

    #[test]
    fn displayed_pixels_are_tone_mapped_and_covered() {
        let image =
            displayed(&[(Vec3::ONE, 1.0), (Vec3::ZERO, 1.0), (Vec3::ONE, 0.0), (Vec3::ONE, 1.0)], &Post::default(), 2);
        assert_eq!(image.pixels[..3], [Color32::WHITE, Color32::BLACK, Color32::TRANSPARENT]);
    }
}
