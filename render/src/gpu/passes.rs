//! The passes as they are compiled: from their entries, with variants of the merge for the needs of scene and view mode.

use super::{
    entries::{
        DIRECT, DISPLAY, HISTORY, KEEP, MARKS, MERGE, MESHLESS, MIRROR_RAYS, MIRRORED_SURFACE, MIRRORS, PARAMETERS,
        PREDICT, SECOND_RAYS, SHADOW, SKETCH, SUNS, SURFACE, VISIBILITY, WAVELET,
    },
    lit::LitKernels,
};
use crate::{
    device::{
        Shaders, SharedDevice,
        pass::{Entry, GpuPath, Pass, Text, compile_now},
    },
    error::BackendError,
    shade::mirrors::DEEPEST,
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
    /// Whether vertices have light beside that of the tree, see [`PosedLight`](crate::light::implicit::PosedLight).
    pub posed: bool,
    /// Whether bump or normal maps bend shading normals.
    pub bent: bool,
}

impl MergeVariant {
    /// Values of the constants of [`MERGE`].
    fn values(self) -> [f64; 8] {
        let Self { field, is_first, refine, lit, mirrors, by_direction, posed, bent } = self;
        let [is_first, refine, lit, by_direction, posed, bent] =
            [is_first, refine, lit, by_direction, posed, bent].map(u32::from);
        [field, is_first, refine, lit, mirrors, by_direction, posed, bent].map(f64::from)
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
    pub lit: Arc<LitKernels>,
    merge: Arc<Text>,
    merges: HashMap<MergeVariant, Pass>,
    /// All but the merge.
    all: Vec<Pass>,
}

impl Passes {
    /// The passes from `shaders`; those that have a kernel run so on that path. What is compiled on the device already is taken.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn new(device: &SharedDevice, shaders: &Shaders, path: GpuPath) -> Result<Self, BackendError> {
        let text = |entry: &'static Entry| device.texts.of(&device.gpu, shaders, path, entry);
        let all = RefCell::new(Vec::new());
        let variant = |text: &Arc<Text>, values: &[f64]| {
            let pass = text.variant(values);
            all.borrow_mut().push(pass.clone());
            pass
        };
        let pass = |entry, values: &[f64]| Ok::<_, BackendError>(variant(&text(entry)?, values));
        let (has_veils, merge) = ([f64::from(shaders.has_veils)], text(&MERGE)?);
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
            lit: LitKernels::new(device, shaders)?.into(),
            merges: HashMap::new(),
            merge,
            all: all.into_inner(),
        })
    }

    /// All of them, and the merge in its variants.
    pub fn all(&self) -> impl Iterator<Item = &Pass> {
        self.all.iter().chain(self.merges.values())
    }

    /// Compiles all of them now.
    ///
    /// # Errors
    /// A shader that does not compile, with the compiler's message.
    pub fn compile(&self) -> Result<(), BackendError> {
        compile_now(self.all().cloned());
        check(self.all())
    }

    /// Those that a sample of a picture takes, by those of its light and of the light in its mirrors, and its display.
    pub fn of_picture(&self, light: [&[PartPass]; 1 + DEEPEST as usize]) -> Vec<Pass> {
        let Self { visibility, surface, parameters, marks, display, .. } = self;
        let [sharp, second] = &self.mirror_rays;
        let of_mirrors = [second, sharp, &self.mirrored_surface, &self.second_rays, &self.mirrors];
        let has_mirrors = !light[1].is_empty();
        let of_light = light.into_iter().flatten().flat_map(PartPass::passes);
        let seen = [visibility, surface, parameters, marks].into_iter();
        let all = of_light.chain(seen).chain(of_mirrors.into_iter().filter(|_| has_mirrors)).chain([display]);
        all.cloned().collect()
    }

    /// What is made of a sketch, and of a picture for the next.
    pub fn of_sketches(&self) -> impl Iterator<Item = &Pass> {
        self.sketch.iter().chain([&self.keep, &self.history, &self.predict])
    }

    /// What those that are compiled took for it, by their labels.
    pub fn compile_times(&self) -> Vec<(&'static str, Duration)> {
        self.all().filter_map(|pass| Some((pass.label, pass.compile_time()?))).collect()
    }

    /// Takes the variants of the merge that others have in use, if they are of the same text or are to be compiled anew at once.
    pub fn take_variants(&mut self, of: &Self, compiles_all: bool) {
        if !compiles_all && !Arc::ptr_eq(&self.merge, &of.merge) {
            return;
        }
        of.merges.keys().for_each(|&variant| drop(self.merge(variant)));
    }

    /// A variant of the merge.
    pub fn merge(&mut self, variant: MergeVariant) -> Pass {
        let Self { merge, merges, .. } = self;
        merges.entry(variant).or_insert_with(|| merge.variant(&variant.values())).clone()
    }
}

/// Waits for the compiler.
///
/// # Errors
/// What it says against a pass.
pub fn check<'a>(passes: impl Iterator<Item = &'a Pass>) -> Result<(), BackendError> {
    let message = |pass: &Pass| Some(format!("{} does not compile: {}", pass.label, pass.error()?));
    passes.filter_map(message).map(BackendError::Driver).next().map_or(Ok(()), Err)
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

impl PartPass {
    /// All that it takes.
    pub fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.suns.iter().map(|(rays, _)| rays).chain([&self.pass])
    }
}
