//! Sharp lobes: a lobe narrower than a few light samples reads the environment's map itself, or looks along rays.
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
//!
//! Where mirrors show the scene ([`super::mirrors`]), cuts give no light of the window. A ray for each sample of the picture finds a
//! surface, whose light replaces `L V`, or finds none: the map's part is then the first factor.

pub(crate) mod rays;

use crate::{
    light::mirrored_map::MirroredMap,
    shade::surface::{ReceiverX8, SurfacePoint},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, GgxLobe, Lobes, MIN_ALPHA, NO_LOBE},
    color::LUMINANCE,
    simd::{Lanes, Vec3x8},
};
use std::f32::consts::{PI, TAU};
use wide::f32x8;

/// A lobe narrower than this many radii of a light sample is sharp, and reads the map alone.
const SHARP: f32 = 3.0;
/// A lobe wider than this many radii reads light samples alone.
const SOFT: f32 = 5.0;
/// Half-width of the window in widths of a light sample's blur, which then lies inside.
const WINDOW: f32 = 6.0;
/// Half-width of the window in widths of the lobe.
const OF_LOBE: f32 = 3.0;
/// Solid angle of the directions that a cone reflects, in twice the variance of their half vectors: the square of twice their range.
const OF_CONE: f32 = 24.0;
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

/// Times that the place in the rings passes from one end to the other during a turn of the disc.
const RINGS_A_TURN: f32 = 64.0;

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 12] = [
    ("SHARP", SHARP),
    ("SOFT", SOFT),
    ("WINDOW", WINDOW),
    ("OF_LOBE", OF_LOBE),
    ("OF_CONE", OF_CONE),
    ("MIRROR_SAMPLES", SAMPLES as f32),
    ("FILLED", FILLED),
    ("CORRELATED_LOW", CORRELATED[0]),
    ("CORRELATED_HIGH", CORRELATED[1]),
    ("GOLDEN_COS", GOLDEN.x),
    ("GOLDEN_SIN", GOLDEN.y),
    ("RINGS_A_TURN", RINGS_A_TURN),
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
    /// See [`SurfacePoint::by_cone`].
    by_cone: f32,
}

impl Mirror {
    /// Whether a lobe of this width may read the map, among light samples of this solid angle in steradians.
    pub fn may_be(narrowest: f32, leaf_solid_angle: f32) -> bool {
        sharpness(narrowest / sample_radius(leaf_solid_angle)) > 0.0
    }

    /// Mirror for the lobes of a point, among light samples of this solid angle in steradians.
    pub fn at(point: &SurfacePoint, leaf_solid_angle: f32) -> Option<Self> {
        let widths = Widths::among_samples(sample_radius(leaf_solid_angle));
        Self::of(point.brdf.as_brdf().lobes(), point.slopes, point.wo, widths)
            .map(|mirror| Self { by_cone: point.by_cone, ..mirror })
    }

    /// Mirror for a model's lobes, on a surface with these [slopes](SurfacePoint::slopes), seen from the local direction `wo`.
    fn of(
        lobes: Lobes,
        [xx, xy, yy]: [f32; 3],
        wo: Vec3,
        Widths { sharp, added }: Widths<impl Fn(f32) -> f32>,
    ) -> Option<Self> {
        let (mut sampled, mut count) = ([[MIN_ALPHA; 2]; MOST_LOBES], 0);
        let (mut share, mut widest) = (0.0_f32, [0.0_f32; 2]);
        for [along, across] in lobes.into_iter().filter(|&lobe| lobe != NO_LOBE) {
            let [along, across] = [(along * along + xx).sqrt(), (across * across + yy).sqrt()];
            let correlation = xy.abs() / (along * across);
            let sharpness = sharp(along.min(across)) * falling(correlation, CORRELATED);
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
        let added = added / wo.z.max(0.1);
        let blurred = WINDOW * WINDOW * 0.125 * added * added;
        let half_axes = widest.map(|width| (OF_LOBE * OF_LOBE * width * width + blurred).sqrt());
        sampled[count] = half_axes.map(|axis| (axis / FILLED).min(1.0));
        let reach = 2.0 * half_axes[0].max(half_axes[1]).atan();
        let axes = half_axes.map(|axis| 1.0 / (axis * axis));
        Some(Self { share, lobes: sampled, count: count + 1, axes, reach, wo, by_cone: 0.0 })
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
        for eight in self.samples(lobes, Disc::MIDDLE)[..self.count * SAMPLES].as_chunks::<8>().0 {
            let local = Vec3x8::<L>::from_array(*eight);
            let solid_angles = self.solid_angles(lobes, local);
            let direction = receiver.world(local);
            let patches = solid_angles + L::splat(OF_CONE * self.by_cone);
            let radiance = map.radiance_x8(direction.portable(), patches.to_array());
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
    fn samples(&self, lobes: &[GgxLobe], Disc { mut turn, ring }: Disc) -> [Vec3; MOST_LOBES * SAMPLES] {
        let mut samples = [Vec3::NEG_Z; MOST_LOBES * SAMPLES];
        for (i, of_each) in samples[..self.count * SAMPLES].chunks_mut(self.count).enumerate() {
            let radius = ((i as f32 + ring) / SAMPLES as f32).sqrt();
            for (sample, lobe) in of_each.iter_mut().zip(lobes) {
                let half = lobe.visible_normal(self.wo, radius * turn);
                *sample = 2.0 * self.wo.dot(half) * half - self.wo;
            }
            turn = GOLDEN.rotate(turn);
        }
        samples
    }

    /// A ray that stands for the window, from two numbers in [0, 1): its direction, and a weight. The mean over all numbers of
    /// weight times radiance is `share · ∫ f L w`. `None` if the window reflects nothing.
    pub fn ray(&self, point: &SurfacePoint, u: [f32; 2]) -> Option<(Vec3, Vec3)> {
        self.ray_beside(point, u, None)
    }

    /// The same for what another window leaves.
    fn ray_beside(&self, point: &SurfacePoint, [turn, pick]: [f32; 2], beside: Option<&Self>) -> Option<(Vec3, Vec3)> {
        let disc = Disc { turn: Vec2::from_angle(TAU * turn), ring: (RINGS_A_TURN * turn).fract() };
        let fan = self.fan(point, disc, beside);
        let luminance = |ray: usize| fan.weights[ray].dot(LUMINANCE);
        // Lobe by lobe: evenly spread numbers then choose each lobe as often as its share says.
        let by_lobes = || (0..self.count).flat_map(|lobe| (lobe..fan.count).step_by(self.count));
        let total: f32 = by_lobes().map(luminance).sum();
        let mut left = pick * total;
        let ray = by_lobes().find(|&ray| {
            left -= luminance(ray);
            luminance(ray) > 0.0 && left < 0.0
        })?;
        Some((fan.directions[ray], fan.weights[ray] * (total / luminance(ray))))
    }

    /// Width of the widest sharp lobe.
    pub fn width(&self) -> f32 {
        let sharp = self.lobes[..self.count - 1].as_flattened();
        sharp.iter().copied().fold(0.0, f32::max)
    }

    /// The sampled directions and their weights, without the share of another window.
    fn fan(&self, point: &SurfacePoint, disc: Disc, beside: Option<&Self>) -> Fan {
        let lobes = self.lobes.map(GgxLobe::new);
        let lobes = &lobes[..self.count];
        let receiver = ReceiverX8::<f32x8>::new(point);
        let mut fan = Fan { count: self.count * SAMPLES, ..Fan::EMPTY };
        let eights = fan.directions.as_chunks_mut::<8>().0.iter_mut().zip(fan.weights.as_chunks_mut::<8>().0);
        for (local, (directions, weights)) in
            self.samples(lobes, disc)[..fan.count].as_chunks::<8>().0.iter().zip(eights)
        {
            let local = Vec3x8::from_array(*local);
            let direction = receiver.world(local);
            let mut share = self.window(local) * f32x8::splat(self.share);
            if let Some(other) = beside {
                share = Lanes::at_least(share - other.window(local) * f32x8::splat(other.share), 0.0);
            }
            let amount = receiver.receives(direction) & (share * self.solid_angles(lobes, local));
            let weight = point.reflect(local, f32x8::ZERO) * amount;
            for lane in 0..8 {
                (directions[lane], weights[lane]) = (direction.lane(lane), weight.lane(lane));
            }
        }
        fan
    }

    /// A point's light without the window's: `reflected` is the light samples' total, `seen` their visible light in the window.
    pub fn without_window(&self, reflected: Vec3, seen: Vec3) -> Vec3 {
        (reflected - seen * self.share).max(Vec3::ZERO)
    }

    /// `share · ∫ f L w` for the map alone.
    pub fn of_map(&self, point: &SurfacePoint, map: &MirroredMap) -> Vec3 {
        self.unshadowed::<f32x8>(point, map) * self.share
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

/// Where the samples of a lobe begin on its disc.
#[derive(Clone, Copy)]
struct Disc {
    /// Cosine and sine of the first angle.
    turn: Vec2,
    /// Place in rings of equal area, 0 to 1.
    ring: f32,
}

impl Disc {
    const MIDDLE: Self = Self { turn: Vec2::X, ring: 0.5 };
}

/// Directions of a window in world space.
struct Fan {
    directions: [Vec3; MOST_LOBES * SAMPLES],
    /// BRDF times cosine, share and solid angle; zero below the horizons.
    weights: [Vec3; MOST_LOBES * SAMPLES],
    count: usize,
}

impl Fan {
    const EMPTY: Self =
        Self { directions: [Vec3::ZERO; MOST_LOBES * SAMPLES], weights: [Vec3::ZERO; MOST_LOBES * SAMPLES], count: 0 };

    /// Sum of the weights.
    fn total(&self) -> Vec3 {
        self.weights[..self.count].iter().sum()
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

/// Which lobes are sharp.
struct Widths<F> {
    /// 1 for sharp widths, 0 for soft ones.
    sharp: F,
    /// Width that a light adds to a lobe, in radians.
    added: f32,
}

impl Widths<()> {
    /// Among light samples of this radius in radians.
    fn among_samples(radius: f32) -> Widths<impl Fn(f32) -> f32> {
        Widths { sharp: move |width| sharpness(width / radius), added: radius }
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
