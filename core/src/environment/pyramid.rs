//! Mip maps of an environment, for means over patches of directions.

use super::{bilinear, texel_solid_angle, uv_from_direction};
use crate::image::Image;
use glam::Vec3;
use rayon::prelude::*;
use std::{borrow::Cow, f32::consts::PI};

/// Longest side of the finest level: one of its texels is as wide as the sharpest lobe, 0.003 radians.
const LONGEST: u32 = 2048;

/// The levels of a map, each half as wide and high as the one before, until one side is a single texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    levels: Vec<Image>,
}

impl Pyramid {
    /// The pyramid of a latitude-longitude map. The finest level is the map itself, halved until no side is longer than
    /// 2,048 texels.
    pub fn new(map: &Image) -> Self {
        // Large maps are not copied.
        let mut finest = Cow::Borrowed(map);
        while finest.size.into_iter().any(|side| side > LONGEST) {
            finest = Cow::Owned(halved(&finest));
        }
        let mut levels = vec![finest.into_owned()];
        while let Some(coarsest) = levels.last().filter(|level| !level.size.contains(&1)) {
            levels.push(halved(coarsest));
        }
        Self { levels }
    }

    /// All levels, finest first.
    pub fn levels(&self) -> &[Image] {
        &self.levels
    }

    /// All levels in one map: the finest, and the others side by side below it.
    pub fn atlas(&self) -> Image {
        let [width, height] = self.levels[0].size;
        let below = self.levels.get(1).map_or(0, |level| level.size[1]);
        let mut atlas = Image::filled([width, height + below], Vec3::ZERO);
        for (i, level) in self.levels.iter().enumerate() {
            let [left, top] = self.place(i);
            for (row, texels) in level.pixels.chunks(level.width()).enumerate() {
                let first = (top as usize + row) * width as usize + left as usize;
                atlas.pixels[first..first + texels.len()].copy_from_slice(texels);
            }
        }
        atlas
    }

    /// The top left texel of a level in the atlas.
    fn place(&self, level: usize) -> [u32; 2] {
        let [width, height] = self.levels[0].size;
        if level == 0 { [0, 0] } else { [width - (width >> (level - 1)), height] }
    }

    /// Mean radiance over a patch of about `solid_angle` steradians around a unit direction. Twin of `patch_radiance` in
    /// `shaders/mirror.wgsl`.
    pub fn radiance(&self, direction: Vec3, solid_angle: f32) -> Vec3 {
        // Texels have equal height everywhere. Near the poles they are narrower than high, so a patch skips some.
        let texels = solid_angle.sqrt() * self.levels[0].height() as f32 / PI;
        // Blends levels by the size of the patch, not by its logarithm, which shaders compute differently.
        let last = self.levels.len() - 1;
        let fine = (texels.max(1.0) as u32).ilog2().min(last as u32) as usize;
        let rest = (texels / (1_u32 << fine) as f32 - 1.0).clamp(0.0, 1.0);
        let coarse = (fine + 1).min(last);
        let uv = uv_from_direction(direction);
        bilinear(&self.levels[fine], uv).lerp(bilinear(&self.levels[coarse], uv), rest)
    }
}

/// The map at half the size: means of the texels that each new one covers, weighted by their solid angles.
fn halved(map: &Image) -> Image {
    let size = map.size.map(|side| (side / 2).max(1));
    // For an odd side a texel covers parts of others.
    let covered = move |i: u32, axis: usize| {
        let scale = map.size[axis] as f32 / size[axis] as f32;
        let (first, end) = (i as f32 * scale, (i + 1) as f32 * scale);
        let last = (end.ceil() as usize).min(map.size[axis] as usize);
        (first as usize..last).map(move |k| (k, end.min((k + 1) as f32) - first.max(k as f32)))
    };
    let areas: Vec<f32> = (0..map.size[1]).map(|row| texel_solid_angle(row, map.size)).collect();
    let texel = |i: u32| {
        let (x, y) = (i % size[0], i / size[0]);
        let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
        for (row, high) in covered(y, 1) {
            for (column, wide) in covered(x, 0) {
                let area = high * wide * areas[row];
                sum += map.at(column, row) * area;
                weight += area;
            }
        }
        sum / weight
    };
    Image { size, pixels: (0..size[0] * size[1]).into_par_iter().map(texel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{constant, texel_direction};

    fn mean(map: &Image) -> Vec3 {
        let texel = |i: usize| map.pixels[i] * texel_solid_angle(i as u32 / map.size[0], map.size);
        (0..map.pixels.len()).map(texel).sum::<Vec3>() / (4.0 * PI)
    }

    #[test]
    fn all_levels_have_the_light_of_the_map() {
        for size in [[64, 32], [37, 20], [5, 9], [1, 1]] {
            let map = Image::from_fn(size, |x, y| Vec3::new(x as f32, y as f32, ((x * 7 + y * 3) % 5) as f32));
            let pyramid = Pyramid::new(&map);
            assert!(pyramid.levels().last().unwrap().size.contains(&1));
            for level in pyramid.levels() {
                let [of_level, of_map] = [mean(level), mean(&map)];
                let tolerance = if size == [64, 32] { 1e-5 } else { 0.05 };
                assert!((of_level - of_map).abs().max_element() <= tolerance * of_map.max_element(), "{size:?}");
            }
        }
        assert_eq!(Pyramid::new(&constant(Vec3::ONE)).radiance(Vec3::Y, 1.0), Vec3::ONE);
    }

    #[test]
    fn a_patch_has_the_mean_of_its_directions() {
        let map = Image::from_fn([256, 128], |x, y| Vec3::splat(f32::from((x / 2 + y / 2) % 2 == 0)));
        let pyramid = Pyramid::new(&map);
        let direction = texel_direction(70, 60, map.size);
        let texel = texel_solid_angle(60, map.size);
        assert!((pyramid.radiance(direction, 64.0 * texel).x - 0.5).abs() < 0.02);
        let point = pyramid.radiance(direction, 0.01 * texel).x;
        assert!((point - map.at(70, 60).x).abs() < 1e-3 && (point - 0.5).abs() > 0.4, "negative control: {point}");
    }

    #[test]
    fn an_atlas_has_all_levels_apart() {
        for size in [[64, 32], [37, 20], [6, 9], [1, 4], [2, 2]] {
            let pyramid = Pyramid::new(&Image::from_fn(size, |x, y| Vec3::splat((1 + x + 7 * y) as f32)));
            let atlas = pyramid.atlas();
            let mut taken = vec![false; atlas.pixels.len()];
            for (i, level) in pyramid.levels().iter().enumerate() {
                let [left, top] = pyramid.place(i);
                for (j, texel) in level.pixels.iter().enumerate() {
                    let (x, y) = (left as usize + j % level.width(), top as usize + j / level.width());
                    assert_eq!(atlas.at(x, y), *texel, "{size:?} {i}");
                    assert!(!std::mem::replace(&mut taken[y * atlas.width() + x], true), "{size:?} {i}");
                }
            }
        }
    }

    #[test]
    fn a_wide_map_is_halved_first() {
        let pyramid = Pyramid::new(&Image::from_fn([4096, 8], |x, _| Vec3::splat((x % 2) as f32)));
        assert_eq!(pyramid.levels()[0].size, [2048, 4]);
        assert!(pyramid.levels()[0].pixels.iter().all(|p| (*p - 0.5).abs().max_element() < 1e-5));
    }
}
