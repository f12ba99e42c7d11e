//! Reflection by a glossy source: from cells of arriving light, and from lamps, toward knots of directions.

use crate::light::sent::{DIRECTIONS, KNOTS, Toward};
use glam::{Mat3, Vec2, Vec3};
use lapidary_core::{
    brdf::{Brdf, BrdfVisitor, LightsX8, SurfaceBrdf},
    lights::Light,
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
    sphere::{concentric::HemisphereCells, frame_around, inv_kappa_of},
};
use std::{
    array::from_fn,
    f32::consts::{FRAC_1_PI, PI},
    marker::PhantomData,
    sync::LazyLock,
};
use wide::f32x8;

/// Cells of arriving light around the normal of a group.
pub const CELLS: HemisphereCells = HemisphereCells { side: 8 };
/// Rays of a cell.
pub const RAYS_OF_A_CELL: usize = 8;
/// Least height of a direction over the horizon, as a cosine. Knots below stand for the light sent just above, to which values
/// between them and those above belong.
const LEAST_COSINE: f32 = 0.05;
/// Knots lower than this lie in no such interval.
const LOWEST: f32 = -0.3;
/// Eights of cells.
const EIGHTS: usize = CELLS.len() / 8;
/// Solid angle of a knot.
const OF_KNOT: f32 = 4.0 * PI / ((KNOTS.side - 1) * (KNOTS.side - 1)) as f32;

/// The first of the knots with a knot's direction: those along the edges of the square come twice.
static FIRST: LazyLock<[usize; KNOTS.len()]> = LazyLock::new(|| {
    let is_same = |a: usize, b: usize| DIRECTIONS[a].distance_squared(DIRECTIONS[b]) < 1e-6;
    from_fn(|knot| (0..knot).find(|&other| is_same(other, knot)).unwrap_or(knot))
});

/// A surface with lobes.
pub struct Glossy {
    brdf: SurfaceBrdf,
    local_from_world: Mat3,
    local_from_cells: Mat3,
}

/// What a surface reflects of the radiance in each cell toward each knot.
#[derive(Clone)]
pub struct Transfer {
    albedo: Vec3,
    toward: Vec<[Vec3x8; EIGHTS]>,
    /// The rows that show a surface point: those of knots from which it is seen.
    seen: Vec<usize>,
}

/// Eight lights, each as wide as a knot at least: a sharper lobe would show its light toward no knot, or all of it toward one.
struct ArrivingX8 {
    /// Unit directions in the local frame.
    wi: Vec3x8,
    inv_kappa: f32x8,
    /// Factors of what is reflected.
    power: Vec3x8,
}

impl ArrivingX8 {
    /// Lights by local directions, solid angles in steradians, and factors.
    fn of(lights: &[(Vec3, f32, Vec3)]) -> Self {
        let light = |i: usize| lights.get(i).copied().unwrap_or((Vec3::Z, 0.0, Vec3::ZERO));
        Self {
            wi: Vec3x8::from_array(from_fn(|i| light(i).0)),
            inv_kappa: f32x8::new(from_fn(|i| inv_kappa_of(light(i).1 + OF_KNOT))),
            power: Vec3x8::from_array(from_fn(|i| light(i).2)),
        }
    }
}

impl Glossy {
    /// A surface with its tangent frame and its geometric normal, around which cells lie.
    pub fn new(brdf: SurfaceBrdf, world_from_local: Mat3, normal: Vec3) -> Self {
        let local_from_world = world_from_local.transpose();
        Self { brdf, local_from_world, local_from_cells: local_from_world * frame_around(normal) }
    }

    /// Its reflection of all cells.
    pub fn transfer(&self) -> Transfer {
        let light = |cell: usize| {
            let wi = self.local_from_cells * CELLS.direction_of(cell);
            let solid_angle = CELLS.weight() / wi.z.max(LEAST_COSINE);
            (wi, solid_angle, Vec3::splat(solid_angle))
        };
        let lights: [ArrivingX8; EIGHTS] =
            from_fn(|eight| ArrivingX8::of(&from_fn::<_, 8, _>(|i| light(8 * eight + i))));
        let mut toward = vec![[Vec3x8::splat(Vec3::ZERO); EIGHTS]; KNOTS.len()];
        let seen = self.seen();
        self.reflect(&seen, &lights, |knot, eight, reflected| toward[knot][eight] = reflected);
        Transfer { albedo: self.brdf.as_brdf().albedo(), toward, seen }
    }

    /// Radiance toward all knots, for lamps that light a place together with this irradiance in W/m². Each has its share in it as if
    /// nothing were between.
    pub fn reflected_lamps(&self, lights: &[Light], at: Vec3, irradiance: Vec3) -> Toward {
        let arriving = |light: &Light| {
            let sample = light.sampler().sample(at, Vec2::splat(0.5))?;
            let wi = self.local_from_world * sample.direction;
            (wi.z > 0.0).then_some((wi, 0.0, sample.irradiance))
        };
        let mut lamps: Vec<(Vec3, f32, Vec3)> = lights.iter().filter_map(arriving).collect();
        let whole: Vec3 = lamps.iter().map(|(wi, _, power)| *power * wi.z).sum();
        let is_known = whole.cmpgt(Vec3::ZERO);
        let scale = Vec3::select(is_known, irradiance / whole, Vec3::ZERO);
        // Of a lamp whose middle is hidden by the horizon, or whose cone ends here, no direction is known.
        let diffuse = Vec3::select(is_known, Vec3::ZERO, self.brdf.as_brdf().albedo() * irradiance * FRAC_1_PI);
        lamps.iter_mut().for_each(|(.., power)| *power *= scale);
        let (lights, seen): (Vec<ArrivingX8>, _) = (lamps.chunks(8).map(ArrivingX8::of).collect(), self.seen());
        let mut sums = [diffuse; KNOTS.len()];
        self.reflect(&seen, &lights, |knot, _, reflected| sums[knot] += reflected.reduce_add());
        with_unseen(sums, &seen)
    }

    /// Knots from which the surface is seen, or between which and those values are interpolated; each direction once.
    fn seen(&self) -> Vec<usize> {
        let is_seen = |knot: &usize| (self.local_from_world * DIRECTIONS[*knot]).z > LOWEST && FIRST[*knot] == *knot;
        (0..KNOTS.len()).filter(is_seen).collect()
    }

    /// Passes on what the surface reflects of eight lights toward a knot.
    fn reflect(&self, knots: &[usize], lights: &[ArrivingX8], add: impl FnMut(usize, usize, Vec3x8)) {
        let toward: Vec<(usize, Vec3)> =
            knots.iter().map(|&knot| (knot, lifted(self.local_from_world * DIRECTIONS[knot]))).collect();
        InstructionSet::widest().run(Reflection { brdf: &self.brdf, lights, toward: &toward, add });
    }
}

impl Transfer {
    /// The share of light that it reflects as a diffuse surface.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// Radiance toward all knots, for the mean radiance that arrives in each cell.
    pub fn reflected(&self, arriving: &[Vec3; CELLS.len()]) -> Toward {
        let arriving = from_fn(|eight| Vec3x8::from_array(from_fn(|lane| arriving[8 * eight + lane])));
        with_unseen(InstructionSet::widest().run(Transferred { by: self, arriving: &arriving }), &self.seen)
    }
}

/// Light of cells, reflected by a transfer.
struct Transferred<'a> {
    by: &'a Transfer,
    arriving: &'a [Vec3x8; EIGHTS],
}

impl Kernel for Transferred<'_> {
    type Output = Toward;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Toward {
        let mut reflected = [Vec3::ZERO; KNOTS.len()];
        for &knot in &self.by.seen {
            let mut sum = Vec3x8::<L>::splat(Vec3::ZERO);
            for (share, light) in self.by.toward[knot].iter().zip(self.arriving) {
                sum = sum + Vec3x8::load(share).scale(Vec3x8::load(light));
            }
            reflected[knot] = sum.reduce_add();
        }
        reflected
    }
}

/// Values of all knots: others of the same direction as a seen one have its value, those from which the surface is not seen the mean.
fn with_unseen(of_seen: Toward, seen: &[usize]) -> Toward {
    let mean = seen.iter().map(|&knot| of_seen[knot]).sum::<Vec3>() / seen.len().max(1) as f32;
    let mut values = [mean; KNOTS.len()];
    seen.iter().for_each(|&knot| values[knot] = of_seen[knot]);
    from_fn(|knot| values[FIRST[knot]])
}

/// A direction at least just above the horizon.
fn lifted(local: Vec3) -> Vec3 {
    if local.z >= LEAST_COSINE {
        return local;
    }
    let flat = local.truncate().normalize_or(Vec2::X) * (1.0 - LEAST_COSINE * LEAST_COSINE).sqrt();
    flat.extend(LEAST_COSINE)
}

/// Reflection of lights by a surface toward knots with local directions.
struct Reflection<'a, A> {
    brdf: &'a SurfaceBrdf,
    lights: &'a [ArrivingX8],
    toward: &'a [(usize, Vec3)],
    add: A,
}

impl<A: FnMut(usize, usize, Vec3x8)> Kernel for Reflection<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.brdf.visit(Reflect { of: self, lanes: PhantomData::<L> });
    }
}

/// [`Reflection`] for each model.
struct Reflect<'a, A, L> {
    of: Reflection<'a, A>,
    lanes: PhantomData<L>,
}

impl<A: FnMut(usize, usize, Vec3x8), L: Lanes> BrdfVisitor for Reflect<'_, A, L> {
    #[inline(always)]
    fn visit(mut self, brdf: &impl Brdf) {
        for &(knot, wo) in self.of.toward {
            for (eight, ArrivingX8 { wi, inv_kappa, power }) in self.of.lights.iter().enumerate() {
                let lights = LightsX8::at(Vec3x8::<L>::load(wi), L::new(inv_kappa.to_array()));
                let reflected = brdf.reflect(&lights, wo).scale(Vec3x8::load(power));
                (self.of.add)(knot, eight, reflected.portable());
            }
        }
    }
}

#[cfg(test)]
impl Glossy {
    /// The BRDF itself times the cosine of a lamp in one world direction, toward another.
    pub fn one_lamp(&self, lamp: Vec3, toward: Vec3) -> Vec3 {
        self.brdf.as_brdf().brdf_cos(self.local_from_world * lamp, self.local_from_world * toward)
    }

    /// The world direction of a cell.
    pub fn world_of_cell(&self, cell: usize) -> Vec3 {
        self.local_from_world.transpose() * self.local_from_cells * CELLS.direction_of(cell)
    }
}
