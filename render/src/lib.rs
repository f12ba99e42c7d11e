//! Dataset, lighting, materials and camera to image.
//!
//! [`Renderer::render`] merges cuts on the CPU (paper, 4.2); [`Renderer::samples_reference`] and
//! [`Renderer::path_reference`] trace rays instead, to see what the cuts lose and what the light samples lose.
//! All three sample the pixel and look up the surface by the same code, so that edges and textures do not count as
//! error. [`compare`] measures pictures.

mod appearance;
mod backend;
mod background;
mod baked;
mod buried;
pub mod compare;
mod components;
mod cpu;
mod direct;
mod display;
mod frame;
pub mod gpu;
mod indirect;
mod lighting;
mod local_rig;
mod node_field;
mod painter;
mod path;
mod picture;
mod post;
mod refine;
mod renderer;
mod samples;
mod shade;
mod surface;
mod surface_layers;
mod view;
mod view_mode;
mod wireframe;

pub use appearance::Appearance;
pub use backend::{Backend, BackendError, PictureStats};
pub use baked::Baked;
pub use buried::is_buried;
pub use components::{Components, Solution};
pub use cpu::{CPU, CpuBackend};
pub use display::display_pixel;
pub use indirect::{SourceLighting, SourceRig};
pub use lighting::{LightRig, LocalLighting, SceneLighting};
pub use local_rig::LocalRig;
pub use path::PathSettings;
pub use post::{Post, ToneMap};
pub use refine::Refinement;
pub use renderer::{BrdfSampling, Illumination, RenderStats, Renderer};
pub use surface_layers::{NO_SURFACE, SurfaceLayers};
pub use view::{Background, Progress, Quiet, View};
pub use view_mode::{ViewMode, shows_source_cuts};
