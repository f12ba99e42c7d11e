//! Renders preview balls on a thread of its own. The latest request wins; the last picture stays until a new one is there.

use super::preview_ball::{Ball, BallPixel};
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_core::material::Material;
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
    ball: Ball,
    post: Post,
    size: u32,
    context: Context,
}

/// The worker and its last picture.
pub struct Preview {
    requests: Sender<Request>,
    pictures: Receiver<ColorImage>,
    asked: Option<Asked>,
    shown: Option<TextureHandle>,
}

/// What the last request was for.
#[derive(Clone, PartialEq)]
struct Asked {
    material: Material,
    textures: Vec<usize>,
    light_revision: u64,
    lighting: usize,
    post: Post,
    size: u32,
}

impl Asked {
    fn new(ball: &Ball, light_revision: u64, post: Post, size: u32) -> Self {
        // A name does not show.
        let material = Material { name: String::new(), ..ball.material.clone() };
        let textures = ball.textures.iter().map(|t| Arc::as_ptr(t) as usize).collect();
        Self { material, textures, light_revision, lighting: Arc::as_ptr(&ball.lighting) as usize, post, size }
    }
}

impl Default for Preview {
    fn default() -> Self {
        let (requests, incoming) = channel();
        let (outgoing, pictures) = channel();
        // It ends when the panel is dropped and the channel with it.
        thread::spawn(move || work(&incoming, &outgoing));
        Self { requests, pictures, asked: None, shown: None }
    }
}

impl Preview {
    /// The latest picture of `ball`, or of what came before it, `size` pixels across. Asks for a new one if anything changed.
    pub fn picture(
        &mut self,
        context: &Context,
        ball: Ball,
        light_revision: u64,
        post: Post,
        size: u32,
    ) -> Option<&TextureHandle> {
        let wanted = Asked::new(&ball, light_revision, post, size);
        if self.asked.as_ref() != Some(&wanted) {
            self.asked = Some(wanted);
            // A worker that is gone leaves the last picture.
            let _ = self.requests.send(Request { ball, post, size, context: context.clone() });
        }
        if let Some(image) = self.pictures.try_iter().last() {
            self.shown = Some(context.load_texture("material preview", image, TextureOptions::LINEAR));
        }
        self.shown.as_ref()
    }

    /// Whether there is a picture.
    #[cfg(test)]
    pub fn has_picture(&self) -> bool {
        self.shown.is_some()
    }
}

fn work(requests: &Receiver<Request>, pictures: &Sender<ColorImage>) {
    while let Ok(first) = requests.recv() {
        let request = requests.try_iter().last().unwrap_or(first);
        let image = displayed(&request.ball.render(request.size), &request.post, request.size);
        if pictures.send(image).is_err() {
            return;
        }
        request.context.request_repaint();
    }
}

/// Radiance as a display shows it.
fn displayed(pixels: &[BallPixel], post: &Post, size: u32) -> ColorImage {
    let color = |&(radiance, coverage): &BallPixel| {
        let [r, g, b] = post.display(radiance).to_array().map(|c| (c * 255.0 + 0.5) as u8);
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
        let lighting = Arc::new(SceneLighting::new(&tree, &[Vec3::ONE; 64], 16));
        Ball { material: Material::default(), textures: Vec::new(), lighting }
    }

    #[test]
    fn what_shows_is_asked_for_and_a_new_name_is_not() {
        let ball = ball();
        let asked = Asked::new(&ball, 1, Post::default(), 64);
        let renamed = Ball { material: Material { name: "x".into(), ..Default::default() }, ..ball.clone() };
        assert!(asked == Asked::new(&renamed, 1, Post::default(), 64));
        let two_sided = Ball { material: Material { double_sided: true, ..Default::default() }, ..ball.clone() };
        assert!(asked != Asked::new(&two_sided, 1, Post::default(), 64));
        assert!(asked != Asked::new(&ball, 2, Post::default(), 64));
        assert!(asked != Asked::new(&ball, 1, Post { exposure: 1.0, ..Post::default() }, 64));
    }

    #[test]
    fn a_picture_arrives_and_stays_while_another_is_made() {
        let (mut preview, context, ball) = (Preview::default(), Context::default(), ball());
        let start = Instant::now();
        while preview.picture(&context, ball.clone(), 1, Post::default(), 8).is_none() {
            assert!(start.elapsed() < Duration::from_secs(20), "no picture came");
            thread::sleep(Duration::from_millis(2));
        }
        let kept = preview.picture(&context, ball, 2, Post::default(), 8);
        assert!(kept.is_some(), "the last picture stays");
    }

    #[test]
    fn displayed_pixels_are_tone_mapped_and_covered() {
        let image =
            displayed(&[(Vec3::ONE, 1.0), (Vec3::ZERO, 1.0), (Vec3::ONE, 0.0), (Vec3::ONE, 1.0)], &Post::default(), 2);
        assert_eq!(image.pixels[..3], [Color32::WHITE, Color32::BLACK, Color32::TRANSPARENT]);
    }
}
