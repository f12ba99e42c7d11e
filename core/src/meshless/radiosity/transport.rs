//! One bounce on its way to the functions, in parts that a caller may stop between.

use super::{Radiosity, follow::Renewed};
use crate::{
    gather_table::{GatherHit, RayFan},
    meshless::object_bases::Carrier,
};
use glam::{Mat3A, Vec3, Vec3A};
use rayon::prelude::*;

/// Light that is sent at once: by the functions of the sender level, or by the sky.
#[derive(Clone, Debug)]
pub(super) enum Sent {
    Sky,
    /// What surfaces emit: radiance of each sender.
    Emission(Vec<Vec3A>),
    /// What surfaces reflect: radiance of each sender.
    Reflection(Vec<Vec3A>),
}

/// Light on its way to the functions, level by level.
#[derive(Clone, Debug)]
pub(super) struct Transport {
    pub(super) sent: Sent,
    /// Vector irradiance of the functions of the levels so far.
    pub(super) received: Vec<Mat3A>,
    /// Functions whose children gather.
    splits: Vec<bool>,
    level: usize,
    /// The functions of the level that gather.
    active: Vec<u32>,
    /// What the first of them gathered.
    found: Vec<Mat3A>,
    /// Difference from the parents above which a function's children gather.
    enough: f32,
    pub(super) gathers: u64,
}

/// What a receiver gathers, and the rays by which it does.
type Traced = (Mat3A, Renewed);

/// A receiver's rays and what gathers by them.
struct Gather<'a> {
    fan: &'a RayFan,
    /// The fan in the world.
    frame: glam::Mat3,
    hits: &'a [GatherHit],
    first_sender: u32,
}

impl Gather<'_> {
    /// The vector irradiance of what is sent.
    fn of(&self, sent: &Sent, sky: Option<&(dyn Fn(Vec3) -> Vec3 + Sync)>) -> Mat3A {
        let Self { fan, frame, hits, first_sender } = *self;
        let mut columns = [Vec3A::ZERO; 3];
        let mut add = |direction: Vec3, radiance: Vec3A| {
            let direction = Vec3A::from(direction);
            columns[0] += direction * radiance.x;
            columns[1] += direction * radiance.y;
            columns[2] += direction * radiance.z;
        };
        let rays = fan.directions().iter().zip(hits);
        match (sent, sky) {
            (Sent::Emission(sent) | Sent::Reflection(sent), _) => rays.for_each(|(&direction, hit)| {
                if let Some(sender) = hit.lit() {
                    add(direction, sent[(sender - first_sender) as usize]);
                }
            }),
            (Sent::Sky, Some(sky)) => rays
                .filter(|(_, hit)| hit.sender == GatherHit::MISS)
                .for_each(|(&direction, _)| add(direction, sky(frame * direction).into())),
            (Sent::Sky, None) => {}
        }
        let frame = glam::Mat3A::from(frame);
        let [x, y, z] = columns.map(|column| frame * column * fan.solid_angle());
        Mat3A::from_cols(x, y, z)
    }
}

impl Radiosity {
    /// Light on its way to the first level.
    pub(super) fn transport(&self, sent: Sent) -> Transport {
        let functions = self.bases.len();
        let mut transport = Transport {
            sent,
            received: vec![Mat3A::ZERO; functions],
            splits: vec![false; functions],
            level: 0,
            active: Vec::new(),
            found: Vec::new(),
            gathers: 0,
            enough: 0.0,
        };
        transport.active = self.active(&transport);
        transport
    }

    /// The functions of the level that gather: those whose parents' light is not enough. Where no parent reaches or knows, only rays
    /// tell.
    fn active(&self, transport: &Transport) -> Vec<u32> {
        let tells_little = |parent: usize| transport.splits[parent] || self.covered[parent];
        let wants = |function: usize| {
            let row = self.bases.parents().row(function);
            !self.covered[function] && (row.is_empty() || row.iter().any(|(parent, _)| tells_little(*parent as usize)))
        };
        self.bases.level(transport.level).filter(|&f| wants(f)).map(|f| f as u32).collect()
    }

    /// Gathers until the rays of as many receivers are traced, or to the end. Returns whether all is gathered.
    pub(super) fn gather_some(
        &mut self,
        surface: &dyn Carrier,
        sky: Option<&(dyn Fn(Vec3) -> Vec3 + Sync)>,
        transport: &mut Transport,
        receivers: usize,
    ) -> bool {
        let mut left = receivers.max(1);
        while transport.level < self.bases.levels() {
            let waiting = &transport.active[transport.found.len()..];
            let is_within =
                |function: &&u32| self.is_known(**function) || left.checked_sub(1).map(|rest| left = rest).is_some();
            let now: Vec<u32> = waiting.iter().take_while(is_within).copied().collect();
            let is_all = now.len() == waiting.len();
            let found = self.gathered(surface, sky, &transport.sent, now);
            transport.found.extend(found);
            if !is_all {
                return false;
            }
            self.end_level(transport);
        }
        true
    }

    /// What some functions gather. Their rays are kept while there is room.
    fn gathered(
        &mut self,
        surface: &dyn Carrier,
        sky: Option<&(dyn Fn(Vec3) -> Vec3 + Sync)>,
        sent: &Sent,
        functions: Vec<u32>,
    ) -> Vec<Mat3A> {
        let first_sender = self.bases.level(self.bases.sender_level()).start as u32;
        let unknown: Vec<u32> = functions.iter().copied().filter(|&function| !self.is_known(function)).collect();
        let traced = self.rows_at_once(surface, &unknown).unwrap_or_default();
        let of = |&function: &u32| -> Traced {
            let rays = self.renewed(surface, function, traced.get(&function).map(|row| &**row));
            let hits = rays.row().or(self.table.row(function)).expect("it was traced now or before");
            let frame = self.placed(surface, function).frame;
            (Gather { fan: &self.fan, frame, hits, first_sender }.of(sent, sky), rays)
        };
        let all: Vec<Traced> = functions.par_iter().map(of).collect();
        let keep = |(function, (found, rays)): (u32, Traced)| {
            self.know(function, rays);
            found
        };
        functions.into_iter().zip(all).map(keep).collect()
    }

    /// Refines the level: its functions take their parents' light, but those that gathered.
    fn end_level(&self, transport: &mut Transport) {
        let (level, range) = (transport.level, self.bases.level(transport.level));
        let Transport { received, splits, active, found, enough, gathers, .. } = transport;
        let pull = |function| self.bases.parents().product(function, received);
        let pulled: Vec<Mat3A> = range.clone().into_par_iter().map(pull).collect();
        received[range].copy_from_slice(&pulled);
        if level == 0 {
            *enough = self.settings.threshold * mean_length(found);
        }
        for (&function, found) in active.iter().zip(&*found) {
            let function = function as usize;
            splits[function] = level == 0 || length(&(*found - received[function])) > *enough;
            received[function] = *found;
        }
        *gathers += active.len() as u64;
        found.clear();
        transport.level += 1;
        transport.active = match transport.level < self.bases.levels() {
            true => self.active(transport),
            false => Vec::new(),
        };
    }
}

fn length(vector: &Mat3A) -> f32 {
    [vector.x_axis, vector.y_axis, vector.z_axis].map(|column| column.length_squared()).iter().sum::<f32>().sqrt()
}

fn mean_length(vectors: &[Mat3A]) -> f32 {
    vectors.iter().map(length).sum::<f32>() / vectors.len().max(1) as f32
}
