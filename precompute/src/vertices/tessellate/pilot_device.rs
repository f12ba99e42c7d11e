//! The pilot's rays on a device: a fan of all directions, and one of those of short edges' midpoints.

use super::pilot::OF_SHORT;
use glam::{Mat3, Vec3};
use lapidary_core::ray::{Fan, FanDevice, Hit, Intersector, OpenRays, RayDevice, RayDevices, RayDirections, RayOrigin};

/// A scene with both fans on a device.
pub(super) enum PilotDevice {
    /// For distant light alone.
    Open([Box<dyn RayDevice>; 2]),
    /// For the nearness of surfaces, too.
    Hits([Box<dyn FanDevice>; 2]),
}

/// What rays in all directions of a fan meet, origin by origin.
pub(super) enum Met {
    Open(OpenRays),
    Hits(Vec<Option<Hit>>),
}

impl PilotDevice {
    /// A device that takes the scene; `None` leaves the rays to the cores, as in scenes with thin surfaces.
    ///
    /// # Errors
    /// A description of the device's failure.
    pub fn new(
        devices: Option<&dyn RayDevices>,
        scene: &Intersector,
        with_nearness: bool,
        toward: &[Vec3],
    ) -> Result<Option<Self>, String> {
        let Some(devices) = devices.filter(|_| !scene.has_veils()) else { return Ok(None) };
        let of_short: Vec<Vec3> = toward.iter().copied().step_by(OF_SHORT).collect();
        if with_nearness {
            let fans = [devices.fans(scene, toward)?, devices.fans(scene, &of_short)?];
            return Ok(both(fans).map(Self::Hits));
        }
        let rays = [toward, &of_short].map(|directions| devices.device(scene, RayDirections::All(directions)));
        let [all, of_short] = rays;
        Ok(both([all?, of_short?]).map(Self::Open))
    }

    /// What rays meet in every `step`th direction: 1, or [`OF_SHORT`].
    ///
    /// # Errors
    /// A description of the device's failure.
    pub fn trace(&self, origins: &[RayOrigin], step: usize) -> Result<Met, String> {
        let fan = usize::from(step == OF_SHORT);
        match self {
            Self::Open(devices) => devices[fan].open(origins).map(Met::Open),
            Self::Hits(devices) => {
                let at = |at: &RayOrigin| Fan { origin: at.origin, frame: Mat3::IDENTITY };
                devices[fan].first_hits(&origins.iter().map(at).collect::<Vec<_>>()).map(Met::Hits)
            }
        }
    }
}

fn both<T>(made: [Option<T>; 2]) -> Option<[T; 2]> {
    let [all, of_short] = made;
    Some([all?, of_short?])
}

impl Met {
    /// Distance in meters of what the ray of an origin in one of `directions` meets: infinite if it is open. It is 0 where no nearness
    /// is asked for.
    pub fn distance(&self, origin: usize, direction: usize, directions: usize) -> f32 {
        match self {
            Self::Open(open) => {
                let word = open.rows[origin * directions.div_ceil(32) + direction / 32];
                if word >> (direction % 32) & 1 == 1 { f32::INFINITY } else { 0.0 }
            }
            Self::Hits(hits) => hits[origin * directions + direction].map_or(f32::INFINITY, |hit| hit.distance),
        }
    }
}
