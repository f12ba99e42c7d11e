//! Reads pictures that lie behind the scene.

use anyhow::Result;
use lapidary_core::{
    color::codes_from_linear,
    texture::{ColorSpace, Texels},
};
use lapidary_interchange::image::read_texture;
use lapidary_render::Backplate;
use std::path::Path;

/// Reads a picture, which is displayed as other programs display it: codes of 8 bits as they are, others by the sRGB curve.
///
/// # Errors
/// A file that is unreadable, not a picture, or too large.
pub fn read(path: &Path) -> Result<Backplate> {
    let texture = read_texture(path)?;
    let pixels = match &texture.texels {
        Texels::U8(texels) => texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect(),
        other => (0..other.count()).map(|i| codes_from_linear(other.at(i, ColorSpace::Srgb).truncate())).collect(),
    };
    Ok(Backplate::new(texture.size, pixels).expect("a picture has the pixels of its size"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::image::Image;
    use lapidary_interchange::image;

    #[test]
    fn a_picture_is_shown_as_other_programs_show_it() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        for path in [&png, &exr] {
            image::write(&Image::filled([3, 2], Vec3::splat(0.215_860_5)), path).unwrap();
            let plate = read(path).unwrap();
            assert_eq!((plate.size(), plate.pixels()[0]), ([3, 2], [128; 3]), "{}", path.display());
        }
        std::fs::write(&png, b"no picture").unwrap();
        assert!(read(&png).is_err());
    }
}
