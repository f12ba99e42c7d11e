//! The lobes of a point that have rays where mirrors show the scene.
//!
//! Lobes that are sharp among light samples have a ray, which shows surfaces and the map. Among sources of bounced light, which
//! stand close and far apart, wider lobes are sharp too: for the rest of their light they have a second ray, which shows surfaces
//! alone. The environment's own light reaches wider lobes by cuts, without noise.

use super::{Disc, Mirror, Widths, falling};
use crate::{
    appearance::{Appearance, narrowest_lobe},
    light::bounce::SourceLighting,
    shade::surface::SurfacePoint,
    stale::Marks,
};
use glam::Vec3;
use lapidary_core::{
    color::{LUMINANCE, luminance},
    dataset::Dataset,
    simd::{Lanes, Vec3x8},
};
use wide::f32x8;

/// Narrower lobes, by microfacet `alpha`, see surfaces along rays; wider ones than the second see them as baked.
const SCENE: [f32; 2] = [0.15, 0.25];

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 2] = [("SCENE_SHARP", SCENE[0]), ("SCENE_SOFT", SCENE[1])];

/// Whether any material has lobes that mirror the scene, in pictures of a dataset.
pub fn has_mirrors(appearance: &Appearance, dataset: &Dataset) -> bool {
    marks(appearance, dataset.tree.leaf_solid_angle()) != Marks::default()
}

/// Materials with lobes that may have rays, among light samples of this solid angle in steradians.
pub(crate) fn marks(appearance: &Appearance, leaf_solid_angle: f32) -> Marks {
    let is_sharp = |width: f32| width < SCENE[1] || Mirror::may_be(width, leaf_solid_angle);
    let materials = appearance.materials.iter().enumerate();
    let sharp = materials.filter(|(_, material)| is_sharp(narrowest_lobe(material)));
    Marks::of_materials(sharp.map(|(index, _)| index))
}

/// The lobes of a point that have rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLobes {
    /// Those that are sharp among light samples.
    pub map: Option<Mirror>,
    /// Those that are sharp among sources, unless all are of the first.
    pub scene: Option<Mirror>,
}

impl RayLobes {
    /// At a point, among light samples of this solid angle in steradians; `None` without any.
    pub fn at(point: &SurfacePoint, leaf_solid_angle: f32) -> Option<Self> {
        let map = Mirror::at(point, leaf_solid_angle);
        let widths = Widths { sharp: |width| falling(width, SCENE), added: 0.0 };
        let scene = Mirror::of(point.brdf.as_brdf().lobes(), point.slopes, point.wo, widths);
        let is_covered = |scene: &Mirror| map.is_some_and(|map| map.share >= 1.0 && map.count == scene.count);
        let scene = scene.filter(|scene| !is_covered(scene));
        (map.is_some() || scene.is_some()).then_some(Self { map, scene })
    }

    /// Those alone that are sharp among light samples.
    pub fn of_map(point: &SurfacePoint, leaf_solid_angle: f32) -> Option<Self> {
        Some(Self { map: Some(Mirror::at(point, leaf_solid_angle)?), scene: None })
    }

    /// Share of the light of surfaces of a radiance, from eight local directions, that rays give, if those of wider lobes show
    /// only light up to a luminance.
    #[inline(always)]
    pub fn share_below<L: Lanes>(&self, wi: Vec3x8<L>, radiance: Vec3x8<L>, brightest: f32) -> L {
        let of_map = window(&self.map, wi);
        if self.scene.is_none() {
            return of_map;
        }
        let rest = (window(&self.scene, wi) - of_map).at_least(0.0);
        let luminance = radiance.dot(Vec3x8::splat(LUMINANCE)).at_least(f32::MIN_POSITIVE);
        of_map + rest * (L::splat(brightest) / luminance).fast_min(L::splat(1.0))
    }

    /// Share of the light of surfaces from one local direction that rays give.
    pub fn share_of(&self, wi: Vec3) -> f32 {
        self.share_below(Vec3x8::<f32x8>::splat(wi), Vec3x8::splat(Vec3::ZERO), f32::INFINITY).to_array()[0]
    }

    /// The lobes by which spreads of lights are narrowed, see [`Mirror::spread`].
    #[inline(always)]
    pub fn narrowing(&self) -> Option<&Mirror> {
        self.scene.as_ref().or(self.map.as_ref())
    }

    /// Part of the albedo that rays give.
    pub fn albedo(&self, point: &SurfacePoint) -> Vec3 {
        let [of_map, rest] = [(&self.map, &None), (&self.scene, &self.map)].map(|(mirror, beside)| {
            mirror.map_or(Vec3::ZERO, |mirror| mirror.fan(point, Disc::MIDDLE, beside.as_ref()).total())
        });
        of_map + rest
    }

    /// A ray for surfaces that the first does not show, as [`Mirror::ray`].
    pub fn second_ray(&self, point: &SurfacePoint, u: [f32; 2]) -> Option<(Vec3, Vec3)> {
        self.scene?.ray_beside(point, u, self.map.as_ref())
    }

    /// Width of the widest lobe.
    pub fn width(&self) -> f32 {
        [self.map, self.scene].iter().flatten().map(Mirror::width).fold(0.0, f32::max)
    }
}

#[inline(always)]
fn window<L: Lanes>(mirror: &Option<Mirror>, wi: Vec3x8<L>) -> L {
    match mirror {
        Some(mirror) => mirror.window(wi) * L::splat(mirror.share),
        None => L::splat(0.0),
    }
}

/// Light of a surface that a ray of wider lobes meets, up to a luminance: the rest is small and bright, and shows by cuts without
/// noise.
pub(crate) fn up_to(brightest: f32, light: Vec3) -> Vec3 {
    light * (brightest / luminance(light).max(f32::MIN_POSITIVE)).min(1.0)
}

/// The most that rays of wider lobes show: so many times the mean of the surfaces that send bounced light. One ray of 16 samples then
/// changes a pixel by half at most.
const TIMES_MEAN: f32 = 8.0;

/// See [`up_to`]; all light without sources, of which cuts could show the rest.
pub(crate) fn brightest_by_rays(sources: Option<&SourceLighting>) -> f32 {
    sources.map_or(f32::INFINITY, |lighting| TIMES_MEAN * luminance(lighting.nodes.radiance[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Renderer,
        test_scenes::{dataset, from_above, mesh, mirror, surface_at, white},
    };

    #[test]
    fn what_rays_do_not_show_of_a_bright_surface_stays_with_the_cuts() {
        let mut floor = dataset(mesh(8, false), white());
        floor.scene.materials[0] = mirror(0.18);
        let point = surface_at(&Renderer::new(floor), &from_above(8));
        let lobes = RayLobes::at(&point, 1e-3).expect("a lobe with a ray");
        let wi = Vec3::new(-point.wo.x, -point.wo.y, point.wo.z);
        let share = |light: Vec3, brightest| {
            lobes.share_below(Vec3x8::<f32x8>::splat(wi), Vec3x8::splat(light), brightest).to_array()[0]
        };
        let whole = lobes.share_of(wi);
        assert!(lobes.map.is_none() && whole > 0.3, "{whole}");
        for light in [Vec3::splat(0.1), Vec3::new(5.0, 1.0, 0.2), Vec3::splat(300.0)] {
            let (by_cuts, by_rays) = (light * (1.0 - share(light, 2.0)), up_to(2.0, light) * whole);
            assert!((by_cuts + by_rays - light).length() < 1e-3 * light.length(), "{by_cuts} {by_rays}");
            assert!(luminance(up_to(2.0, light)) < 2.001);
        }
        assert_eq!(share(Vec3::splat(300.0), f32::INFINITY), whole, "negative control: all by rays");
        assert_eq!(share(Vec3::ZERO, 2.0), whole);
    }
}
