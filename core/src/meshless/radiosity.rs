//! Bounced light solved anew, without links: light that was not sent yet is gathered by rays, level by level, as fine as it changes
//! (Zollhöfer and Stamminger, *Meshless Radiosity on the GPU*, 2011).
//!
//! Levels hold absolute values (5). A function gathers if its parents saw that theirs is not enough; all others take the value of
//! their parents (Fig. 4). Rays end at functions of one level, which send for the surface around them (5.1).

mod device;
mod follow;
mod transport;

use super::{
    function_tree::FunctionTree,
    object_bases::{Carrier, ObjectBases, RayEnd},
};
use crate::{
    gather_table::{GatherHit, GatherTable, RayFan},
    ray::Fan,
    sparse::SparseRows,
    surfel::Surfel,
    transport::BounceEnergy,
};
use follow::Moves;
use glam::{Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::{collections::HashMap, f32::consts::FRAC_1_PI};
use transport::{Sent, Transport};

pub use device::{ActiveFunctions, ReceiverRays, TransportDevice};

/// How light is gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiositySettings {
    /// Rays of a receiver (512 in the paper).
    pub rays: usize,
    /// Difference from the parents above which a function's children gather, as a share of the mean light.
    pub threshold: f32,
    /// Most bounces (6 in the paper).
    pub bounces: u32,
    /// Share of the first bounce below which no more are added.
    pub least: f32,
    /// Most bytes of rays that are kept; further ones are traced again for each bounce.
    pub table_bytes: u64,
}

impl RadiositySettings {
    /// Usual settings.
    pub const DEFAULT: Self = Self { rays: 512, threshold: 0.05, bounces: 6, least: 0.005, table_bytes: 2 << 30 };

    /// Most bytes of the kept rays of some functions, if they all gather.
    pub fn bytes_of_rays(&self, functions: u64) -> u64 {
        (functions * (self.rays * size_of::<GatherHit>()) as u64).min(self.table_bytes)
    }
}

impl Default for RadiositySettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The surfaces of the functions under the present lights and materials, one value a function.
pub struct LitFunctions<'a> {
    /// Irradiance from local lights in W/m².
    pub direct: &'a [Vec3],
    /// Diffuse reflectance.
    pub reflectance: &'a [Vec3],
    /// Emitted radiance in W/(m² sr).
    pub emitted: &'a [Vec3],
    /// Radiance of the sky in W/(m² sr), if it shines.
    pub sky: Option<&'a (dyn Fn(Vec3) -> Vec3 + Sync)>,
}

/// Solves for bounced light again and again, and keeps the rays.
pub struct Radiosity {
    bases: ObjectBases,
    tree: FunctionTree,
    fan: RayFan,
    settings: RadiositySettings,
    /// Whether each function is covered, so that light cannot reach it: it takes the light of the open functions around it. Empty
    /// before the first look.
    covered: Vec<bool>,
    /// For each sender: itself and the next finer functions of the same owner around it, as a mean.
    around: SparseRows,
    table: GatherTable,
    moves: Moves,
    /// What gathers in place of the cores.
    device: Option<Box<dyn TransportDevice>>,
    /// Number of the device's last step.
    device_step: u64,
}

/// A solution and the light that it has not sent yet.
#[derive(Clone, Debug)]
pub struct RadiosityLight {
    /// Vector irradiance of each function from all bounces in W/m², one column per color channel.
    pub total: Vec<Mat3A>,
    /// Irradiance in W/m² that was not sent yet.
    unsent: Vec<Vec3>,
    /// Mean irradiance of the senders: direct light, then each bounce.
    mean_irradiance: Vec<Vec3>,
    /// Gathers so far.
    pub gathers: u64,
    /// Light that is not gathered by all functions yet.
    underway: Option<Transport>,
}

/// How far a solution is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadiosityStep {
    /// Within a bounce, of which nothing is added yet.
    Partial,
    /// A bounce was added, and more follow.
    Bounce,
    /// The last bounce was added.
    Last,
}

impl Radiosity {
    /// A solver for some bases; no ray is traced yet.
    pub fn new(bases: ObjectBases, settings: RadiositySettings) -> Self {
        Self {
            tree: FunctionTree::new(&bases),
            fan: RayFan::new(settings.rays),
            around: around_senders(&bases),
            table: GatherTable::new(bases.len(), settings.table_bytes),
            moves: Moves::none(bases.len()),
            covered: Vec::new(),
            device: None,
            device_step: 0,
            settings,
            bases,
        }
    }

    /// The functions.
    pub fn bases(&self) -> &ObjectBases {
        &self.bases
    }

    /// Directions of the rays of each receiver, before they are turned.
    pub fn directions(&self) -> &[Vec3] {
        self.fan.directions()
    }

    /// The rays that are kept.
    pub fn table(&self) -> &GatherTable {
        &self.table
    }

    /// The points of the functions where they are now.
    pub fn placed_points(&self, surface: &dyn Carrier) -> Vec<Surfel> {
        self.bases.points().par_iter().map(|point| surface.now(point)).collect()
    }

    /// Direct light of local lights, of which nothing is sent yet.
    pub fn begin(&mut self, surface: &dyn Carrier, lit: &LitFunctions) -> RadiosityLight {
        let functions = self.bases.len();
        if self.covered.is_empty() {
            self.covered = (0..functions as u32).into_par_iter().map(|f| self.is_covered(surface, f)).collect();
        }
        RadiosityLight {
            total: vec![Mat3A::ZERO; functions],
            unsent: self.filled(lit.direct),
            mean_irradiance: Vec::new(),
            gathers: 0,
            underway: None,
        }
    }

    /// Goes on by about as many rays as `receivers` have: a caller may stop between, and a bounce is the same in parts as at once.
    /// The sky's light comes first, then what surfaces emit, which counts as a bounce.
    pub fn advance(
        &mut self,
        surface: &dyn Carrier,
        lit: &LitFunctions,
        light: &mut RadiosityLight,
        receivers: usize,
    ) -> RadiosityStep {
        let mut underway = light.underway.take().unwrap_or_else(|| self.send(lit, light));
        if !self.gather_some(surface, lit.sky, &mut underway, receivers) {
            light.underway = Some(underway);
            return RadiosityStep::Partial;
        }
        let received = self.irradiance(surface, &underway.received);
        light.unsent.iter_mut().zip(&received).for_each(|(sum, part)| *sum += *part);
        light.gathers += underway.gathers;
        if matches!(underway.sent, Sent::Sky) {
            light.mean_irradiance.push(self.mean(&light.unsent));
            return RadiosityStep::Partial;
        }
        light.total.iter_mut().zip(&underway.received).for_each(|(sum, part)| *sum += *part);
        light.mean_irradiance.push(self.mean(&received));
        match matches!(underway.sent, Sent::Reflection(_)) && !self.is_worth_more(light) {
            true => RadiosityStep::Last,
            false => RadiosityStep::Bounce,
        }
    }

    /// Whether another bounce would add anything.
    fn is_worth_more(&self, light: &RadiosityLight) -> bool {
        let bounces = light.mean_irradiance.len() as u32 - 1;
        let [first, last] = [0, light.mean_irradiance.len() - 1].map(|i| light.mean_irradiance[i].max_element());
        bounces < self.settings.bounces && last > self.settings.least * first
    }

    /// Sends what comes next.
    fn send(&self, lit: &LitFunctions, light: &mut RadiosityLight) -> Transport {
        let is_new = light.mean_irradiance.is_empty();
        if is_new && lit.sky.is_some() {
            return self.transport(Sent::Sky);
        }
        if is_new {
            light.mean_irradiance.push(self.mean(&light.unsent));
        }
        let emits = || lit.emitted.iter().any(|emitted| *emitted != Vec3::ZERO);
        if light.mean_irradiance.len() == 1 && emits() {
            return self.transport(Sent::Emission(self.senders(|function| lit.emitted[function])));
        }
        let unsent = std::mem::replace(&mut light.unsent, vec![Vec3::ZERO; self.bases.len()]);
        let radiance = |function: usize| lit.reflectance[function] * unsent[function] * FRAC_1_PI;
        self.transport(Sent::Reflection(self.senders(radiance)))
    }

    /// Values of open functions, from which covered ones take theirs, level by level.
    fn filled(&self, values: &[Vec3]) -> Vec<Vec3> {
        let mut filled = values.to_vec();
        for function in (0..filled.len()).filter(|&function| self.covered[function]) {
            filled[function] = self.bases.parents().product(function, &filled);
        }
        filled
    }

    /// Whether a function sees nothing that sends light, beyond the distance that the finest level can tell apart.
    fn is_covered(&self, surface: &dyn Carrier, function: u32) -> bool {
        let radii = self.bases.radii();
        let (fan, reach) = (self.placed(surface, function), radii[radii.len() - 1]);
        let step = (self.fan.directions().len() / 8).max(1);
        let eight = std::array::from_fn(|i| fan.frame * self.fan.directions()[i * step]);
        let is_near = |end: &RayEnd| match end {
            RayEnd::Sky => false,
            RayEnd::Dark(_) => true,
            RayEnd::Surface(at) => at.position.distance(fan.origin) < reach,
        };
        surface.ends(fan.origin, &[eight]).as_flattened().iter().all(is_near)
    }

    /// Radiance of the senders, from that of the functions.
    fn senders(&self, radiance: impl Fn(usize) -> Vec3 + Sync) -> Vec<Vec3A> {
        let mean = |sender: usize| {
            let around = self.around.row(sender).iter();
            around.fold(Vec3::ZERO, |sum, &(function, weight)| sum + radiance(function as usize) * weight).into()
        };
        (0..self.around.len()).into_par_iter().map(mean).collect()
    }

    /// Irradiance of the functions by their shading normals, at least 0.
    fn irradiance(&self, surface: &dyn Carrier, vectors: &[Mat3A]) -> Vec<Vec3> {
        let of = |(point, vector): (&Surfel, &Mat3A)| {
            super::irradiance(vector, surface.shading_normal(&surface.now(point))).max(Vec3::ZERO)
        };
        self.bases.points().par_iter().zip(vectors).map(of).collect()
    }

    /// The mean over the senders, which lie at even distances.
    fn mean(&self, values: &[Vec3]) -> Vec3 {
        let senders = &values[self.bases.level(self.bases.sender_level())];
        senders.iter().copied().sum::<Vec3>() / senders.len().max(1) as f32
    }

    fn row(&self, surface: &dyn Carrier, function: u32) -> Box<[GatherHit]> {
        let fan = self.placed(surface, function);
        let eights: Vec<[Vec3; 8]> =
            self.fan.directions().as_chunks().0.iter().map(|eight| fan.turned(eight)).collect();
        self.hits(surface, fan.origin, &eights).collect()
    }

    /// The rays of some functions, if a device traces them.
    fn rows_at_once(&self, surface: &dyn Carrier, functions: &[u32]) -> Option<HashMap<u32, Box<[GatherHit]>>> {
        if !surface.traces_fans() {
            return None;
        }
        let fans: Vec<Fan> = functions.iter().map(|&function| self.placed(surface, function)).collect();
        let ends = surface.ends_of_fans(&fans, self.fan.directions())?;
        let rows = functions.par_iter().zip(&fans).zip(ends.par_chunks(self.fan.directions().len()));
        let row = |((&function, fan), ends): ((&u32, &Fan), &[RayEnd])| {
            (function, ends.iter().map(|end| self.hit(surface, fan.origin, *end)).collect())
        };
        Some(rows.map(row).collect())
    }

    /// The ends of rays of an origin.
    fn hits<'a>(
        &'a self,
        surface: &'a dyn Carrier,
        origin: Vec3,
        directions: &[[Vec3; 8]],
    ) -> impl Iterator<Item = GatherHit> + 'a {
        surface.ends(origin, directions).into_iter().flatten().map(move |end| self.hit(surface, origin, end))
    }

    /// The end of a ray with the sender that stands for it.
    fn hit(&self, surface: &dyn Carrier, origin: Vec3, end: RayEnd) -> GatherHit {
        match end {
            RayEnd::Sky => GatherHit::OPEN,
            RayEnd::Dark(at) => GatherHit::dark(surface.owner(&at).object, at.position.distance(origin)),
            RayEnd::Surface(at) => {
                let (owner, distance) = (surface.owner(&at), at.position.distance(origin));
                match self.tree.find(owner, &surface.as_baked(&at)) {
                    Some(sender) => GatherHit { sender, distance },
                    None => GatherHit::dark(owner.object, distance),
                }
            }
        }
    }

    fn placed(&self, surface: &dyn Carrier, function: u32) -> Fan {
        let point = surface.now(&self.bases.points()[function as usize]);
        Fan { origin: point.position + point.normal * surface.offset(), frame: RayFan::frame(function, point.normal) }
    }
}

impl RadiosityLight {
    /// Energy of the bounces so far.
    pub fn energy(&self) -> BounceEnergy {
        BounceEnergy::of(&self.mean_irradiance)
    }
}

/// Weights of the functions that show what a sender sends: those of the next level with the same owner, and itself where there are
/// none.
fn around_senders(bases: &ObjectBases) -> SparseRows {
    let senders = bases.level(bases.sender_level());
    let finer = match bases.sender_level() + 1 < bases.levels() {
        true => bases.level(bases.sender_level() + 1),
        false => 0..0,
    };
    let mut children: Vec<Vec<(u32, f32)>> = vec![Vec::new(); senders.len()];
    for child in finer {
        for &(parent, value) in bases.parents().row(child) {
            if bases.owners()[parent as usize] == bases.owners()[child] {
                children[parent as usize - senders.start].push((child as u32, value));
            }
        }
    }
    SparseRows::build(senders.len(), |sender, out| {
        let sum: f32 = children[sender].iter().map(|child| child.1).sum();
        match sum > 0.0 {
            true => out.extend(children[sender].iter().map(|&(child, value)| (child, value / sum))),
            false => out.push(((senders.start + sender) as u32, 1.0)),
        }
    })
}
