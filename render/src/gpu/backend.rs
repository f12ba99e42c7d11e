//! [`Backend`](crate::Backend) on the GPU: resources grouped by what changes them, and pictures made of passes.

mod bounce;
mod encode;
mod groups;
mod history;
mod interface;
mod picture;
mod timing;

pub use timing::PassTimes;

use super::{
    direct::DirectLights,
    light::{GpuLight, GpuMap, GpuSources},
    materials::GpuMaterials,
    meshless::GpuMeshless,
    passes::Passes,
    scene::GpuScene,
    shadows::Plan,
    targets::{Sums, Target, Targets},
};
use crate::{
    appearance::{Appearance, Assigned},
    device::{GpuDevice, ModelSet, Room, ShaderSource, Shaders, SharedDevice, is_emulated, layout, readback},
    error::BackendError,
    light::local::LocalLighting,
    measure::compare::map::magma_stops,
    sampling::BrdfSampling,
    stale::Part,
    summed::{DirectStep, Summed, SummedLights},
    view::View,
};
use bounce::ShownBounce;
use history::History;
use lapidary_core::{dataset::Dataset, environment::Environment, opacity::Opacities};
use picture::Picture;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// The renderer on one adapter.
pub struct GpuBackend {
    gpu: GpuDevice,
    /// The same, with the kernels of other work.
    device: SharedDevice,
    passes: Passes,
    shaders: Shaders,
    frame: wgpu::Buffer,
    display: wgpu::Buffer,
    magma: wgpu::Buffer,
    scene: Option<Loaded>,
    light: Option<(GpuLight, Arc<Environment>)>,
    local: LocalLighting,
    bounce: ShownBounce,
    /// Bounced light as it was last shown.
    sources: Option<GpuSources>,
    meshless: GpuMeshless,
    /// Stands in where no environment is shown; made for the scene.
    dark: Option<(GpuLight, Arc<Environment>)>,
    map: Option<GpuMap>,
    /// What the surfaces let through.
    opacities: Opacities,
    local_lights: DirectLights,
    targets: Option<Targets>,
    /// What is in the sums of the targets.
    state: Option<SumState>,
    /// `None` after any change, until it is begun or resumed.
    picture: Option<Picture>,
    /// The last picture, if nothing but camera and size has changed since.
    history: Option<History>,
}

/// Which picture the sums have.
struct SumState {
    summed: Summed,
    /// Shadow maps of the local lights in them.
    plan: Plan,
    /// Which of each part's textures holds the sums.
    front: usize,
    /// Samples of which the pixels know what they show.
    marked: u32,
    /// Which of the textures holds that.
    marks_front: usize,
}

/// A scene and how it looks.
struct Loaded {
    scene: GpuScene,
    /// The patch of each vertex, or a single one where nothing asks for them.
    patches: wgpu::Buffer,
    materials: GpuMaterials,
    /// The materials of its triangles.
    assigned: Assigned,
    dataset: Arc<Dataset>,
}

impl GpuBackend {
    /// On the fastest adapter.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses.
    pub fn new(room: Room, source: &ShaderSource) -> Result<Self, BackendError> {
        Self::on(SharedDevice::new(room)?, source)
    }

    /// On the fastest adapter, unless that computes on the processor: the CPU renderer is faster there.
    ///
    /// # Errors
    /// As [`Self::new`]; an emulated adapter counts as none.
    pub fn on_hardware(room: Room, source: &ShaderSource) -> Result<Self, BackendError> {
        let device = SharedDevice::new(room)?;
        if is_emulated(&device.gpu.info) {
            return Err(BackendError::NoAdapter { reason: format!("{} is emulated", device.name()) });
        }
        Self::on(device, source)
    }

    fn on(device: SharedDevice, source: &ShaderSource) -> Result<Self, BackendError> {
        let gpu = (*device.gpu).clone();
        let shaders = Shaders { source: source.clone(), ..Default::default() };
        let passes = Passes::new(&gpu, &shaders, &[])?;
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
            device,
            passes,
            shaders,
            scene: None,
            light: None,
            local: LocalLighting::default(),
            bounce: ShownBounce::default(),
            sources: None,
            meshless: GpuMeshless::default(),
            dark: None,
            map: None,
            opacities: Opacities::default(),
            targets: None,
            state: None,
            picture: None,
            history: None,
        })
    }

    /// Its device, for other work.
    pub fn device(&self) -> &SharedDevice {
        &self.device
    }

    /// Builds the passes anew if materials have other models, parts or maps than they are compiled for, or the first lets light
    /// through. Where others do so than before, shadows are rendered anew.
    fn compile_for(&mut self, appearance: &Appearance, is_new_scene: bool) -> Result<(), BackendError> {
        let (models, opacities) = (ModelSet::of(appearance), appearance.opacities());
        let mut has_veils = self.shaders.has_veils;
        let lets_through_otherwise = opacities != self.opacities;
        if lets_through_otherwise {
            has_veils = opacities.thin().iter().any(Option::is_some);
        }
        let compiled = &self.shaders.models;
        // What a material had before it may have again: edits add to what is compiled.
        let models = if is_new_scene { models } else { models.joined(compiled) };
        let fits = compiled.covers(&models) && models.covers(compiled);
        if !fits || has_veils != self.shaders.has_veils {
            let shaders = Shaders { models, has_veils, source: self.shaders.source.clone() };
            self.passes = Passes::new(&self.gpu, &shaders, &self.passes.variants())?;
            self.shaders = shaders;
            self.local_lights.forget_shadows();
        }
        if lets_through_otherwise {
            self.opacities = opacities;
            self.local_lights.forget_shadows();
        }
        Ok(())
    }

    fn submit(&mut self, encode: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder)) -> Result<(), BackendError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encode(self, &mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    /// The lights go with where their scene is, and with them what was said of them.
    fn forget_light(&mut self) {
        self.local_lights.set(&[], 1.0);
        (self.local, self.bounce) = (LocalLighting::default(), ShownBounce::default());
        (self.picture, self.state, self.history) = (None, None, None);
    }

    fn picture(&self) -> &Picture {
        self.picture.as_ref().expect("a picture is begun before it is rendered")
    }

    fn state(&self) -> &SumState {
        self.state.as_ref().expect("a picture is begun before it is rendered")
    }

    /// The other texture of each part has the sums now.
    fn flip(&mut self) {
        if let Some(state) = &mut self.state {
            state.front = 1 - state.front;
        }
    }

    /// Which of each part's textures is shown.
    fn shown(&self) -> usize {
        let front = self.state().front;
        if self.picture().lattices.filled { 1 - front } else { front }
    }

    /// What is rendered next, of a sample, writes over a sketch.
    fn leave_sketch(&mut self, sample: u32) {
        if let Some(picture) = &mut self.picture {
            (picture.lattices.filled, picture.seen) = (false, sample);
        }
    }

    /// All rows have a sample.
    fn sample_done(&mut self, sample: u32) {
        self.flip();
        if let Some(state) = &mut self.state {
            state.summed.complete = sample + 1;
        }
    }

    /// Replaces the local lights in the sums by those that shine now.
    fn step_lights(&mut self, lights: &mut SummedLights, before: Option<(&Plan, bool)>) -> DirectStep {
        let shown = self.local.shown_lights();
        let step = lights.update(&shown, before.is_some_and(|(_, complete)| complete));
        if self.local_lights.order(lights, before.map(|(plan, _)| plan)) || step == DirectStep::Anew {
            return step;
        }
        // With other shadow maps, a sum of lights is not what it was.
        *lights = SummedLights { direct: shown, added: Vec::new() };
        self.local_lights.order(lights, None);
        DirectStep::Anew
    }

    /// Begins a picture of which there is nothing yet.
    fn begin_anew(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        (self.picture, self.state) = (None, None);
        self.check_size(view.size)?;
        let mut summed = Summed::new(view, sampling);
        self.step_lights(&mut summed.lights, None);
        self.picture = Some(self.prepared(view, sampling)?);
        let plan = self.local_lights.plan().clone();
        self.state = Some(SumState { summed, plan, front: 0, marked: 0, marks_front: 0 });
        self.submit(|s, encoder| s.clear_all(encoder))
    }

    fn loaded(&self) -> &Loaded {
        self.scene.as_ref().expect("a picture is begun with a scene")
    }

    fn targets(&self) -> &Targets {
        self.targets.as_ref().expect("a picture is begun with targets")
    }

    fn read_texels<T: bytemuck::Pod>(&self, target: &Target) -> Result<Vec<[T; 4]>, BackendError> {
        Ok(bytemuck::pod_collect_to_vec(&readback::read(&self.gpu, &target.texture)?))
    }

    /// The sums of each part that the light has.
    fn sums(&self) -> impl Iterator<Item = (Part, &Sums)> {
        let front = self.shown();
        let parts = Part::ALL.into_iter().zip(&self.targets().parts);
        parts.filter_map(move |(part, sums)| Some((part, &sums.as_ref()?[front])))
    }

    /// Replaces the room for shadow maps, and forgets the lights.
    #[cfg(test)]
    pub(super) fn limit_shadows(&mut self, room: super::shadows::ShadowRoom) {
        self.local_lights = DirectLights::within(room);
    }

    /// Coefficients of the meshless basis, to see whether they were uploaded again.
    #[cfg(test)]
    pub(super) fn coefficients(&self) -> Option<&wgpu::Buffer> {
        self.meshless.coefficients()
    }

    /// Whether local lights take up textures.
    #[cfg(test)]
    pub(super) fn lights_take_room(&self) -> bool {
        self.local_lights.takes_room()
    }

    /// Output of the deferred pass: the geometry texels of `geometry.wgsl`, for tests on the same buffers.
    #[cfg(test)]
    pub(super) fn read_geometry(&self) -> Vec<[u32; 4]> {
        let bytes = readback::read(&self.gpu, &self.targets().geometry.texture).expect("the device is there");
        bytemuck::pod_collect_to_vec(&bytes)
    }
}
