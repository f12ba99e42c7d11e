//! [`Backend`](crate::Backend) on the GPU: what draws, what it shows, and how far a picture of that is. Pictures are made of
//! passes.

mod bounce;
mod encode;
mod groups;
mod history;
mod interface;
mod mirrors;
mod picture;
mod pipelines;
mod progress;
mod shown;
mod timing;

pub use timing::PassTimes;

use super::targets::Target;
use crate::{
    appearance::Appearance,
    device::{GpuDevice, ModelSet, ShaderSource, Shaders, SharedDevice, pass::GpuPath, readback},
    error::BackendError,
    sampling::BrdfSampling,
    summed::Summed,
    view::View,
};
use pipelines::Pipelines;
use progress::{Progress, SumState};
use shown::Shown;

/// The renderer on one adapter.
pub struct GpuBackend {
    pipelines: Pipelines,
    shown: Shown,
    progress: Progress,
}

impl GpuBackend {
    /// On a device, with some shaders, whose passes run so if they have a kernel.
    ///
    /// # Errors
    /// A driver that refuses, or shaders of a folder that do not compile.
    pub fn new(device: SharedDevice, source: &ShaderSource, path: GpuPath) -> Result<Self, BackendError> {
        let pipelines = Pipelines::new(device, source, path)?;
        Ok(Self { shown: Shown::new(pipelines.gpu()), progress: Progress::default(), pipelines })
    }

    /// How its passes run that have a kernel.
    pub fn path(&self) -> GpuPath {
        self.pipelines.path
    }

    /// Takes another path. A picture is to be begun anew.
    ///
    /// # Errors
    /// A shader that cannot be read, or does not compile.
    pub fn set_path(&mut self, path: GpuPath) -> Result<(), BackendError> {
        self.pipelines.reload(path)?;
        self.shown.local_lights.forget_shadows();
        self.progress.forget();
        Ok(())
    }

    /// Its device, for other work.
    pub fn device(&self) -> &SharedDevice {
        &self.pipelines.device
    }

    /// Takes other passes if materials have other models, parts or maps than they are compiled for, or the first lets light
    /// through. Where others do so than before, shadows are rendered anew.
    fn compile_for(&mut self, appearance: &Appearance, is_new_scene: bool) -> Result<(), BackendError> {
        let Self { pipelines, shown, .. } = self;
        let Shaders { models: compiled, has_veils: had_veils, .. } = &pipelines.shaders;
        let (models, opacities, mut has_veils) = (ModelSet::of(appearance), appearance.opacities(), *had_veils);
        let lets_through_otherwise = opacities != shown.opacities;
        if lets_through_otherwise {
            has_veils = opacities.thin().iter().any(Option::is_some);
        }
        // What a material had before it may have again: edits add to what is compiled.
        let models = if is_new_scene { models } else { models.joined(compiled) };
        let fits = compiled.covers(&models) && models.covers(compiled);
        if !fits || has_veils != *had_veils {
            pipelines.specialize(models, has_veils)?;
            shown.local_lights.forget_shadows();
        }
        if lets_through_otherwise {
            shown.opacities = opacities;
            shown.local_lights.forget_shadows();
        }
        Ok(())
    }

    /// Begins a picture of which there is nothing yet.
    fn begin_anew(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        (self.progress.picture, self.progress.state) = (None, None);
        self.pipelines.check_size(view.size)?;
        let mut summed = Summed::new(view, sampling);
        self.shown.step_lights(&mut summed.lights, None);
        self.progress.picture = Some(self.prepared(view, sampling)?);
        self.progress.state = Some(SumState::new(summed, self.shown.local_lights.plan().clone()));
        self.pipelines.submit(|encoder| self.progress.clear_all(encoder))
    }

    /// Lights turned environments by kernels, be it on an emulated device.
    #[cfg(test)]
    pub(super) fn light_by_kernels(&mut self) {
        self.pipelines.light_by_kernels = true;
    }

    /// Replaces the room for shadow maps, and forgets the lights.
    #[cfg(test)]
    pub(super) fn limit_shadows(&mut self, room: super::shadows::ShadowRoom) {
        self.shown.local_lights = super::direct::DirectLights::within(room);
    }

    /// Coefficients of the meshless basis, to see whether they were uploaded again.
    #[cfg(test)]
    pub(super) fn coefficients(&self) -> Option<&wgpu::Buffer> {
        self.shown.bounce.functions.coefficients()
    }

    /// Whether local lights take up textures.
    #[cfg(test)]
    pub(super) fn lights_take_room(&self) -> bool {
        self.shown.local_lights.takes_room()
    }

    /// Output of the deferred pass: the geometry texels of `geometry.wgsl`, for tests on the same buffers.
    #[cfg(test)]
    pub(super) fn read_geometry(&self) -> Vec<[u32; 4]> {
        texels(self.pipelines.gpu(), &self.progress.targets().geometry).expect("the device is there")
    }
}

/// The texels of a target, row by row.
fn texels<T: bytemuck::Pod>(gpu: &GpuDevice, target: &Target) -> Result<Vec<T>, BackendError> {
    Ok(bytemuck::pod_collect_to_vec(&readback::read(gpu, &target.texture)?))
}
