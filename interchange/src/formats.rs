//! The lists of scene, material and picture formats.

pub use crate::{
    export::MaterialFormat,
    file_format::{FileFormat, listed},
    image::PictureFormat,
    import::{Content, SceneFormat},
};
