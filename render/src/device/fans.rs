//! First hits of the rays of many receivers on the GPU, for light that is solved anew. Twin of [`Intersector::closest_hits`].

use super::{
    adapter::GpuDevice,
    box_hierarchy::BoxHierarchy,
    buffers::{storage, uniform},
    compute::SharedDevice,
    kernels::{FANS, FanWork},
    layout,
    rays::{dispatch, told},
    readback::read_range,
};
use crate::error::BackendError;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use lapidary_core::ray::{Fan, FanDevice, Hit, Intersector};
use std::sync::{Arc, Mutex, PoisonError};

/// Fans of one piece of work, so that a desktop stays alive.
const FANS_AT_A_TIME: usize = 256;

/// Bit of the back of a triangle, as in the shader.
const BACK: u32 = 1 << 31;

/// A scene and the directions of a fan on an adapter.
pub struct GpuFans {
    gpu: Arc<GpuDevice>,
    pipeline: wgpu::ComputePipeline,
    hierarchy: Arc<BoxHierarchy>,
    work: wgpu::BindGroup,
    /// Held while rays are traced.
    fans: Mutex<wgpu::Buffer>,
    hits: wgpu::Buffer,
    directions: usize,
    /// Triangle of the mesh for each triangle of the hierarchy.
    triangles: Vec<u32>,
}

impl GpuFans {
    /// Takes a scene, and one direction or more.
    ///
    /// # Errors
    /// A scene beyond the adapter's limits, or a lost device.
    pub fn new(device: &SharedDevice, scene: &Intersector, directions: &[Vec3]) -> Result<Self, BackendError> {
        let gpu = &device.gpu;
        let uniforms = layout::FanUniforms { directions: directions.len() as u32 };
        let uniforms = uniform(gpu, "uniforms of fans", bytemuck::bytes_of(&uniforms));
        let toward: Vec<[f32; 4]> = directions.iter().map(|d| d.extend(0.0).to_array()).collect();
        let toward = storage(gpu, "directions of fans", bytemuck::cast_slice(&toward));
        let fans = storage(gpu, "fans", bytemuck::cast_slice(&[layout::Fan::zeroed(); FANS_AT_A_TIME]));
        let hits = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("hits of fans"),
            size: (FANS_AT_A_TIME * directions.len() * size_of::<layout::FanHit>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let work = FanWork { uniforms: &uniforms, directions: &toward, fans: &fans, hits: &hits }.bind(gpu);
        Ok(Self {
            pipeline: device.ray_pipeline(&FANS, &FanWork::LAYOUT)?,
            hierarchy: device.hierarchy(scene)?,
            work,
            fans: Mutex::new(fans),
            hits,
            directions: directions.len(),
            triangles: scene.leaf_triangle_ids().to_vec(),
            gpu: gpu.clone(),
        })
    }

    /// The same rays in another scene.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_scene(self, device: &SharedDevice, scene: &Intersector) -> Result<Self, BackendError> {
        let hierarchy = device.hierarchy(scene)?;
        Ok(Self { hierarchy, triangles: scene.leaf_triangle_ids().to_vec(), ..self })
    }

    fn trace(&self, fans: &[Fan]) -> Result<Vec<layout::FanHit>, BackendError> {
        let gpu = &self.gpu;
        let packed: Vec<layout::Fan> = fans.iter().map(packed).collect();
        let held = self.fans.lock().unwrap_or_else(PoisonError::into_inner);
        gpu.queue.write_buffer(&held, 0, bytemuck::cast_slice(&packed));
        dispatch(gpu, &self.pipeline, [&self.hierarchy.group, &self.work], [self.directions as u32, fans.len() as u32]);
        read_range(gpu, &self.hits, 0..fans.len() * self.directions)
    }

    fn hit(&self, found: &layout::FanHit) -> Option<Hit> {
        let leaf = (found.triangle & !BACK).checked_sub(1)?;
        Some(Hit {
            triangle: self.triangles[leaf as usize],
            distance: found.distance,
            barycentric: Vec2::from(found.barycentric),
            back_face: found.triangle & BACK != 0,
        })
    }
}

impl FanDevice for GpuFans {
    fn first_hits(&self, fans: &[Fan]) -> Result<Vec<Option<Hit>>, String> {
        let mut hits = Vec::with_capacity(fans.len() * self.directions);
        for some in fans.chunks(FANS_AT_A_TIME) {
            let found = self.trace(some).map_err(|error| told(&self.gpu, &error))?;
            hits.extend(found.iter().map(|found| self.hit(found)));
        }
        Ok(hits)
    }
}

fn packed(fan: &Fan) -> layout::Fan {
    let columns = [fan.frame.x_axis, fan.frame.y_axis, fan.frame.z_axis];
    layout::Fan {
        frame: columns.map(|column| column.extend(0.0).to_array()),
        origin: fan.origin.extend(0.0).to_array(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_adapter::{on_adapter, shared_device};
    use lapidary_core::{gather_table::RayFan, test_scenes::soup};

    #[test]
    fn first_hits_on_the_gpu_are_those_of_the_processor() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let fan = RayFan::new(72);
        let at = |i: usize| Fan {
            origin: 0.05 * Vec3::new(i as f32, -0.7 * i as f32, 0.3),
            frame: RayFan::frame(i as u32, Vec3::new(0.6, 0.0, 0.8)),
        };
        // More than one piece of work.
        let fans: Vec<Fan> = (0..FANS_AT_A_TIME + 44).map(at).collect();
        for triangles in [600, 3, 0] {
            let scene = Intersector::new(&soup(5, triangles));
            let found = GpuFans::new(&device, &scene, fan.directions()).unwrap().first_hits(&fans).unwrap();
            let eights = fan.directions().as_chunks::<8>().0;
            let expected = fans.iter().flat_map(|fan| {
                let turned: Vec<[Vec3; 8]> = eights.iter().map(|eight| fan.turned(eight)).collect();
                scene.closest_hits(fan.origin, &turned).into_iter().flatten()
            });
            let expected: Vec<Option<Hit>> = expected.collect();
            let is_same = |(a, b): &(&Option<Hit>, &Option<Hit>)| match (a, b) {
                (Some(a), Some(b)) => {
                    (a.triangle, a.back_face) == (b.triangle, b.back_face)
                        && (a.distance - b.distance).abs() < 1e-4 * b.distance
                        && a.barycentric.distance(b.barycentric) < 1e-3
                }
                (a, b) => a.is_none() && b.is_none(),
            };
            assert_eq!(found.len(), expected.len());
            let same = found.iter().zip(&expected).filter(is_same).count();
            let ties = found.len() - same;
            // A driver may fuse products and sums: rays along an edge then fall to either side.
            assert!(ties * 1000 <= found.len(), "{ties} of {}", found.len());
            let hits = expected.iter().filter(|hit| hit.is_some()).count();
            assert!(triangles < 600 || hits > 1000, "{hits}");
            let others = found.iter().skip(fan.directions().len()).zip(&expected).filter(is_same).count();
            assert!(triangles < 600 || others * 10 < 9 * found.len(), "negative control: rays of the next fan");
        }
    }
}
