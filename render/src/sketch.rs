//! The first sample of a picture, from coarse to fine: moving pictures keep full edges and textures.
//!
//! Cheap data is computed for every pixel: its surface with normal, position and albedo ([`Guide`]). The expensive reflected light
//! is computed first at the pixels of a lattice: every eighth in both directions, then every fourth, every second, and all. No
//! pixel is computed twice, and the last lattice completes the sample. Until then a joint bilateral filter fills the pixels in
//! between. It interpolates radiance divided by albedo, which varies slowly, and multiplies it by each pixel's own albedo.

use glam::{IVec2, Vec2, Vec3};
use lapidary_core::{color::luminance, image::Region};

/// Lattice spacings in pixels, from coarse to fine.
pub const STRIDES: [u32; 4] = [8, 4, 2, 1];

/// Pixels along each side of a tile, a multiple of all strides.
const TILE: u32 = 64;

/// Least albedo that radiance is divided by, per channel: half of an 8-bit step of white.
pub(crate) const LEAST_ALBEDO: f32 = 1.0 / 512.0;

/// Least share of the filter's weight that must fit, so that no single far or tilted neighbor decides.
pub(crate) const LEAST_SHARE: f32 = 1.0 / 16.0;

/// Weight of a surface of another material if no lattice point fits: it matters only if nothing else is near.
pub(crate) const OTHER: f32 = 1e-3;

/// Square tiles of a picture, numbered in rows from the top left corner and cropped at the right and lower edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    size: [u32; 2],
}

impl Tiles {
    /// Pixels of an uncropped tile.
    pub const MOST_PIXELS: usize = (TILE * TILE) as usize;

    /// Tiles of a picture of `size` pixels.
    pub fn of(size: [u32; 2]) -> Self {
        Self { size }
    }

    fn columns(self) -> u32 {
        self.size[0].div_ceil(TILE)
    }

    /// Number of tiles.
    pub fn count(self) -> u32 {
        self.columns() * self.size[1].div_ceil(TILE)
    }

    /// The pixels of a tile.
    pub fn region(self, tile: u32) -> Region {
        let [x, y] = [tile % self.columns(), tile / self.columns()].map(|i| i * TILE);
        Region { x, y, width: TILE.min(self.size[0] - x), height: TILE.min(self.size[1] - y) }
    }

    /// The part of a lattice in a tile, in lattice columns and rows.
    pub(crate) fn on_lattice(self, tile: u32, stride: u32) -> Region {
        let Region { x, y, width, height } = self.region(tile);
        let [width, height] = [width, height].map(|side| side.div_ceil(stride));
        Region { x: x / stride, y: y / stride, width, height }
    }

    /// All tiles by distance to `place`, a position in the picture from 0 to 1 in both directions.
    pub fn nearest_first(self, place: Vec2) -> Vec<u32> {
        let place = place * Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let distance_sq = |&tile: &u32| {
            let Region { x, y, width, height } = self.region(tile);
            let middle = Vec2::new(x as f32, y as f32) + 0.5 * Vec2::new(width as f32, height as f32);
            middle.distance_squared(place)
        };
        let mut tiles: Vec<u32> = (0..self.count()).collect();
        tiles.sort_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b)));
        tiles
    }

    /// Tile number of a pixel, and the pixel's index in the tile, row by row.
    pub(crate) fn place(self, x: u32, y: u32) -> (usize, usize) {
        let tile = (y / TILE) * self.columns() + x / TILE;
        (tile as usize, ((y % TILE) * TILE + x % TILE) as usize)
    }
}

/// Pixels of a lattice that coarser lattices do not have, per pixel of the picture.
pub fn share_of_lattice(stride: u32) -> f64 {
    let share = 1.0 / f64::from(stride * stride);
    if stride == STRIDES[0] { share } else { 0.75 * share }
}

/// The surface at a pixel's first sample, as input of the filter. Exactly one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Guide {
    /// Index of the material, or [`Guide::BACKGROUND`] or [`Guide::BACK`].
    pub material: u32,
    /// The triangle, with [`Guide::FROM_BEHIND`] if its back is visible.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: Vec2,
    /// Position in meters.
    pub position: Vec3,
    /// Unit normal before bump and normal map.
    pub smooth_normal: Vec3,
    /// Unit normal after bump and normal map.
    pub normal: Vec3,
    /// Share of reflected light, as for bounces; at least [`LEAST_ALBEDO`].
    pub albedo: Vec3,
}

impl Guide {
    /// No surface.
    pub const BACKGROUND: u32 = u32::MAX;
    /// The back of a one-sided surface.
    pub const BACK: u32 = u32::MAX - 1;
    /// Flag of a triangle seen from behind.
    pub const FROM_BEHIND: u32 = 1 << 31;

    /// A pixel without a surface to shade: the background, or a one-sided surface from behind.
    pub fn unlit(material: u32) -> Self {
        let [zero, one] = [Vec3::ZERO, Vec3::ONE];
        let (triangle, barycentric) = (0, Vec2::ZERO);
        Self { material, triangle, barycentric, position: zero, smooth_normal: zero, normal: zero, albedo: one }
    }

    /// Whether there is a surface to shade.
    pub fn is_lit(&self) -> bool {
        self.material < Self::BACK
    }

    /// Albedo as a divisor.
    pub fn divisor(albedo: Vec3) -> Vec3 {
        albedo.max(Vec3::splat(LEAST_ALBEDO))
    }

    /// How well the light at `other` represents the light here, 0 to 1: see [`Self::fit_surface`]. The ratio of the albedos limits
    /// the error of light that does not scale with albedo, such as gloss over a dark texture.
    pub fn fit(&self, other: &Self, reach: f32) -> f32 {
        let surface = self.fit_surface(other.material, other.position, other.normal, reach);
        if surface == 0.0 {
            return 0.0;
        }
        let (a, b) = (luminance(self.albedo), luminance(other.albedo));
        surface * (a.min(b) / a.max(b))
    }

    /// How well a surface position represents the light here, 0 to 1. `reach` is the lattice spacing in meters.
    ///
    /// It is exactly zero on another material, on a plane more than `reach` away, and if the normals differ by more than 60
    /// degrees: light does not bleed over edges.
    pub fn fit_surface(&self, material: u32, position: Vec3, normal: Vec3, reach: f32) -> f32 {
        if self.material != material {
            return 0.0;
        }
        let apart = self.smooth_normal.dot(position - self.position).abs();
        let plane = 1.0 - apart / reach;
        let turned = 2.0 * self.normal.dot(normal) - 1.0;
        if plane > 0.0 && turned > 0.0 { plane * turned } else { 0.0 }
    }
}

/// The lattice points around a pixel and their weights in a tent filter: the four around it for `cells` of 1, which is
/// bilinear interpolation, and sixteen for 2.
pub(crate) fn around([x, y]: [u32; 2], stride: u32, cells: i32) -> impl Iterator<Item = (IVec2, f32)> {
    let (pixel, side) = (IVec2::new(x as i32, y as i32), stride as i32);
    let first = pixel - pixel % side - (cells - 1) * side;
    let all = 2 * cells;
    let width = (cells * side) as f32;
    (0..all * all).map(move |i| {
        let point = first + side * IVec2::new(i % all, i / all);
        let away = (point - pixel).abs().as_vec2() / width;
        (point, (1.0 - away.x).max(0.0) * (1.0 - away.y).max(0.0))
    })
}

/// A weighted mean of interpolated values.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mean {
    sum: Vec3,
    weight: f32,
}

impl Mean {
    /// Adds radiance over albedo.
    pub fn add(&mut self, value: Vec3, weight: f32) {
        self.sum += value * weight;
        self.weight += weight;
    }

    /// The mean, if enough weight of a filter over `cells` fitted.
    pub fn fitting(self, cells: i32) -> Option<Vec3> {
        // The weights of a tent sum to its area in cells.
        (self.weight >= LEAST_SHARE * (cells * cells) as f32).then(|| self.sum / self.weight)
    }

    /// The mean, if anything was added.
    pub fn any(self) -> Option<Vec3> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once_and_are_found_by_their_pixels() {
        for size in [[1, 1], [64, 64], [130, 65], [3, 200]] {
            let tiles = Tiles::of(size);
            let mut covered = vec![0; (size[0] * size[1]) as usize];
            for tile in 0..tiles.count() {
                let region = tiles.region(tile);
                for (x, y) in region.rows().flat_map(|y| region.columns().map(move |x| (x, y))) {
                    covered[(y * size[0] + x) as usize] += 1;
                    assert_eq!(tiles.place(x, y).0, tile as usize);
                }
            }
            assert!(covered.iter().all(|&count| count == 1), "{size:?}");
        }
        assert_eq!(Tiles::of([0, 0]).count(), 0);
    }

    #[test]
    fn the_tile_under_the_pointer_comes_first_and_the_farthest_last() {
        let tiles = Tiles::of([256, 128]);
        let order = tiles.nearest_first(Vec2::new(0.9, 0.9));
        assert_eq!((order[0], order[7]), (7, 0));
        assert_eq!(tiles.nearest_first(Vec2::splat(0.1))[0], 0, "negative control");
    }

    #[test]
    fn lattices_add_up_to_the_picture() {
        assert!((STRIDES.map(share_of_lattice).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn weights_of_the_tent_sum_to_its_cells_and_vanish_on_other_lattice_points() {
        for cells in [1, 2] {
            for pixel in [[16, 16], [19, 22], [23, 17]] {
                let sum: f32 = around(pixel, 8, cells).map(|(_, weight)| weight).sum();
                assert!((sum - (cells * cells) as f32).abs() < 1e-5);
            }
        }
        let weights: Vec<f32> = around([16, 24], 8, 1).map(|(_, weight)| weight).collect();
        assert_eq!(weights, [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn other_materials_planes_and_corners_do_not_fit_and_the_same_plane_does() {
        let here =
            Guide { material: 1, smooth_normal: Vec3::Y, normal: Vec3::Y, albedo: Vec3::splat(0.5), ..Guide::unlit(1) };
        let fit = |other: Guide| here.fit(&other, 0.1);
        assert_eq!(fit(Guide { position: Vec3::X, ..here }), 1.0);
        assert_eq!(fit(Guide { material: 2, ..here }), 0.0);
        assert_eq!(fit(Guide { position: 0.11 * Vec3::Y, ..here }), 0.0);
        assert_eq!(fit(Guide { normal: Vec3::X, ..here }), 0.0);
        assert!((fit(Guide { albedo: Vec3::splat(0.1), ..here }) - 0.2).abs() < 1e-6);
        assert!(!Guide::unlit(Guide::BACK).is_lit() && here.is_lit());
        assert_eq!(size_of::<Guide>(), 64);
    }
}
