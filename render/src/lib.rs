//! Renders images from dataset, lighting, materials and camera.
//!
//! A [`LitScene`] shows one [`Look`] after another by merging cuts (paper, 4.2). [`Renderer::samples_reference`] and
//! [`Renderer::path_reference`] trace rays instead: the first shows the error of the cuts, the second also the error of the light
//! samples. All three share the code for pixel samples and surface lookups, so edges and textures do not count as error.
//! [`compare`] measures pictures.
//!
//! | folder | contents |
//! |---|---|
//! | `shade/` | from a sample of a pixel to the light that its surface reflects: camera ray, surface point, merge of the cuts (4.2) |
//! | `light/` | the light of a picture: environment, local lights, bounced light (4.1) |
//! | `reference/` | pictures by rays instead of cuts: all light samples, light paths |
//! | `measure/` | metrics, and a picture's error explained, split into causes, predicted |
//! | `device/` | the graphics device, and what computes on it without a picture |
//! | `cpu/` | pictures on the cores of this machine |
//! | [`gpu`] | the same on a graphics adapter |

mod appearance;
mod backend;
mod backplate;
mod baked;
mod cpu;
mod device;
mod error;
pub mod gpu;
mod light;
mod lit_scene;
mod look;
mod measure;
mod post;
mod reference;
mod remedy;
mod renderer;
mod sampling;
mod shade;
mod sketch;
mod stale;
mod summed;
#[cfg(any(test, feature = "test-scenes"))]
pub mod test_looks;
#[cfg(test)]
mod test_scenes;
mod view;
mod view_mode;

pub use appearance::{Appearance, Assigned};
pub use backend::{Backend, BackendFactory, PictureStats, RenderStats, ShadedSamples, Tier};
pub use backplate::Backplate;
pub use baked::{Baked, Posing};
pub use cpu::{
    backend::{CPU, CpuBackend},
    display::display_pixel,
    surface_layers::{NO_SURFACE, SurfaceLayers},
};
pub use device::{DeviceCuts, SeenLight};
pub use error::BackendError;
pub use lapidary_core::image::{Region, RegionError};
pub use light::{
    bounce::{MeshlessLight, RadiosityRays, RadiosityRig, SourceLighting, SourceRig},
    buried::is_buried,
    components::Components,
    environment::{Distant, EnvironmentLight, Illumination, LightRig, SceneLighting},
    implicit::{
        Sides,
        detail::ImplicitDetail,
        seen::{CoreSight, LeafSight},
    },
    in_view::{lights_view, shows_light},
    local::{LocalLighting, LocalRig},
    situation::{Changes, Gathering, Relight, Situation},
    solver::{BounceLight, solutions::Solution},
    tree_light::TreeLight,
};
pub use lit_scene::{FinishedPicture, LitScene, ladder::Refined};
pub use look::{Look, Redo};
pub use measure::{
    compare,
    cut_light::{CutLight, GatheredLight, NoCuts, TreeOf},
    explain::{ExplainError, ExplainedNode, ExplainedSun, ExplainedVertex, PixelExplanation, cut_map::CutMap},
    lettering::Lettering,
    predict::{Bin, Calibration, CalibrationError, PredictedError, calibrate, predicted_error},
    split::{ErrorSplit, SplitError, SplitJob, SplitPicture, SplitStep, vertices::TraceVertex},
};
pub use post::{Post, ToneMap, vignetted};
pub use reference::{
    path::{
        PathPicture,
        settings::{PathSettings, SamplePositions},
    },
    samples::SampledLight,
};
pub use remedy::{Remedy, Wording};
pub use renderer::Renderer;
pub use sampling::BrdfSampling;
pub use shade::{mirror::rays::has_mirrors, surface::SurfacePlace, unoccluded::UnoccludedShader};
pub use sketch::{STRIDES, Tiles, share_of_lattice};
pub use stale::{Marks, Pixels, Stale};
pub use view::{Background, Preview, Progress, Quiet, View};
pub use view_mode::{BasisView, ViewMode, shows_source_cuts};
