//! Placement of a picture on a surface: converts between the transform of a MaterialX document, whose v begins at the
//! bottom, and a texture slot's, whose v begins at the top.

use crate::material_file::SlotFile;
use glam::{Affine2, Mat2, Vec2};

/// The numbers of a slot that place its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// See [`crate::import::SlotFile::scale`].
    pub scale: Vec2,
    /// See [`crate::import::SlotFile::offset`].
    pub offset: Vec2,
    /// See [`crate::import::SlotFile::rotation_degrees`].
    pub rotation_degrees: f32,
}

/// Converts between the two directions of v.
fn flipped() -> Affine2 {
    Affine2::from_mat2_translation(Mat2::from_diagonal(Vec2::new(1.0, -1.0)), Vec2::Y)
}

impl Placement {
    /// The transform of coordinates whose v begins at the top.
    fn transform(&self) -> Affine2 {
        let (sin, cos) = self.rotation_degrees.to_radians().sin_cos();
        let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        Affine2::from_mat2_translation(turn * Mat2::from_diagonal(self.scale), self.offset)
    }

    /// The placement of a document's transform; `None` unless it is a scale followed by a rotation and an offset.
    pub fn of_document(transform: Affine2) -> Option<Self> {
        let Affine2 { matrix2, translation: offset } = flipped() * transform * flipped();
        let (x, y) = (matrix2.x_axis, matrix2.y_axis);
        let is_turned = x.y != 0.0 || y.x != 0.0;
        let angle = if is_turned { (-x.y).atan2(x.x) } else { 0.0 };
        let (sin, cos) = angle.sin_cos();
        let scale = if is_turned { Vec2::new(x.length(), y.dot(Vec2::new(sin, cos))) } else { Vec2::new(x.x, y.y) };
        let placement = Self { scale, offset, rotation_degrees: angle.to_degrees() };
        let is_same = placement.transform().matrix2.abs_diff_eq(matrix2, 1e-4 * (x.length() + y.length()));
        (is_same && offset.is_finite()).then_some(placement)
    }

    /// `uvtiling` and `uvoffset` of a `tiledimage`, if it is not rotated.
    pub fn tiling(&self) -> Option<[Vec2; 2]> {
        let Self { scale, offset, rotation_degrees } = *self;
        (rotation_degrees == 0.0).then(|| [scale, Vec2::new(-offset.x, offset.y - 1.0 + scale.y)])
    }

    /// Scale, rotation in degrees and offset of a `place2d` about (0, 1), which divides by the scale.
    pub fn place2d(&self) -> (Vec2, f32, Vec2) {
        let inverse = |x: f32| if x.abs() > 1e-6 { 1.0 / x } else { 1e6 };
        let scale = Vec2::new(inverse(self.scale.x), inverse(self.scale.y));
        (scale, -self.rotation_degrees, Vec2::new(-self.offset.x, self.offset.y))
    }
}

/// A document's transform by `tiledimage`: coordinates times tiling, minus offset.
pub fn tiled(tiling: Vec2, offset: Vec2) -> Affine2 {
    Affine2::from_mat2_translation(Mat2::from_diagonal(tiling), -offset)
}

/// Whether a picture is turned or mirrored: its normals are then too.
pub fn is_turned(slot: &SlotFile) -> bool {
    slot.rotation_degrees != 0.0 || slot.scale.min_element() < 0.0
}

/// A document's transform by `rotate2d`.
pub fn turned(degrees: f32) -> Affine2 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Affine2::from_mat2(Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos)))
}

/// A document's transform by `place2d`; `turned_first` is its operation order 1.
pub fn placed(pivot: Vec2, scale: Vec2, degrees: f32, offset: Vec2, turned_first: bool) -> Affine2 {
    let turn = turned(degrees);
    let divide = Affine2::from_mat2(Mat2::from_diagonal(1.0 / scale));
    let shift = Affine2::from_translation(-offset);
    let inner = if turned_first { divide * turn * shift } else { shift * turn * divide };
    Affine2::from_translation(pivot) * inner * Affine2::from_translation(-pivot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::texture::TextureSlot;

    fn slot(placement: Placement) -> TextureSlot {
        let Placement { scale, offset, rotation_degrees } = placement;
        TextureSlot { scale, offset, rotation: rotation_degrees.to_radians(), ..Default::default() }
    }

    #[test]
    fn a_point_of_the_picture_is_the_same_from_either_begin_of_v() {
        let placement =
            Placement { scale: Vec2::new(2.0, -3.0), offset: Vec2::new(0.25, 0.125), rotation_degrees: 30.0 };
        let (scale, degrees, offset) = placement.place2d();
        let of_document = placed(Vec2::Y, scale, degrees, offset, false);
        for uv in [Vec2::new(0.1, 0.9), Vec2::new(0.5, 0.25), Vec2::new(3.0, -1.0)] {
            let expected = slot(placement).transform(uv);
            let found = of_document.transform_point2(Vec2::new(uv.x, 1.0 - uv.y));
            assert!((Vec2::new(found.x, 1.0 - found.y) - expected).length() < 1e-5, "{uv}");
            let read = slot(Placement::of_document(of_document).unwrap()).transform(uv);
            assert!((read - expected).length() < 1e-5, "{uv}");
            assert!((found - expected).length() > 1e-2, "negative control: without the flip, {uv}");
        }
    }

    #[test]
    fn a_tiling_is_written_as_it_is_read() {
        let placement = Placement { scale: Vec2::new(2.0, 3.0), offset: Vec2::new(0.25, 0.1), rotation_degrees: 0.0 };
        let [tiling, offset] = placement.tiling().unwrap();
        let read = Placement::of_document(tiled(tiling, offset)).unwrap();
        assert!((read.offset - placement.offset).length() < 1e-6 && read.scale == placement.scale);
        assert_eq!(Placement { rotation_degrees: 5.0, ..placement }.tiling(), None);
    }

    #[test]
    fn a_skewed_transform_is_refused() {
        assert!(Placement::of_document(placed(Vec2::ZERO, Vec2::new(1.0, 4.0), 30.0, Vec2::ZERO, true)).is_none());
        assert!(Placement::of_document(Affine2::from_mat2(Mat2::from_diagonal(Vec2::splat(f32::NAN)))).is_none());
        assert!(Placement::of_document(Affine2::IDENTITY).is_some());
    }
}
