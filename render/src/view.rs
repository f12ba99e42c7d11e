//! The contents of a picture, and the sampling of its pixels.

use crate::view_mode::{BasisView, ViewMode};
use glam::{DVec2, Vec2, Vec3};
use lapidary_core::{
    camera::{Camera, Projection, aperture_sample},
    ground::Ground,
    image::{Image, Region},
};

/// The background.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The environment.
    #[default]
    Environment,
    /// The environment out of focus: blurred to the given standard deviation in radians.
    Blurred(f32),
    /// Uniform radiance; use black to measure errors on surfaces alone.
    Flat(Vec3),
    /// Transparent: the picture has no coverage there, and a ground only its shadow's.
    Transparent,
}

/// A camera and a picture size.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel; 1 is the pixel center.
    pub aa: u32,
    /// The background.
    pub background: Background,
    /// Whether pixels without a surface stay black. The ground still catches the background.
    pub hides_background: bool,
    /// How the ground is shown, if the scene has one.
    pub ground: Ground,
    /// Whether sharp reflections show the scene, see [`crate::BrdfSampling::Once`] for the exception; else they show the environment
    /// alone, and bounced light as baked.
    pub mirrors: bool,
    /// The quantity that the pixels show.
    pub mode: ViewMode,
    /// Selection for the modes of the meshless basis.
    pub basis: BasisView,
    /// Draws triangle edges over the picture.
    pub wireframe: bool,
    /// The only pixels that references trace; the others stay black. Renderers with cuts ignore the region.
    pub region: Option<Region>,
}

impl View {
    /// A view with one sample at the center of each pixel and the environment as background.
    pub fn new(camera: Camera, size: [u32; 2]) -> Self {
        Self {
            camera,
            size,
            aa: 1,
            background: Background::Environment,
            hides_background: false,
            ground: Ground::On,
            mirrors: true,
            mode: ViewMode::Shaded,
            basis: BasisView::default(),
            wireframe: false,
            region: None,
        }
    }

    /// The view of surfaces alone, for measuring errors: on black, with the ground as a surface.
    pub(crate) fn of_surfaces(&self) -> Self {
        let ground = if self.ground == Ground::Off { Ground::Off } else { Ground::On };
        let (background, mode) = (Background::Flat(Vec3::ZERO), ViewMode::Shaded);
        Self { background, ground, mode, wireframe: false, ..self.clone() }
    }

    /// How the ground is shown. A shadow-only ground is off in transparent wireframe views: its lines would have no surface.
    pub fn ground(&self) -> Ground {
        let is_seen_through = self.background == Background::Transparent && self.wireframe;
        if self.ground == Ground::Shadow && is_seen_through { Ground::Off } else { self.ground }
    }

    /// Maps pixels to rays, and points to pixels, from the center of the lens.
    pub fn projection(&self) -> Projection {
        self.camera.projection(self.size)
    }

    /// Whether both show light, and differ in camera or size and otherwise at most in the number of samples.
    pub(crate) fn is_same_but_seen_from(&self, other: &Self) -> bool {
        let View { camera, size, aa, .. } = self.clone();
        let is_moved = (&camera, size) != (&other.camera, other.size);
        self.mode == ViewMode::Shaded && is_moved && View { camera, size, aa, ..other.clone() } == *self
    }

    /// The same for a sample of each pixel, which sees through another point of the lens.
    pub fn projection_of(&self, sample: u32) -> Projection {
        self.projection_through(aperture_sample(sample % self.aa.max(1)))
    }

    /// The same through a point of the lens, in its unit disc.
    pub(crate) fn projection_through(&self, point: Vec2) -> Projection {
        self.camera.through(point).projection(self.size)
    }

    /// Positions of the samples within a pixel, the same for all pixels and renderers: the center, or points of the R2 sequence
    /// (Roberts 2018), which fill the square evenly for any number.
    pub fn pixel_offsets(&self) -> Vec<Vec2> {
        (0..self.aa.max(1)).map(|i| pixel_sample_position(i, DVec2::splat(0.5))).collect()
    }
}

/// Point `i` of the R2 sequence that starts at `first`, in the unit square.
pub(crate) fn pixel_sample_position(i: u32, first: DVec2) -> Vec2 {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053); // 1/p and 1/p² for the plastic number p
    // Rounding to single precision may give 1, which belongs to the next pixel.
    (first + STEP * f64::from(i)).fract().as_vec2().min(Vec2::splat(1.0 - f32::EPSILON))
}

/// An unfinished reference.
pub struct Preview<'a> {
    /// The picture.
    pub image: &'a Image,
    /// Pixels whose column and row are multiples of it are traced; others repeat the nearest one to the upper left.
    pub step: u32,
    /// Relative RMSE by noise, if known.
    pub noise: Option<f64>,
}

/// Follows a reference's progress, and may stop it.
pub trait Progress: Sync {
    /// `done` of `total` units of work are complete.
    fn advanced(&self, done: u64, total: u64);

    /// The picture so far; called between passes.
    fn preview(&self, _preview: &Preview) {}

    /// Whether to call [`Self::preview`] after this many passes of light paths.
    fn wants_preview(&self, passes: u32) -> bool {
        passes.is_power_of_two()
    }

    /// Whether to stop with a complete but coarse picture.
    fn cancelled(&self) -> bool {
        false
    }

    /// Whether to stop at once and leave the picture incomplete.
    fn abandoned(&self) -> bool {
        false
    }
}

/// Ignores progress.
pub struct Quiet;

impl Progress for Quiet {
    fn advanced(&self, _done: u64, _total: u64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_the_centre_or_fill_the_pixel() {
        let mut view = View::new(Camera::look_at(Vec3::Z, Vec3::ZERO, 40.0), [8, 8]);
        assert_eq!(view.pixel_offsets(), [Vec2::splat(0.5)]);
        view.aa = 16;
        let offsets = view.pixel_offsets();
        let mean = offsets.iter().sum::<Vec2>() / 16.0;
        assert!((mean - 0.5).abs().max_element() < 0.1, "{mean}");
        let quadrant = |q: Vec2| offsets.iter().filter(|o| o.cmpge(q).all() && o.cmplt(q + 0.5).all()).count();
        for q in [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(0.0, 0.5), Vec2::splat(0.5)] {
            assert!((3..=6).contains(&quadrant(q)));
        }
    }
}
