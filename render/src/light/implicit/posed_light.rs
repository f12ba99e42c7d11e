//! The light of posed objects, on the cores or on the device that made it.

use crate::device::{
    GpuDevice, VertexPlanes,
    layout::constants::{POSED_BOUNCE, POSED_GROWTH, POSED_UNCOVERED},
};
use glam::{Vec3, Vec4};
use std::sync::{Arc, OnceLock};

/// Values for both sides of the vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sides {
    /// Values on the side of the normals.
    pub front: Vec<Vec3>,
    /// Values on the opposite side.
    pub back: Vec<Vec3>,
}

impl Sides {
    /// No light at some vertices.
    pub fn dark(vertices: usize) -> Self {
        Self { front: vec![Vec3::ZERO; vertices], back: vec![Vec3::ZERO; vertices] }
    }

    /// Value at a point of a triangle, by its vertices' weights.
    #[inline]
    pub fn at(&self, vertices: [u32; 3], weights: [f32; 3], from_behind: bool) -> Vec3 {
        let side = if from_behind { &self.back } else { &self.front };
        vertices.iter().zip(weights).map(|(&vertex, weight)| side[vertex as usize] * weight).sum()
    }
}

/// The light of posed objects, for pixels. At glossy vertices irradiance is that with which a diffuse surface of the same albedo would
/// reflect as much toward one eye.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedLight {
    /// Whether each vertex is away from its baked position.
    pub is_moved: Arc<[bool]>,
    /// Relative growth of the environment's light at the vertices, `E(posed) / E(as baked) - 1`, -1 to 1. It is 0 at vertices with
    /// new cuts, and exactly 0 between vertices whose light is unchanged.
    pub growth: Sides,
    /// Additional irradiance of the environment in W/m², at vertices that were too dark for their ratio.
    pub uncovered: Sides,
    /// Bounced irradiance in W/m²: its difference from the bake, or all of it for moved vertices.
    pub bounce: Sides,
}

/// The light of posed objects where it was made.
#[derive(Clone, Debug)]
pub enum PosedLighting {
    OnCores(PosedLight),
    OnDevice(Box<DeviceLight>),
}

/// The light of posed objects on a device.
#[derive(Clone, Debug)]
pub struct DeviceLight {
    /// Those of `posed.wgsl`.
    pub planes: VertexPlanes,
    /// Whether bounces are shown, see [`PosedLight::without_bounces`].
    pub has_bounces: bool,
    is_moved: Arc<[bool]>,
    /// The same on the cores, once a reader there has asked.
    read: OnceLock<PosedLight>,
}

impl PosedLight {
    /// Light that is as baked.
    pub fn as_baked(vertices: usize) -> Self {
        let dark = || Sides::dark(vertices);
        Self { is_moved: vec![false; vertices].into(), growth: dark(), uncovered: dark(), bounce: dark() }
    }

    /// The same for a picture whose bounced light follows poses: none is added.
    #[must_use]
    pub fn without_bounces(&self) -> Self {
        let vertices = self.is_moved.len();
        Self { is_moved: vec![false; vertices].into(), bounce: Sides::dark(vertices), ..self.clone() }
    }
}

impl PosedLighting {
    /// That of a device.
    pub fn on_device(planes: VertexPlanes, is_moved: Arc<[bool]>) -> Self {
        Self::OnDevice(DeviceLight { planes, has_bounces: true, is_moved, read: OnceLock::new() }.into())
    }

    /// The light on the cores. That of a device is read back, once; of a lost one it is as baked, and whoever draws there tells.
    pub fn known(&self) -> &PosedLight {
        match self {
            Self::OnCores(light) => light,
            Self::OnDevice(light) => light.read.get_or_init(|| light.read_back()),
        }
    }

    /// The light on a device, if it was made there.
    pub fn there(&self, gpu: &GpuDevice) -> Option<&DeviceLight> {
        match self {
            Self::OnDevice(light) if light.planes.are_on(gpu) => Some(&**light),
            _ => None,
        }
    }

    /// As [`PosedLight::without_bounces`].
    #[must_use]
    pub fn without_bounces(&self) -> Self {
        match self {
            Self::OnCores(light) => Self::OnCores(light.without_bounces()),
            Self::OnDevice(light) => {
                Self::OnDevice(DeviceLight { has_bounces: false, read: OnceLock::new(), ..(**light).clone() }.into())
            }
        }
    }
}

impl DeviceLight {
    fn read_back(&self) -> PosedLight {
        let sides = |plane| {
            let texels = self.planes.read(plane).ok()?;
            let side =
                |first| texels.iter().skip(first).step_by(2).map(|&texel| Vec4::from(texel).truncate()).collect();
            Some(Sides { front: side(0), back: side(1) })
        };
        let read = || {
            Some(PosedLight {
                is_moved: self.is_moved.clone(),
                growth: sides(POSED_GROWTH)?,
                uncovered: sides(POSED_UNCOVERED)?,
                bounce: sides(POSED_BOUNCE)?,
            })
        };
        let light = read().unwrap_or_else(|| PosedLight::as_baked(self.is_moved.len()));
        if self.has_bounces { light } else { light.without_bounces() }
    }
}
