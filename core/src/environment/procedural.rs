//! Procedural environments: a constant, sun and sky, a studio, and a card for checking orientations.

use super::{texel_direction, texel_solid_angle, uv_from_direction};
use crate::image::Image;
use glam::{Mat3, Vec3};
use std::f32::consts::{FRAC_PI_4, PI, TAU};

/// Size of the maps: a texel is a third of a degree, slightly more than the sun's radius.
const SIZE: [u32; 2] = [1024, 512];

/// The same radiance from all directions.
pub fn constant(radiance: Vec3) -> Image {
    Image::filled([16, 8], radiance)
}

/// Haziness of the sky: a clear day with a little vapor (Preetham, figure 2).
const TURBIDITY: f32 = 3.0;

/// Radiance per luminance in kcd/m². It gives a white wall in the noon sun a radiance of about 3.
const RADIANCE_PER_KCD: f32 = 0.1;

/// Angular radius of the sun in radians.
const SUN_RADIUS: f32 = 0.004_65;

/// Illuminance of the sun above the atmosphere in klx.
const SUN_KLX: f32 = 128.0;

/// Reflectance of the ground below the horizon.
const GROUND_ALBEDO: f32 = 0.2;

/// A clear sky and the sun at `elevation` in radians, halfway between +X and +Z, over gray ground.
///
/// The sky follows Preetham, Shirley and Smits, *A Practical Analytic Model for Daylight* (SIGGRAPH 1999). The sun's
/// color is the attenuation by air and aerosols of their appendix. The sun is smaller than two texels: its energy is
/// spread over the texels that it covers, so irradiance is right at any resolution.
pub fn sun_and_sky(elevation: f32) -> Image {
    // At the horizon the model divides by zero.
    let elevation = elevation.clamp(0.5f32.to_radians(), 0.5 * PI);
    let azimuth = FRAC_PI_4;
    let sun = Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos());
    let sky = Preetham::new(sun);
    let mut map = Image::from_fn(SIZE, |x, y| sky.radiance(texel_direction(x, y, SIZE)));
    let sun_irradiance = sun_irradiance(elevation);
    add_disc(&mut map, sun, SUN_RADIUS, sun_irradiance);
    let ground = GROUND_ALBEDO / PI * irradiance_from_above(&map);
    for y in SIZE[1] / 2..SIZE[1] {
        let row = (y * SIZE[0]) as usize;
        map.pixels[row..row + SIZE[0] as usize].fill(ground);
    }
    map
}

/// The five Perez coefficients for each of x, y and Y, and the zenith values over the formula's values there.
struct Preetham {
    sun: Vec3,
    coefficients: [[f32; 5]; 3],
    scale: [f32; 3],
}

impl Preetham {
    fn new(sun: Vec3) -> Self {
        let t = TURBIDITY;
        let coefficients = [
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
        ];
        let theta = sun.y.acos();
        let zenith =
            [zenith_chromaticity(&ZENITH_X, theta), zenith_chromaticity(&ZENITH_Y, theta), zenith_luminance(theta)];
        let scale = std::array::from_fn(|i| zenith[i] / perez(&coefficients[i], 1.0, theta));
        Self { sun, coefficients, scale }
    }

    fn radiance(&self, direction: Vec3) -> Vec3 {
        let cos_theta = direction.y.max(0.01); // the formula goes on a little below the horizon as it is there
        let gamma = direction.dot(self.sun).clamp(-1.0, 1.0).acos();
        let [x, y, luminance] = std::array::from_fn(|i| self.scale[i] * perez(&self.coefficients[i], cos_theta, gamma));
        RADIANCE_PER_KCD * rgb_from_xyy(x, y, luminance.max(0.0)).max(Vec3::ZERO)
    }
}

fn perez([a, b, c, d, e]: &[f32; 5], cos_theta: f32, gamma: f32) -> f32 {
    (1.0 + a * (b / cos_theta).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
}

/// Rows by powers of turbidity from the second down, columns by powers of the sun's zenith angle from the third down.
const ZENITH_X: [[f32; 4]; 3] =
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]];
const ZENITH_Y: [[f32; 4]; 3] =
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]];

fn zenith_chromaticity(table: &[[f32; 4]; 3], theta: f32) -> f32 {
    let row = |[a, b, c, d]: [f32; 4]| ((a * theta + b) * theta + c) * theta + d;
    (row(table[0]) * TURBIDITY + row(table[1])) * TURBIDITY + row(table[2])
}

/// Luminance in kcd/m².
fn zenith_luminance(theta: f32) -> f32 {
    let chi = (4.0 / 9.0 - TURBIDITY / 120.0) * (PI - 2.0 * theta);
    ((4.0453 * TURBIDITY - 4.9710) * chi.tan() - 0.2155 * TURBIDITY + 2.4192).max(0.0)
}

fn rgb_from_xyy(x: f32, y: f32, luminance: f32) -> Vec3 {
    let xyz = luminance * Vec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let rgb_from_xyz = Mat3::from_cols(
        Vec3::new(3.240_97, -0.969_244, 0.055_630),
        Vec3::new(-1.537_383, 1.875_968, -0.203_977),
        Vec3::new(-0.498_611, 0.041_555, 1.056_972),
    );
    rgb_from_xyz * xyz
}

/// Irradiance of the sun on a surface that faces it: attenuated by Rayleigh scattering and by aerosols.
fn sun_irradiance(elevation: f32) -> Vec3 {
    let air_mass = 1.0 / (elevation.sin() + 0.15 * (elevation.to_degrees() + 3.885).powf(-1.253));
    let micrometres = Vec3::new(0.65, 0.55, 0.45);
    let aerosols = 0.04608 * TURBIDITY - 0.04586;
    let depth = 0.008_735 * micrometres.powf(-4.08) + aerosols * micrometres.powf(-1.3);
    RADIANCE_PER_KCD * SUN_KLX * (-air_mass * depth).exp()
}

/// Adds a disc of light with the given irradiance on a surface that faces it. Energy is conserved: each of many equal
/// parts of the disc adds to its texel, divided by the texel's solid angle.
fn add_disc(map: &mut Image, center: Vec3, radius: f32, irradiance: Vec3) {
    const PARTS: u32 = 4096;
    const GOLDEN_ANGLE: f32 = 2.399_963;
    let (tangent, bitangent) = center.any_orthonormal_pair();
    for i in 0..PARTS {
        let r = radius * ((i as f32 + 0.5) / PARTS as f32).sqrt();
        let (sin, cos) = (i as f32 * GOLDEN_ANGLE % TAU).sin_cos();
        let uv = uv_from_direction((center + r * (cos * tangent + sin * bitangent)).normalize());
        let x = ((uv.x * map.size[0] as f32) as u32).min(map.size[0] - 1);
        let y = ((uv.y * map.size[1] as f32) as u32).min(map.size[1] - 1);
        let solid_angle = texel_solid_angle(y, map.size);
        let index = (y * map.size[0] + x) as usize;
        map.pixels[index] += irradiance / (PARTS as f32 * solid_angle);
    }
}

/// Irradiance on a horizontal surface from the upper half of a map.
fn irradiance_from_above(map: &Image) -> Vec3 {
    let row = |y: u32| {
        let cosine = texel_direction(0, y, map.size).y;
        let sum: Vec3 = (0..map.size[0]).map(|x| map.at(x as usize, y as usize)).sum();
        cosine * texel_solid_angle(y, map.size) * sum
    };
    (0..map.size[1] / 2).map(row).sum()
}

/// A soft box of the studio.
struct SoftBox {
    /// Direction of its center, of any length.
    toward: Vec3,
    /// Half its width and height in radians.
    half_size: [f32; 2],
    radiance: Vec3,
}

const SOFT_BOXES: [SoftBox; 4] = [
    // Warm key from the upper left in front; cool, wide fill from the right; rim from behind; strip overhead.
    SoftBox { toward: Vec3::new(0.8, 0.6, 0.7), half_size: [0.35, 0.35], radiance: Vec3::new(13.0, 12.0, 10.8) },
    SoftBox { toward: Vec3::new(-1.0, 0.25, 0.35), half_size: [0.45, 0.5], radiance: Vec3::new(1.8, 2.0, 2.3) },
    SoftBox { toward: Vec3::new(-0.5, 0.5, -1.0), half_size: [0.12, 0.5], radiance: Vec3::new(9.0, 9.0, 9.0) },
    SoftBox { toward: Vec3::new(0.0, 1.0, 0.1), half_size: [0.55, 0.15], radiance: Vec3::new(5.0, 5.0, 5.0) },
];

/// Four soft boxes around a dark backdrop that brightens slightly toward the top.
pub fn studio() -> Image {
    Image::from_fn(SIZE, |x, y| {
        let direction = texel_direction(x, y, SIZE);
        let backdrop = Vec3::splat(0.03).lerp(Vec3::splat(0.12), smooth_step(-0.6, 0.9, direction.y));
        backdrop + SOFT_BOXES.iter().map(|b| b.radiance_from(direction)).sum::<Vec3>()
    })
}

impl SoftBox {
    /// Radiance of the box from a direction, seen from the center; its last eighth fades out.
    fn radiance_from(&self, direction: Vec3) -> Vec3 {
        let axis = self.toward.normalize();
        let right = Vec3::Y.cross(axis).normalize();
        let (x, y, depth) = (direction.dot(right), direction.dot(axis.cross(right)), direction.dot(axis));
        if depth <= 0.0 {
            return Vec3::ZERO;
        }
        let inside = |offset: f32, half: f32| 1.0 - smooth_step(0.875, 1.0, (offset / depth).abs() / half.tan());
        self.radiance * inside(x, self.half_size[0]) * inside(y, self.half_size[1])
    }
}

fn smooth_step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A test card: +X red, -X cyan, +Y white, -Y blue, +Z green, -Z magenta, each in a board of 8 x 8 squares.
pub fn orientation() -> Image {
    Image::from_fn(SIZE, |x, y| {
        let d = texel_direction(x, y, SIZE);
        let size = d.abs();
        let (color, a, b) = if size.x >= size.y && size.x >= size.z {
            (if d.x > 0.0 { Vec3::X } else { Vec3::new(0.0, 1.0, 1.0) }, d.z / size.x, d.y / size.x)
        } else if size.y >= size.z {
            (if d.y > 0.0 { Vec3::ONE } else { Vec3::Z }, d.x / size.y, d.z / size.y)
        } else {
            (if d.z > 0.0 { Vec3::Y } else { Vec3::new(1.0, 0.0, 1.0) }, d.x / size.z, d.y / size.z)
        };
        let square = |t: f32| (4.0 * (t + 1.0)).floor() as i32;
        if (square(a) + square(b)).rem_euclid(2) == 0 { color } else { 0.5 * color }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Environment;

    fn luminance(rgb: Vec3) -> f32 {
        crate::color::luminance(rgb)
    }

    #[test]
    fn a_disc_keeps_its_energy_on_any_map() {
        for size in [[64, 32], [1024, 512], [4096, 2048]] {
            for elevation in [0.1f32, 0.8, 1.57] {
                let mut map = Image::filled(size, Vec3::ZERO);
                let center = Vec3::new(elevation.cos(), elevation.sin(), 0.0);
                add_disc(&mut map, center, SUN_RADIUS, Vec3::splat(10.0));
                let energy = |x: u32, y: u32| map.at(x as usize, y as usize).x * texel_solid_angle(y, size);
                let sum: f32 =
                    (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| energy(x, y)).sum();
                assert!((sum - 10.0).abs() < 0.01, "{size:?} at {elevation}: {sum}");
            }
        }
    }

    #[test]
    fn irradiance_under_a_constant_sky_is_pi() {
        let irradiance = irradiance_from_above(&Image::filled([128, 64], Vec3::ONE));
        assert!((irradiance.x - PI).abs() < 0.003, "{irradiance}");
    }

    #[test]
    fn the_sky_is_blue_the_sun_is_where_it_should_be_and_reddens_as_it_sets() {
        let map = sun_and_sky(0.6);
        let environment = Environment::new(String::new(), map);
        let north = environment.radiance(Vec3::new(-0.4, 0.8, -0.4).normalize());
        assert!(north.z > 1.3 * north.x, "{north}");
        let brightest = (0..environment.map.pixels.len())
            .max_by(|a, b| luminance(environment.map.pixels[*a]).total_cmp(&luminance(environment.map.pixels[*b])))
            .unwrap() as u32;
        let sun = texel_direction(brightest % SIZE[0], brightest / SIZE[0], SIZE);
        let expected = Vec3::new(0.6f32.cos() * FRAC_PI_4.sin(), 0.6f32.sin(), 0.6f32.cos() * FRAC_PI_4.cos());
        assert!(sun.dot(expected) > 0.9999);
        let (noon, evening) = (sun_irradiance(1.2), sun_irradiance(0.05));
        assert!(evening.x / evening.z > 3.0 * noon.x / noon.z && luminance(evening) < 0.3 * luminance(noon));
    }

    #[test]
    fn the_card_has_its_colours_on_their_axes() {
        let card = Environment::new(String::new(), orientation());
        let at = |d: Vec3| card.radiance((d + Vec3::splat(0.05)).normalize());
        for (direction, color) in [
            (Vec3::X, Vec3::X),
            (Vec3::NEG_X, Vec3::new(0.0, 1.0, 1.0)),
            (Vec3::Y, Vec3::ONE),
            (Vec3::NEG_Y, Vec3::Z),
            (Vec3::Z, Vec3::Y),
            (Vec3::NEG_Z, Vec3::new(1.0, 0.0, 1.0)),
        ] {
            assert!((at(direction) - color).length() < 1e-3, "{direction}: {}", at(direction));
        }
    }

    #[test]
    fn the_studio_is_lit_from_the_key_more_than_from_the_backdrop() {
        let studio = Environment::new(String::new(), studio());
        assert!((studio.radiance(SOFT_BOXES[0].toward.normalize()).x - 13.0).abs() < 0.2);
        assert!(studio.radiance(Vec3::NEG_Y).x < 0.1);
    }
}
