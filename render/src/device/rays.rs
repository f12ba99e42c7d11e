//! Rays on the GPU for bakes: which directions meet nothing, from many origins at a time. Twin of
//! [`Intersector::trace_batch`]. The walk itself is `shaders/traverse.wgsl`, for other compute passes too.

use super::{
    adapter::GpuDevice,
    bindings::{GroupLayout, Shaders, module_of},
    buffers::{storage, uniform},
    compute::{Compute, SharedDevice},
    kernels::{Hierarchy, RAYS, RayWork},
    layout,
    readback::read_words,
    shaders::Program,
};
use crate::{error::BackendError, remedy::Remedy};
use bytemuck::Zeroable;
use glam::Vec3;
use lapidary_core::ray::{BoxNode, Intersector, RayDevice, RayDevices, RayOrigin};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::BufferUsages as Usages;

/// Origins of one piece of work, so that a desktop stays alive and a bake can be cancelled.
const ORIGINS_AT_A_TIME: usize = 64;

/// Directions of a workgroup, as in the shaders.
const DIRECTIONS_PER_GROUP: u32 = 64;

/// Most levels of a hierarchy, as in the shader.
const MOST_LEVELS: usize = 64;

/// An adapter that traces rays.
pub struct GpuRays {
    /// Whether a scene that it does not take is an error for the caller, or left to the cores.
    is_asked_for: bool,
    gpu: Arc<GpuDevice>,
    pipeline: wgpu::ComputePipeline,
}

impl GpuRays {
    /// On a device. Whether a scene that it does not take is an error, or left to the cores, is for the caller to say.
    ///
    /// # Errors
    /// A driver that refuses.
    pub fn on(device: &SharedDevice, is_asked_for: bool) -> Result<Self, BackendError> {
        Ok(Self { is_asked_for, gpu: device.gpu.clone(), pipeline: pipeline(&device.gpu, &RAYS, &RayWork::LAYOUT)? })
    }

    /// The fastest adapter that is more than an emulation on the processor, if there is one that works. Scenes that it does not
    /// take are left to the cores.
    pub fn of_hardware() -> Option<Self> {
        let Compute::Device(device) = Compute::of_hardware() else { return None };
        Self::on(&device, false).ok()
    }

    fn scene(&self, scene: &Intersector, directions: &[Vec3]) -> Result<GpuRayScene, BackendError> {
        let gpu = &self.gpu;
        let hierarchy = hierarchy(gpu, scene)?;
        let words = directions.len().div_ceil(32);
        let count = directions.len() as u32;
        let uniforms = layout::RayUniforms { directions: count, words: words as u32 };
        let uniforms = uniform(gpu, "uniforms of rays", bytemuck::bytes_of(&uniforms));
        let toward: Vec<[f32; 4]> = directions.iter().map(|d| d.extend(0.0).to_array()).collect();
        let toward = storage(gpu, "directions of rays", bytemuck::cast_slice(&toward));
        let no_origins = [layout::RayOrigin::zeroed(); ORIGINS_AT_A_TIME];
        let origins = storage(gpu, "origins of rays", bytemuck::cast_slice(&no_origins));
        let open = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("open rays"),
            size: (ORIGINS_AT_A_TIME * words * size_of::<u32>()) as u64,
            usage: Usages::STORAGE | Usages::COPY_SRC,
            mapped_at_creation: false,
        });
        let work = RayWork { rays: &uniforms, directions: &toward, origins: &origins, open_words: &open }.bind(gpu);
        gpu.check()?;
        let (gpu, pipeline, origins) = (self.gpu.clone(), self.pipeline.clone(), Mutex::new(origins));
        Ok(GpuRayScene { gpu, pipeline, hierarchy, work, origins, open, words, directions: count })
    }
}

impl RayDevices for GpuRays {
    fn device(&self, scene: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn RayDevice>>, String> {
        match self.scene(scene, directions) {
            Ok(scene) => Ok(Some(Box::new(scene))),
            Err(_) if !self.is_asked_for => Ok(None),
            Err(error) => Err(told(&self.gpu, &error)),
        }
    }
}

/// An adapter that will not do, and why.
fn told(gpu: &GpuDevice, error: &BackendError) -> String {
    error.of_adapter(&gpu.info.name, Remedy::words).unwrap_or_else(|| error.to_string())
}

/// The hierarchy of a scene, bound.
pub(super) fn hierarchy(gpu: &GpuDevice, scene: &Intersector) -> Result<wgpu::BindGroup, BackendError> {
    let BoxHierarchy { nodes, corners } = BoxHierarchy::new(gpu, scene)?;
    Ok(Hierarchy { nodes: &nodes, corners: &corners }.bind(gpu))
}

/// The hierarchy of a scene on the GPU, without thin surfaces.
pub(crate) struct BoxHierarchy {
    pub nodes: wgpu::Buffer,
    pub corners: wgpu::Buffer,
}

impl BoxHierarchy {
    /// Uploads it.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for.
    pub fn new(gpu: &GpuDevice, scene: &Intersector) -> Result<Self, BackendError> {
        let (nodes, triangles) = scene.hierarchy();
        gpu.within("the hierarchy", "levels", levels(&nodes) as u64, MOST_LEVELS as u64, Remedy::Cpu)?;
        let mut nodes: Vec<layout::BoxNode> = nodes.iter().map(packed).collect();
        let mut corners: &[f32] = bytemuck::cast_slice(triangles);
        if nodes.is_empty() {
            // A buffer has contents: a triangle without an area, which no ray crosses.
            (nodes, corners) = (vec![layout::BoxNode { triangles: 1, ..Zeroable::zeroed() }], &[0.0; 9]);
        }
        let bytes = size_of_val(corners).max(size_of_val(&nodes[..])) as u64;
        gpu.within("the triangles", "bytes", bytes, gpu.max_storage_bytes(), Remedy::Cpu)?;
        let nodes = storage(gpu, "nodes of rays", bytemuck::cast_slice(&nodes));
        let corners = storage(gpu, "triangles of rays", bytemuck::cast_slice(corners));
        Ok(Self { nodes, corners })
    }
}

/// The pipeline of a program whose groups are [`Hierarchy`] and its work.
pub(super) fn pipeline(
    gpu: &GpuDevice,
    program: &Program,
    work: &GroupLayout,
) -> Result<wgpu::ComputePipeline, BackendError> {
    let groups = [Hierarchy::LAYOUT.on(gpu), work.on(gpu)];
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(program.name),
        bind_group_layouts: &groups.each_ref().map(Some),
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(program.name),
        layout: Some(&layout),
        module: &module_of(gpu, program.name, &Shaders::default().text(program)?),
        entry_point: None,
        compilation_options: Default::default(),
        cache: gpu.pipeline_cache(),
    });
    gpu.check()?;
    Ok(pipeline)
}

/// A scene and directions on the GPU.
struct GpuRayScene {
    gpu: Arc<GpuDevice>,
    pipeline: wgpu::ComputePipeline,
    hierarchy: wgpu::BindGroup,
    work: wgpu::BindGroup,
    /// Held while rays of its origins are traced.
    origins: Mutex<wgpu::Buffer>,
    open: wgpu::Buffer,
    words: usize,
    directions: u32,
}

impl GpuRayScene {
    fn trace(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, BackendError> {
        let gpu = &self.gpu;
        let packed: Vec<layout::RayOrigin> = origins.iter().map(packed_origin).collect();
        let held = self.origins.lock().unwrap_or_else(PoisonError::into_inner);
        gpu.queue.write_buffer(&held, 0, bytemuck::cast_slice(&packed));
        dispatch(gpu, &self.pipeline, [&self.hierarchy, &self.work], [self.directions, origins.len() as u32]);
        read_words(gpu, &self.open, origins.len() * self.words)
    }
}

/// Traces so many directions from so many origins by a program of [`pipeline`].
pub(super) fn dispatch(
    gpu: &GpuDevice,
    pipeline: &wgpu::ComputePipeline,
    [hierarchy, work]: [&wgpu::BindGroup; 2],
    [directions, origins]: [u32; 2],
) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, hierarchy, &[]);
        pass.set_bind_group(1, work, &[]);
        pass.dispatch_workgroups(directions.div_ceil(DIRECTIONS_PER_GROUP), origins, 1);
    }
    gpu.queue.submit([encoder.finish()]);
}

impl RayDevice for GpuRayScene {
    fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String> {
        let mut open = Vec::with_capacity(origins.len() * self.words);
        for some in origins.chunks(ORIGINS_AT_A_TIME) {
            open.extend(self.trace(some).map_err(|error| told(&self.gpu, &error))?);
        }
        Ok(open)
    }
}

fn packed(node: &BoxNode) -> layout::BoxNode {
    layout::BoxNode { low: node.min.into(), first: node.first, high: node.max.into(), triangles: node.triangles }
}

fn packed_origin(at: &RayOrigin) -> layout::RayOrigin {
    layout::RayOrigin {
        origin: at.origin.into(),
        height: at.half.height,
        normal: at.half.normal.into(),
        is_above: u32::from(at.half.is_above),
    }
}

/// Levels of a hierarchy.
fn levels(nodes: &[BoxNode]) -> usize {
    let (mut deepest, mut stack) = (0, vec![(0, 1)]);
    while let Some((index, level)) = stack.pop() {
        let Some(node) = nodes.get(index as usize) else { continue };
        deepest = deepest.max(level);
        if node.triangles == 0 {
            stack.extend([(node.first, level + 1), (node.first + 1, level + 1)]);
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_adapter::{on_adapter, shared_device};
    use lapidary_core::{
        ray::{DirectionSet, HalfSpace, OPEN},
        sphere::fibonacci_directions,
        test_scenes::soup,
    };

    #[test]
    fn rays_on_the_gpu_agree_with_those_on_the_processor() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let rays = GpuRays::on(&device, true).unwrap();
        for (triangles, lights) in [(600, 4096), (3, 64), (0, 32)] {
            let scene = Intersector::new(&soup(5, triangles));
            let directions = fibonacci_directions(lights);
            let device = rays.device(&scene, &directions).unwrap().expect("it takes a small scene");
            let at = |i: usize| RayOrigin {
                origin: 0.05 * Vec3::new(i as f32, -0.7 * i as f32, 0.3),
                half: HalfSpace { normal: Vec3::new(0.6, 0.8, 0.0), height: -0.1, is_above: !i.is_multiple_of(3) },
            };
            // More than one piece of work.
            let origins: Vec<RayOrigin> = (0..70).map(at).collect();
            let open = device.open(&origins).unwrap();
            let set = DirectionSet::new(&directions);
            let (mut ties, mut seen) = (0, 0);
            for (row, at) in open.chunks(lights.div_ceil(32)).zip(&origins) {
                let mut visible = vec![0; lights];
                scene.trace_batch(at.origin, &set, |_, d| at.half.has(d), &mut visible);
                let differs = |(i, v): &(usize, &u8)| row[i / 32] >> (i % 32) & 1 != u32::from(**v / OPEN);
                ties += visible.iter().enumerate().filter(differs).count();
                seen += visible.iter().filter(|v| **v == OPEN).count();
            }
            // A driver may fuse products and sums: rays along an edge then fall to either side.
            assert!(ties * 100_000 <= 70 * lights, "{ties} of {}", 70 * lights);
            assert!(seen > 0);
            let moved: Vec<RayOrigin> = origins.iter().map(|at| RayOrigin { origin: at.origin + 1.0, ..*at }).collect();
            assert!(device.open(&moved).unwrap() != open || triangles == 0, "negative control: other origins");
        }
    }
}
