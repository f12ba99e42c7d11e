//! The pipelines: built once from the shaders, with variants of the merge for the needs of scene and view mode.

use super::{
    direct::DirectPasses,
    lit::LitPass,
    meshless::MeshlessPass,
    pipeline::{Layouts, Pipeline, layouts},
    targets::format,
};
use crate::{
    device::{
        GpuDevice, Shaders, module,
        shaders::{DISPLAY, HISTORY, KEEP, MARKS, MERGE, PARAMETERS, PREDICT, SKETCH, SURFACE, VISIBILITY},
    },
    error::BackendError,
};
use std::collections::HashMap;

/// Specialisation of the merge pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MergeVariant {
    /// Which tree of lights is merged, one of the constants `FIELD_...`.
    pub field: u32,
    /// Whether it renders the first part of the light.
    pub is_first: bool,
    pub refine: bool,
    pub lit: bool,
    /// Whether sharp lobes may read the map.
    pub mirrors: bool,
}

/// All pipelines.
pub struct Passes {
    pub layouts: Layouts,
    pub visibility: wgpu::RenderPipeline,
    pub surface: wgpu::RenderPipeline,
    pub parameters: wgpu::RenderPipeline,
    pub marks: wgpu::RenderPipeline,
    pub keep: wgpu::RenderPipeline,
    pub display: wgpu::RenderPipeline,
    /// For the first part of the light and the others.
    pub sketch: [wgpu::RenderPipeline; 2],
    /// Keep a picture for the next one, and find its pixels in that.
    pub history: wgpu::RenderPipeline,
    pub predict: wgpu::RenderPipeline,
    pub direct: DirectPasses,
    pub meshless: MeshlessPass,
    pub lit: LitPass,
    merge_module: wgpu::ShaderModule,
    merge: HashMap<MergeVariant, wgpu::RenderPipeline>,
}

impl Passes {
    /// Builds the pipelines from `source`, the merge pass in `variants`.
    ///
    /// # Errors
    /// A shader that cannot be read or does not compile, with the compiler's message.
    pub fn new(gpu: &GpuDevice, shaders: &Shaders, variants: &[MergeVariant]) -> Result<Self, BackendError> {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut passes = Self::build(gpu, shaders);
        if let Ok(passes) = &mut passes {
            variants.iter().for_each(|&variant| drop(passes.merge(gpu, variant).clone()));
        }
        match pollster::block_on(scope.pop()) {
            None => passes,
            Some(error) => Err(BackendError::Driver(error.to_string())),
        }
    }

    fn build(gpu: &GpuDevice, shaders: &Shaders) -> Result<Self, BackendError> {
        let layouts = layouts(gpu);
        let l = &layouts;
        let load = |program| module(gpu, shaders, program);
        let visibility = Pipeline {
            depth: true,
            layouts: &[&l.frame, &l.scene],
            targets: &[format::TRIANGLE],
            constants: &[shaders.veils()],
            ..Pipeline::new(load(&VISIBILITY)?, "visibility")
        };
        let surface = Pipeline {
            layouts: &[&l.frame, &l.scene, &l.ids],
            targets: &[format::GEOMETRY, format::FLOATS],
            ..Pipeline::new(load(&SURFACE)?, "surface")
        };
        let parameters = Pipeline {
            layouts: &[&l.frame, &l.scene, &l.parameters],
            targets: &[format::FLOATS],
            ..Pipeline::new(load(&PARAMETERS)?, "parameters")
        };
        let marks = Pipeline {
            layouts: &[&l.frame, &l.scene, &l.patches, &l.marks],
            targets: &[format::MARKS],
            ..Pipeline::new(load(&MARKS)?, "marks")
        };
        let keep = Pipeline { layouts: &[&l.keep], targets: &format::SUMS, ..Pipeline::new(load(&KEEP)?, "kept sums") };
        let display =
            Pipeline { layouts: &[&l.display], targets: &[format::SHOWN], ..Pipeline::new(load(&DISPLAY)?, "display") };
        let sketch_module = load(&SKETCH)?;
        let sketch = [1.0, 0.0].map(|is_first| {
            let pipeline = Pipeline {
                layouts: &[&l.frame, &l.scene, &l.lattice, &l.merge],
                targets: &format::SUMS,
                constants: &[("IS_FIRST", is_first)],
                ..Pipeline::new(sketch_module.clone(), "sketch")
            };
            pipeline.build(gpu)
        });
        let history = Pipeline {
            layouts: &[&l.frame, &l.scene, &l.added, &l.merge],
            targets: &format::SUMS,
            ..Pipeline::new(load(&HISTORY)?, "history")
        };
        let predict = Pipeline {
            layouts: &[&l.frame, &l.scene, &l.past, &l.merge],
            targets: &[format::FLOATS],
            ..Pipeline::new(load(&PREDICT)?, "predict")
        };
        Ok(Self {
            visibility: visibility.build(gpu),
            surface: surface.build(gpu),
            parameters: parameters.build(gpu),
            marks: marks.build(gpu),
            keep: keep.build(gpu),
            display: display.build(gpu),
            sketch,
            history: history.build(gpu),
            predict: predict.build(gpu),
            direct: DirectPasses::new(gpu, shaders, &layouts)?,
            meshless: MeshlessPass::new(gpu, shaders, &layouts)?,
            lit: LitPass::new(gpu, shaders)?,
            merge_module: load(&MERGE)?,
            merge: HashMap::new(),
            layouts,
        })
    }

    /// The variants of the merge pass that are in use.
    pub fn variants(&self) -> Vec<MergeVariant> {
        self.merge.keys().copied().collect()
    }

    /// The merge pass for a variant, built at its first use.
    pub fn merge(&mut self, gpu: &GpuDevice, variant: MergeVariant) -> &wgpu::RenderPipeline {
        let (l, module) = (&self.layouts, &self.merge_module);
        self.merge.entry(variant).or_insert_with(|| {
            let flag = |name, on| (name, f64::from(u8::from(on)));
            let pipeline = Pipeline {
                layouts: &[&l.frame, &l.scene, &l.light, &l.merge],
                targets: &format::SUMS,
                constants: &[
                    ("FIELD", f64::from(variant.field)),
                    flag("IS_FIRST", variant.is_first),
                    flag("REFINE", variant.refine),
                    flag("LIT", variant.lit),
                    flag("MIRRORS", variant.mirrors),
                ],
                ..Pipeline::new(module.clone(), "merge")
            };
            pipeline.build(gpu)
        })
    }
}
