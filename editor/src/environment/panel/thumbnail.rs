//! Small pictures of environment maps: means over texels, exposed by the log-average (Reinhard et al. 2002, Eq. 1).

use egui::{Color32, ColorImage};
use glam::Vec3;
use lapidary_core::{
    color::{codes, luminance},
    environment::{Environment, texel_solid_angle},
    image::Image,
};
use lapidary_render::{Post, ToneMap};
use std::ops::Range;

/// Displayed luminance of the log-average.
const KEY: f32 = 0.18;
/// Least luminance relative to the mean, so that black does not drag the log-average to zero.
const DARKEST: f32 = 1e-3;

/// A picture of a map, exposed for this map alone.
pub fn thumbnail(environment: &Environment, size: [usize; 2]) -> ColorImage {
    let small = reduced(&environment.map, size.map(|s| s.max(1) as u32));
    let weighted = small.pixels.iter().enumerate().map(|(i, &p)| {
        let row = i as u32 / small.size[0];
        (luminance(p), texel_solid_angle(row, small.size))
    });
    let post = adapted(weighted);
    let pixels = small.pixels.iter().map(|&p| display_color(&post, p)).collect();
    ColorImage::new([small.width(), small.height()], pixels)
}

/// Exposure and tone curve for luminances with weights.
pub fn adapted(weighted: impl Iterator<Item = (f32, f32)> + Clone) -> Post {
    let weight: f32 = weighted.clone().map(|(_, w)| w).sum();
    let mean = weighted.clone().map(|(l, w)| l * w).sum::<f32>() / weight;
    let log_mean = weighted.map(|(l, w)| l.max(DARKEST * mean).max(f32::MIN_POSITIVE).ln() * w).sum::<f32>() / weight;
    let stops = (KEY / log_mean.exp()).log2();
    let exposure = if mean > 0.0 && stops.is_finite() { stops } else { 0.0 };
    Post { exposure, tone_map: ToneMap::Reinhard, ..Post::default() }
}

/// A radiance as the display shows it.
pub fn display_color(post: &Post, radiance: Vec3) -> Color32 {
    let [r, g, b] = codes(post.display(radiance));
    Color32::from_rgb(r, g, b)
}

/// The map in another size: means of the texels that each new one covers, so that small lamps stay.
fn reduced(map: &Image, size: [u32; 2]) -> Image {
    Image::from_fn(size, |x, y| {
        let rows = covered(y, size[1], map.height());
        let columns = covered(x, size[0], map.width());
        let count = rows.len() * columns.len();
        let sum: Vec3 = rows.flat_map(|r| columns.clone().map(move |c| map.at(c, r))).sum();
        sum / count as f32
    })
}

/// The texels of `from` that the `i`-th of `to` covers; at least one.
fn covered(i: u32, to: u32, from: usize) -> Range<usize> {
    let at = |i: u32| i as usize * from / to as usize;
    at(i)..at(i + 1).max(at(i) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_interchange::environment;

    fn environment(size: [u32; 2], f: impl FnMut(u32, u32) -> Vec3) -> Environment {
        Environment::new("test".into(), Image::from_fn(size, f))
    }

    #[test]
    fn dim_and_bright_constants_look_the_same() {
        let shown = |radiance: f32| thumbnail(&environment([64, 32], |_, _| Vec3::splat(radiance)), [16, 8]);
        let gray = shown(1.0).pixels[0];
        assert_eq!(gray, Color32::from_gray(109), "0.18 / 1.18, encoded");
        for radiance in [1e-4, 100.0, 1e5] {
            assert!(shown(radiance).pixels.iter().all(|p| p.r().abs_diff(gray.r()) <= 1), "{radiance}");
        }
    }

    #[test]
    fn a_lamp_of_one_texel_is_still_seen() {
        let with = |lamp: f32| {
            let map = environment([512, 256], |x, y| Vec3::splat(if (x, y) == (100, 90) { lamp } else { 0.1 }));
            let picture = thumbnail(&map, [32, 16]);
            (picture.pixels[5 * 32 + 6].r(), picture.pixels[0].r())
        };
        let (lamp, around) = with(1e4);
        assert!(lamp > around + 60, "{lamp} on {around}");
        let (none, around) = with(0.1);
        assert_eq!(none, around, "negative control");
    }

    #[test]
    fn sides_are_not_swapped() {
        let (card, _) = environment::from_spec("orientation").unwrap();
        let picture = thumbnail(&card, [64, 32]);
        let [left, right] = [16, 48].map(|x| picture.pixels[15 * 64 + x]);
        assert!(left.r() > left.g() + 50, "+X is red: {left:?}");
        assert!(right.g() > right.r() + 50, "-X is cyan: {right:?}");
    }

    #[test]
    fn odd_sizes_and_black_maps_make_pictures() {
        for (from, to) in [([1, 1], [8, 4]), ([5, 7], [16, 3]), ([64, 32], [0, 0])] {
            let picture = thumbnail(&environment(from, |_, _| Vec3::ZERO), to);
            assert_eq!(picture.size, to.map(|s| s.max(1)));
            assert!(picture.pixels.iter().all(|p| *p == Color32::BLACK));
        }
    }
}
