//! The picture on the screen, and pictures on their way to files.

use super::{backplate::BackplateShown, requests::Requests};
use crate::{
    jobs::render_thread::{RenderRequest, RenderThread, RenderedFrame},
    viewport::Faded,
    workspace::Workspace,
};
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_render::{BackendFactory, Backplate, ImplicitDetail, Tier};
use lapidary_studies::jobs::Wake;
use std::{
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// A picture to write, once it is complete.
pub struct Export {
    /// Identifier of its request.
    pub id: u64,
    pub path: PathBuf,
    /// Whether the background is transparent.
    pub transparent: bool,
    /// The picture behind it.
    pub backplate: Option<Arc<Backplate>>,
}

impl Export {
    /// A png holds display values; exr and hdr are scene-linear.
    pub fn is_png(&self) -> bool {
        self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
    }
}

/// The written file, or why it could not be written.
type Written = Result<PathBuf, String>;

/// Seconds of a fade.
const FADE_SECONDS: f64 = 0.15;

/// The last picture with another method or coarser detail of its light, which fades into the present one.
struct Fading {
    texture: TextureHandle,
    size: [u32; 2],
    since: f64,
}

/// Pictures, on the screen and on their way to files.
pub struct Picture {
    /// The thread that renders it.
    pub render: RenderThread,
    /// The last request to the render thread.
    pub requests: Requests,
    pub texture: Option<TextureHandle>,
    fading: Option<Fading>,
    /// The picture on the screen.
    pub shown: Option<RenderedFrame>,
    /// The picture behind it.
    pub backplate: BackplateShown,
    pub exports: Vec<Export>,
    pub exports_asked: u64,
    pub written: (Sender<Written>, Receiver<Written>),
}

impl Picture {
    /// With nothing rendered yet.
    pub fn new(factory: BackendFactory, wake: Wake) -> Self {
        Self {
            render: RenderThread::start(factory, wake),
            requests: Requests::default(),
            texture: None,
            fading: None,
            shown: None,
            backplate: BackplateShown::default(),
            exports: Vec::new(),
            exports_asked: 0,
            written: channel(),
        }
    }

    /// The request of the shown picture, if any.
    pub fn asked(&self, work: &Workspace) -> Option<&RenderRequest> {
        self.requests.last_sent().filter(|_| self.can_be_compared(work))
    }

    /// Whether there is a picture to compare.
    pub fn can_be_compared(&self, work: &Workspace) -> bool {
        work.scene.rendered().is_some() && self.shown.is_some()
    }

    /// The picture on the screen.
    pub fn texture(&self) -> Option<&TextureHandle> {
        self.texture.as_ref()
    }

    /// The frame in the viewport, with its statistics.
    pub fn shown(&self) -> Option<&RenderedFrame> {
        self.shown.as_ref()
    }

    /// Seconds per sample of a pixel, measured on the picture in the window.
    pub fn pixel_secs(&self) -> Option<f64> {
        let shown = self.shown()?;
        let samples = f64::from(shown.size[0]) * f64::from(shown.size[1]) * f64::from(shown.samples);
        (samples > 0.0 && shown.millis > 0.0).then(|| 1e-3 * shown.millis / samples)
    }

    /// The scene was closed.
    pub fn clear(&mut self) {
        (self.texture, self.fading, self.shown) = (None, None, None);
    }

    /// The fading picture while it is visible; requests another frame then.
    pub fn faded(&self, ctx: &Context) -> Option<Faded> {
        let Fading { texture, size, since } = self.fading.as_ref()?;
        let opacity = left_after(ctx.input(|input| input.time) - since)?;
        ctx.request_repaint();
        Some(Faded { texture: texture.id(), size: *size, opacity })
    }

    pub fn show(&mut self, ctx: &Context, frame: RenderedFrame) {
        let pixels: &[u8] = frame.pixels.as_flattened();
        let image = ColorImage::from_rgba_unmultiplied(frame.size.map(|s| s as usize), pixels);
        let means = |frame: &RenderedFrame| (frame.tier, frame.detail);
        let before = self.shown.as_ref().filter(|shown| fades(means(shown), means(&frame))).map(|shown| shown.size);
        if let Some((texture, size)) = self.texture.take_if(|_| before.is_some()).zip(before) {
            self.fading = Some(Fading { texture, size, since: ctx.input(|input| input.time) });
        }
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => self.texture = Some(ctx.load_texture("picture", image, TextureOptions::LINEAR)),
        }
        self.shown = Some(frame);
    }
}

/// Method of a picture's light, and the detail of posed objects' light.
type Means = (Tier, Option<ImplicitDetail>);

/// Whether a picture fades into the next. It does not if the next is coarser, since then something has just begun to move.
fn fades(shown: Means, next: Means) -> bool {
    shown.0 != next.0 || shown.1 < next.1
}

/// Opacity of a picture after fading for some seconds, if above 0.
fn left_after(seconds: f64) -> Option<f32> {
    let left = 1.0 - seconds / FADE_SECONDS;
    (left > 0.0).then_some(left as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_goes_over_into_one_of_other_means_or_a_finer_one() {
        let posed = |detail| (Tier::Implicit, Some(detail));
        let ([coarsest, .., finest], cuts) = (ImplicitDetail::LADDER.map(posed), (Tier::Cuts, None));
        let solved = (Tier::Solved, Some(coarsest.1.expect("it is posed")));
        assert!(fades(coarsest, solved) && fades(solved, cuts));
        assert!(fades(cuts, coarsest) && fades(finest, cuts) && fades(coarsest, finest));
        assert!(!fades(finest, coarsest), "something begins to move");
        assert!(!fades(cuts, cuts) && !fades(finest, finest), "more samples of the same");
    }

    #[test]
    fn a_fading_picture_lasts_long_enough_to_be_seen_and_less_than_a_quarter_of_a_second() {
        assert_eq!(left_after(0.0), Some(1.0));
        let two_frames = left_after(2.0 / 60.0).unwrap();
        assert!((0.5..1.0).contains(&two_frames), "{two_frames}");
        assert_eq!(left_after(0.25), None);
    }
}
