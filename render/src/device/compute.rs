//! What computes beside the picture.

use super::{
    adapter::{GpuDevice, Room, has_hardware, is_emulated},
    bindings::{GroupLayout, Shaders},
    box_hierarchy::{BoxHierarchies, BoxHierarchy},
    kernel::{Kernel, ray_pipeline},
    kernels::{IMPLICIT_GLOSS, KernelProgram},
    model_kernel::ModelKernel,
    models::ModelSet,
    pass::Texts,
    shaders::Program,
};
use crate::error::BackendError;
use lapidary_core::ray::Intersector;
use serde::Serialize;
use std::{
    collections::HashMap,
    fmt,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

/// The cores of this machine, or the one graphics device that pictures, rays and light share.
#[derive(Clone)]
pub enum Compute {
    /// The cores.
    Cores,
    /// The device.
    Device(SharedDevice),
}

/// A graphics device, and the kernels and passes that were compiled on it. Copies share all.
#[derive(Clone)]
pub struct SharedDevice {
    pub(crate) gpu: Arc<GpuDevice>,
    kernels: Arc<Mutex<Kernels>>,
    /// By names of programs.
    rays: Arc<Mutex<HashMap<&'static str, wgpu::ComputePipeline>>>,
    gloss: ModelKernel,
    hierarchies: BoxHierarchies,
    /// Of passes.
    pub(crate) texts: Texts,
}

/// Kernels by their texts and values of constants.
type Kernels = HashMap<(String, Vec<u64>), Arc<Kernel>>;

/// An adapter, for reports.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterFacts {
    /// Its name.
    pub name: String,
    /// Whether it is a card, part of the processor, or emulated.
    pub kind: String,
    /// Name and version.
    pub driver: String,
    /// Vulkan, Metal, Dx12 or Gl.
    pub interface: String,
    /// Most bytes of a storage buffer.
    pub max_storage_bytes: u64,
    /// Most texels along the side of a texture.
    pub max_texture_side: u32,
}

impl fmt::Debug for Compute {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Cores => f.write_str("Cores"),
            Self::Device(device) => f.debug_tuple("Device").field(&device.name()).finish(),
        }
    }
}

impl Compute {
    /// The fastest adapter.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses.
    pub fn on_adapter(room: Room) -> Result<Self, BackendError> {
        Ok(Self::Device(SharedDevice::new(room)?))
    }

    /// The fastest adapter that is more than an emulation on the processor; the cores if there is none that works.
    pub fn of_hardware() -> Self {
        let device = has_hardware().then(|| SharedDevice::new(Room::All).ok()).flatten();
        device.map_or(Self::Cores, Self::Device)
    }

    /// Whether both are the cores, or the same device.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Device(one), Self::Device(other)) => Arc::ptr_eq(&one.gpu, &other.gpu),
            (one, other) => matches!((one, other), (Self::Cores, Self::Cores)),
        }
    }

    /// The cores in place of a device that is emulated on them.
    pub(crate) fn unless_emulated(device: &SharedDevice) -> Self {
        if device.is_emulated() { Self::Cores } else { Self::Device(device.clone()) }
    }
}

impl SharedDevice {
    /// On the fastest adapter.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses.
    pub fn new(room: Room) -> Result<Self, BackendError> {
        Self::with_cache(room, None)
    }

    /// The same, with compiled pipelines from a folder.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_cache(room: Room, folder: Option<&Path>) -> Result<Self, BackendError> {
        Ok(Self {
            gpu: GpuDevice::with_cache(room, folder)?.into(),
            kernels: Arc::default(),
            rays: Arc::default(),
            gloss: ModelKernel::new(IMPLICIT_GLOSS),
            hierarchies: BoxHierarchies::default(),
            texts: Texts::default(),
        })
    }

    /// Whether its adapter computes on the processor: the CPU renderer is faster then.
    pub fn is_emulated(&self) -> bool {
        is_emulated(&self.gpu.info)
    }

    /// What is known of its adapter.
    pub fn facts(&self) -> AdapterFacts {
        let wgpu::AdapterInfo { name, device_type, driver, driver_info, backend, .. } = &self.gpu.info;
        let limits = &self.gpu.limits;
        AdapterFacts {
            name: name.clone(),
            kind: format!("{device_type:?}"),
            driver: format!("{driver} {driver_info}").trim().into(),
            interface: backend.to_string(),
            max_storage_bytes: self.gpu.max_storage_bytes(),
            max_texture_side: limits.max_texture_dimension_2d,
        }
    }

    /// Bytes of its memory that this program holds, where the driver's interface tells.
    pub fn allocated_bytes(&self) -> Option<u64> {
        self.gpu.device.generate_allocator_report().map(|report| report.total_allocated_bytes)
    }

    /// The name of the adapter.
    pub fn name(&self) -> &str {
        &self.gpu.info.name
    }

    /// A kernel, which is compiled at its first use.
    ///
    /// # Errors
    /// A shader that does not compile, or a lost device.
    pub(crate) fn kernel(&self, program: &KernelProgram) -> Result<Arc<Kernel>, BackendError> {
        self.kernel_from(&Shaders::default(), program, &[])
    }

    /// The same from other shaders, with values of its specialization constants.
    ///
    /// # Errors
    /// As [`Self::kernel`].
    pub(crate) fn kernel_from(
        &self,
        shaders: &Shaders,
        program: &KernelProgram,
        constants: &[(&str, f64)],
    ) -> Result<Arc<Kernel>, BackendError> {
        // Those of a folder are being edited, and would pile up.
        if shaders.source.is_edited() {
            return Ok(Kernel::new(&self.gpu, shaders, program, constants)?.into());
        }
        let values = constants.iter().map(|(_, value)| value.to_bits());
        let key = (shaders.text(&program.program)?, values.collect());
        let mut kernels = self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kernels.get(&key) {
            return Ok(known.clone());
        }
        let made = Arc::new(Kernel::new(&self.gpu, shaders, program, constants)?);
        kernels.insert(key, made.clone());
        Ok(made)
    }

    /// The hierarchy of a scene, which is uploaded once for all that use it.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for, or a lost device.
    pub(crate) fn hierarchy(&self, scene: &Intersector) -> Result<Arc<BoxHierarchy>, BackendError> {
        self.hierarchies.get(&self.gpu, scene)
    }

    /// What glossy leaves reflect, for a scene with some models; `None` while another thread compiles it.
    pub(crate) fn gloss_kernel(&self, models: &ModelSet) -> Option<Arc<Kernel>> {
        self.gloss.get(&self.gpu, models)
    }

    /// The pipeline of a program of rays with its work, which is compiled at its first use.
    ///
    /// # Errors
    /// A shader that does not compile, or a lost device.
    pub(crate) fn ray_pipeline(
        &self,
        program: &Program,
        work: &GroupLayout,
    ) -> Result<wgpu::ComputePipeline, BackendError> {
        let mut known = self.rays.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.get(program.name) {
            return Ok(known.clone());
        }
        let made = ray_pipeline(&self.gpu, program, work)?;
        known.insert(program.name, made.clone());
        Ok(made)
    }
}
