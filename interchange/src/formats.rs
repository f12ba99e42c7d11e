//! The lists of formats of scenes, materials and pictures.

pub use crate::{
    export::MaterialFormat,
    file_format::{FileFormat, listed},
    image::PictureFormat,
    import::{Content, SceneFormat},
};
