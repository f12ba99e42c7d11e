//! The color spaces of FLIP: linear Rec. 709, the opponent space YCxCz, Hunt-adjusted CIELab.

use glam::{Mat3, Vec3, Vec3Swizzles};
use std::sync::LazyLock;

/// CIE XYZ of linear Rec. 709, relative to the D65 white point: each row of the exact matrix divided by its sum.
const XYZ_FROM_LINEAR: Mat3 = Mat3::from_cols(
    Vec3::new(10_135_552.0 / X_OF_WHITE, 2_613_072.0 / Y_OF_WHITE, 1_425_312.0 / Z_OF_WHITE),
    Vec3::new(8_788_810.0 / X_OF_WHITE, 8_788_810.0 / Y_OF_WHITE, 8_788_810.0 / Z_OF_WHITE),
    Vec3::new(4_435_075.0 / X_OF_WHITE, 887_015.0 / Y_OF_WHITE, 70_074_185.0 / Z_OF_WHITE),
);
const X_OF_WHITE: f32 = 23_359_437.0;
const Y_OF_WHITE: f32 = 12_288_897.0;
const Z_OF_WHITE: f32 = 80_288_307.0;

static LINEAR_FROM_XYZ: LazyLock<Mat3> = LazyLock::new(|| XYZ_FROM_LINEAR.inverse());

/// YCxCz, a linear cousin of CIELab in which blurring is meaningful (section 4.1.1).
pub(super) fn opponent_from_linear(rgb: Vec3) -> Vec3 {
    let xyz = XYZ_FROM_LINEAR * rgb;
    Vec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

fn linear_from_opponent(ycc: Vec3) -> Vec3 {
    let y = (ycc.x + 16.0) / 116.0;
    *LINEAR_FROM_XYZ * Vec3::new(y + ycc.y / 500.0, y, y - ycc.z / 200.0)
}

fn lab_from_linear(rgb: Vec3) -> Vec3 {
    let f = (XYZ_FROM_LINEAR * rgb).map(cube_root_with_linear_toe);
    Vec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

/// The compression of CIELab (CIE 15): a cube root above (6/29)³, a line below.
fn cube_root_with_linear_toe(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// Colors look less colorful when they are dark (section 4.1.2, after Hunt).
fn hunt_adjusted(lab: Vec3) -> Vec3 {
    let colorfulness = 0.01 * lab.x;
    Vec3::new(lab.x, colorfulness * lab.y, colorfulness * lab.z)
}

/// Hunt-adjusted CIELab of a filtered opponent color, brought back into the display's gamut first.
pub(super) fn perceived(ycc: Vec3) -> Vec3 {
    hunt_adjusted(lab_from_linear(linear_from_opponent(ycc).clamp(Vec3::ZERO, Vec3::ONE)))
}

/// City-block in lightness, Euclidean in chroma (section 4.1.3): Euclidean CIELab fails for large differences.
pub(super) fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + difference.yz().length()
}

/// Distance between green and blue, the most different colors in the display's gamut.
pub(super) fn largest_difference() -> f32 {
    let [green, blue] = [Vec3::Y, Vec3::Z].map(|rgb| hunt_adjusted(lab_from_linear(rgb)));
    hyab(green, blue)
}
