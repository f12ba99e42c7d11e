//! Picture files: OpenEXR and its layers, Radiance HDR, PNG, JPEG and TGA.

mod layers;
mod open_exr;
mod picture_format;
mod primaries;
mod radiance;
mod read;
mod write;

pub use layers::{Layer, LayeredImage, MetaValue, Metadata, read_layer};
pub use picture_format::PictureFormat;
pub use read::{Footprint, decode, decode_with, dimensions, footprint, read, read_texture};
pub(crate) use write::srgb_bytes;
pub use write::{encode_png, encode_png_pixels, write, write_with};
