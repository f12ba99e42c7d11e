//! Direct light of local lights at a pixel, by shadow rays and without random numbers.
//!
//! One ray to a light without extent is exact; lights too faint to be visible cast none ([`brightest`]). A rectangle has a grid of
//! 4 x 4 cells with one ray each. Interleaved gradient noise (Jimenez 2014) shifts the grid per pixel, which the eye averages
//! easily. If the BRDF's lobe is narrower than a cell, the ray stands for several points of the cell. The solid angle of each point
//! filters the lobe, as on nodes of a cut, so highlights of rectangles have no spots.

mod brightest;
mod seen;

pub(crate) use seen::{EightPoints, LightsSeen};

use crate::shade::surface::{ReceiverX8, SurfacePoint};
use brightest::delta_light;
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, LightsX8, narrow_widths},
    lights::{Disc, Light, LightSample, LightSampler},
    offset,
    ray::{Blockers, Cone, Intersector},
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
    sphere::SPHERE,
};
use std::array::from_fn;
use wide::f32x8;

/// Steps of the R2 sequence (Roberts 2018): 1/p and 1/p² for the plastic number p.
const STEP: Vec2 = Vec2::new(0.754_877_67, 0.569_840_3);

/// Cells along each edge of a light with an extent.
pub(crate) const CELLS: u32 = 4;
/// Number of cells.
const ALL_CELLS: usize = (CELLS * CELLS) as usize;

/// Ray targets in the cells, before the shift.
const STEPS: [Vec2; ALL_CELLS] = {
    let (mut steps, mut cell) = ([Vec2::ZERO; ALL_CELLS], 0);
    while cell < ALL_CELLS {
        let [x, y] = [STEP.x * cell as f32, STEP.y * cell as f32];
        steps[cell] = Vec2::new(x - x as u32 as f32, y - y as u32 as f32);
        cell += 1;
    }
    steps
};

/// Most points along each edge of a cell.
const FINEST: f32 = 8.0;

/// Offset of a pixel's light samples in the unit square: each sample of the pixel has a ray for each cell of a light.
pub(crate) fn pixel_shift(x: u32, y: u32, sample: u32) -> Vec2 {
    ray_shift(x, y, (sample % 4096) * CELLS * CELLS)
}

/// Offset of a pixel's rays in the unit square, if each sample of the pixel has one.
pub(crate) fn ray_shift(x: u32, y: u32, ray: u32) -> Vec2 {
    let noise = |x: f32, y: f32| (52.982_918 * (0.067_110_56 * x + 0.005_837_15 * y).fract()).fract();
    let (x, y) = (x as f32, y as f32);
    // Far apart, the two numbers are independent.
    let start = Vec2::new(noise(x, y), noise(y + 37.0, x + 91.0));
    (start + STEP * ray as f32).fract()
}

/// Share of a light's radiance at `distance` meters that reaches a point.
pub(crate) fn arriving_share(intersector: &Intersector, point: &SurfacePoint, direction: Vec3, distance: f32) -> f32 {
    intersector.transmittance_before(point.ray_origin, direction, offset::REACH_OF_SHADING * distance)
}

/// Lights and the geometry that shadows them.
#[derive(Clone, Copy)]
pub(crate) struct DirectLights<'a> {
    /// The lights.
    pub lights: &'a [Light],
    /// Casts shadow rays.
    pub intersector: &'a Intersector,
}

impl<'a> DirectLights<'a> {
    /// A shader for these lights.
    pub fn shader(&self) -> DirectShader<'a> {
        let samplers = self.lights.iter().filter(|light| light.shines()).map(Light::sampler).collect();
        DirectShader { lights: samplers, intersector: self.intersector }
    }
}

/// Shades points with the direct light of all lights that shine.
pub(crate) struct DirectShader<'a> {
    lights: Vec<LightSampler<'a>>,
    intersector: &'a Intersector,
}

impl DirectShader<'_> {
    /// Reflected radiance at a point; `shift` comes from [`pixel_shift`].
    pub fn reflected(&self, point: &SurfacePoint, shift: Vec2) -> Vec3 {
        self.reflected_beside(point, shift, LightsSeen::default(), &mut Vec::new())
    }

    /// [`Self::reflected`] for a point with known [`Self::lights_seen`], beside a point with these blockers for each light.
    pub fn reflected_beside(
        &self,
        point: &SurfacePoint,
        shift: Vec2,
        seen: LightsSeen,
        blockers: &mut Vec<Blockers>,
    ) -> Vec3 {
        let mut arriving = Arriving::at(point);
        for (i, light) in self.lights.iter().enumerate().filter(|(_, light)| !light.light().is_delta()) {
            match (light.disc(), seen.of(i)) {
                (Some(_), Some(false)) => {}
                (Some(disc), seen) => {
                    blockers.resize(blockers.len().max(i + 1), Blockers::default());
                    self.add_sun((light, disc), shift, seen == Some(true), (&mut arriving, &mut blockers[i]))
                }
                (None, _) => self.add(light, shift, &mut arriving),
            }
        }
        let delta = self.lights.iter().enumerate().filter(|(_, light)| light.light().is_delta());
        let share = |light, direction, distance| match seen.of(light) {
            Some(is_seen) => f32::from(u8::from(is_seen)),
            None => arriving_share(self.intersector, point, direction, distance),
        };
        arriving.reflected() + delta_light(point, delta, share)
    }

    /// Adds a disc light; `is_open` if nothing blocks it.
    fn add_sun(
        &self,
        (sun, disc): (&LightSampler, &Disc),
        shift: Vec2,
        is_open: bool,
        (arriving, blockers): (&mut Arriving, &mut Blockers),
    ) {
        let point = arriving.point;
        let middle = sun.sample(point.ray_origin, Vec2::splat(0.5));
        let Some(middle) = middle.filter(|_| point.may_receive(disc)) else { return };
        let aimed = InstructionSet::widest().run(Aim { disc, shift, point });
        let shares = match is_open {
            true => aimed.received.map(|bits| from_fn(|i| f32::from(bits >> i & 1))),
            false => self.shares(point, disc, &aimed, blockers),
        };
        if arriving.points_of_cell(&middle) > 1 {
            let cells = cells(shift).into_iter().zip(shares.into_iter().flatten());
            let open = cells.filter(|&(_, share)| share > 0.0);
            return open.for_each(|(cell, share)| arriving.add_cell(sun, cell, &middle, share));
        }
        let irradiance = Vec3x8::splat(middle.irradiance * (1.0 / ALL_CELLS as f32));
        let inv_kappa = f32x8::splat(inv_kappa(&middle, ALL_CELLS as u32));
        for (directions, shares) in aimed.directions.into_iter().zip(shares).filter(|(_, shares)| *shares != [0.0; 8]) {
            let irradiance = irradiance * f32x8::new(shares);
            arriving.sum += EightLights { directions, irradiance, inv_kappa }.reflected(point);
        }
    }

    /// Share of a sun's light that arrives along each of its rays.
    fn shares(&self, point: &SurfacePoint, disc: &Disc, aimed: &Aimed, blockers: &mut Blockers) -> [[f32; 8]; 2] {
        let Aimed { directions, received } = aimed;
        let cone = Cone { origin: point.ray_origin, axis: disc.axis, sine: disc.sine() };
        let open = self.intersector.open_within(&cone, directions, *received, blockers);
        let mut shares = [[0.0; 8]; 2];
        for (i, share) in
            shares.as_flattened_mut().iter_mut().enumerate().filter(|(i, _)| open[i / 8] >> (i % 8) & 1 == 1)
        {
            *share = match self.intersector.has_veils() {
                true => self.intersector.past_veils(point.ray_origin, directions[i / 8].lane(i % 8), f32::INFINITY),
                false => 1.0,
            };
        }
        shares
    }

    /// Adds a rectangle.
    fn add(&self, light: &LightSampler, shift: Vec2, arriving: &mut Arriving) {
        let point = arriving.point;
        for (corner, shift) in cells(shift) {
            let ray = light.sample(point.ray_origin, (corner + shift) / CELLS as f32);
            let Some(ray) = ray.filter(|ray| point.receives(ray.direction)) else { continue };
            let share = arriving_share(self.intersector, point, ray.direction, ray.distance);
            if share > 0.0 {
                arriving.add_cell(light, (corner, shift), &ray, share);
            }
        }
    }
}

/// The cells of a light with an extent: the corner of each in cells, and the target of its ray in it.
pub(crate) fn cells(shift: Vec2) -> [(Vec2, Vec2); ALL_CELLS] {
    from_fn(|cell| {
        let corner = Vec2::new((cell % CELLS as usize) as f32, (cell / CELLS as usize) as f32);
        (corner, (shift + STEP * cell as f32).fract())
    })
}

/// The cells by halves: corners in cells, and [`STEPS`], along both axes.
const EIGHTS: [[[[f32; 8]; 2]; 2]; 2] = {
    let (mut eights, mut cell) = ([[[[0.0; 8]; 2]; 2]; 2], 0);
    while cell < ALL_CELLS {
        let (half, lane) = (cell / 8, cell % 8);
        eights[half][0][0][lane] = (cell % CELLS as usize) as f32;
        eights[half][0][1][lane] = (cell / CELLS as usize) as f32;
        eights[half][1][0][lane] = STEPS[cell].x;
        eights[half][1][1][lane] = STEPS[cell].y;
        cell += 1;
    }
    eights
};

/// Positions of eight of the [`cells`] in the unit square.
#[inline(always)]
fn cells_x8<L: Lanes>(shift: Vec2, half: usize) -> [L; 2] {
    let [corners, steps] = EIGHTS[half];
    [along_x8(corners[0], steps[0], shift.x), along_x8(corners[1], steps[1], shift.y)]
}

/// The same positions along one axis.
#[inline(always)]
fn along_x8<L: Lanes>(corners: [f32; 8], steps: [f32; 8], shift: f32) -> L {
    let (one, moved) = (L::splat(1.0), L::new(steps) + L::splat(shift));
    let wrapped = moved.simd_ge(one).select(moved - one, moved);
    (L::new(corners) + wrapped) * L::splat(1.0 / CELLS as f32)
}

/// Rays from a point to the cells of a sun.
struct Aim<'a> {
    disc: &'a Disc,
    shift: Vec2,
    point: &'a SurfacePoint,
}

struct Aimed {
    /// Unit directions in world space.
    directions: [Vec3x8; 2],
    /// Directions that the point receives, one bit each.
    received: [u8; 2],
}

impl Kernel for Aim<'_> {
    type Output = Aimed;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Aimed {
        let receiver = ReceiverX8::<L>::new(self.point);
        let first = self.disc.directions(cells_x8::<L>(self.shift, 0));
        let second = self.disc.directions(cells_x8::<L>(self.shift, 1));
        let received = [receiver.receives_by_both(first), receiver.receives_by_both(second)];
        Aimed {
            directions: [first.portable(), second.portable()],
            received: [received[0].to_bitmask() as u8, received[1].to_bitmask() as u8],
        }
    }
}

/// Inverse concentration of one of `samples` parts of a light.
fn inv_kappa(sample: &LightSample, samples: u32) -> f32 {
    // A cap of solid angle w has a mean resultant of 1 - w / 4π; 1 / kappa tends to its difference from one.
    1.0 / (SPHERE * sample.pdf * samples as f32)
}

/// Eight lights that arrive at a point.
#[derive(Clone, Copy)]
struct EightLights {
    /// Unit directions to them in world space.
    directions: Vec3x8,
    irradiance: Vec3x8,
    inv_kappa: f32x8,
}

impl EightLights {
    /// Radiance that a point reflects of them; zero below the horizons of its normals.
    fn reflected(self, point: &SurfacePoint) -> Vec3 {
        InstructionSet::widest().run(Reflected { point, lights: self })
    }
}

/// [`EightLights::reflected`] in the machine's instruction set.
struct Reflected<'a> {
    point: &'a SurfacePoint,
    lights: EightLights,
}

impl Kernel for Reflected<'_> {
    type Output = Vec3;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec3 {
        let EightLights { directions, irradiance, inv_kappa } = &self.lights;
        let receiver = ReceiverX8::<L>::new(self.point);
        let lights = receiver.lights_at_centers(Vec3x8::load(directions), L::new(inv_kappa.to_array()));
        let (wo, irradiance, mut sum) = (self.point.wo, Vec3x8::load(irradiance), Vec3::ZERO);
        self.point.brdf.visit(Reflect { lights, wo, irradiance, sum: &mut sum });
        sum
    }
}

/// [`Reflected`] for each model.
struct Reflect<'a, L> {
    lights: LightsX8<L>,
    wo: Vec3,
    irradiance: Vec3x8<L>,
    sum: &'a mut Vec3,
}

impl<L: Lanes> BrdfVisitor for Reflect<'_, L> {
    #[inline(always)]
    fn visit(self, brdf: &impl Brdf) {
        *self.sum = brdf.reflect(&self.lights, self.wo).scale(self.irradiance).reduce_add();
    }
}

/// Incoming light from up to eight directions, not yet reflected.
struct Arriving<'a> {
    point: &'a SurfacePoint,
    /// Angular width in radians that the narrowest lobe reflects.
    lobe: f32,
    directions: [Vec3; 8],
    irradiance: [Vec3; 8],
    inv_kappa: [f32; 8],
    count: usize,
    sum: Vec3,
}

impl<'a> Arriving<'a> {
    fn at(point: &'a SurfacePoint) -> Self {
        // A lobe of half vectors within alpha reflects directions within two alphas on both sides.
        let lobes = narrow_widths(point.lobes()).into_iter().filter(|&width| width > 0.0);
        let lobe = lobes.reduce(f32::min).map_or(f32::INFINITY, |width| 4.0 * width);
        let (directions, irradiance) = ([Vec3::Z; 8], [Vec3::ZERO; 8]);
        Self { point, lobe, directions, irradiance, inv_kappa: [0.0; 8], count: 0, sum: Vec3::ZERO }
    }

    /// Points that the cell at the end of `ray` needs along each edge.
    fn points_of_cell(&self, ray: &LightSample) -> u32 {
        let cell_edge = (1.0 / ray.pdf).sqrt() / CELLS as f32;
        (cell_edge / self.lobe).ceil().clamp(1.0, FINEST) as u32
    }

    /// Adds a cell of a light, of which a share arrives along `ray`, at as many points as the lobe needs.
    fn add_cell(&mut self, light: &LightSampler, (corner, shift): (Vec2, Vec2), ray: &LightSample, share: f32) {
        let edge = self.points_of_cell(ray);
        let all = CELLS * edge;
        if edge == 1 {
            return self.add(ray, all * all, share);
        }
        for i in 0..edge * edge {
            let u = corner + (Vec2::new((i % edge) as f32, (i / edge) as f32) + shift) / edge as f32;
            let sample = light.sample(self.point.ray_origin, u / CELLS as f32);
            let received = sample.filter(|s| self.point.receives(s.direction));
            received.iter().for_each(|sample| self.add(sample, all * all, share));
        }
    }

    /// Adds a share of one of a light's samples.
    fn add(&mut self, sample: &LightSample, samples: u32, share: f32) {
        let i = self.count;
        self.directions[i] = sample.direction;
        self.irradiance[i] = sample.irradiance * (share / samples as f32);
        self.inv_kappa[i] = inv_kappa(sample, samples);
        self.count += 1;
        if self.count == 8 {
            self.reflect();
        }
    }

    fn reflect(&mut self) {
        let lights = EightLights {
            directions: Vec3x8::from_array(self.directions),
            irradiance: Vec3x8::from_array(self.irradiance),
            inv_kappa: f32x8::new(self.inv_kappa),
        };
        self.sum += lights.reflected(self.point);
        (self.irradiance, self.count) = ([Vec3::ZERO; 8], 0);
    }

    fn reflected(mut self) -> Vec3 {
        if self.count > 0 {
            self.reflect();
        }
        self.sum
    }
}

#[cfg(test)]
mod tests;
