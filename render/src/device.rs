//! The graphics device, and what computes on it without a picture: kernels, rays, implicit visibility, meshless radiosity. Within
//! WebGPU's default limits and without optional features.

mod adapter;
mod bindings;
mod boundaries;
mod box_hierarchy;
mod buffers;
mod cache;
mod compute;
mod fans;
mod implicit;
mod kernel;
pub(crate) mod kernels;
pub(crate) mod layout;
mod model_kernel;
mod models;
pub(crate) mod output;
mod pace;
pub(crate) mod pass;
mod radiosity;
mod rays;
pub(crate) mod readback;
pub(crate) mod shaders;
mod shadow_rays;
mod tables;
#[cfg(test)]
pub(crate) mod test_adapter;
mod written;

pub(crate) use adapter::{GpuDevice, is_emulated};
pub use adapter::{Room, has_hardware};
pub(crate) use bindings::{Binding, Bound, GroupLayout, Shaders, bind_groups, bound};
pub(crate) use box_hierarchy::BoxHierarchy;
pub(crate) use buffers::{storage, uniform, written};
pub use compute::{AdapterFacts, Compute, SharedDevice};
pub(crate) use fans::GpuFans;
pub(crate) use implicit::{
    CutRequest, CutTables, GlossRequest, GlossTable, LeafLobes, LeavesBeside, VertexPlanes, VertexRequest,
};
pub use implicit::{DeviceCuts, ForestTimes, GpuForest, GpuImplicit, SeenLight};
pub(crate) use kernel::Kernel;
pub(crate) use models::ModelSet;
pub(crate) use radiosity::GpuRadiosity;
pub use rays::GpuRays;
pub use shaders::ShaderSource;
pub(crate) use shadow_rays::{GpuShadowRays, ShadowRay};
pub(crate) use tables::tables;
