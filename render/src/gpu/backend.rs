//! [`Backend`] on the GPU: resources by what changes them, and pictures made of passes.

mod encode;

use super::{
    device::{GpuDevice, Room},
    direct::{DirectLights, DirectPicture},
    layout,
    light::{GpuLight, GpuMap, GpuSources, scaled_map},
    materials::GpuMaterials,
    passes::{Passes, bind},
    readback,
    scene::GpuScene,
    shaders::ShaderSource,
    targets::{Sums, Target, Targets},
};
use crate::{
    BrdfSampling, Illumination, LocalLighting, Post, SceneLighting, View, ViewMode,
    appearance::Appearance,
    backend::{Backend, BackendError, PictureStats},
    baked::Baked,
    compare::map::magma_stops,
    view::Background,
};
use glam::Vec2;
use lapidary_core::{dataset::Dataset, environment::Environment, image::Image};
use std::{
    ops::Range,
    sync::Arc,
    time::{Duration, Instant},
};
use wgpu::util::DeviceExt;

/// Said where the meshless solution is asked for.
const NO_VERTEX_IRRADIANCE: &str = "the graphics adapter shows no meshless bounce; choose cuts or cuts+meshless, or the \
                                    CPU renderer";

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

/// The picture that is being made.
struct Picture {
    view: View,
    sampling: BrdfSampling,
    offsets: Vec<Vec2>,
    count_top: f32,
    groups: Groups,
    /// Local lights, if they are seen.
    direct: Option<DirectPicture>,
    /// How many samples are complete.
    samples: u32,
}

/// Everything the passes of a picture read.
struct Groups {
    frame: wgpu::BindGroup,
    scene: wgpu::BindGroup,
    materials: wgpu::BindGroup,
    light: wgpu::BindGroup,
    triangle: wgpu::BindGroup,
    geometry: wgpu::BindGroup,
    /// Surface sources, if their light is shown.
    sources: Option<wgpu::BindGroup>,
    /// By which of the sums is read.
    merge_complete: [wgpu::BindGroup; 2],
    merge_partial: [wgpu::BindGroup; 2],
    display: [wgpu::BindGroup; 2],
}

/// Wall-clock time of each pass of one sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct PassTimes {
    /// Rasterising triangle numbers and depth.
    pub visibility: Duration,
    /// Barycentric weights, frames and BRDF parameters.
    pub deferred: Duration,
    /// Local lights, and the merge.
    pub merge: Duration,
    /// The post pass.
    pub display: Duration,
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
            frame: uniform("frame", size_of::<layout::Frame>()),
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
            map: None,
            targets: None,
            picture: None,
        })
    }

    /// Renders one sample pass by pass, waiting for each, and says how long each took.
    ///
    /// # Errors
    /// A lost device.
    ///
    /// # Panics
    /// Before [`Backend::begin`].
    pub fn timed_sample(&mut self, sample: u32, post: &Post) -> Result<PassTimes, BackendError> {
        let height = self.picture().view.size[1];
        self.write_frame(sample);
        self.gpu.wait()?;
        self.write_display(post, sample + 1);
        Ok(PassTimes {
            visibility: self.timed(|s, encoder| s.encode_visibility(encoder))?,
            deferred: self.timed(|s, encoder| s.encode_deferred(encoder))?,
            merge: self.timed(|s, encoder| s.encode_merge(encoder, sample, 0..height))?,
            display: self.timed(|s, encoder| s.encode_display(encoder, sample + 1))?,
        })
    }

    fn timed(&mut self, encode: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder)) -> Result<Duration, BackendError> {
        let start = Instant::now();
        self.submit(encode)?;
        Ok(start.elapsed())
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

    fn groups(
        &self,
        loaded: &Loaded,
        light: &GpuLight,
        map: &wgpu::TextureView,
        targets: &Targets,
        direct: Option<&DirectPicture>,
    ) -> Groups {
        use wgpu::BindingResource::TextureView as View;
        let layouts = &self.passes.layouts;
        let group = |label, layout, resources: &[wgpu::BindingResource]| bind(&self.gpu, label, layout, resources);
        let (scene, materials) = (&loaded.scene, &loaded.materials);
        let merge = |from: &Sums, sum: Option<&wgpu::TextureView>| {
            let inputs = [
                View(&targets.geometry.view),
                View(&targets.rotation.view),
                View(&targets.color_roughness.view),
                View(&targets.others.view),
                View(sum.unwrap_or(&from.value.view)),
                View(&from.work.view),
                View(map),
            ];
            group("merge", &layouts.merge, &inputs)
        };
        let display = |from: &Sums| {
            let (sum, work) = (View(&from.value.view), View(&from.work.view));
            let inputs = [self.display.as_entire_binding(), self.magma.as_entire_binding(), sum, work];
            group("display", &layouts.display, &inputs)
        };
        let geometry = [scene.vertices.as_entire_binding(), scene.triangles.as_entire_binding()];
        let pool = View(&materials.pool.view);
        let look = [materials.buffer.as_entire_binding(), pool, materials.linear_from_srgb.as_entire_binding()];
        let lit = [
            light.nodes.as_entire_binding(),
            light.tan_half_radius.as_entire_binding(),
            View(&scene.cuts),
            View(&light.cut),
        ];
        Groups {
            frame: group("frame", &layouts.frame, &[self.frame.as_entire_binding()]),
            scene: group("scene", &layouts.scene, &geometry),
            materials: group("materials", &layouts.materials, &look),
            light: group("light", &layouts.light, &lit),
            triangle: group("triangle", &layouts.ids, &[View(&targets.triangle.view)]),
            geometry: group("geometry", &layouts.ids, &[View(&targets.geometry.view)]),
            sources: self.sources.as_ref().zip(scene.sources.as_ref()).map(|(lit, baked)| {
                // Radii of sources are seen from each point: there is no table of them.
                let tan_half_radius = light.tan_half_radius.as_entire_binding();
                let sent = [lit.nodes.as_entire_binding(), tan_half_radius, View(&baked.cuts), View(&lit.cut)];
                group("sources", &layouts.light, &sent)
            }),
            merge_complete: [0, 1].map(|i| merge(&targets.complete[i], direct.map(|direct| &direct.sum))),
            merge_partial: [0, 1].map(|i| merge(&targets.partial[i], None)),
            display: [display(&targets.complete[0]), display(&targets.complete[1])],
        }
    }

    fn prepare_direct(&mut self, mode: ViewMode) -> Option<DirectPicture> {
        self.local.shown_lights().filter(|_| mode == ViewMode::Shaded)?;
        let scene = &self.scene.as_ref()?.scene;
        self.local_lights.prepare(&self.gpu, &self.passes, scene, &self.frame, self.targets.as_ref()?)
    }

    /// Replaces the room for shadow maps, and forgets the lights.
    #[cfg(test)]
    pub(super) fn limit_shadows(&mut self, room: super::shadows::ShadowRoom) {
        self.local_lights = DirectLights::within(room);
    }

    /// What the deferred pass saw: the geometry texels of `geometry.wgsl`, for tests on the same buffers.
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
        self.local_lights.forget_shadows();
        (self.light, self.picture, self.sources) = (None, None, None);
        self.local = LocalLighting::default();
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
        let remark = self.local_lights.set(&lighting.lights);
        self.gpu.check()?;
        let vertices = lighting.shown_vertex_irradiance().map(|_| NO_VERTEX_IRRADIANCE.to_owned());
        Ok(remark.into_iter().chain(vertices).collect())
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.picture = None;
        let limit = u64::from(self.gpu.limits.max_texture_dimension_2d);
        let longest = u64::from(view.size[0].max(view.size[1]));
        self.gpu.within("the sides of the picture", "pixels", longest, limit, "render a smaller picture")?;
        let bytes = u64::from(view.size[0].next_multiple_of(256)) * u64::from(view.size[1]) * 16;
        let limit = self.gpu.limits.max_buffer_size;
        self.gpu.within("the pixels of the picture", "bytes", bytes, limit, "render a smaller picture")?;
        if self.targets.as_ref().is_none_or(|t| t.size != view.size) {
            // Freed first: two sets of a large picture may not fit.
            self.targets = None;
            self.targets = Some(Targets::new(&self.gpu, view.size));
        }
        let before = self.sources.take();
        self.sources = self.local.shown_indirect().map(|lighting| GpuSources::new(&self.gpu, lighting, before));
        let (light, environment) = self.light_or_dark();
        let blur = match view.background {
            Background::Blurred(width) => Some(width),
            _ => None,
        };
        self.map = Some(GpuMap::new(&self.gpu, &environment, blur, self.map.take()));
        let map = self.map.as_ref().map(|m| m.view.clone()).expect("it was just made");
        let direct = self.prepare_direct(view.mode);
        let groups = self.groups(self.loaded(), &light, &map, self.targets(), direct.as_ref());
        let count_top = view.mode.count_top(light.max_nodes);
        let offsets = view.pixel_offsets();
        self.picture = Some(Picture { view: view.clone(), sampling, offsets, count_top, groups, direct, samples: 0 });
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
        })
    }
}

impl GpuBackend {
    /// The environment if it is shown.
    fn shown_environment(&self) -> Option<&(GpuLight, Arc<Environment>)> {
        self.light.as_ref().filter(|_| self.local.components.environment)
    }

    /// The light, or none where there is none yet.
    fn light_or_dark(&self) -> (GpuLight, Arc<Environment>) {
        self.shown_environment().cloned().unwrap_or_else(|| {
            let map = Image::filled([1, 1], glam::Vec3::ZERO);
            let environment = Environment { name: String::new(), map };
            (GpuLight::dark(&self.gpu, self.loaded().scene.tree_height), environment.into())
        })
    }

    fn read_floats(&self, target: &Target) -> Result<Vec<[f32; 4]>, BackendError> {
        Ok(bytemuck::pod_collect_to_vec(&readback::read(&self.gpu, target)?))
    }
}
