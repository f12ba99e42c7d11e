//! A kernel whose text depends on the models of a scene. Another thread compiles it.

use super::{adapter::GpuDevice, bindings::Shaders, kernel::Kernel, kernels::KernelProgram, models::ModelSet};
use std::{
    sync::{Arc, Mutex, OnceLock, PoisonError},
    thread,
};

/// The kernel for the models of the last scene. Copies share it.
#[derive(Clone)]
pub struct ModelKernel {
    program: KernelProgram,
    known: Arc<Mutex<Option<Known>>>,
}

/// What is compiled, or will be.
struct Known {
    models: ModelSet,
    /// `None` in it for a text that does not compile.
    kernel: Arc<OnceLock<Option<Arc<Kernel>>>>,
}

impl ModelKernel {
    /// Of a program; nothing is compiled yet.
    pub fn new(program: KernelProgram) -> Self {
        Self { program, known: Arc::default() }
    }

    /// The kernel for a scene with some models. `None` while it is being compiled, and where it does not compile.
    pub fn get(&self, gpu: &GpuDevice, models: &ModelSet) -> Option<Arc<Kernel>> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.as_ref().is_none_or(|known| !known.models.covers(models)) {
            let models = known.as_ref().map_or_else(|| models.clone(), |known| models.joined(&known.models));
            *known = Some(Known::compile(gpu, self.program, models));
        }
        known.as_ref()?.kernel.get()?.clone()
    }
}

impl Known {
    fn compile(gpu: &GpuDevice, program: KernelProgram, models: ModelSet) -> Self {
        let kernel = Arc::new(OnceLock::new());
        let (made, gpu, shaders) =
            (kernel.clone(), gpu.clone(), Shaders { models: models.clone(), ..Default::default() });
        let compile = move || made.set(Kernel::new(&gpu, &shaders, &program, &[]).ok().map(Arc::new)).is_ok();
        // Without a thread it is never there.
        let _ = thread::Builder::new().name("compile".into()).spawn(compile);
        Self { models, kernel }
    }
}
