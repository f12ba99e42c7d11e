//! Compiled shaders, and what is bound to them. A bind group is declared once, by the names and kinds of its bindings: its layout and
//! the structure of what is bound follow. A test compares it with the shaders.

use super::{
    adapter::GpuDevice,
    models::ModelSet,
    shaders::{Program, ShaderSource},
};
use crate::error::BackendError;
use wgpu::{BindGroupLayout, BindingResource, ShaderStages as Stages};

/// Where the text of shaders comes from, and for which models it is compiled.
#[derive(Clone, Debug, Default)]
pub struct Shaders {
    pub source: ShaderSource,
    pub models: ModelSet,
    /// Whether any surface lets light through.
    pub has_veils: bool,
}

impl Shaders {
    /// Whether all loops end. Ours do: they walk cuts, lists, trees and queues of checked data forward, and look for free places where
    /// there are some. What users write may not, and drivers may take for unreachable what does not end.
    pub fn loops_end(&self) -> bool {
        matches!(self.source, ShaderSource::Embedded) && !self.models.has_written()
    }

    /// The text of a program.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn text(&self, program: &Program) -> Result<String, BackendError> {
        let text = self.source.text(program, &self.models);
        text.map_err(|e| BackendError::Driver(format!("shader {}: {e}", program.name)))
    }
}

/// A compiled text. Loops that are not known to end get a bound, beyond what any takes, which costs two registers each.
pub fn module_of(gpu: &GpuDevice, name: &str, text: &str, loops_end: bool) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(name), source: wgpu::ShaderSource::Wgsl(text.into()) };
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: !loops_end, ..Default::default() };
    // SAFETY: all checks but that of loops stay, and loops without it end.
    unsafe { gpu.device.create_shader_module_trusted(descriptor, checks) }
}

/// A kind of binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    Uniform,
    Storage,
    /// A buffer that a compute pass writes.
    Written,
    /// Textures that a compute pass writes.
    WrittenFloats,
    WrittenUints,
    Uint,
    Float,
    DepthLayers,
}

/// A bind group as shaders declare it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupLayout {
    pub name: &'static str,
    /// Names and kinds of the bindings 0, 1, ...
    pub bindings: &'static [(&'static str, Binding)],
}

impl GroupLayout {
    /// Of a group without bindings, before others that a program has.
    pub const EMPTY: Self = Self { name: "Nothing", bindings: &[] };

    /// The layout on a device, which has equal ones but once.
    pub fn on(&self, gpu: &GpuDevice) -> BindGroupLayout {
        let entry = |(index, (_, kind)): (usize, &(&str, Binding))| wgpu::BindGroupLayoutEntry {
            binding: index as u32,
            visibility: match kind {
                Binding::Written | Binding::WrittenFloats | Binding::WrittenUints => Stages::COMPUTE,
                _ => Stages::VERTEX_FRAGMENT | Stages::COMPUTE,
            },
            ty: kind.of_layout(),
            count: None,
        };
        let entries: Vec<_> = self.bindings.iter().enumerate().map(entry).collect();
        gpu.device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(self.name), entries: &entries })
    }

    /// Resources at its bindings.
    pub fn bind(&self, gpu: &GpuDevice, resources: &[BindingResource]) -> wgpu::BindGroup {
        let numbered = (0..).zip(resources.iter().cloned());
        let entries: Vec<_> = numbered.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.name),
            layout: &self.on(gpu),
            entries: &entries,
        })
    }
}

impl Binding {
    /// The format of a texture that is written.
    pub fn format(self) -> Option<wgpu::TextureFormat> {
        match self {
            Self::WrittenFloats => Some(wgpu::TextureFormat::Rgba32Float),
            Self::WrittenUints => Some(wgpu::TextureFormat::Rgba32Uint),
            _ => None,
        }
    }

    fn of_layout(self) -> wgpu::BindingType {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let plane = |sample_type| texture(sample_type, wgpu::TextureViewDimension::D2);
        match self {
            Self::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Self::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Self::Written => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
            Self::WrittenFloats | Self::WrittenUints => wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: self.format().expect("it is written"),
                view_dimension: wgpu::TextureViewDimension::D2,
            },
            Self::Uint => plane(wgpu::TextureSampleType::Uint),
            Self::Float => plane(wgpu::TextureSampleType::Float { filterable: false }),
            Self::DepthLayers => texture(wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array),
        }
    }
}

/// What a binding holds.
pub trait Bound {
    fn resource(&self) -> BindingResource<'_>;
}

impl Bound for wgpu::Buffer {
    fn resource(&self) -> BindingResource<'_> {
        self.as_entire_binding()
    }
}

impl Bound for wgpu::TextureView {
    fn resource(&self) -> BindingResource<'_> {
        BindingResource::TextureView(self)
    }
}

/// What is bound at a kind of binding.
macro_rules! bound {
    ($life:lifetime Uniform) => { &$life wgpu::Buffer };
    ($life:lifetime Storage) => { &$life wgpu::Buffer };
    ($life:lifetime Written) => { &$life wgpu::Buffer };
    ($life:lifetime Uint) => { &$life wgpu::TextureView };
    ($life:lifetime Float) => { &$life wgpu::TextureView };
    ($life:lifetime DepthLayers) => { &$life wgpu::TextureView };
}

/// Declares bind groups: a structure of what is bound, in the order of the bindings, with its layout.
macro_rules! bind_groups {
    ($($(#[$doc:meta])* $group:ident { $($binding:ident: $kind:ident),+ $(,)? })+) => {$(
        $(#[$doc])*
        pub struct $group<'a> {
            $(pub $binding: $crate::device::bound!('a $kind)),+
        }

        impl $group<'_> {
            /// Its names and kinds.
            pub const LAYOUT: $crate::device::GroupLayout = $crate::device::GroupLayout {
                name: stringify!($group),
                bindings: &[$((stringify!($binding), $crate::device::Binding::$kind)),+],
            };

            /// Binds it.
            pub fn bind(&self, gpu: &$crate::device::GpuDevice) -> wgpu::BindGroup {
                use $crate::device::Bound;
                Self::LAYOUT.bind(gpu, &[$(self.$binding.resource()),+])
            }
        }
    )+};
}

pub(crate) use {bind_groups, bound};
