//! Direct light of local lights at a pixel, by shadow rays and without random numbers.
//!
//! One ray to a light without extent is exact; lights too faint to be visible cast none ([`brightest`]). A rectangle
//! has a grid of 4 x 4 cells with one ray to each. Interleaved gradient noise (Jimenez 2014) shifts the grid per pixel,
//! which the eye averages easily. If the BRDF's lobe is narrower than a cell, the one ray stands for several points of
//! the cell. The lobe is filtered by the solid angle of each point, as on nodes of a cut, so that highlights of
//! rectangles are free of spots.

mod brightest;

use crate::shade::surface::{ReceiverX8, SurfacePoint};
use brightest::delta_light;
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, LightsX8, narrow_widths},
    lights::{Disc, Light, LightSample, LightSampler},
    ray::{EightRays, Intersector, offset},
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
    sphere::SPHERE,
};
use std::array::from_fn;
use wide::f32x8;

/// Steps of the R2 sequence (Roberts 2018): 1/p and 1/p² for the plastic number p.
const STEP: Vec2 = Vec2::new(0.754_877_67, 0.569_840_3);

/// Cells along each edge of a light with an extent.
const CELLS: u32 = 4;
/// Its cells.
const ALL_CELLS: usize = (CELLS * CELLS) as usize;

/// Where rays go to in the cells, but for the shift.
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

/// Offset in the unit square of a pixel's light samples.
pub(crate) fn pixel_shift(x: u32, y: u32, sample: u32) -> Vec2 {
    let noise = |x: f32, y: f32| (52.982_918 * (0.067_110_56 * x + 0.005_837_15 * y).fract()).fract();
    let (x, y) = (x as f32, y as f32);
    // Far apart, the two numbers are independent of each other.
    let start = Vec2::new(noise(x, y), noise(y + 37.0, x + 91.0));
    (start + STEP * ((sample % 4096) * CELLS * CELLS) as f32).fract()
}

/// Share of the light of a light at `distance` metres that arrives at a point.
pub(crate) fn arriving_share(intersector: &Intersector, point: &SurfacePoint, direction: Vec3, distance: f32) -> f32 {
    intersector.transmittance_before(point.ray_origin, direction, offset::REACH_OF_SHADING * distance)
}

/// Lights, and what casts their shadow rays.
#[derive(Clone, Copy)]
pub(crate) struct DirectLights<'a> {
    /// The lights.
    pub lights: &'a [Light],
    /// Casts shadow rays.
    pub intersector: &'a Intersector,
}

impl DirectLights<'_> {
    /// Radiance that a point reflects of their direct light; `shift` is that of [`pixel_shift`].
    pub fn reflected(&self, point: &SurfacePoint, shift: Vec2) -> Vec3 {
        let Self { lights, intersector } = *self;
        let mut arriving = Arriving::at(point);
        for light in lights.iter().filter(|light| light.shines() && !light.is_delta()) {
            self.add(light, shift, &mut arriving);
        }
        let delta = lights.iter().filter(|light| light.is_delta());
        arriving.reflected()
            + delta_light(point, delta, |direction, distance| arriving_share(intersector, point, direction, distance))
    }

    /// Adds a distant light of which one point of each cell is enough.
    fn add_disc(&self, disc: &Disc, middle: &LightSample, shift: Vec2, arriving: &mut Arriving) {
        let point = arriving.point;
        let receiver = ReceiverX8::<f32x8>::new(point);
        let eights = [0, 1].map(|half| disc.directions(cells_x8(shift, half)));
        let rays = eights.map(|directions| {
            let is_received = receiver.receives_by_both(directions).to_bitmask() as u8;
            EightRays::new([point.ray_origin; 8], from_fn(|i| directions.lane(i)), is_received)
        });
        let irradiance = Vec3x8::splat(middle.irradiance * (1.0 / ALL_CELLS as f32));
        let inv_kappa = f32x8::splat(inv_kappa(middle, ALL_CELLS as u32));
        let open = self.intersector.open(&rays);
        for (directions, open) in eights.into_iter().zip(open).filter(|&(_, open)| open != 0) {
            let share = |i: usize| match open >> i & 1 {
                0 => 0.0,
                _ => self.intersector.past_veils(point.ray_origin, directions.lane(i), f32::INFINITY),
            };
            let irradiance = irradiance * f32x8::new(from_fn(share));
            arriving.sum += EightLights { directions, irradiance, inv_kappa }.reflected(point);
        }
    }

    /// Adds a light with an extent.
    fn add(&self, light: &Light, shift: Vec2, arriving: &mut Arriving) {
        let (point, sampler) = (arriving.point, light.sampler());
        if ![point.smooth_normal, point.world_from_local.z_axis].iter().all(|&normal| sampler.may_be_above(normal)) {
            return;
        }
        let middle = sampler.sample(point.ray_origin, Vec2::splat(0.5));
        if let (Some(disc), Some(middle)) = (sampler.disc(), middle)
            && arriving.points_of_cell(&middle) == 1
        {
            return self.add_disc(disc, &middle, shift, arriving);
        }
        let cells = cells(shift);
        let rays = cells.map(|(corner, shift)| {
            let ray = sampler.sample(point.ray_origin, (corner + shift) / CELLS as f32);
            ray.filter(|ray| point.receives(ray.direction))
        });
        let shares = seen(point, &rays, self.intersector);
        for ((cell, ray), share) in cells.into_iter().zip(&rays).zip(shares).filter(|&(_, share)| share > 0.0) {
            ray.iter().for_each(|ray| arriving.add_cell(&sampler, cell, ray, share));
        }
    }
}

/// The cells of a light with an extent: the corner of each, in cells, and where in it its ray goes to.
fn cells(shift: Vec2) -> [(Vec2, Vec2); ALL_CELLS] {
    from_fn(|cell| {
        let corner = Vec2::new((cell % CELLS as usize) as f32, (cell / CELLS as usize) as f32);
        (corner, (shift + STEP * cell as f32).fract())
    })
}

/// Places in the unit square of eight of the [`cells`].
#[inline(always)]
fn cells_x8(shift: Vec2, half: usize) -> [f32x8; 2] {
    let cells: [(Vec2, Vec2); 8] = from_fn(|i| {
        let cell = 8 * half + i;
        (Vec2::new((cell % CELLS as usize) as f32, (cell / CELLS as usize) as f32), STEPS[cell])
    });
    let at = |of: fn(Vec2) -> f32| {
        let moved = f32x8::new(cells.map(|(_, step)| of(step))) + f32x8::splat(of(shift));
        let wrapped = moved.simd_ge(f32x8::splat(1.0)).select(moved - f32x8::splat(1.0), moved);
        (f32x8::new(cells.map(|(corner, _)| of(corner))) + wrapped) * f32x8::splat(1.0 / CELLS as f32)
    };
    [at(|v| v.x), at(|v| v.y)]
}

/// Inverse concentration of the part of a light that one of so many samples stands for.
fn inv_kappa(sample: &LightSample, samples: u32) -> f32 {
    // A cap of solid angle w has a mean resultant of 1 - w / 4π, and 1 / kappa tends to what is missing to one.
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
    /// What a point reflects of them; nothing from below the horizons of its normals.
    fn reflected(self, point: &SurfacePoint) -> Vec3 {
        InstructionSet::widest().run(Reflected { point, lights: self })
    }
}

/// [`EightLights::reflected`] in the instructions of the machine.
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

/// Share of the light that arrives along each ray. Those to a distant light are traced eight at a time.
fn seen(point: &SurfacePoint, rays: &[Option<LightSample>; ALL_CELLS], intersector: &Intersector) -> [f32; ALL_CELLS] {
    let is_distant = rays.iter().flatten().all(|ray| ray.distance.is_infinite());
    if !is_distant {
        let share = |ray: &LightSample| arriving_share(intersector, point, ray.direction, ray.distance);
        return from_fn(|i| rays[i].as_ref().map_or(0.0, share));
    }
    let eight = |rays: &[Option<LightSample>]| {
        let directions = from_fn(|i| rays[i].map_or(Vec3::Y, |ray| ray.direction));
        let active = (0..8).map(|i| u8::from(rays[i].is_some()) << i).sum();
        EightRays::new([point.ray_origin; 8], directions, active)
    };
    let eights: [EightRays; ALL_CELLS / 8] = from_fn(|i| eight(&rays[8 * i..]));
    let open = intersector.open(&eights);
    let share = |i: usize, ray: &LightSample| match open[i / 8] >> (i % 8) & 1 {
        0 => 0.0,
        _ => intersector.past_veils(point.ray_origin, ray.direction, f32::INFINITY),
    };
    from_fn(|i| rays[i].as_ref().map_or(0.0, |ray| share(i, ray)))
}

/// Light from up to eight directions that has not been reflected yet.
struct Arriving<'a> {
    point: &'a SurfacePoint,
    /// Width in radians of what its narrowest lobe reflects of a light.
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

    /// How many points along each edge a cell needs that `ray` goes to.
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
