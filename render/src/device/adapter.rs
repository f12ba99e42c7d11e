//! Adapter, device and their limits. This is the one place that states the needs of the renderer: WebGPU's default
//! limits and no optional feature. Where the adapter has more room, it is used, and where it hands out compiled pipelines, these are kept.

use super::cache::PipelineCache;
use crate::{error::BackendError, remedy::Remedy};
use std::{
    collections::HashMap,
    fmt,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread::ThreadId,
};

/// A device and its queue. Copies are of the same device.
#[derive(Clone)]
pub struct GpuDevice {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    pub info: wgpu::AdapterInfo,
    /// On disk.
    pub pipelines: Option<PipelineCache>,
    troubles: Arc<Mutex<Troubles>>,
}

/// Reports of the driver.
#[derive(Default)]
struct Troubles {
    /// Why the device is lost.
    lost: Option<String>,
    /// The first error of each thread since it asked: the driver tells it to the one whose call it was.
    errors: HashMap<ThreadId, String>,
}

impl fmt::Debug for GpuDevice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("GpuDevice").field(&self.info.name).finish()
    }
}

/// How much room to ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Room {
    /// As much as the adapter has.
    #[default]
    All,
    /// WebGPU's defaults: every conforming adapter has these.
    Defaults,
}

impl GpuDevice {
    /// The fastest adapter that will do.
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
        let adapter = fastest_adapter().map_err(|e| BackendError::NoAdapter { reason: e.to_string() })?;
        let limits = wanted_limits(&adapter.limits(), room);
        let features = folder.map_or(wgpu::Features::empty(), |_| adapter.features() & PipelineCache::FEATURES);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lapidary"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| BackendError::Driver(e.to_string()))?;
        let (troubles, info) = (Arc::default(), adapter.get_info());
        report_troubles(&device, &troubles);
        let pipelines = folder.and_then(|folder| PipelineCache::open(&device, &info, folder));
        Ok(Self { device, queue, limits, info, pipelines, troubles })
    }

    /// Whether both are of the same device.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.troubles, &other.troubles)
    }

    /// Waits for all submitted work.
    ///
    /// # Errors
    /// A lost device, or what the driver reported.
    pub fn wait(&self) -> Result<(), BackendError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map(|_| ()).map_err(|e| BackendError::Driver(e.to_string()))
    }

    /// Errors of this thread since its last call; the loss of the device at each.
    ///
    /// # Errors
    /// A lost device, or what the driver reported.
    pub fn check(&self) -> Result<(), BackendError> {
        let mut troubles = locked(&self.troubles);
        let error = troubles.errors.remove(&std::thread::current().id());
        match (&troubles.lost, error) {
            (Some(reason), _) => Err(BackendError::DeviceLost { reason: reason.clone() }),
            (None, Some(message)) => Err(BackendError::Driver(message)),
            (None, None) => Ok(()),
        }
    }

    /// An error if `needed` is more than the adapter allows.
    ///
    /// # Errors
    /// [`BackendError::Limit`] with both numbers.
    pub fn within(
        &self,
        what: &'static str,
        unit: &'static str,
        needed: u64,
        limit: u64,
        remedy: Remedy,
    ) -> Result<(), BackendError> {
        if needed <= limit {
            return Ok(());
        }
        Err(BackendError::Limit { what, needed, limit, unit, adapter: self.info.name.clone(), remedy })
    }

    /// Most bytes of one storage buffer.
    pub fn max_storage_bytes(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }
}

/// Whether the fastest adapter is more than an emulation on the processor.
pub fn has_hardware() -> bool {
    fastest_adapter().is_ok_and(|adapter| !is_emulated(&adapter.get_info()))
}

/// Whether an adapter computes on the processor.
pub fn is_emulated(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}

/// OpenGL only where there is nothing better.
fn fastest_adapter() -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    adapter(wgpu::Backends::PRIMARY).or_else(|_| adapter(wgpu::Backends::SECONDARY))
}

/// The fastest adapter of some kinds of drivers; the variable WGPU_BACKEND is respected.
fn adapter(backends: wgpu::Backends) -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor { backends, ..descriptor }.with_env());
    let options =
        wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    pollster::block_on(instance.request_adapter(&options))
}

/// WebGPU's defaults, with the adapter's room for textures and buffers on request.
fn wanted_limits(adapter: &wgpu::Limits, room: Room) -> wgpu::Limits {
    let defaults = wgpu::Limits::default();
    if room == Room::Defaults {
        return defaults;
    }
    wgpu::Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d.max(defaults.max_texture_dimension_2d),
        max_buffer_size: adapter.max_buffer_size.max(defaults.max_buffer_size),
        max_storage_buffer_binding_size: adapter
            .max_storage_buffer_binding_size
            .max(defaults.max_storage_buffer_binding_size),
        ..defaults
    }
}

fn locked(troubles: &Mutex<Troubles>) -> MutexGuard<'_, Troubles> {
    troubles.lock().unwrap_or_else(PoisonError::into_inner)
}

fn report_troubles(device: &wgpu::Device, troubles: &Arc<Mutex<Troubles>>) {
    let lost = troubles.clone();
    device.set_device_lost_callback(move |reason, message| {
        // Dropping the device is no loss.
        if reason != wgpu::DeviceLostReason::Destroyed {
            locked(&lost).lost = Some(message);
        }
    });
    let errors = troubles.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        locked(&errors).errors.entry(std::thread::current().id()).or_insert_with(|| error.to_string());
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_adapter::on_adapter;

    #[test]
    fn each_thread_is_told_its_own_errors() {
        let Some((_one_at_a_time, gpu)) = on_adapter(|| GpuDevice::new(Room::Defaults)) else { return };
        let fails = |gpu: &GpuDevice| {
            let size = 2 * gpu.limits.max_buffer_size;
            let usage = wgpu::BufferUsages::STORAGE;
            let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            });
        };
        let other = gpu.clone();
        let of_other = std::thread::spawn(move || {
            fails(&other);
            other.check()
        });
        assert!(matches!(of_other.join().unwrap(), Err(BackendError::Driver(_))));
        assert!(gpu.check().is_ok(), "the error of another thread");
        fails(&gpu);
        assert!(matches!(gpu.check(), Err(BackendError::Driver(_))), "negative control");
        assert!(gpu.check().is_ok(), "it is told once");
    }
}
