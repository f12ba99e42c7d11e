//! The pipelines: built once from the shaders, with variants of the merge for the needs of scene and view mode.

use super::{
    bounce::BouncePass,
    device::GpuDevice,
    direct::DirectPasses,
    shaders::{DISPLAY, MERGE, PARAMETERS, Program, SURFACE, ShaderSource, VISIBILITY},
    targets::format,
};
use crate::backend::BackendError;
use std::collections::HashMap;
use wgpu::{BindGroupLayout, ShaderStages as Stages};

/// Bind group layouts by what they hold.
pub struct Layouts {
    pub frame: BindGroupLayout,
    pub scene: BindGroupLayout,
    pub materials: BindGroupLayout,
    pub light: BindGroupLayout,
    /// One texture of unsigned integers.
    pub ids: BindGroupLayout,
    pub merge: BindGroupLayout,
    /// Passes before the merge.
    pub addition: BindGroupLayout,
    pub display: BindGroupLayout,
}

/// Specialisation of the merge pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MergeVariant {
    /// Which tree of lights is merged, one of the constants `FIELD_...`.
    pub field: u32,
    /// Whether it is the first pass of a sample.
    pub is_first: bool,
    pub refine: bool,
    pub has_ggx: bool,
    pub has_ward: bool,
}

/// All pipelines.
pub struct Passes {
    pub layouts: Layouts,
    pub visibility: wgpu::RenderPipeline,
    pub surface: wgpu::RenderPipeline,
    pub parameters: wgpu::RenderPipeline,
    pub display: wgpu::RenderPipeline,
    pub direct: DirectPasses,
    pub bounce: BouncePass,
    merge_module: wgpu::ShaderModule,
    merge: HashMap<MergeVariant, wgpu::RenderPipeline>,
}

impl Passes {
    /// Builds the pipelines from `source`, the merge pass in `variants`.
    ///
    /// # Errors
    /// A shader that cannot be read or does not compile, with the compiler's message.
    pub fn new(gpu: &GpuDevice, source: &ShaderSource, variants: &[MergeVariant]) -> Result<Self, BackendError> {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut passes = Self::build(gpu, source);
        if let Ok(passes) = &mut passes {
            variants.iter().for_each(|&variant| drop(passes.merge(gpu, variant).clone()));
        }
        match pollster::block_on(scope.pop()) {
            None => passes,
            Some(error) => Err(BackendError::Driver(error.to_string())),
        }
    }

    fn build(gpu: &GpuDevice, source: &ShaderSource) -> Result<Self, BackendError> {
        let layouts = layouts(gpu);
        let l = &layouts;
        let deferred = [&l.frame, &l.scene, &l.materials, &l.ids];
        let load = |program| module(gpu, source, program);
        let visibility = Pipeline {
            depth: true,
            layouts: &[&l.frame, &l.scene],
            targets: &[format::TRIANGLE],
            ..Pipeline::new(load(&VISIBILITY)?, "visibility")
        };
        let surface = Pipeline {
            layouts: &deferred,
            targets: &[format::GEOMETRY, format::FLOATS],
            ..Pipeline::new(load(&SURFACE)?, "surface")
        };
        let parameters = Pipeline {
            layouts: &deferred,
            targets: &[format::FLOATS, format::FLOATS],
            ..Pipeline::new(load(&PARAMETERS)?, "parameters")
        };
        let display =
            Pipeline { layouts: &[&l.display], targets: &[format::SHOWN], ..Pipeline::new(load(&DISPLAY)?, "display") };
        Ok(Self {
            visibility: visibility.build(gpu),
            surface: surface.build(gpu),
            parameters: parameters.build(gpu),
            display: display.build(gpu),
            direct: DirectPasses::new(gpu, source, &layouts)?,
            bounce: BouncePass::new(gpu, source, &layouts)?,
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
                targets: &[format::FLOATS, format::FLOATS],
                constants: &[
                    ("FIELD", f64::from(variant.field)),
                    flag("IS_FIRST", variant.is_first),
                    flag("REFINE", variant.refine),
                    flag("HAS_GGX", variant.has_ggx),
                    flag("HAS_WARD", variant.has_ward),
                ],
                ..Pipeline::new(module.clone(), "merge")
            };
            pipeline.build(gpu)
        })
    }
}

/// The compiled text of a program.
pub fn module(gpu: &GpuDevice, source: &ShaderSource, program: &Program) -> Result<wgpu::ShaderModule, BackendError> {
    let text = source.text(program).map_err(|e| BackendError::Driver(format!("shader {}: {e}", program.name)))?;
    Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(program.name),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    }))
}

/// Differences between pipelines.
pub struct Pipeline<'a> {
    pub module: wgpu::ShaderModule,
    pub label: &'static str,
    pub layouts: &'a [&'a BindGroupLayout],
    pub targets: &'a [wgpu::TextureFormat],
    pub constants: &'a [(&'a str, f64)],
    pub depth: bool,
}

impl<'a> Pipeline<'a> {
    pub fn new(module: wgpu::ShaderModule, label: &'static str) -> Self {
        Self { module, label, layouts: &[], targets: &[], constants: &[], depth: false }
    }

    pub fn build(&self, gpu: &GpuDevice) -> wgpu::RenderPipeline {
        let layouts: Vec<_> = self.layouts.iter().map(|&l| Some(l)).collect();
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let target = |&format: &wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        let targets: Vec<_> = self.targets.iter().map(target).collect();
        let options = wgpu::PipelineCompilationOptions { constants: self.constants, ..Default::default() };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            // Depth grows toward the eye and is 0 at infinity: floats are finest near 0.
            depth_stencil: self.depth.then(|| wgpu::DepthStencilState {
                format: format::DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fragment"),
                compilation_options: options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A kind of binding.
#[derive(Clone, Copy)]
pub enum Binding {
    Uniform,
    Storage,
    Uint,
    Float,
    DepthLayers,
}

fn layouts(gpu: &GpuDevice) -> Layouts {
    use Binding::{Float, Storage, Uint, Uniform};
    let layout = |label, bindings: &[Binding]| layout(gpu, label, bindings);
    Layouts {
        frame: layout("frame", &[Uniform]),
        scene: layout("scene", &[Storage, Storage]),
        materials: layout("materials", &[Storage, Uint, Uniform]),
        light: layout("light", &[Storage, Storage, Uint, Uint]),
        ids: layout("ids", &[Uint]),
        merge: layout("merge", &[Uint, Float, Float, Float, Float, Float, Float]),
        addition: layout("addition", &[Uint, Float, Float, Float, Float]),
        display: layout("display", &[Uniform, Uniform, Float, Float]),
    }
}

/// Bindings 0, 1, ... of these kinds.
pub fn layout(gpu: &GpuDevice, label: &str, bindings: &[Binding]) -> BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture_of =
        |sample_type, view_dimension| wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false };
    let texture = |sample_type| texture_of(sample_type, wgpu::TextureViewDimension::D2);
    let entry = |(binding, kind): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: Stages::VERTEX_FRAGMENT,
        ty: match kind {
            Binding::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Binding::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Binding::Uint => texture(wgpu::TextureSampleType::Uint),
            Binding::Float => texture(wgpu::TextureSampleType::Float { filterable: false }),
            Binding::DepthLayers => texture_of(wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array),
        },
        count: None,
    };
    let entries: Vec<_> = bindings.iter().enumerate().map(entry).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Resources at bindings 0, 1, ... of a layout.
pub fn bind(
    gpu: &GpuDevice,
    label: &str,
    layout: &BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let numbered = resources.iter().enumerate();
    let entries: Vec<_> = numbered
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
