//! Bounced light solved anew, without links: light that was not sent yet is gathered by rays, level by level, as fine as it changes
//! (Zollhöfer and Stamminger, *Meshless Radiosity on the GPU*, 2011).
//!
//! Levels hold absolute values (5). A function gathers if its parents saw that theirs is not enough; all others take the value of
//! their parents (Fig. 4). Rays end at functions of one level, which send for the surface around them (5.1).

use super::{
    function_tree::FunctionTree,
    object_bases::{Carrier, ObjectBases, RayEnd},
};
use crate::{
    bounds::Bounds,
    gather_table::{GatherHit, GatherTable, Moved, RayFan},
    sparse::SparseRows,
    surfel::Surfel,
    transport::BounceEnergy,
};
use glam::{Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

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
}

impl RadiositySettings {
    /// Usual settings.
    pub const DEFAULT: Self = Self { rays: 512, threshold: 0.05, bounces: 6, least: 0.005 };
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
}

/// Light that is sent at once: by the functions of the sender level, or by the sky.
enum Sent<'a> {
    Functions(&'a [Vec3A]),
    Sky(&'a (dyn Fn(Vec3) -> Vec3 + Sync)),
}

impl Sent<'_> {
    /// The vector irradiance of a receiver from its rays.
    fn gathered(&self, fan: &RayFan, frame: glam::Mat3, hits: &[GatherHit], first_sender: u32) -> Mat3A {
        let mut columns = [Vec3A::ZERO; 3];
        let mut add = |direction: Vec3, radiance: Vec3A| {
            let direction = Vec3A::from(direction);
            columns[0] += direction * radiance.x;
            columns[1] += direction * radiance.y;
            columns[2] += direction * radiance.z;
        };
        for (&direction, hit) in fan.directions().iter().zip(hits) {
            match (self, hit.lit()) {
                (Self::Functions(sent), Some(sender)) => add(direction, sent[(sender - first_sender) as usize]),
                (Self::Sky(sky), _) if hit.sender == GatherHit::MISS => add(direction, sky(frame * direction).into()),
                _ => {}
            }
        }
        let frame = glam::Mat3A::from(frame);
        let [x, y, z] = columns.map(|column| frame * column * fan.solid_angle());
        Mat3A::from_cols(x, y, z)
    }
}

impl Radiosity {
    /// A solver for some bases; no ray is traced yet.
    pub fn new(bases: ObjectBases, settings: RadiositySettings) -> Self {
        Self {
            tree: FunctionTree::new(&bases),
            fan: RayFan::new(settings.rays),
            around: around_senders(&bases),
            table: GatherTable::new(bases.len()),
            covered: Vec::new(),
            settings,
            bases,
        }
    }

    /// The functions.
    pub fn bases(&self) -> &ObjectBases {
        &self.bases
    }

    /// The rays that are kept.
    pub fn table(&self) -> &GatherTable {
        &self.table
    }

    /// The points of the functions where they are now.
    pub fn placed_points(&self, surface: &dyn Carrier) -> Vec<Surfel> {
        self.bases.points().par_iter().map(|point| surface.now(point)).collect()
    }

    /// Direct light, of which nothing is sent yet.
    pub fn begin(&mut self, surface: &dyn Carrier, lit: &LitFunctions) -> RadiosityLight {
        let functions = self.bases.len();
        if self.covered.is_empty() {
            self.covered = (0..functions as u32).into_par_iter().map(|f| self.is_covered(surface, f)).collect();
        }
        let mut light = RadiosityLight {
            total: vec![Mat3A::ZERO; functions],
            unsent: self.filled(lit.direct),
            mean_irradiance: Vec::new(),
            gathers: 0,
        };
        if let Some(sky) = lit.sky {
            let (received, gathers) = self.transport(surface, &Sent::Sky(sky));
            light.gathers += gathers;
            let received = self.irradiance(surface, &received);
            light.unsent.iter_mut().zip(received).for_each(|(sum, part)| *sum += part);
        }
        light.mean_irradiance.push(self.mean(&light.unsent));
        if lit.emitted.iter().any(|emitted| *emitted != Vec3::ZERO) {
            self.send(surface, &mut light, |function| lit.emitted[function]);
        }
        light
    }

    /// Adds the next bounce. Returns whether more would add anything.
    pub fn bounce(&mut self, surface: &dyn Carrier, lit: &LitFunctions, light: &mut RadiosityLight) -> bool {
        let unsent = std::mem::replace(&mut light.unsent, vec![Vec3::ZERO; self.bases.len()]);
        self.send(surface, light, |function| lit.reflectance[function] * unsent[function] * FRAC_1_PI);
        let bounces = light.mean_irradiance.len() as u32 - 1;
        let [first, last] = [0, light.mean_irradiance.len() - 1].map(|i| light.mean_irradiance[i].max_element());
        bounces < self.settings.bounces && last > self.settings.least * first
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

    /// Sends radiance of the functions, and adds what arrives to what is not sent yet.
    fn send(&mut self, surface: &dyn Carrier, light: &mut RadiosityLight, radiance: impl Fn(usize) -> Vec3 + Sync) {
        let mean = |sender: usize| {
            self.around
                .row(sender)
                .iter()
                .fold(Vec3::ZERO, |sum, &(function, weight)| sum + radiance(function as usize) * weight)
        };
        let sent: Vec<Vec3A> = (0..self.around.len()).into_par_iter().map(|sender| mean(sender).into()).collect();
        let (received, gathers) = self.transport(surface, &Sent::Functions(&sent));
        light.gathers += gathers;
        light.total.iter_mut().zip(&received).for_each(|(sum, part)| *sum += *part);
        let received = self.irradiance(surface, &received);
        light.mean_irradiance.push(self.mean(&received));
        light.unsent.iter_mut().zip(received).for_each(|(sum, part)| *sum += part);
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

    /// Vector irradiance of all functions from what is sent, and the number of gathers.
    fn transport(&mut self, surface: &dyn Carrier, sent: &Sent) -> (Vec<Mat3A>, u64) {
        let mut received = vec![Mat3A::ZERO; self.bases.len()];
        let mut gathers: Vec<bool> = vec![false; self.bases.len()];
        let (mut enough, mut count) = (0.0, 0);
        for level in 0..self.bases.levels() {
            let range = self.bases.level(level);
            let parents = self.bases.parents();
            // Where no parent reaches or knows, only rays tell.
            let tells_little = |parent: usize| gathers[parent] || self.covered[parent];
            let wants = |function: usize| {
                let row = parents.row(function);
                !self.covered[function]
                    && (row.is_empty() || row.iter().any(|(parent, _)| tells_little(*parent as usize)))
            };
            let active: Vec<u32> = range.clone().filter(|&f| wants(f)).map(|f| f as u32).collect();
            self.trace(surface, &active);
            let found: Vec<Mat3A> = active.par_iter().map(|&function| self.gather(surface, sent, function)).collect();
            let pulled: Vec<Mat3A> =
                range.clone().into_par_iter().map(|f| self.bases.parents().product(f, &received)).collect();
            received[range.clone()].copy_from_slice(&pulled);
            if level == 0 {
                enough = self.settings.threshold * mean_length(&found);
            }
            for (&function, found) in active.iter().zip(&found) {
                let function = function as usize;
                let change = length(&(*found - received[function]));
                gathers[function] = level == 0 || change > enough;
                received[function] = *found;
            }
            count += active.len() as u64;
        }
        (received, count)
    }

    /// Traces the rays of functions that have none.
    fn trace(&mut self, surface: &dyn Carrier, functions: &[u32]) {
        let missing: Vec<u32> = functions.iter().copied().filter(|&f| self.table.row(f).is_none()).collect();
        let rows: Vec<Box<[GatherHit]>> = missing.par_iter().map(|&function| self.row(surface, function)).collect();
        missing.into_iter().zip(rows).for_each(|(function, row)| self.table.keep(function, row));
    }

    fn row(&self, surface: &dyn Carrier, function: u32) -> Box<[GatherHit]> {
        let fan = self.placed(surface, function);
        let eights: Vec<[Vec3; 8]> =
            self.fan.directions().as_chunks().0.iter().map(|eight| fan.directions(eight)).collect();
        self.hits(surface, fan.origin, &eights).collect()
    }

    /// The ends of rays of an origin.
    fn hits<'a>(
        &'a self,
        surface: &'a dyn Carrier,
        origin: Vec3,
        directions: &[[Vec3; 8]],
    ) -> impl Iterator<Item = GatherHit> + 'a {
        let end = move |end: RayEnd| match end {
            RayEnd::Sky => GatherHit::OPEN,
            RayEnd::Dark(at) => GatherHit::dark(surface.owner(&at).object, at.position.distance(origin)),
            RayEnd::Surface(at) => {
                let (owner, distance) = (surface.owner(&at), at.position.distance(origin));
                match self.tree.find(owner, &surface.as_baked(&at)) {
                    Some(sender) => GatherHit { sender, distance },
                    None => GatherHit::dark(owner.object, distance),
                }
            }
        };
        surface.ends(origin, directions).into_iter().flatten().map(end)
    }

    fn placed(&self, surface: &dyn Carrier, function: u32) -> Placed {
        let point = surface.now(&self.bases.points()[function as usize]);
        Placed {
            origin: point.position + point.normal * surface.offset(),
            frame: RayFan::frame(function, point.normal),
        }
    }

    fn gather(&self, surface: &dyn Carrier, sent: &Sent, function: u32) -> Mat3A {
        let first_sender = self.bases.level(self.bases.sender_level()).start as u32;
        let hits = self.table.row(function).expect("its rays were traced");
        sent.gathered(&self.fan, self.placed(surface, function).frame, hits, first_sender)
    }

    /// Traces again what a move of objects changes, by eights as they were traced first. `surface` is the moved one, `boxes` are around
    /// the moved objects now, and `left` are those that they left. Returns the number of rays.
    pub fn follow(
        &mut self,
        surface: &dyn Carrier,
        is_moved: &(dyn Fn(u32) -> bool + Sync),
        boxes: &[Bounds],
        left: &[Bounds],
    ) -> u64 {
        self.look_again(surface, is_moved, &[boxes, left].concat());
        let moved = Moved { object_of: &|sender| self.bases.owners()[sender as usize].object, is_moved, boxes };
        let receivers: Vec<u32> = self.table.receivers().collect();
        let renewed: Vec<(u32, RenewedEights)> =
            receivers.into_par_iter().map(|function| (function, self.renewed(surface, function, &moved))).collect();
        let mut rays = 0;
        for (function, eights) in renewed {
            let row = self.table.row_mut(function);
            rays += 8 * eights.len() as u64;
            eights.into_iter().for_each(|(first, hits)| row[first..first + 8].copy_from_slice(&hits));
        }
        rays
    }

    /// Looks again whether functions are covered, where a move can change it.
    fn look_again(&mut self, surface: &dyn Carrier, is_moved: &(dyn Fn(u32) -> bool + Sync), boxes: &[Bounds]) {
        let reach = self.bases.radii()[self.bases.levels() - 1] + surface.offset();
        let boxes: Vec<Bounds> = boxes.iter().map(|b| b.grown(reach)).collect();
        let owners = self.bases.owners();
        let again = |(function, &known): (usize, &bool)| {
            let place = || surface.now(&self.bases.points()[function]).position;
            let changes = is_moved(owners[function].object) || boxes.iter().any(|b| b.contains(place()));
            if changes { self.is_covered(surface, function as u32) } else { known }
        };
        self.covered = self.covered.par_iter().enumerate().map(again).collect();
    }

    /// The eights of a function's rays that a move changes, by their first ray.
    fn renewed(&self, surface: &dyn Carrier, function: u32, moved: &Moved) -> RenewedEights {
        let fan = self.placed(surface, function);
        let itself = (moved.is_moved)((moved.object_of)(function));
        let row = self.table.row(function).expect("its rays were traced");
        let (ends, directions) = (row.as_chunks::<8>().0, self.fan.directions().as_chunks::<8>().0);
        let stale: Vec<(usize, [Vec3; 8])> = directions
            .iter()
            .zip(ends)
            .enumerate()
            .map(|(i, (eight, ends))| (i, fan.directions(eight), ends))
            .filter(|(_, eight, ends)| {
                itself || eight.iter().zip(*ends).any(|(&direction, end)| moved.changes(fan.origin, direction, end))
            })
            .map(|(i, eight, _)| (8 * i, eight))
            .collect();
        let eights: Vec<[Vec3; 8]> = stale.iter().map(|(_, eight)| *eight).collect();
        let hits: Vec<GatherHit> = self.hits(surface, fan.origin, &eights).collect();
        stale.into_iter().zip(hits.as_chunks::<8>().0).map(|((first, _), hits)| (first, *hits)).collect()
    }
}

/// Ends of rays that were traced again, by eights with the number of their first ray.
type RenewedEights = Vec<(usize, [GatherHit; 8])>;

/// Where a receiver's rays begin, and how its fan is turned.
struct Placed {
    origin: Vec3,
    frame: glam::Mat3,
}

impl Placed {
    fn directions(&self, fan: &[Vec3; 8]) -> [Vec3; 8] {
        fan.map(|direction| self.frame * direction)
    }
}

impl RadiosityLight {
    /// Energy of the bounces so far.
    pub fn energy(&self) -> BounceEnergy {
        BounceEnergy::of(&self.mean_irradiance)
    }
}

fn length(vector: &Mat3A) -> f32 {
    [vector.x_axis, vector.y_axis, vector.z_axis].map(|column| column.length_squared()).iter().sum::<f32>().sqrt()
}

fn mean_length(vectors: &[Mat3A]) -> f32 {
    vectors.iter().map(length).sum::<f32>() / vectors.len().max(1) as f32
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
