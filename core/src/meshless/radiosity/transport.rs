//! One bounce on its way to the functions, in parts that a caller may stop between.

use super::{
    Radiosity,
    device::{DeviceProgress, ReceiverRays},
    follow::Renewed,
};
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
    /// How far it is on a device, if one gathers. The fields of the levels above then stay as they begin.
    pub(super) on_device: Option<DeviceProgress>,
}

/// A receiver's rays and what gathers by them.
pub(super) struct Gather<'a> {
    receiver: u32,
    fan: &'a RayFan,
    /// The fan in the world.
    frame: glam::Mat3,
    hits: &'a [GatherHit],
    first_sender: u32,
}

impl Gather<'_> {
    /// The vector irradiance of what is sent.
    fn of(&self, sent: &Sent, sky: Option<&(dyn Fn(Vec3) -> Vec3 + Sync)>) -> Mat3A {
        let Self { fan, frame, hits, first_sender, .. } = *self;
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

    /// The rays as a device takes them.
    pub(super) fn told(&self) -> ReceiverRays {
        let sender = |hit: &GatherHit| hit.lit().map_or(u32::MAX, |sender| sender - self.first_sender);
        let senders = self.hits.iter().map(sender).collect();
        ReceiverRays { function: self.receiver, frame: self.frame, senders }
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
            on_device: None,
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
        if let Some(is_all) = self.gather_on_device(surface, transport, receivers) {
            return is_all;
        }
        let mut left = receivers.max(1);
        while transport.level < self.bases.levels() {
            let waiting = &transport.active[transport.found.len()..];
            let now = &waiting[..self.count_within(waiting, &mut left)];
            let is_all = now.len() == waiting.len();
            let found = self.with_rays(surface, now, |gather| gather.of(&transport.sent, sky));
            transport.found.extend(found);
            if !is_all {
                return false;
            }
            self.end_level(transport);
        }
        true
    }

    /// How many of the first of some functions can gather before more than `left` of them have their rays traced.
    pub(super) fn count_within(&self, functions: &[u32], left: &mut usize) -> usize {
        let mut is_within =
            |function: u32| self.is_known(function) || left.checked_sub(1).map(|rest| *left = rest).is_some();
        functions.iter().take_while(|&&function| is_within(function)).count()
    }

    /// What comes of the rays of some functions as they are now. They are kept while there is room.
    pub(super) fn with_rays<T: Send>(
        &mut self,
        surface: &dyn Carrier,
        functions: &[u32],
        act: impl Fn(&Gather) -> T + Sync,
    ) -> Vec<T> {
        let first_sender = self.bases.level(self.bases.sender_level()).start as u32;
        let unknown: Vec<u32> = functions.iter().copied().filter(|&function| !self.is_known(function)).collect();
        let traced = self.rows_at_once(surface, &unknown).unwrap_or_default();
        let of = |&receiver: &u32| -> (T, Renewed) {
            let rays = self.renewed(surface, receiver, traced.get(&receiver).map(|row| &**row));
            let hits = rays.row().or(self.table.row(receiver)).expect("it was traced now or before");
            let frame = self.placed(surface, receiver).frame;
            (act(&Gather { receiver, fan: &self.fan, frame, hits, first_sender }), rays)
        };
        let all: Vec<(T, Renewed)> = functions.par_iter().map(of).collect();
        let keep = |(&function, (found, rays)): (&u32, (T, Renewed))| {
            self.know(function, rays);
            found
        };
        functions.iter().zip(all).map(keep).collect()
    }

    /// Refines the level: its functions take their parents' light, but those that gathered.
    fn end_level(&self, transport: &mut Transport) {
        let (level, range) = (transport.level, self.bases.level(transport.level));
        let Transport { received, splits, active, found, enough, gathers, .. } = transport;
        let pull = |function| self.bases.parents().product(function, received);
        let pulled: Vec<Mat3A> = range.clone().into_par_iter().map(pull).collect();
        received[range].copy_from_slice(&pulled);
        if level == 0 {
            *enough = self.settings.threshold * mean_length(found, found.len());
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

/// Sum of the lengths over `count`.
pub(super) fn mean_length(vectors: &[Mat3A], count: usize) -> f32 {
    vectors.iter().map(length).sum::<f32>() / count.max(1) as f32
}
