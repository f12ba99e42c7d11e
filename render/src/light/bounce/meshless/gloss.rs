//! Bounced light by direction at meshless functions, for glossy receivers: the tensor product of the basis with directions (meshless
//! paper, 2.1). Links between functions know no directions, so functions look along rays, which are kept. Vector irradiance stays
//! the measure of how much light arrives; directions say from where.

use super::functions::MeshlessLight;
use crate::{baked::Baked, light::bounce::ends::SurfaceRays, shade::surface::SurfacePoint};
use glam::{Mat3, Vec3};
use lapidary_core::{
    gather_table::RayFan,
    meshless::{Basis, FunctionPlace, Projection, RayEnd},
    simd::{Lanes, Vec3x8},
    sphere::{concentric::HemisphereCells, harmonics::Harmonics, inv_kappa_of},
    surfel::{GradedGrid, Surfel},
    transport::Coefficient,
};
use rayon::prelude::*;
use std::{f32::consts::PI, sync::LazyLock};
use wide::f32x8;

/// Rays of a function.
const RAYS: usize = 128;
/// Most functions that look: those of finer levels see what the coarser ones see.
const MOST_FUNCTIONS: usize = 8192;
/// Cells over which a BRDF is evaluated.
pub(crate) const CELLS: HemisphereCells = HemisphereCells { side: 8 };
/// The end of a ray that meets no sender.
const DARK: u32 = u32::MAX;

/// Rays of the functions of the first levels, with the senders that they meet.
pub struct LookingFunctions {
    levels: usize,
    projection: Projection,
    fan: RayFan,
    /// [`RAYS`] a function.
    senders: Vec<u32>,
}

/// Radiance that arrives at the functions of the first levels, by direction.
#[derive(Debug)]
pub struct ArrivingByDirection {
    /// Number of levels.
    pub levels: usize,
    /// One a function.
    pub coefficients: Vec<Harmonics>,
}

impl LookingFunctions {
    /// Traces the rays.
    pub fn new(baked: &Baked, basis: &Basis) -> Self {
        let few = |&levels: &usize| basis.first_levels(levels).len() <= MOST_FUNCTIONS;
        let levels = (1..=basis.sender_levels()).take_while(few).last().unwrap_or(0);
        let (fan, rays) = (RayFan::new(RAYS), SurfaceRays::new(baked));
        let reach = |level: usize| basis.level(level).map(move |_| basis.radii()[level]);
        let reaches = (0..basis.sender_levels()).flat_map(reach);
        let senders = GradedGrid::of(basis.sender_points().iter().copied().zip(reaches));
        let met = |end: RayEnd| match end {
            RayEnd::Surface(at) => senders.nearest(&at).map_or(DARK, |sender| sender as u32),
            _ => DARK,
        };
        let of_function = |function: usize| {
            let at: &Surfel = &basis.points()[function];
            let frame = RayFan::frame(function as u32, at.normal);
            let directions: Vec<Vec3> = fan.directions().iter().map(|&direction| frame * direction).collect();
            rays.ends(at, &directions).into_iter().map(met)
        };
        let senders = basis.first_levels(levels).into_par_iter().flat_map_iter(of_function).collect();
        Self { levels, projection: Projection::new(basis, levels), fan, senders }
    }

    /// What arrives where senders send this radiance in W/(m² sr).
    pub fn arriving(&self, basis: &Basis, sent: &[Vec3]) -> ArrivingByDirection {
        let of_function = |(function, senders): (usize, &[u32])| {
            let frame = RayFan::frame(function as u32, basis.points()[function].normal);
            let lit = senders.iter().zip(self.fan.directions()).filter(|(sender, _)| **sender != DARK);
            lit.fold(Harmonics::ZERO, |sum, (&sender, &direction)| {
                let power = sent[sender as usize] * self.fan.solid_angle();
                sum + Harmonics::of_light(frame * direction, power)
            })
        };
        let rays = self.senders.par_chunks(self.fan.directions().len());
        let values: Vec<Harmonics> = rays.enumerate().map(of_function).collect();
        ArrivingByDirection { levels: self.levels, coefficients: self.projection.pull_push(&values) }
    }
}

impl MeshlessLight {
    /// What a surface reflects of the light that arrives there, over what a white diffuse one would reflect; `None` if that is not
    /// known by direction, or if the surface is diffuse.
    ///
    /// Where its BRDF is that of a diffuse surface, this is its albedo.
    pub(crate) fn reflectance(&self, place: &FunctionPlace, point: &SurfacePoint) -> Option<Vec3> {
        let arriving = self.by_direction()?;
        point.brdf.as_brdf().narrowest_lobe()?;
        let functions = self.functions();
        let of_level =
            |level: usize| functions.evaluate_in(functions.slot_at(level, place), level, place, &arriving.coefficients);
        let sum = (0..arriving.levels).filter_map(of_level).fold(Harmonics::ZERO, |sum, part| sum + part);
        let Mat3 { x_axis, y_axis, z_axis } = point.world_from_local;
        let axes = [x_axis, y_axis, z_axis].map(Vec3x8::<f32x8>::splat);
        let [mut received, mut reflected] = [Vec3x8::splat(Vec3::ZERO); 2];
        for cell in &*EIGHTS {
            let wi = cell.wi;
            let light = sum.at_x8(axes[0] * wi.x + axes[1] * wi.y + axes[2] * wi.z);
            let light = Vec3x8 { x: light.x.at_least(0.0), y: light.y.at_least(0.0), z: light.z.at_least(0.0) };
            received = received + light;
            reflected = reflected + point.reflect(wi, cell.spread).scale(light) * cell.inv_cosine;
        }
        let (received, reflected) = (received.reduce_add(), reflected.reduce_add());
        let is_lit = received.cmpgt(Vec3::splat(f32::MIN_POSITIVE));
        Some(Vec3::select(is_lit, PI * reflected / received, point.brdf.as_brdf().albedo()))
    }
}

/// Eight cells of the hemisphere.
struct CellsX8 {
    /// Unit directions in the local frame.
    wi: Vec3x8,
    /// Their spread, by which lobes are as wide at least.
    spread: f32x8,
    inv_cosine: f32x8,
}

static EIGHTS: LazyLock<Vec<CellsX8>> = LazyLock::new(|| {
    let eight = |first: usize| {
        let wi = Vec3x8::from_array(std::array::from_fn(|lane| CELLS.direction_of(first + lane)));
        let inv_cosine = f32x8::splat(1.0) / wi.z;
        CellsX8 { wi, spread: inv_cosine * f32x8::splat(inv_kappa_of(CELLS.weight())), inv_cosine }
    };
    (0..CELLS.len()).step_by(8).map(eight).collect()
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Renderer, View,
        light::bounce::MeshlessRig,
        test_scenes::{Edited, WALL, from_above, glossy, linked_floor_and_wall, point_light, surface_at},
    };
    use lapidary_core::{camera::Camera, dataset::Dataset, material::BrdfModel, sphere::fibonacci_directions};

    /// The wall sends, and a metal floor receives.
    fn metal_floor() -> Dataset {
        let mut dataset = linked_floor_and_wall();
        dataset.scene.materials[0].model = BrdfModel::Ggx;
        dataset.scene.materials[0].parameters =
            lapidary_core::brdf::GgxParameters { base_color: Vec3::ONE, metalness: 1.0, ..glossy(0.5) }.into();
        dataset
    }

    #[test]
    fn light_arrives_from_the_wall_and_by_its_solid_angle() {
        let baked = Baked::from(linked_floor_and_wall());
        let basis = &baked.dataset.meshless.as_ref().unwrap().basis;
        let looking = LookingFunctions::new(&baked, basis);
        let floor = basis.points().iter().position(|point| point.normal == Vec3::Y).unwrap();
        let sent: Vec<Vec3> =
            basis.points().iter().map(|point| Vec3::splat(f32::from(u8::from(point.normal != Vec3::Y)))).collect();
        let values: Vec<Harmonics> = looking.arriving(basis, &sent).coefficients;
        let found = values[floor];
        // Through the plane of the wall, by brute force.
        let directions = fibonacci_directions(100_000);
        let meets = |d: &&Vec3| {
            let at = **d * (WALL[0].x / d.x);
            d.x < 0.0 && (WALL[0].y..WALL[2].y).contains(&at.y) && at.z.abs() < WALL[0].z
        };
        let solid_angle = directions.iter().filter(meets).count() as f32 * 4.0 * PI / directions.len() as f32;
        let mean = found.0[0].x / 0.282_094_8;
        assert!((mean / solid_angle - 1.0).abs() < 0.2, "{mean} for {solid_angle}");
        let [toward, away] = [-1.0, 1.0].map(|x| found.at(Vec3::new(x, 0.5, 0.0).normalize()).x);
        assert!(toward > 5.0 * away.abs(), "negative control: {toward} {away}");
        let dark = looking.arriving(basis, &vec![Vec3::ZERO; sent.len()]);
        assert!(dark.coefficients.iter().all(|of| *of == Harmonics::ZERO));
    }

    #[test]
    fn a_glossy_floor_mirrors_the_wall_to_the_other_side() {
        let baked = Baked::from(metal_floor());
        let mut rig = Edited::new(&baked, MeshlessRig::new(&baked).unwrap());
        rig.set_lights(&[point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)]);
        let light = rig.light();
        let renderer = Renderer::new(baked.dataset.clone());
        let seen_from = |eye: Vec3| {
            let point =
                surface_at(&renderer, &View { camera: Camera::look_at(eye, Vec3::ZERO, 30.0), ..from_above(8) });
            light.reflectance(&FunctionPlace::new(point.position, point.face_normal), &point).unwrap().x
        };
        let [across, aside] = [Vec3::new(2.0, 1.2, 0.0), Vec3::new(0.0, 1.2, 2.0)].map(seen_from);
        assert!(across > 2.0 * aside, "{across} {aside}");
        let mut diffuse = linked_floor_and_wall();
        diffuse.scene.materials.iter_mut().for_each(|material| material.model = BrdfModel::Lambert);
        let diffuse = Baked::from(diffuse);
        let mut rig = Edited::new(&diffuse, MeshlessRig::new(&diffuse).unwrap());
        assert!(rig.light().by_direction().is_none(), "diffuse surfaces need no directions");
    }
}
