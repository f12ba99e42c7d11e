//! Picture files: OpenEXR and its layers, Radiance HDR, PNG, JPEG, TGA, TIFF, WebP and KTX2.

mod ktx2;
mod layer_path;
mod layers;
mod open_exr;
mod picture_format;
mod primaries;
mod radiance;
mod read;
mod remark;
mod tiff;
mod write;

#[cfg(test)]
mod tests;

pub use layer_path::{file_and_layer, layer_of, layers_in, with_layer};
pub(crate) use layer_path::{name_of, split};
pub use layers::{Layer, LayeredImage, MetaValue, Metadata};
pub use picture_format::PictureFormat;
pub use read::{Footprint, decode, decode_with, dimensions, footprint, read, read_in, read_layer, read_texture};
pub(crate) use write::srgb_bytes;
pub use write::{encode_png, encode_png_pixels, write, write_with};
