//! Options that several commands share.

mod backend;
pub mod choices;
mod lens;
mod light;
mod outside;
mod picture;
mod pose;
mod shot;
mod view;

pub use backend::{AdapterMemory, BackendOption, DeviceArgs, MeasuredPath, PathMemory, shader_source};
pub use lens::LensArgs;
pub use light::{LocalLightArgs, warn_of_buried};
pub use outside::OutsideArgs;
pub use picture::PictureArgs;
pub use pose::{MotionArgs, PoseArgs};
pub use shot::ShotOption;
pub use view::{SMOOTH, ViewArgs, ViewedScene, check_memory, replace_materials};
