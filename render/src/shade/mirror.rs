//! Sharp lobes: a lobe narrower than a few light samples reads the environment's map itself.
//!
//! Light samples are too coarse for sharp lobes: filtered samples blur a mirror by the sample spacing. A window `w` around the
//! mirror direction, as wide as the lobe and a sample together, has its light replaced:
//!
//! `∫ f L V w  =  ∫ f L w · (Σ f̃ L V w / Σ f̃ L w)`
//!
//! The first factor has no visibility. Importance samples of the lobe, and of one that fills the window, read it from the map, each
//! from a pyramid level that matches the sample spacing (Krivanek and Colbert 2008, *Real-time Shading with Filtered Importance
//! Sampling*). The second factor is the visible share of this light, over the nodes of the merged cut. Both need only the widths of
//! a model's lobes. Twin of `shaders/mirror.wgsl`.

use crate::{
    light::mirrored_map::MirroredMap,
    shade::surface::{ReceiverX8, SurfacePoint},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, GgxLobe, Lobes, MIN_ALPHA, NO_LOBE},
    simd::{Lanes, Vec3x8},
};
use std::f32::consts::PI;
use wide::f32x8;

/// A lobe narrower than this many radii of a light sample is sharp, and reads the map alone.
const SHARP: f32 = 3.0;
/// A lobe wider than this many radii reads light samples alone.
const SOFT: f32 = 5.0;
/// Half-width of the window in widths of a light sample's blur, which then lies inside.
const WINDOW: f32 = 6.0;
/// Half-width of the window in widths of the lobe.
const OF_LOBE: f32 = 3.0;
/// Directions per lobe.
const SAMPLES: usize = 8;
/// Most sampled lobes: three sharp ones and one that fills the window.
const MOST_LOBES: usize = 4;
/// Half-width of the window in widths of the lobe that fills it. That lobe samples a diffuse or rough base.
const FILLED: f32 = 2.5;
/// Range of slope correlation over which a mirror fades: axis-aligned lobes cannot sample slopes off both axes.
const CORRELATED: [f32; 2] = [0.1, 0.3];
/// Rotation between samples as cosine and sine: the golden section of a full turn, which fills discs evenly.
const GOLDEN: Vec2 = Vec2::new(-0.737_368_8, -0.675_490_26);

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 10] = [
    ("SHARP", SHARP),
    ("SOFT", SOFT),
    ("WINDOW", WINDOW),
    ("OF_LOBE", OF_LOBE),
    ("MIRROR_SAMPLES", SAMPLES as f32),
    ("FILLED", FILLED),
    ("CORRELATED_LOW", CORRELATED[0]),
    ("CORRELATED_HIGH", CORRELATED[1]),
    ("GOLDEN_COS", GOLDEN.x),
    ("GOLDEN_SIN", GOLDEN.y),
];

/// Angular radius in radians of a disc with this solid angle.
fn sample_radius(leaf_solid_angle: f32) -> f32 {
    (leaf_solid_angle / PI).sqrt()
}

/// The sharp lobes of one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror {
    /// Share of the window's light that is replaced; below 1 for moderately soft lobes.
    share: f32,
    /// Widths of the sampled lobes, the first `count`: the sharp ones, and one that fills the window.
    lobes: [[f32; 2]; MOST_LOBES],
    count: usize,
    /// Inverse squares of the window's half-axes, in slopes of half vectors.
    axes: [f32; 2],
    /// Largest angle in radians from the mirror direction to the window's rim.
    reach: f32,
    wo: Vec3,
}

impl Mirror {
    /// Whether a lobe of this width may read the map, among light samples of this solid angle in steradians.
    pub fn may_be(narrowest: f32, leaf_solid_angle: f32) -> bool {
        sharpness(narrowest / sample_radius(leaf_solid_angle)) > 0.0
    }

    /// Mirror for the lobes of a point, among light samples of this solid angle in steradians.
    pub fn at(point: &SurfacePoint, leaf_solid_angle: f32) -> Option<Self> {
        Self::of(point.brdf.as_brdf().lobes(), point.slopes, point.wo, leaf_solid_angle)
    }

    /// Mirror for a model's lobes, on a surface with these [slopes](SurfacePoint::slopes), seen from the local direction `wo`.
    fn of(lobes: Lobes, [xx, xy, yy]: [f32; 3], wo: Vec3, leaf_solid_angle: f32) -> Option<Self> {
        let sample_radius = sample_radius(leaf_solid_angle);
        let (mut sampled, mut count) = ([[MIN_ALPHA; 2]; MOST_LOBES], 0);
        let (mut share, mut widest) = (0.0_f32, [0.0_f32; 2]);
        for [along, across] in lobes.into_iter().filter(|&lobe| lobe != NO_LOBE) {
            let [along, across] = [(along * along + xx).sqrt(), (across * across + yy).sqrt()];
            let correlation = xy.abs() / (along * across);
            let sharpness = sharpness(along.min(across) / sample_radius) * falling(correlation, CORRELATED);
            if sharpness > 0.0 {
                sampled[count] = [along.max(MIN_ALPHA), across.max(MIN_ALPHA)];
                widest = [widest[0].max(along), widest[1].max(across)];
                count += 1;
                share = share.max(sharpness);
            }
        }
        if !(share > 0.0 && wo.z > 0.0) {
            return None;
        }
        // Width that a sample adds in the space of half vectors, larger at grazing angles.
        let added = sample_radius / wo.z.max(0.1);
        let blurred = WINDOW * WINDOW * 0.125 * added * added;
        let half_axes = widest.map(|width| (OF_LOBE * OF_LOBE * width * width + blurred).sqrt());
        sampled[count] = half_axes.map(|axis| (axis / FILLED).min(1.0));
        let reach = 2.0 * half_axes[0].max(half_axes[1]).atan();
        let axes = half_axes.map(|axis| 1.0 / (axis * axis));
        Some(Self { share, lobes: sampled, count: count + 1, axes, reach, wo })
    }

    /// Window weight of eight local directions: 1 around the mirror direction, 0 outside.
    #[inline(always)]
    pub fn window<L: Lanes>(&self, wi: Vec3x8<L>) -> L {
        let half = wi + Vec3x8::splat(self.wo);
        let slopes = half.x * half.x * L::splat(self.axes[0]) + half.y * half.y * L::splat(self.axes[1]);
        let distance = slopes / (half.z * half.z).at_least(1e-6);
        // Smooth from half of the half-axes to their ends.
        let t = ((L::splat(1.0) - distance) * L::splat(4.0 / 3.0)).at_least(0.0).fast_min(L::splat(1.0));
        t * t * (L::splat(3.0) - t - t)
    }

    /// Spread of eight lights for widening lobes: zero except well inside the window. A widened lobe has bright tails, which would
    /// add light outside the window.
    #[inline(always)]
    pub fn spread<L: Lanes>(&self, wi: Vec3x8<L>, inv_kappa: L) -> L {
        inv_kappa * (L::splat(1.0) - (L::splat(1.0) - self.inside(wi)) * L::splat(self.share))
    }

    /// The eighth power of the window.
    #[inline(always)]
    fn inside<L: Lanes>(&self, wi: Vec3x8<L>) -> L {
        let window = self.window(wi);
        let squared = window * window;
        let fourth = squared * squared;
        fourth * fourth
    }

    /// Spread of eight light samples for widening lobes; zero for soft lobes, which take samples as single directions.
    pub fn sample_spread(&self, wi: Vec3x8, inv_kappa: f32x8) -> f32x8 {
        inv_kappa * (self.inside(wi) * f32x8::splat(self.share))
    }

    /// Mask of the cones of `radius` that reach into the window, from the cosine of their angle to the mirror direction.
    #[inline(always)]
    pub fn overlaps<L: Lanes>(&self, cos: L, radius: L) -> L {
        let angle = (L::splat(self.reach) + radius).fast_min(L::splat(PI));
        let sq = angle * angle;
        // Taylor's polynomial of degree 6 lies below the cosine.
        let least = L::splat(1.0) - sq * (L::splat(0.5) - sq * (L::splat(1.0 / 24.0) - sq * L::splat(1.0 / 720.0)));
        cos.simd_gt(least)
    }

    /// `∫ f L w`: unoccluded light of the window.
    #[inline(always)]
    pub fn unshadowed<L: Lanes>(&self, point: &SurfacePoint, map: &MirroredMap) -> Vec3 {
        let (receiver, mut sum) = (ReceiverX8::<L>::new(point), Vec3::ZERO);
        point.brdf.visit(Unshadowed { mirror: self, receiver, map, sum: &mut sum });
        sum
    }

    #[inline(always)]
    fn unshadowed_with<L: Lanes>(&self, brdf: &impl Brdf, receiver: &ReceiverX8<L>, map: &MirroredMap) -> Vec3 {
        let lobes = self.lobes.map(GgxLobe::new);
        let lobes = &lobes[..self.count];
        let mut sum = Vec3x8::<L>::splat(Vec3::ZERO);
        for eight in self.samples(lobes)[..self.count * SAMPLES].as_chunks::<8>().0 {
            let local = Vec3x8::<L>::from_array(*eight);
            let solid_angles = self.solid_angles(lobes, local);
            let direction = receiver.world(local);
            let radiance = map.radiance_x8(direction.portable(), solid_angles.to_array());
            let lights = receiver.lights_at_centers(direction, L::splat(0.0));
            let light = brdf.reflect(&lights, self.wo).scale(Vec3x8::from_array(radiance));
            sum = sum + light * (self.window(local) * solid_angles);
        }
        sum.reduce_add()
    }

    /// Solid angles of eight local directions among [`Self::samples`]; 0 below the horizon.
    #[inline(always)]
    fn solid_angles<L: Lanes>(&self, lobes: &[GgxLobe], local: Vec3x8<L>) -> L {
        let mut density = L::splat(0.0);
        for lobe in lobes {
            density = density + lobe.pdf_x8(local, self.wo);
        }
        let solid_angles = L::splat(1.0) / (L::splat(SAMPLES as f32) * density.at_least(1e-6));
        solid_angles & local.z.simd_gt(L::splat(0.0))
    }

    /// Local directions sampled from the lobes, including those below the horizon.
    fn samples(&self, lobes: &[GgxLobe]) -> [Vec3; MOST_LOBES * SAMPLES] {
        let mut samples = [Vec3::NEG_Z; MOST_LOBES * SAMPLES];
        let mut turn = Vec2::X;
        for (i, of_each) in samples[..self.count * SAMPLES].chunks_mut(self.count).enumerate() {
            let radius = ((i as f32 + 0.5) / SAMPLES as f32).sqrt();
            for (sample, lobe) in of_each.iter_mut().zip(lobes) {
                let half = lobe.visible_normal(self.wo, radius * turn);
                *sample = 2.0 * self.wo.dot(half) * half - self.wo;
            }
            turn = GOLDEN.rotate(turn);
        }
        samples
    }

    /// A point's light with the window's light replaced: `reflected` is the nodes' total, `seen` their visible light in the window,
    /// `all` their unoccluded light there. [`Self::unshadowed`] is computed only if `seen` is not zero.
    #[inline(always)]
    pub fn sharpened(&self, reflected: Vec3, seen: Vec3, all: Vec3, unshadowed: impl FnOnce() -> Vec3) -> Vec3 {
        if seen == Vec3::ZERO {
            return reflected;
        }
        let unshadowed = unshadowed();
        let share = |seen: f32, all: f32| if all > 0.0 { (seen / all).min(1.0) } else { 0.0 };
        let shares = Vec3::new(share(seen.x, all.x), share(seen.y, all.y), share(seen.z, all.z));
        reflected + (shares * unshadowed - seen) * self.share
    }
}

/// [`Mirror::unshadowed`] for each model.
struct Unshadowed<'m, L> {
    mirror: &'m Mirror,
    receiver: ReceiverX8<L>,
    map: &'m MirroredMap,
    sum: &'m mut Vec3,
}

impl<L: Lanes> BrdfVisitor for Unshadowed<'_, L> {
    #[inline(always)]
    fn visit(self, brdf: &impl Brdf) {
        *self.sum = self.mirror.unshadowed_with(brdf, &self.receiver, self.map);
    }
}

/// 1 for sharp lobes, with the width in radii of a light sample; 0 for soft ones.
fn sharpness(width: f32) -> f32 {
    falling(width, [SHARP, SOFT])
}

/// 1 below `low`, 0 above `high`, smooth between.
fn falling(x: f32, [low, high]: [f32; 2]) -> f32 {
    let t = ((high - x) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests;
