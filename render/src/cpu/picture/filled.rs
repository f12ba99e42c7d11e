//! Stand-ins for pixels of a sketch.

use crate::stale::LightPart;
use glam::Vec3;

/// Stand-ins for pixels that lack their first sample.
#[derive(Default)]
pub struct Filled {
    /// Radiance, or the quantity of the view's mode, by [`LightPart`]; empty for parts that the light lacks.
    pub values: [Vec<Vec3>; LightPart::COUNT],
    /// Wireframe coverage; empty without a wireframe.
    pub(super) wire: Vec<f32>,
    /// Whether the value is the share of light that a ground transmits; empty without such a ground.
    pub(super) through: Vec<bool>,
}

/// The stand-ins of a row.
pub struct FilledRow<'f> {
    pub y: u32,
    /// Values by [`LightPart`].
    pub values: [&'f mut [Vec3]; LightPart::COUNT],
    /// Wireframe coverage; empty without a wireframe.
    pub wire: &'f mut [f32],
    /// Empty without a ground that transmits light.
    pub through: &'f mut [bool],
}

impl Filled {
    /// The rows of a picture of this width.
    pub fn rows(&mut self, width: u32) -> Vec<FilledRow<'_>> {
        let width = width.max(1) as usize;
        let count = self.values[LightPart::Environment as usize].len().div_ceil(width) as u32;
        let mut values = self.values.each_mut().map(|values| values.chunks_mut(width));
        let mut wire = self.wire.chunks_mut(width);
        let mut through = self.through.chunks_mut(width);
        let mut row = |y| FilledRow {
            y,
            values: values.each_mut().map(|rows| rows.next().unwrap_or_default()),
            wire: wire.next().unwrap_or_default(),
            through: through.next().unwrap_or_default(),
        };
        (0..count).map(&mut row).collect()
    }
}
