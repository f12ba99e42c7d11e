//! The bounced light of a picture, by the passes that show it.

use crate::{
    device::{GpuDevice, pass::Pass},
    error::BackendError,
    gpu::{
        light::GpuSources, lit::LitKernels, meshless::GpuMeshless, passes::Passes, scene::GpuScene, wavelet::GpuPatches,
    },
    light::{
        bounce::{MeshlessLight, PatchLight, SourceLighting},
        implicit::{PosedLight, PosedLighting, Sides},
        local::LocalLighting,
        solver::BounceLight,
    },
    view::View,
    view_mode::ViewMode,
};
use std::sync::Arc;

/// Bounced light as it is shown, with what is uploaded of it.
#[derive(Default)]
pub struct GpuBounce {
    pub light: ShownBounce,
    /// As they were last shown.
    pub sources: Option<GpuSources>,
    pub functions: GpuMeshless,
    pub patches: GpuPatches,
}

impl GpuBounce {
    /// Other bounced light. Nothing is uploaded yet.
    pub fn set(&mut self, light: ShownBounce) {
        self.light = light;
        if self.light.functions.is_none() {
            self.functions.forget_light();
        }
        if self.light.patches.is_none() {
            self.patches.forget_light();
        }
    }

    /// Uploads the light of sources, if it is shown.
    ///
    /// # Errors
    /// A lost device.
    pub fn upload(&mut self, gpu: &GpuDevice, kernels: &LitKernels, scene: &GpuScene) -> Result<(), BackendError> {
        let (before, shown) = (self.sources.take(), self.light.sources.as_ref().zip(scene.sources.as_ref()));
        let make = |(lighting, baked)| GpuSources::new(gpu, kernels, baked, lighting, before);
        self.sources = shown.map(make).transpose()?;
        Ok(())
    }

    /// The pass that evaluates bounced light at every pixel, and what it reads, if there is any to show.
    ///
    /// # Errors
    /// Light beyond the adapter's limits.
    pub fn evaluated(
        &mut self,
        gpu: &GpuDevice,
        passes: &Passes,
        view: &View,
    ) -> Result<Option<(Pass, wgpu::BindGroup)>, BackendError> {
        let shaded = view.mode == ViewMode::Shaded;
        if let Some(light) = self.light.functions.as_ref().filter(|_| shaded || view.mode.is_of_basis()) {
            return Ok(Some((passes.meshless.clone(), self.functions.bound(gpu, light, view.basis)?)));
        }
        if let Some(light) = self.light.patches.as_ref().filter(|_| shaded) {
            return Ok(Some((passes.wavelet.clone(), self.patches.bound(gpu, light)?)));
        }
        let is_of_vertices = shaded && self.light.is_of_vertices;
        Ok(is_of_vertices.then(|| (passes.meshless.clone(), GpuMeshless::without_functions(gpu))))
    }
}

/// Bounced light as the passes show it.
#[derive(Default)]
pub struct ShownBounce {
    /// Gathered in the merge.
    pub sources: Option<Arc<SourceLighting>>,
    /// Evaluated in a pass of their own.
    pub functions: Option<Arc<MeshlessLight>>,
    /// Evaluated likewise.
    pub patches: Option<Arc<PatchLight>>,
    /// Whether there is only light of vertices, which else the other passes add.
    pub is_of_vertices: bool,
    /// Light of vertices: what posed objects change, and in its bounces those as baked that are of vertices too.
    pub posed: Option<Arc<PosedLighting>>,
}

impl ShownBounce {
    /// That of a picture.
    pub fn of(local: &LocalLighting) -> Self {
        let none = Self { posed: local.posed.clone(), ..Self::default() };
        match local.shown_bounce() {
            Some(BounceLight::Sources(lighting)) => Self { sources: Some(lighting.clone()), ..none },
            Some(BounceLight::Functions(light)) => Self { functions: Some(light.clone()), ..none },
            Some(BounceLight::Patches(light)) => Self { patches: Some(light.clone()), ..none },
            Some(BounceLight::Vertices(sides)) => {
                let posed = with_bounce(local.posed.as_deref().map(PosedLighting::known), sides);
                Self { is_of_vertices: true, posed: Some(PosedLighting::OnCores(posed).into()), ..none }
            }
            None => Self { is_of_vertices: local.posed.is_some() && local.components.indirect, ..none },
        }
    }
}

/// Adds bounced light as baked to vertices that have not moved.
fn with_bounce(posed: Option<&PosedLight>, as_baked: &Sides) -> PosedLight {
    let mut sum = posed.cloned().unwrap_or_else(|| PosedLight::as_baked(as_baked.front.len()));
    for (sums, side) in [(&mut sum.bounce.front, &as_baked.front), (&mut sum.bounce.back, &as_baked.back)] {
        let stays = sums.iter_mut().zip(side).zip(&*sum.is_moved).filter(|(_, moved)| !**moved);
        stays.for_each(|((sum, as_baked), _)| *sum += *as_baked);
    }
    sum
}
