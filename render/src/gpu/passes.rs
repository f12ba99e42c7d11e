//! The passes as they are compiled: from their entries, with variants of the merge for the needs of scene and view mode.

use super::{
    entries::{
        DIRECT, DISPLAY, Entry, HISTORY, KEEP, MARKS, MERGE, MESHLESS, MIRROR_RAYS, MIRRORED_SURFACE, MIRRORS,
        PARAMETERS, PREDICT, SECOND_RAYS, SHADOW, SKETCH, SUNS, SURFACE, VISIBILITY, WAVELET,
    },
    lit::LitKernels,
    pipeline::{GpuPath, Pass, Text},
};
use crate::{
    device::{GpuDevice, Shaders},
    error::BackendError,
    stale::LightPart,
};
use std::{cell::RefCell, collections::HashMap, sync::Arc, time::Duration};

/// Specialization of the merge pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MergeVariant {
    /// Which tree of lights is merged, one of the constants `FIELD_...`.
    pub field: u32,
    /// Whether it renders the first part of the light.
    pub is_first: bool,
    pub refine: bool,
    pub lit: bool,
    /// What sharp lobes do, one of the constants `MIRRORS_...` or `NO_MIRRORS`.
    pub mirrors: u32,
    /// Whether nodes send by direction.
    pub by_direction: bool,
}

impl MergeVariant {
    /// Values of the constants of [`MERGE`].
    fn values(self) -> [f64; 6] {
        let Self { field, is_first, refine, lit, mirrors, by_direction } = self;
        [field, is_first.into(), refine.into(), lit.into(), mirrors, by_direction.into()].map(f64::from)
    }
}

/// All passes.
pub struct Passes {
    pub visibility: Pass,
    pub surface: Pass,
    pub parameters: Pass,
    pub marks: Pass,
    pub shadow: Pass,
    pub suns: Pass,
    pub direct: Pass,
    pub meshless: Pass,
    pub wavelet: Pass,
    /// Rays of sharp lobes, and of wider ones.
    pub mirror_rays: [Pass; 2],
    pub second_rays: Pass,
    pub mirrored_surface: Pass,
    pub mirrors: Pass,
    pub keep: Pass,
    /// For the first part of the light and the others.
    pub sketch: [Pass; 2],
    pub history: Pass,
    pub predict: Pass,
    pub display: Pass,
    pub lit: LitKernels,
    merge: Arc<Text>,
    merges: HashMap<MergeVariant, Pass>,
    /// All but the merge.
    all: Vec<Pass>,
}

impl Passes {
    /// The passes from `shaders`; those that have a kernel run so on that path.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders, path: GpuPath) -> Result<Self, BackendError> {
        let text = |entry: &'static Entry| Text::new(gpu, shaders, path, entry);
        let all = RefCell::new(Vec::new());
        let variant = |text: &Arc<Text>, values: &[f64]| {
            let pass = text.variant(values);
            all.borrow_mut().push(pass.clone());
            pass
        };
        let pass = |entry, values: &[f64]| Ok::<_, BackendError>(variant(&text(entry)?, values));
        let has_veils = [f64::from(shaders.has_veils)];
        let [sketch, mirror_rays] = [text(&SKETCH)?, text(&MIRROR_RAYS)?];
        Ok(Self {
            visibility: pass(&VISIBILITY, &has_veils)?,
            surface: pass(&SURFACE, &[])?,
            parameters: pass(&PARAMETERS, &[])?,
            marks: pass(&MARKS, &[])?,
            shadow: pass(&SHADOW, &has_veils)?,
            suns: pass(&SUNS, &has_veils)?,
            direct: pass(&DIRECT, &[])?,
            meshless: pass(&MESHLESS, &[])?,
            wavelet: pass(&WAVELET, &[])?,
            mirror_rays: [0.0, 1.0].map(|is_second| variant(&mirror_rays, &[is_second])),
            second_rays: pass(&SECOND_RAYS, &[])?,
            mirrored_surface: pass(&MIRRORED_SURFACE, &has_veils)?,
            mirrors: pass(&MIRRORS, &[])?,
            keep: pass(&KEEP, &[])?,
            sketch: [1.0, 0.0].map(|is_first| variant(&sketch, &[is_first])),
            history: pass(&HISTORY, &[])?,
            predict: pass(&PREDICT, &[])?,
            display: pass(&DISPLAY, &[])?,
            lit: LitKernels::new(gpu, shaders)?,
            merge: text(&MERGE)?,
            merges: HashMap::new(),
            all: all.into_inner(),
        })
    }

    /// Compiles all of them now, and the merge in `variants`.
    ///
    /// # Errors
    /// A shader that does not compile, with the compiler's message.
    pub fn compile(&mut self, gpu: &GpuDevice, variants: &[MergeVariant]) -> Result<(), BackendError> {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let merges: Vec<Pass> = variants.iter().map(|&variant| self.merge(variant)).collect();
        for pass in self.all.iter().chain(&merges) {
            pass.pipeline();
        }
        match pollster::block_on(scope.pop()) {
            None => Ok(()),
            Some(error) => Err(BackendError::Driver(error.to_string())),
        }
    }

    /// What those that are compiled took for it, by their labels.
    pub fn compile_times(&self) -> Vec<(&'static str, Duration)> {
        let passes = self.all.iter().chain(self.merges.values());
        passes.filter_map(|pass| Some((pass.label, pass.compile_time()?))).collect()
    }

    /// The variants of the merge that are in use.
    pub fn variants(&self) -> Vec<MergeVariant> {
        self.merges.keys().copied().collect()
    }

    /// A variant of the merge.
    pub fn merge(&mut self, variant: MergeVariant) -> Pass {
        let Self { merge, merges, .. } = self;
        merges.entry(variant).or_insert_with(|| merge.variant(&variant.values())).clone()
    }
}

/// A pass of a picture that adds samples to the sums of a part of the light.
#[derive(Clone)]
pub struct PartPass {
    pub part: LightPart,
    pub pass: Pass,
    /// What it reads beside the frame, the scene, and the points to shade.
    pub light: wgpu::BindGroup,
    /// The pass of the rays to suns before it, and what that reads in place of the light.
    pub suns: Option<(Pass, wgpu::BindGroup)>,
}
