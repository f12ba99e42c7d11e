//! Pipelines of passes that draw, built from their entries. What draws on one device shares them.

use super::{
    adapter::GpuDevice,
    bindings::{GroupLayout, Shaders, module_of},
    cache::PipelineCache,
    output::Output,
    shaders::Program,
};
use crate::error::BackendError;
use serde::{Deserialize, Serialize};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Mutex, OnceLock, PoisonError, Weak,
        atomic::{AtomicBool, Ordering::SeqCst},
    },
    thread,
    time::{Duration, Instant},
};
use wgpu::TextureFormat;

/// How passes run that have two entry points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GpuPath {
    /// A fragment for each pixel.
    #[default]
    Fragment,
    /// An invocation of a kernel for each.
    Compute,
}

/// A pass that draws.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub program: Program,
    /// What it reads: groups 0, 1, ...
    pub groups: &'static [GroupLayout],
    /// Formats of the textures that it writes, if its program has no [`Output`].
    pub targets: &'static [TextureFormat],
    /// Format of the depth in which it draws triangles; passes without one cover the picture.
    pub depth: Option<TextureFormat>,
    /// Specialization constants, which tell its variants apart. Without any there is one variant.
    pub constants: &'static [&'static str],
}

impl Entry {
    /// Over every pixel, in one variant.
    pub const fn new(name: &'static str, parts: [&'static [&'static str]; 2]) -> Self {
        Self { program: Program { name, parts, output: None }, groups: &[], targets: &[], depth: None, constants: &[] }
    }

    /// With a kernel beside its fragments.
    pub const fn writing(name: &'static str, parts: [&'static [&'static str]; 2], output: Output) -> Self {
        let drawing = Self::new(name, parts);
        Self { program: Program { output: Some(output), ..drawing.program }, ..drawing }
    }

    /// Formats of the textures that it writes.
    pub fn formats(&self) -> Vec<TextureFormat> {
        self.program.output.map_or(self.targets.to_vec(), |output| output.formats().collect())
    }
}

/// The texts of passes on a device, each once for all that draw with it. Copies share them.
#[derive(Clone, Default)]
pub struct Texts {
    known: Arc<Mutex<Vec<Weak<Text>>>>,
}

impl Texts {
    /// The text of a pass, which is a kernel on that path if it can be.
    ///
    /// # Errors
    /// A shader that cannot be read.
    pub fn of(
        &self,
        gpu: &GpuDevice,
        shaders: &Shaders,
        path: GpuPath,
        entry: &'static Entry,
    ) -> Result<Arc<Text>, BackendError> {
        let text = shaders.text(&entry.program)?;
        let mut all = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|known| known.strong_count() > 0);
        let name = entry.program.name;
        let is_same = |known: &Arc<Text>| (known.entry.program.name, known.path, &known.text) == (name, path, &text);
        if let Some(known) = all.iter().filter_map(Weak::upgrade).find(is_same) {
            return Ok(known);
        }
        let new = Arc::new(Text {
            entry,
            text,
            gpu: gpu.clone(),
            path,
            loops_end: shaders.loops_end(),
            variants: Mutex::default(),
            #[cfg(test)]
            kept: Mutex::default(),
            module: OnceLock::new(),
        });
        all.push(Arc::downgrade(&new));
        Ok(new)
    }
}

/// The text of a pass, of which variants are built.
pub struct Text {
    entry: &'static Entry,
    text: String,
    gpu: GpuDevice,
    path: GpuPath,
    /// See [`Shaders::loops_end`].
    loops_end: bool,
    /// Those in use.
    variants: Mutex<Vec<Weak<Variant>>>,
    /// Tests share a device, and what one has compiled stays for the next.
    #[cfg(test)]
    kept: Mutex<Vec<Arc<Variant>>>,
    /// With what the compiler says against it.
    module: OnceLock<(wgpu::ShaderModule, Option<String>)>,
}

/// One variant of a pass. It is compiled at its first use, or before by [`compile_soon`] or [`compile_now`]: most pictures use few of the passes.
#[derive(Clone)]
pub struct Pass {
    pub label: &'static str,
    variant: Arc<Variant>,
}

struct Variant {
    text: Arc<Text>,
    /// Of the constants of its entry.
    values: Vec<f64>,
    built: OnceLock<Built>,
    /// Whether another thread compiles it, or will.
    is_queued: AtomicBool,
    /// Whether a picture waits for it that was queued for no picture.
    is_hurried: AtomicBool,
    is_begun: AtomicBool,
    /// Whether that thread is done with it, be it by a panic.
    was_tried: AtomicBool,
}

/// What became of a variant.
struct Built {
    pipeline: Pipeline,
    /// What it took to compile.
    time: Duration,
    /// What the compiler said against it.
    error: Option<String>,
}

/// How a pass runs.
pub enum Pipeline {
    Fragments(wgpu::RenderPipeline),
    /// A kernel, and its group 0.
    Kernel(wgpu::ComputePipeline, Output),
}

impl Text {
    /// The variant with these values of the constants of its entry.
    pub fn variant(self: &Arc<Self>, values: &[f64]) -> Pass {
        let label = self.entry.program.name;
        debug_assert_eq!(self.entry.constants.len(), values.len(), "{label}");
        let mut all = self.variants.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|known| known.strong_count() > 0);
        let known = all.iter().filter_map(Weak::upgrade).find(|known| known.values == values);
        let variant = known.unwrap_or_else(|| {
            let new = Arc::new(Variant::new(self.clone(), values));
            all.push(Arc::downgrade(&new));
            #[cfg(test)]
            self.kept.lock().unwrap_or_else(PoisonError::into_inner).push(new.clone());
            new
        });
        Pass { label, variant }
    }

    fn compiled(&self) -> wgpu::ShaderModule {
        module_of(&self.gpu, self.entry.program.name, &self.text, self.loops_end)
    }

    fn module(&self) -> &(wgpu::ShaderModule, Option<String>) {
        self.module.get_or_init(|| told(&self.gpu.device, || self.compiled()))
    }
}

impl Pass {
    /// Its pipeline, after it is compiled.
    pub fn pipeline(&self) -> &Pipeline {
        &self.built().pipeline
    }

    /// What the compiler says against it.
    pub fn error(&self) -> Option<&str> {
        self.built().error.as_deref()
    }

    /// Whether [`Self::pipeline`] does not wait for a compiler; false for one that [`compile_soon`] was not told of.
    pub fn is_compiled(&self) -> bool {
        self.variant.built.get().is_some() || self.variant.was_tried.load(SeqCst)
    }

    /// What it took to compile, if it is.
    pub fn compile_time(&self) -> Option<Duration> {
        self.variant.built.get().map(|built| built.time)
    }

    /// The device that it is compiled on.
    pub fn gpu(&self) -> &GpuDevice {
        &self.variant.text.gpu
    }

    fn built(&self) -> &Built {
        self.variant.built()
    }

    /// Whether nobody compiles it yet; somebody does from now on.
    fn take(&self) -> bool {
        !self.is_compiled() && !self.variant.is_queued.swap(true, SeqCst)
    }

    /// The same, though it may wait at the end of a queue.
    fn take_now(&self) -> bool {
        let (is_new, was_hurried) = (self.take(), self.variant.is_hurried.swap(true, SeqCst));
        is_new || !(was_hurried || self.variant.is_begun.load(SeqCst))
    }
}

/// Compiles passes on other threads. Those that nobody uses any more are left out.
pub fn compile_soon(passes: impl IntoIterator<Item = Pass>) {
    compile(passes.into_iter().filter(Pass::take));
}

/// The same for passes that a picture waits for: they do not wait for others.
pub fn compile_now(passes: impl IntoIterator<Item = Pass>) {
    compile(passes.into_iter().filter(Pass::take_now));
}

/// As many at once as there are cores, the first ones first.
fn compile(passes: impl Iterator<Item = Pass>) {
    let missing: Vec<Weak<Variant>> = passes.map(|pass| Arc::downgrade(&pass.variant)).collect();
    let threads = thread::available_parallelism().map_or(1, usize::from).min(missing.len());
    let queue = Arc::new(Mutex::new(missing.into_iter()));
    let spawns = || {
        let queue = queue.clone();
        thread::Builder::new().name("compile".into()).spawn(move || compile_all(&queue))
    };
    if (0..threads).filter(|_| spawns().is_ok()).count() == 0 {
        // Without a thread they are compiled at their first use.
        while let Some(variant) = next(&queue) {
            variant.was_tried.store(true, SeqCst);
        }
    }
}

/// Compiles what is in a queue. The last thread writes the cache.
fn compile_all(queue: &Arc<Mutex<std::vec::IntoIter<Weak<Variant>>>>) {
    let mut cache = None;
    while let Some(variant) = next(queue) {
        // The next use panics again, where somebody hears of it.
        let _ = catch_unwind(AssertUnwindSafe(|| variant.built().time));
        variant.was_tried.store(true, SeqCst);
        cache = variant.text.gpu.pipelines.clone();
    }
    if Arc::strong_count(queue) == 1 {
        cache.iter().for_each(PipelineCache::save);
    }
}

fn next(queue: &Mutex<std::vec::IntoIter<Weak<Variant>>>) -> Option<Arc<Variant>> {
    queue.lock().unwrap_or_else(PoisonError::into_inner).find_map(|variant| variant.upgrade())
}

impl Variant {
    fn new(text: Arc<Text>, values: &[f64]) -> Self {
        let [is_queued, is_hurried, is_begun, was_tried] = [(); 4].map(|()| AtomicBool::new(false));
        Self { text, values: values.to_vec(), built: OnceLock::new(), is_queued, is_hurried, is_begun, was_tried }
    }

    fn built(&self) -> &Built {
        self.built.get_or_init(|| self.build())
    }

    fn build(&self) -> Built {
        let start = Instant::now();
        self.is_begun.store(true, SeqCst);
        let of_module = self.text.module().1.clone();
        let (pipeline, error) = told(&self.text.gpu.device, || self.pipeline());
        Built { pipeline, time: start.elapsed(), error: of_module.or(error) }
    }

    fn pipeline(&self) -> Pipeline {
        let Text { entry, path, .. } = &*self.text;
        let constants: Vec<_> = entry.constants.iter().copied().zip(self.values.iter().copied()).collect();
        let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        match entry.program.output {
            Some(output) if *path == GpuPath::Compute => self.kernel(output, options),
            _ => Pipeline::Fragments(self.fragments(options)),
        }
    }

    fn layout(&self, groups: &[wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
        let groups: Vec<_> = groups.iter().map(Some).collect();
        self.text.gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.text.entry.program.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        })
    }

    fn kernel(&self, output: Output, compilation_options: wgpu::PipelineCompilationOptions) -> Pipeline {
        let (Text { gpu, entry, .. }, (module, _)) = (&*self.text, self.text.module());
        let groups: Vec<_> = [&output].into_iter().chain(&entry.groups[1..]).map(|group| group.on(gpu)).collect();
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry.program.name),
            layout: Some(&self.layout(&groups)),
            module,
            entry_point: Some("compute"),
            compilation_options,
            cache: gpu.pipeline_cache(),
        });
        Pipeline::Kernel(pipeline, output)
    }

    fn fragments(&self, compilation_options: wgpu::PipelineCompilationOptions) -> wgpu::RenderPipeline {
        let (Text { gpu, entry, .. }, (module, _)) = (&*self.text, self.text.module());
        let groups: Vec<_> = entry.groups.iter().map(|group| group.on(gpu)).collect();
        let target = |format: wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry.program.name),
            layout: Some(&self.layout(&groups)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: entry.depth.map(depth),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment"),
                compilation_options,
                targets: &entry.formats().into_iter().map(target).collect::<Vec<_>>(),
            }),
            multiview_mask: None,
            cache: gpu.pipeline_cache(),
        })
    }
}

/// What is made, and what the device says against it.
fn told<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> (T, Option<String>) {
    let kinds = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory];
    let scopes = kinds.map(|kind| device.push_error_scope(kind));
    let made = make();
    let errors: Vec<_> = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
    (made, errors.first().map(ToString::to_string))
}

/// Depth grows toward the eye and is 0 at infinity: floats are finest near 0.
fn depth(format: TextureFormat) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    }
}
