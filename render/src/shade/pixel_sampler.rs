//! Pixel sampling that all CPU renderers share: from a sample of a pixel to the surface or background seen there.

use crate::{
    renderer::Renderer,
    shade::{
        background::Backdrop,
        surface::{FirstHit, SurfacePoint, Surfaces},
        wireframe::{self, Screen},
    },
    view::View,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    camera::Lens,
    image::Region,
    ray::{Hit, SeenFrom},
};
use std::ops::Range;

/// Casts camera rays through the samples of a view's pixels, and shades their hits.
pub(crate) struct PixelSampler<'a> {
    pub view: &'a View,
    screen: Screen,
    lens: Lens,
    backdrop: &'a Backdrop,
    surfaces: Surfaces<'a>,
    offsets: Vec<Vec2>,
}

/// The view along one sample of a pixel.
pub(crate) struct Sight {
    /// Position of the sample in the picture, in pixels from the top left corner.
    pub position: Vec2,
    /// Unit direction from the eye.
    pub direction: Vec3,
    /// The first hit.
    pub seen: FirstHit,
}

impl<'a> PixelSampler<'a> {
    pub fn new(renderer: &'a Renderer, view: &'a View, backdrop: &'a Backdrop) -> Self {
        let screen = Screen::new(&view.camera, view.size);
        let lens = view.camera.lens(view.size);
        Self { view, screen, lens, backdrop, surfaces: renderer.surfaces(), offsets: view.pixel_offsets() }
    }

    /// The pixels of a row that are wanted.
    pub fn columns(&self, y: u32) -> Range<u32> {
        match self.view.region {
            None => 0..self.view.size[0],
            Some(region) if region.rows().contains(&y) => region.columns(),
            Some(_) => 0..0,
        }
    }

    /// The view along one of a pixel's samples.
    pub fn sight(&self, x: u32, y: u32, sample: usize) -> Sight {
        self.sight_at(x, y, self.offsets[sample % self.offsets.len()])
    }

    /// The view from a position in the pixel's unit square.
    fn sight_at(&self, x: u32, y: u32, in_pixel: Vec2) -> Sight {
        let (position, direction) = self.toward(x, y, in_pixel);
        Sight { position, direction, seen: self.surfaces.seen_along(self.view.camera.eye, direction) }
    }

    fn toward(&self, x: u32, y: u32, in_pixel: Vec2) -> (Vec2, Vec3) {
        let position = Vec2::new(x as f32, y as f32) + in_pixel;
        (position, self.lens.direction_through(position))
    }

    /// Prepares the camera rays of many pixels.
    pub fn seen_from_eye(&self) -> SeenFrom {
        self.surfaces.seen_from(self.view.camera.eye)
    }

    /// Where the camera rays through the first samples of a region's pixels meet the mesh, row by row.
    pub fn first_hits(&self, seen: &SeenFrom, region: Region) -> Vec<Option<Hit>> {
        // Eight rays at a time are those of four by two pixels; the last ones of a row or column may lie beyond the region.
        let [columns, rows] = [region.width.div_ceil(4), region.height.div_ceil(2)];
        let direction = |block: u32, lane: u32| {
            let (x, y) = (4 * (block % columns) + lane % 4, 2 * (block / columns) + lane / 4);
            self.toward(region.x + x, region.y + y, self.offsets[0]).1
        };
        let eights: Vec<[Vec3; 8]> =
            (0..columns * rows).map(|block| std::array::from_fn(|lane| direction(block, lane as u32))).collect();
        let hits = self.surfaces.hits_from(seen, &eights);
        let hit = |x: u32, y: u32| hits[(y / 2 * columns + x / 4) as usize][(y % 2 * 4 + x % 4) as usize];
        (0..region.height).flat_map(|y| (0..region.width).map(move |x| (x, y))).map(|(x, y)| hit(x, y)).collect()
    }

    /// The view along a pixel's first sample, whose hit is known.
    pub fn first_sight(&self, x: u32, y: u32, hit: Option<Hit>) -> Sight {
        let (position, direction) = self.toward(x, y, self.offsets[0]);
        Sight { position, direction, seen: self.surfaces.seen_at(hit, direction) }
    }

    /// The surface that a pixel's first sample sees at `hit`; `None` for the back of a one-sided one.
    pub fn first_point(&self, x: u32, y: u32, hit: &Hit) -> Option<SurfacePoint> {
        let (_, direction) = self.toward(x, y, self.offsets[0]);
        (!self.surfaces.is_back(hit)).then(|| self.surfaces.point(hit, -direction))
    }

    /// Index of a triangle's material.
    pub fn material(&self, triangle: u32) -> u32 {
        self.surfaces.material(triangle)
    }

    /// Coverage of a sample on a triangle by the lines of a wireframe.
    pub fn wire(&self, position: Vec2, corners: [Vec3; 3]) -> f32 {
        let corners = corners.map(|corner| self.screen.project(corner));
        wireframe::line_coverage(wireframe::edge_distance(position, corners))
    }

    /// [`Self::wire`] of a pixel's first sample.
    pub fn first_wire(&self, x: u32, y: u32, triangle: u32) -> f32 {
        self.wire(Vec2::new(x as f32, y as f32) + self.offsets[0], self.surfaces.corners(triangle))
    }

    /// Background along a direction that hits no surface.
    pub fn behind(&self, direction: Vec3) -> Vec3 {
        self.backdrop.radiance(direction)
    }

    /// One of the pixel's samples: `shade` of its surface, or the background.
    pub fn sample(&self, x: u32, y: u32, sample: usize, shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        self.radiance(self.sight(x, y, sample), shade)
    }

    /// [`Self::sample`] at any position in the pixel's unit square.
    pub fn sample_at(&self, x: u32, y: u32, in_pixel: Vec2, shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        self.radiance(self.sight_at(x, y, in_pixel), shade)
    }

    fn radiance(&self, sight: Sight, mut shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        match sight.seen {
            FirstHit::Surface(point) => shade(&point),
            FirstHit::Back => Vec3::ZERO,
            FirstHit::Background => self.behind(sight.direction),
        }
    }

    /// The mean over the pixel's samples.
    pub fn pixel(&self, x: u32, y: u32, mut shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        let sum: Vec3 = (0..self.offsets.len()).map(|i| self.sample(x, y, i, &mut shade)).sum();
        sum / self.offsets.len() as f32
    }
}
