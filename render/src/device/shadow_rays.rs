//! Rays to lights on the GPU: which of them meet nothing. Twin of [`Intersector::passed_before`] in scenes without thin surfaces.

use super::{
    adapter::GpuDevice,
    box_hierarchy::BoxHierarchy,
    buffers::{storage, uniform, written},
    compute::SharedDevice,
    kernels::{SHADOW_RAYS, ShadowRayWork},
    layout,
    rays::dispatch,
    readback::read_words,
};
use crate::error::BackendError;
use glam::Vec3;
use lapidary_core::ray::{HierarchyNumber, Intersector};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// A ray that ends at a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowRay {
    /// Place in meters, off any surface.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Distance in meters before which something stops it; none stops it at 0.
    pub reach: f32,
}

/// A scene on an adapter that traces rays to lights.
pub struct GpuShadowRays {
    gpu: Arc<GpuDevice>,
    pipeline: wgpu::ComputePipeline,
    hierarchy: Arc<BoxHierarchy>,
    scene: HierarchyNumber,
    has_failed: AtomicBool,
}

impl GpuShadowRays {
    /// Rays of one piece of work, so that a desktop stays alive.
    pub const AT_A_TIME: usize = 1 << 20;

    /// Takes a scene without thin surfaces.
    ///
    /// # Errors
    /// A scene beyond the adapter's limits, or a lost device.
    pub fn new(device: &SharedDevice, scene: &Intersector) -> Result<Self, BackendError> {
        assert!(!scene.has_veils(), "thin surfaces dim light");
        Ok(Self {
            gpu: device.gpu.clone(),
            pipeline: device.ray_pipeline(&SHADOW_RAYS, &ShadowRayWork::LAYOUT)?,
            hierarchy: device.hierarchy(scene)?,
            scene: scene.number(),
            has_failed: AtomicBool::new(false),
        })
    }

    /// Whether it holds a scene on a device.
    pub fn is_of(&self, device: &SharedDevice, scene: &Intersector) -> bool {
        Arc::ptr_eq(&self.gpu, &device.gpu) && self.scene == scene.number()
    }

    /// Whether it has not failed.
    pub fn works(&self) -> bool {
        !self.has_failed.load(Ordering::Relaxed)
    }

    /// Bits of the rays that meet nothing, eight to a byte; `None` from the first failure on.
    pub fn open(&self, rays: &[ShadowRay]) -> Option<Vec<u8>> {
        let mut words = Vec::with_capacity(rays.len().div_ceil(32));
        for some in rays.chunks(Self::AT_A_TIME) {
            let traced = if self.works() { self.trace(some).ok() } else { None };
            self.has_failed.store(traced.is_none(), Ordering::Relaxed);
            words.extend(traced?);
        }
        Some(bytemuck::cast_slice(&words)[..rays.len().div_ceil(8)].to_vec())
    }

    fn trace(&self, rays: &[ShadowRay]) -> Result<Vec<u32>, BackendError> {
        let (gpu, words) = (&self.gpu, rays.len().div_ceil(32));
        let packed: Vec<layout::ShadowRay> = rays.iter().map(packed).collect();
        let uniforms = layout::ShadowRayUniforms { rays: rays.len() as u32 };
        let uniforms = uniform(gpu, "uniforms of shadow rays", bytemuck::bytes_of(&uniforms));
        let packed = storage(gpu, "shadow rays", bytemuck::cast_slice(&packed));
        // A workgroup writes two words.
        let open = written(gpu, "open shadow rays", (words.next_multiple_of(2) * size_of::<u32>()) as u64);
        let work = ShadowRayWork { uniforms: &uniforms, rays: &packed, open_words: &open }.bind(gpu);
        dispatch(gpu, &self.pipeline, [&self.hierarchy.group, &work], [rays.len() as u32, 1]);
        read_words(gpu, &open, words)
    }
}

fn packed(ray: &ShadowRay) -> layout::ShadowRay {
    layout::ShadowRay {
        origin: ray.origin.into(),
        // Shaders know no infinity.
        reach: ray.reach.min(f32::MAX),
        direction: ray.direction.into(),
        padding: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_adapter::{on_adapter, shared_device};
    use lapidary_core::{ray::EightRays, sphere::fibonacci_directions, test_scenes::soup};

    /// Those of eight rays that the cores find open, one bit each.
    fn open_on_cores(scene: &Intersector, rays: &[ShadowRay]) -> u8 {
        let of = |lane: usize| rays.get(lane).copied().unwrap_or(ShadowRay { reach: 0.0, ..rays[0] });
        let eight = EightRays::new(
            std::array::from_fn(|lane| of(lane).origin),
            std::array::from_fn(|lane| of(lane).direction),
            (0..rays.len()).fold(0, |active, lane| active | 1 << lane),
        );
        let passed = scene.passed_before(&eight, std::array::from_fn(|lane| of(lane).reach));
        (0..8).fold(0, |open, lane| open | u8::from(passed[lane] > 0.5) << lane)
    }

    #[test]
    fn shadow_rays_on_the_gpu_agree_with_those_on_the_processor() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let directions = fibonacci_directions(9001);
        let ray = |(i, &direction): (usize, &Vec3)| ShadowRay {
            origin: 0.05 * Vec3::new((i % 70) as f32, -0.7 * (i % 70) as f32, 0.3),
            direction,
            reach: [0.0, 0.3, 1.0, f32::INFINITY][i % 4],
        };
        let rays: Vec<ShadowRay> = directions.iter().enumerate().map(ray).collect();
        let differing = |a: &[u8], b: &[u8]| -> u32 { a.iter().zip(b).map(|(a, b)| (a ^ b).count_ones()).sum() };
        for triangles in [600, 3, 0] {
            let scene = Intersector::new(&soup(5, triangles));
            let on_device = GpuShadowRays::new(&device, &scene).unwrap();
            let open = on_device.open(&rays).unwrap();
            let expected: Vec<u8> = rays.chunks(8).map(|eight| open_on_cores(&scene, eight)).collect();
            assert_eq!(open.len(), expected.len());
            // A driver may fuse products and sums: rays along an edge then fall to either side.
            assert!(differing(&open, &expected) <= 3, "{}", differing(&open, &expected));
            let stopped = rays.len() as u32 - open.iter().map(|byte| byte.count_ones()).sum::<u32>();
            assert!((triangles < 600) != (stopped > 500), "{stopped} are stopped");
            let longer: Vec<ShadowRay> = rays.iter().map(|&ray| ShadowRay { reach: f32::INFINITY, ..ray }).collect();
            let longer = on_device.open(&longer).unwrap();
            assert!(triangles < 600 || differing(&longer, &expected) > 200, "negative control: without their ends");
        }
    }

    #[test]
    fn a_scene_is_uploaded_once_for_all_that_use_it() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let [one, other] = [5, 6].map(|seed| Intersector::new(&soup(seed, 60)));
        let first = GpuShadowRays::new(&device, &one).unwrap();
        let second = GpuShadowRays::new(&device, &one).unwrap();
        assert!(Arc::ptr_eq(&first.hierarchy, &second.hierarchy));
        let elsewhere = GpuShadowRays::new(&device, &other).unwrap();
        assert!(!Arc::ptr_eq(&first.hierarchy, &elsewhere.hierarchy), "negative control: another scene");
        let before = Arc::downgrade(&first.hierarchy);
        drop((first, second));
        assert!(before.upgrade().is_none(), "what nothing uses is freed");
    }
}
