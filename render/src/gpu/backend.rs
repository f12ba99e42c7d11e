//! [`Backend`] on the GPU: resources grouped by what changes them, and pictures made of passes.

mod encode;
mod groups;
mod picture;
mod timing;

pub use timing::PassTimes;

use super::{
    bounce::VertexBounce,
    device::{GpuDevice, Room},
    direct::DirectLights,
    layout,
    light::{GpuLight, GpuMap, GpuSources, scaled_map},
    materials::GpuMaterials,
    passes::Passes,
    readback,
    scene::GpuScene,
    shaders::ShaderSource,
    targets::{Target, Targets},
};
use crate::{
    appearance::Appearance,
    backend::{Backend, BackendError, PictureStats},
    baked::Baked,
    light::{
        environment::{Illumination, SceneLighting},
        local::LocalLighting,
    },
    measure::compare::map::magma_stops,
    post::Post,
    shade::merge::BrdfSampling,
    view::View,
};
use lapidary_core::{dataset::Dataset, environment::Environment, image::Image};
use picture::Picture;
use std::{ops::Range, sync::Arc};
use wgpu::util::DeviceExt;

/// The renderer on one adapter.
pub struct GpuBackend {
    gpu: GpuDevice,
    passes: Passes,
    source: ShaderSource,
    frame: wgpu::Buffer,
    display: wgpu::Buffer,
    magma: wgpu::Buffer,
    scene: Option<Loaded>,
    light: Option<(GpuLight, Arc<Environment>)>,
    local: LocalLighting,
    /// Bounced light as it was last shown.
    sources: Option<GpuSources>,
    bounce: VertexBounce,
    /// Stands in where no environment is shown; made for the scene.
    dark: Option<(GpuLight, Arc<Environment>)>,
    map: Option<GpuMap>,
    local_lights: DirectLights,
    targets: Option<Targets>,
    picture: Option<Picture>,
}

/// A scene and how it looks.
struct Loaded {
    scene: GpuScene,
    materials: GpuMaterials,
    dataset: Arc<Dataset>,
}

impl GpuBackend {
    /// On the fastest adapter.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses.
    pub fn new(room: Room, source: &ShaderSource) -> Result<Self, BackendError> {
        Self::on(GpuDevice::new(room)?, source)
    }

    /// On the fastest adapter, unless that computes on the processor: the CPU renderer is faster there.
    ///
    /// # Errors
    /// As [`Self::new`]; an emulated adapter counts as none.
    pub fn on_hardware(room: Room, source: &ShaderSource) -> Result<Self, BackendError> {
        let gpu = GpuDevice::new(room)?;
        if gpu.info.device_type == wgpu::DeviceType::Cpu {
            return Err(BackendError::NoAdapter { reason: format!("{} is emulated", gpu.info.name) });
        }
        Self::on(gpu, source)
    }

    fn on(gpu: GpuDevice, source: &ShaderSource) -> Result<Self, BackendError> {
        let passes = Passes::new(&gpu, source, &[])?;
        let uniform = |label, size: usize| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let magma = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("magma"),
            contents: bytemuck::cast_slice(&magma_stops().map(|c| c.extend(1.0).to_array())),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        Ok(Self {
            frame: uniform("frame", size_of::<layout::FrameUniforms>()),
            display: uniform("display", size_of::<layout::Display>()),
            magma,
            local_lights: DirectLights::new(&gpu),
            gpu,
            passes,
            source: source.clone(),
            scene: None,
            light: None,
            local: LocalLighting::default(),
            sources: None,
            bounce: VertexBounce::default(),
            dark: None,
            map: None,
            targets: None,
            picture: None,
        })
    }

    fn submit(&mut self, encode: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder)) -> Result<(), BackendError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encode(self, &mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    fn picture(&self) -> &Picture {
        self.picture.as_ref().expect("a picture is begun before it is rendered")
    }

    fn loaded(&self) -> &Loaded {
        self.scene.as_ref().expect("a picture is begun with a scene")
    }

    fn targets(&self) -> &Targets {
        self.targets.as_ref().expect("a picture is begun with targets")
    }

    fn read_floats(&self, target: &Target) -> Result<Vec<[f32; 4]>, BackendError> {
        Ok(bytemuck::pod_collect_to_vec(&readback::read(&self.gpu, target)?))
    }

    /// Replaces the room for shadow maps, and forgets the lights.
    #[cfg(test)]
    pub(super) fn limit_shadows(&mut self, room: super::shadows::ShadowRoom) {
        self.local_lights = DirectLights::within(room);
    }

    /// Bounced light at the vertices, to see whether it was uploaded again.
    #[cfg(test)]
    pub(super) fn vertex_irradiance(&self) -> Option<&wgpu::Buffer> {
        self.bounce.buffer()
    }

    /// Whether local lights take up textures.
    #[cfg(test)]
    pub(super) fn lights_take_room(&self) -> bool {
        self.local_lights.takes_room()
    }

    /// Output of the deferred pass: the geometry texels of `geometry.wgsl`, for tests on the same buffers.
    #[cfg(test)]
    pub(super) fn read_geometry(&self) -> Vec<[u32; 4]> {
        let bytes = readback::read(&self.gpu, &self.targets().geometry).expect("the device is there");
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

impl Backend for GpuBackend {
    fn name(&self) -> String {
        self.gpu.info.name.clone()
    }

    fn reload(&mut self) -> Result<(), BackendError> {
        self.passes = Passes::new(&self.gpu, &self.source, &self.passes.variants())?;
        self.local_lights.forget_shadows();
        self.picture = None;
        Ok(())
    }

    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        let dataset = &baked.dataset;
        let scene = GpuScene::new(&self.gpu, dataset)?;
        let (materials, _) = GpuMaterials::new(&self.gpu, &Appearance::of(&dataset.scene), None);
        self.gpu.check()?;
        self.scene = Some(Loaded { scene, materials, dataset: dataset.clone() });
        // The lights go with their scene, and with them what was said of them.
        self.local_lights.set(&[], 1.0);
        (self.light, self.dark, self.picture, self.sources) = (None, None, None, None);
        (self.local, self.bounce) = (LocalLighting::default(), VertexBounce::default());
        Ok(())
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let Some(loaded) = self.scene.take() else { return Ok(Vec::new()) };
        let (fitted, mut messages) = appearance.fitted(&loaded.dataset.scene.materials);
        let (materials, scaled) = GpuMaterials::new(&self.gpu, &fitted, Some(loaded.materials));
        messages.extend(scaled);
        self.scene = Some(Loaded { materials, ..loaded });
        self.picture = None;
        self.gpu.check()?;
        Ok(messages)
    }

    fn set_light(&mut self, light: &Illumination, lighting: &Arc<SceneLighting>) -> Result<Vec<String>, BackendError> {
        let known = self.light.as_ref().is_some_and(|(_, e)| Arc::ptr_eq(e, &light.environment));
        self.light = Some((GpuLight::new(&self.gpu, light, lighting), light.environment.clone()));
        self.picture = None;
        self.gpu.check()?;
        let message = scaled_map(&light.environment, self.gpu.limits.max_texture_dimension_2d);
        Ok(message.filter(|_| !known).into_iter().collect())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.local = lighting.clone();
        self.picture = None;
        let radius = self.scene.as_ref().map_or(1.0, |loaded| 0.5 * loaded.scene.bounds.diagonal());
        if lighting.shown_vertex_irradiance().is_none() {
            self.bounce = VertexBounce::default();
        }
        let remark = self.local_lights.set(lighting.shown_lights().unwrap_or_default(), radius);
        self.gpu.check()?;
        Ok(remark.into_iter().collect())
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.picture = None;
        self.check_size(view.size)?;
        self.picture = Some(self.prepared(view, sampling));
        self.submit(|s, encoder| s.clear_sums(encoder))
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        if rows.is_empty() {
            return Ok(());
        }
        if rows.start == 0 {
            self.write_frame(sample);
        }
        self.submit(|s, encoder| {
            if rows.start == 0 {
                s.encode_visibility(encoder);
                s.encode_deferred(encoder);
            }
            s.encode_merge(encoder, sample, rows.clone());
        })?;
        if let Some(picture) = self.picture.as_mut().filter(|p| rows.end == p.view.size[1]) {
            picture.samples = sample + 1;
        }
        Ok(())
    }

    fn display(&mut self, post: &Post, samples: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        self.write_display(post, samples);
        self.submit(|s, encoder| s.encode_display(encoder, samples))?;
        Ok(bytemuck::pod_collect_to_vec(&readback::read(&self.gpu, &self.targets().shown)?))
    }

    fn read(&mut self, samples: u32) -> Result<(Image, Vec<f32>), BackendError> {
        let texels = self.read_floats(&self.targets().complete[(samples & 1) as usize].value)?;
        let scale = 1.0 / samples.max(1) as f32;
        let pixels = texels.iter().map(|t| glam::Vec3::new(t[0], t[1], t[2]) * scale).collect();
        let coverage = texels.iter().map(|t| t[3] * scale).collect();
        Ok((Image { size: self.targets().size, pixels }, coverage))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        let texels = self.read_floats(&self.targets().complete[(self.picture().samples & 1) as usize].work)?;
        let sum = |i: usize| texels.iter().map(|t| f64::from(t[i])).sum::<f64>();
        let shaded = sum(3);
        Ok(PictureStats {
            pixels_shaded: shaded as u64,
            mean_merged_nodes: sum(0) / shaded.max(1.0),
            mean_brdf_evaluations: sum(1) / shaded.max(1.0),
            shaded: Default::default(),
        })
    }
}
