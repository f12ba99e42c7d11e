//! Picture files: OpenEXR and its layers, Radiance HDR, PNG, JPEG, TGA, TIFF, WebP and KTX2.

mod ktx2;
mod layers;
mod open_exr;
mod picture_format;
mod primaries;
mod radiance;
mod read;
mod tiff;
mod write;

#[cfg(test)]
mod tests;

pub use layers::{Layer, LayeredImage, MetaValue, Metadata, read_layer};
pub use picture_format::PictureFormat;
pub use read::{Footprint, decode, decode_with, dimensions, footprint, read, read_in, read_texture};
pub(crate) use write::srgb_bytes;
pub use write::{encode_png, encode_png_pixels, write, write_with};
