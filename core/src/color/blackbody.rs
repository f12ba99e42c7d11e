//! Colors of hot bodies, by temperature.

use super::Primaries;
use glam::{DMat3, DVec3, Vec3};
use std::sync::LazyLock;

/// Temperatures for which the approximation holds, in kelvins.
pub const KELVINS: [f32; 2] = [1667.0, 25_000.0];

/// The color of a black body in linear Rec. 709, whose brightest channel is 1. The temperature is clamped to [`KELVINS`].
///
/// Chromaticities are the cubic splines of Kim et al. (US patent 7,024,034, 2006) to the Planckian locus.
pub fn blackbody(kelvin: f32) -> Vec3 {
    let t = f64::from(kelvin.clamp(KELVINS[0], KELVINS[1]));
    let cubic = |x: f64, [a, b, c, d]: [f64; 4]| ((a * x + b) * x + c) * x + d;
    let thousands = 1e3 / t;
    let x = cubic(
        thousands,
        if t <= 4000.0 {
            [-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910]
        } else {
            [-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390]
        },
    );
    let y = cubic(
        x,
        if t <= 2222.0 {
            [-1.106_381_4, -1.348_110_20, 2.185_558_32, -0.202_196_83]
        } else if t <= 4000.0 {
            [-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67]
        } else {
            [3.081_758_0, -5.873_386_70, 3.751_129_97, -0.370_014_83]
        },
    );
    static RGB_FROM_XYZ: LazyLock<DMat3> =
        LazyLock::new(|| Primaries::REC_709.to_xyz().expect("its primaries span colors").inverse());
    let rgb = (*RGB_FROM_XYZ * DVec3::new(x / y, 1.0, (1.0 - x - y) / y)).as_vec3().max(Vec3::ZERO);
    rgb / rgb.max_element()
}

/// The temperature whose color is nearest to one in linear Rec. 709, of any brightness, in kelvins; `None` if none is near.
pub fn temperature_of(color: Vec3) -> Option<f32> {
    /// Farthest color that counts as one of a black body, where the brightest channel is 1.
    const NEAR: f32 = 0.06;
    const STEPS: u32 = 200;
    let color = color / color.max_element();
    let [coldest, hottest] = KELVINS;
    // Equal steps of the reciprocal look about alike.
    let kelvin = |step: f32| 1.0 / (1.0 / coldest + (1.0 / hottest - 1.0 / coldest) * step / STEPS as f32);
    let off = |step: f32| blackbody(kelvin(step)).distance(color);
    let nearest = (0..=STEPS).map(|step| step as f32).min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
    let between = |i: i32| nearest + i as f32 / 20.0;
    let nearest = (-20..=20).map(between).filter(|step| (0.0..=STEPS as f32).contains(step));
    let nearest = nearest.min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
    (off(nearest) <= NEAR).then(|| kelvin(nearest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_those_of_the_planckian_locus() {
        // Chromaticities of the locus, CIE 1931 2 degrees (Wyszecki and Stiles).
        for (kelvin, [x, y]) in [(2856.0, [0.4476, 0.4074]), (5000.0, [0.3451, 0.3516]), (10_000.0, [0.2807, 0.2884])] {
            let xyz = Primaries::REC_709.to_xyz().unwrap() * blackbody(kelvin).as_dvec3();
            let found = [xyz.x, xyz.y].map(|part| part / xyz.element_sum());
            assert!((found[0] - x).abs() < 2e-3 && (found[1] - y).abs() < 2e-3, "{kelvin}: {found:?}");
        }
        let [warm, cold] = [2700.0, 12_000.0].map(blackbody);
        assert!(warm.x > warm.z && cold.z > cold.x, "negative control: {warm} {cold}");
    }

    #[test]
    fn a_temperature_is_read_back_and_green_has_none() {
        for kelvin in [1700.0, 2700.0, 4000.0, 6504.0, 9300.0, 20_000.0] {
            let read = temperature_of(7.0 * blackbody(kelvin)).unwrap();
            assert!((read / kelvin - 1.0).abs() < 0.01, "{read} for {kelvin}");
        }
        assert_eq!(temperature_of(Vec3::new(0.1, 1.0, 0.1)), None);
        assert_eq!(temperature_of(Vec3::ZERO), None);
        assert!((temperature_of(Vec3::ONE).unwrap() - 6500.0).abs() < 300.0, "white is near daylight");
    }
}
