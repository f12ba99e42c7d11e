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
mod cut_light;
mod direct;
mod display;
mod error_split;
mod explain;
mod frame;
pub mod gpu;
mod indirect;
mod lighting;
mod local_rig;
mod look;
mod node_field;
mod painter;
mod path;
mod picture;
mod post;
mod predicted;
mod refine;
mod region;
mod renderer;
mod samples;
mod shade;
mod surface;
mod surface_layers;
#[cfg(any(test, feature = "test-scenes"))]
pub mod test_scenes;
mod view;
mod view_mode;
mod wireframe;

pub use appearance::Appearance;
pub use backend::{Backend, BackendError, PictureStats};
pub use baked::Baked;
pub use buried::is_buried;
pub use components::{Bounces, Components, Solution};
pub use cpu::{CPU, CpuBackend};
pub use cut_light::{CutLight, GatheredLight, NoCuts, TreeOf};
pub use display::display_pixel;
pub use error_split::{ErrorSplit, SplitError, SplitJob, SplitPicture, SplitStep, TraceVertex};
pub use explain::{CutMap, ExplainError, ExplainedNode, ExplainedVertex, PixelExplanation};
pub use indirect::{SourceLighting, SourceRig};
pub use lapidary_core::image::{Region, RegionError};
pub use lighting::{LightRig, LocalLighting, SceneLighting};
pub use local_rig::LocalRig;
pub use look::{Look, same_light};
pub use path::{PathPicture, PathSettings, Places};
pub use post::{Post, ToneMap};
pub use predicted::{Bin, Calibration, CalibrationError, PredictedError, calibrate, predicted_error};
pub use refine::Refinement;
pub use renderer::{BrdfSampling, Illumination, RenderStats, Renderer};
pub use samples::SampledLight;
pub use surface_layers::{NO_SURFACE, SurfaceLayers};
pub use view::{Background, Preview, Progress, Quiet, View};
pub use view_mode::{ViewMode, shows_source_cuts};
