//! Surface properties without light: pictures for compositing, all from one set of camera rays.

use crate::{
    renderer::Renderer,
    shade::{
        background::Backdrop,
        pixel_sampler::{PixelSampler, Sight},
        surface::FirstHit,
    },
    view::View,
};
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;

/// Distance in meters without a surface: far beyond any scene, but finite, because filters cannot handle infinity.
pub const NO_SURFACE: f32 = 1e10;

/// Pictures of surface properties. `normal`, `albedo` and `roughness` are means over the samples of a pixel. As in premultiplied
/// colors, a sample counts as zero if it hits no surface or the back of a one-sided one. `depth` and `position` come from the
/// nearest sample, because a mean would lie off the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLayers {
    /// Shading normal in world space after bump and normal map, -1 to 1.
    pub normal: Image,
    /// Base color after its texture.
    pub albedo: Image,
    /// Perceptual roughness after its texture, one value per pixel.
    pub roughness: Vec<f32>,
    /// World position in meters; zero without a surface.
    pub position: Image,
    /// Distance along the optical axis in meters, one value per pixel; [`NO_SURFACE`] without a surface.
    pub depth: Vec<f32>,
    /// Share of the samples that hit a surface, back or front, one value per pixel.
    pub coverage: Vec<f32>,
}

/// Sums over the samples of one pixel.
#[derive(Clone, Copy)]
struct Pixel {
    normal: Vec3,
    albedo: Vec3,
    roughness: f32,
    position: Vec3,
    depth: f32,
    covered: f32,
}

impl Renderer {
    /// Surface properties in a view, with the current appearance.
    pub fn surface_layers(&self, view: &View) -> SurfaceLayers {
        let backdrop = Backdrop::black();
        let sampler = PixelSampler::new(self, view, &backdrop);
        let [width, height] = view.size;
        let row = |y: u32| (0..width).map(|x| Pixel::of(&sampler, x, y)).collect::<Vec<_>>();
        let pixels: Vec<Pixel> = (0..height).into_par_iter().flat_map_iter(row).collect();
        let image = |value: fn(&Pixel) -> Vec3| Image { size: view.size, pixels: pixels.iter().map(value).collect() };
        let plane = |value: fn(&Pixel) -> f32| pixels.iter().map(value).collect();
        SurfaceLayers {
            normal: image(|p| p.normal),
            albedo: image(|p| p.albedo),
            roughness: plane(|p| p.roughness),
            position: image(|p| p.position),
            depth: plane(|p| p.depth),
            coverage: plane(|p| p.covered),
        }
    }
}

impl Pixel {
    const NOTHING: Self = Self {
        normal: Vec3::ZERO,
        albedo: Vec3::ZERO,
        roughness: 0.0,
        position: Vec3::ZERO,
        depth: NO_SURFACE,
        covered: 0.0,
    };

    fn of(sampler: &PixelSampler, x: u32, y: u32) -> Self {
        let samples = sampler.view.aa.max(1);
        let mut pixel = Self::NOTHING;
        (0..samples).for_each(|sample| pixel.add(sampler, &sampler.sight(x, y, sample as usize)));
        let share = 1.0 / samples as f32;
        Self {
            normal: pixel.normal * share,
            albedo: pixel.albedo * share,
            roughness: pixel.roughness * share,
            covered: pixel.covered * share,
            ..pixel
        }
    }

    fn add(&mut self, sampler: &PixelSampler, sight: &Sight) {
        match &sight.seen {
            FirstHit::Background => {}
            FirstHit::Back => self.covered += 1.0,
            FirstHit::Surface(point) => {
                self.covered += 1.0;
                self.normal += point.world_from_local.z_axis;
                self.albedo += point.base_color;
                self.roughness += point.roughness;
                let depth = sampler.projection.depth(point.position);
                if depth < self.depth {
                    (self.depth, self.position) = (depth, point.position);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Backend, Baked, CpuBackend, ViewMode, test_scenes};
    use glam::Vec2;
    use lapidary_core::{brdf::GgxParameters, camera::Camera, dataset::Dataset};

    const SIZE: [u32; 2] = [16, 12];

    /// A view from above that includes the floor's edges.
    fn view(aa: u32) -> View {
        View { aa, ..View::new(Camera::look_at(Vec3::new(1.0, 3.0, 5.0), Vec3::ZERO, 60.0), SIZE) }
    }

    fn dataset() -> Dataset {
        test_scenes::dataset(test_scenes::mesh(2, true), GgxParameters { roughness: 0.3, ..Default::default() })
    }

    /// Picture and coverage by the CPU renderer in a mode.
    fn shown(baked: &Baked, view: &View, mode: ViewMode) -> (Image, Vec<f32>) {
        let mut backend = CpuBackend::new();
        backend.set_scene(baked).unwrap();
        backend.begin(&View { mode, ..view.clone() }, Default::default()).unwrap();
        (0..view.aa).for_each(|sample| backend.render_rows(sample, 0..view.size[1]).unwrap());
        backend.read(view.aa).unwrap()
    }

    #[test]
    fn surfaces_are_those_of_the_view_modes() {
        let baked = Baked::from(dataset());
        for aa in [1, 4] {
            let view = view(aa);
            let layers = Renderer::new(baked.clone()).surface_layers(&view);
            let (albedo, coverage) = shown(&baked, &view, ViewMode::Albedo);
            let close = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).all(|(a, b)| (*a - *b).length() < 1e-5);
            assert!(close(&layers.albedo.pixels, &albedo.pixels));
            assert_eq!(layers.coverage, coverage);
            let (normals, _) = shown(&baked, &view, ViewMode::Normals);
            let decoded = normals.pixels.iter().zip(&coverage).map(|(n, a)| 2.0 * *n - *a).collect::<Vec<_>>();
            assert!(close(&layers.normal.pixels, &decoded));
            assert!(!close(&layers.normal.pixels, &normals.pixels), "negative control");
            let (roughness, _) = shown(&baked, &view, ViewMode::Roughness);
            assert!(layers.roughness.iter().zip(&roughness.pixels).all(|(a, b)| (a - b.x).abs() < 1e-6));
            assert!(coverage.contains(&0.0) && coverage.contains(&1.0), "the view has an edge");
        }
    }

    #[test]
    fn depth_is_along_the_axis_and_of_the_nearest_sample() {
        let view = view(1);
        let layers = Renderer::new(dataset()).surface_layers(&view);
        let camera = &view.camera;
        let mut seen = 0;
        for (i, (&depth, &position)) in layers.depth.iter().zip(&layers.position.pixels).enumerate() {
            if layers.coverage[i] == 0.0 {
                assert_eq!((depth, position), (NO_SURFACE, Vec3::ZERO));
                continue;
            }
            let pixel = Vec2::new((i % 16) as f32, (i / 16) as f32) + 0.5;
            let through = camera.direction_through(pixel, view.size);
            assert!((position - camera.eye).normalize().dot(through) > 0.999_99);
            let axis = (camera.target - camera.eye).normalize();
            assert!((depth - (position - camera.eye).dot(axis)).abs() < 1e-4);
            seen += 1;
        }
        assert!(seen > 10);
        let finer = Renderer::new(dataset()).surface_layers(&self::view(9));
        assert!(finer.depth.iter().zip(&finer.coverage).all(|(d, c)| (*d == NO_SURFACE) == (*c == 0.0)));
    }
}
