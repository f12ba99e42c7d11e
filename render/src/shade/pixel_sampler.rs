//! Pixel sampling for all CPU renderers: from a sample of a pixel to the surface or background there.

use crate::{
    renderer::Renderer,
    shade::{
        background::Backdrop,
        differentials::Differentials,
        seen_scene::SeenScene,
        surface::{FirstHit, SurfacePoint, Surfaces},
        wireframe,
    },
    view::{Background, View},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    camera::{Projection, disc},
    opacity::chance,
    ray::{Hit, in_eights},
};
use std::ops::Range;

/// Casts camera rays through the samples of a view's pixels and shades their hits.
pub(crate) struct PixelSampler<'a> {
    pub view: &'a View,
    /// From the center of the lens.
    pub projection: Projection,
    scene: SeenScene<'a>,
    /// For each sample of a pixel its position there, and the projection through its point of the lens.
    samples: Vec<(Vec2, Projection)>,
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

impl Sight {
    /// The visible surface, if it can be shaded.
    pub fn surface(&self) -> Option<&SurfacePoint> {
        match &self.seen {
            FirstHit::Surface(point) => Some(point),
            FirstHit::Back | FirstHit::Background => None,
        }
    }
}

/// A position in the picture, and its ray's origin and direction.
struct Toward {
    position: Vec2,
    ray: (Vec3, Vec3),
}

fn toward(projection: &Projection, [x, y]: [u32; 2], in_pixel: Vec2) -> Toward {
    let position = Vec2::new(x as f32, y as f32) + in_pixel;
    Toward { position, ray: projection.ray(position) }
}

/// Tells points of the lens from other chances of a sample.
const APERTURE: u32 = 0x1e45;
/// Samples of a pixel with evenly spread thresholds.
const STRATA: u32 = 16;

/// Opacity thresholds for a pixel sample; surfaces above them are visible. Each triangle has its own, so layers pass light as often
/// as their opacities say. Twin of `threshold` in `shaders/opacity.wgsl`.
fn threshold([x, y]: [u32; 2], sample: u32) -> impl Fn(u32) -> f32 {
    move |triangle| {
        let order = (chance(&[x, y, sample / STRATA, triangle, STRATA]) * 4096.0) as u32;
        let (flips, factor, shift) = (order & 15, 2 * (order >> 4 & 15) + 1, order >> 8);
        let stratum = (((sample % STRATA) ^ flips) * factor + shift) % STRATA;
        (stratum as f32 + chance(&[x, y, sample, triangle])) / STRATA as f32
    }
}

impl<'a> PixelSampler<'a> {
    pub fn new(renderer: &'a Renderer, view: &'a View, backdrop: &'a Backdrop) -> Self {
        let scene = SeenScene::new(renderer, view, backdrop);
        let scene = SeenScene { surfaces: scene.surfaces.filtered(Differentials::of(view)), ..scene };
        let samples = (0..).zip(view.pixel_offsets()).map(|(i, offset)| (offset, view.projection_of(i))).collect();
        Self { view, projection: view.projection(), scene, samples }
    }

    /// Uses point lookups in maps, for enough positions per pixel to filter them.
    pub fn unfiltered(self, renderer: &'a Renderer) -> Self {
        Self { scene: SeenScene { surfaces: Surfaces::of(renderer), ..self.scene }, ..self }
    }

    /// The requested pixels of a row.
    pub fn columns(&self, y: u32) -> Range<u32> {
        match self.view.region {
            None => 0..self.view.size[0],
            Some(region) if region.rows().contains(&y) => region.columns(),
            Some(_) => 0..0,
        }
    }

    /// Position of a sample in its pixel, and its projection.
    fn of_sample(&self, sample: usize) -> (Vec2, &Projection) {
        let (offset, projection) = &self.samples[sample % self.samples.len()];
        (*offset, projection)
    }

    /// The view along one sample of a pixel.
    pub fn sight(&self, x: u32, y: u32, sample: usize) -> Sight {
        let (offset, projection) = self.of_sample(sample);
        let toward = toward(projection, [x, y], offset);
        self.sight_at(toward, threshold([x, y], sample as u32))
    }

    /// The view along a ray; only surfaces above the opacity thresholds are visible.
    fn sight_at(&self, Toward { position, ray }: Toward, threshold: impl Fn(u32) -> f32) -> Sight {
        let (origin, direction) = ray;
        let first = self.scene.surfaces.hit_above(origin, direction, &threshold);
        let hit = self.scene.past_hidden_ground(first, ray, threshold);
        Sight { position, direction, seen: self.scene.seen(hit, direction) }
    }

    /// Hits of the camera rays through one sample of each pixel. Rays are traced eight at a time, faster the closer they are.
    pub fn hits(&self, pixels: &[[u32; 2]], sample: usize) -> Vec<Option<Hit>> {
        let (offset, projection) = self.of_sample(sample);
        let direction = |&pixel: &[u32; 2]| toward(projection, pixel, offset).ray.1;
        let eights = in_eights(pixels.iter().map(direction));
        // Padding rays of the last eight belong to no pixel.
        let of_ray = |ray: usize| threshold(pixels[ray.min(pixels.len() - 1)], sample as u32);
        // Eight rays traced together share an origin: a sample of all pixels sees through one point of the lens.
        let eye = projection.eye;
        let hits = self.scene.surfaces.hits_from(eye, &eights, |ray, triangle| of_ray(ray)(triangle)).into_flattened();
        let first = hits.into_iter().zip(eights.as_flattened()).take(pixels.len()).enumerate();
        first
            .map(|(ray, (hit, &direction))| self.scene.past_hidden_ground(hit, (eye, direction), of_ray(ray)))
            .collect()
    }

    /// The view along one sample of a pixel, from its known hit.
    pub fn sight_of(&self, [x, y]: [u32; 2], sample: usize, hit: Option<Hit>) -> Sight {
        let (offset, projection) = self.of_sample(sample);
        let Toward { position, ray: (_, direction) } = toward(projection, [x, y], offset);
        Sight { position, direction, seen: self.scene.seen(hit, direction) }
    }

    /// Whether the picture stores only the ground's transmitted share.
    pub fn has_alpha_of_ground(&self) -> bool {
        self.view.background == Background::Transparent
            && self.scene.backdrop.catches()
            && self.scene.mesh.ground.is_some()
    }

    /// Whether a material belongs to the ground.
    pub fn is_of_ground(&self, material: u32) -> bool {
        self.scene.mesh.ground_material() == Some(material)
    }

    /// Whether a point lies on a ground of which the picture stores only the transmitted share.
    pub fn lets_light_through(&self, point: &SurfacePoint) -> bool {
        point.is_catcher && self.view.background == Background::Transparent
    }

    /// The surface at `hit` for a pixel's first sample; `None` for the back of a one-sided surface.
    pub fn first_point(&self, x: u32, y: u32, hit: &Hit) -> Option<SurfacePoint> {
        let (offset, projection) = self.of_sample(0);
        let (_, direction) = toward(projection, [x, y], offset).ray;
        match self.scene.seen(Some(*hit), direction) {
            FirstHit::Surface(point) => Some(*point),
            FirstHit::Back | FirstHit::Background => None,
        }
    }

    /// Index of a triangle's material.
    pub fn material(&self, triangle: u32) -> u32 {
        self.scene.surfaces.material(triangle)
    }

    /// Wireframe coverage of a sample on a triangle.
    pub fn wire(&self, position: Vec2, corners: [Vec3; 3]) -> f32 {
        let corners = corners.map(|corner| self.projection.project(corner));
        wireframe::line_coverage(wireframe::edge_distance(position, corners))
    }

    /// [`Self::wire`] for a pixel's first sample.
    pub fn first_wire(&self, x: u32, y: u32, triangle: u32) -> f32 {
        self.wire(Vec2::new(x as f32, y as f32) + self.of_sample(0).0, self.scene.surfaces.corners(triangle))
    }

    /// Share of the light that a ground transmits, from its shown light over a white background.
    pub fn share_let_through(&self, shown: Vec3) -> f32 {
        self.scene.backdrop.share_let_through(shown)
    }

    /// Background along a direction that hits no surface.
    pub fn behind(&self, direction: Vec3) -> Vec3 {
        self.scene.backdrop.radiance(direction)
    }

    /// One sample of the pixel: `shade` of its surface, or the background.
    pub fn sample(&self, x: u32, y: u32, sample: usize, shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        self.radiance(self.sight(x, y, sample), shade)
    }

    /// [`Self::sample`] at any position in the pixel's unit square, through a random point of the lens; thin surfaces are visible by
    /// chance.
    pub fn sample_at(&self, x: u32, y: u32, in_pixel: Vec2, shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        let position = [in_pixel.x.to_bits(), in_pixel.y.to_bits()];
        let by_chance = |triangle| chance(&[x, y, position[0], position[1], triangle]);
        let through_lens;
        let projection = match self.view.camera.lens.f_number {
            None => &self.projection,
            Some(_) => {
                let point = [0, 1].map(|axis| chance(&[x, y, position[0], position[1], APERTURE, axis]));
                through_lens = self.view.projection_through(disc(point.into()));
                &through_lens
            }
        };
        self.radiance(self.sight_at(toward(projection, [x, y], in_pixel), by_chance), shade)
    }

    fn radiance(&self, sight: Sight, mut shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        match sight.seen {
            // A picture without a background contains no light of it.
            FirstHit::Surface(point) if self.lets_light_through(&point) => Vec3::ZERO,
            FirstHit::Surface(point) => shade(&point),
            FirstHit::Back => Vec3::ZERO,
            FirstHit::Background => self.behind(sight.direction),
        }
    }

    /// The mean over the pixel's samples.
    pub fn pixel(&self, x: u32, y: u32, mut shade: impl FnMut(&SurfacePoint) -> Vec3) -> Vec3 {
        let sum: Vec3 = (0..self.samples.len()).map(|i| self.sample(x, y, i, &mut shade)).sum();
        sum / self.samples.len() as f32
    }
}

#[cfg(test)]
pub(crate) mod tests;
