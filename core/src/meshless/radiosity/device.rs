//! Transport on a device, which gathers, pulls and splits level by level. Rays stay with the cores: they tell the device those that it
//! lacks. Twin of [`super::transport`], for all light but that of the sky.

use super::{
    Radiosity,
    transport::{Sent, Transport, mean_length},
};
use crate::meshless::object_bases::Carrier;
use glam::{Mat3, Mat3A, Vec3A};
use std::ops::Range;

/// Most receivers whose rays the device takes in a step: 8 MB of them at 512 rays each.
const RECEIVERS_AT_A_TIME: usize = 4096;

/// Gathers light for the functions level by level. It may add in another order than the cores.
///
/// # Errors
/// Each method describes the device's failure.
pub trait TransportDevice: Send + Sync {
    /// Begins with the radiance of the senders. Covered functions do not gather.
    fn send(&mut self, radiance: &[Vec3A], covered: &[bool]) -> Result<(), String>;

    /// Finds the functions of a level that gather, by the splits of the level before.
    fn find_active(&mut self, level: usize) -> Result<ActiveFunctions, String>;

    /// Takes the rays of receivers in place of those that it has of them.
    fn take_rays(&mut self, receivers: &[ReceiverRays]) -> Result<(), String>;

    /// Counts all rays as unknown: a move may change them.
    fn forget_rays(&mut self);

    /// Gathers for the active functions of a level and pulls the others. Those split that differ from their parents by more than
    /// `enough`.
    fn gather(&mut self, level: usize, enough: f32) -> Result<(), String>;

    /// Vector irradiance of some functions, one column per color channel.
    fn received(&self, functions: Range<usize>) -> Result<Vec<Mat3A>, String>;
}

/// The functions of a level that gather.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ActiveFunctions {
    /// How many there are.
    pub count: usize,
    /// Those of which the device does not know the rays, in ascending order.
    pub unknown: Vec<u32>,
}

/// The rays by which a receiver gathers.
#[derive(Clone, Debug)]
pub struct ReceiverRays {
    /// Index of its function.
    pub function: u32,
    /// The fan in the world.
    pub frame: Mat3,
    /// For each direction the sender that the ray meets, as an index among the senders; [`u32::MAX`] without one.
    pub senders: Box<[u32]>,
}

/// How far a transport is on the device.
#[derive(Clone, Debug)]
pub(super) struct DeviceProgress {
    /// The step of the device that it ended with; after another one, it begins again.
    step: u64,
    level: usize,
    active: ActiveFunctions,
    /// Difference from the parents above which functions split; below zero on the first level, where all split.
    enough: f32,
    gathers: u64,
}

impl Radiosity {
    /// Gathers on a device from now on. The cores go on where it fails.
    pub fn set_device(&mut self, device: Option<Box<dyn TransportDevice>>) {
        self.device = device;
        self.device_step += 1;
    }

    /// Whether a device gathers, which did not fail yet.
    pub fn has_device(&self) -> bool {
        self.device.is_some()
    }

    /// Gathers on the device as [`Self::gather_some`] does; `None` if the cores have to.
    pub(super) fn gather_on_device(
        &mut self,
        surface: &dyn Carrier,
        transport: &mut Transport,
        receivers: usize,
    ) -> Option<bool> {
        let (Sent::Emission(radiance) | Sent::Reflection(radiance)) = &transport.sent else { return None };
        let mut device = self.device.take()?;
        let known = transport.on_device.take().filter(|progress| progress.step == self.device_step);
        let progress = known.map_or_else(|| self.begin_on(&mut *device, radiance), Ok);
        let progress = progress.and_then(|progress| self.go_on(&mut *device, surface, progress, receivers)).ok()?;
        let is_done = progress.level == self.bases.levels();
        if is_done {
            transport.received = device.received(0..self.bases.len()).ok()?;
            transport.gathers = progress.gathers;
        }
        (self.device, transport.on_device) = (Some(device), Some(progress));
        Some(is_done)
    }

    fn begin_on(&self, device: &mut dyn TransportDevice, radiance: &[Vec3A]) -> Result<DeviceProgress, String> {
        device.send(radiance, &self.covered)?;
        let active = device.find_active(0)?;
        Ok(DeviceProgress { step: self.device_step, level: 0, active, enough: -1.0, gathers: 0 })
    }

    /// Goes on until the rays of as many receivers are traced or of [`RECEIVERS_AT_A_TIME`] taken, or to the end.
    fn go_on(
        &mut self,
        device: &mut dyn TransportDevice,
        surface: &dyn Carrier,
        mut progress: DeviceProgress,
        receivers: usize,
    ) -> Result<DeviceProgress, String> {
        let mut left = receivers.max(1);
        while progress.level < self.bases.levels() {
            let unknown = &mut progress.active.unknown;
            let within = self.count_within(unknown, &mut left).min(RECEIVERS_AT_A_TIME);
            let now: Vec<u32> = unknown.drain(..within).collect();
            if !now.is_empty() {
                device.take_rays(&self.with_rays(surface, &now, |gather| gather.told()))?;
            }
            if !unknown.is_empty() {
                break;
            }
            self.end_level_on(device, &mut progress)?;
        }
        self.device_step += 1;
        progress.step = self.device_step;
        Ok(progress)
    }

    fn end_level_on(&self, device: &mut dyn TransportDevice, progress: &mut DeviceProgress) -> Result<(), String> {
        let DeviceProgress { level, active, enough, gathers, .. } = progress;
        device.gather(*level, *enough)?;
        *gathers += active.count as u64;
        if *level == 0 {
            // Those that do not gather have no light yet.
            let light = device.received(self.bases.level(0))?;
            *enough = self.settings.threshold * mean_length(&light, active.count);
        }
        *level += 1;
        if *level < self.bases.levels() {
            *active = device.find_active(*level)?;
        }
        Ok(())
    }
}
