//! The first sample of a picture on lattices, and the filter between their points: see [`crate::sketch`].

use crate::{
    appearance::Appearance,
    cpu::picture::{FirstSample, Lacking, Picture},
    shade::{
        painter::Painter,
        pixel_sampler::PixelSampler,
        surface::{FirstHit, SurfacePoint},
    },
    sketch::{Guide, Mean, Tiles, around, pixel_angle},
    view_mode::ViewMode,
};
use glam::{IVec2, Vec3};
use lapidary_core::{
    camera::Camera,
    image::Region,
    ray::{Hit, SeenFrom},
};
use rayon::prelude::*;

/// A pixel that the filter fills.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Filled {
    /// Radiance, or the quantity of the view's mode.
    pub value: Vec3,
    /// Coverage by the lines of a wireframe.
    pub wire: f32,
}

/// What pixels see, kept while the camera stays, and how far the lattices of each tile are.
#[derive(Default)]
pub(crate) struct Sketch {
    seen_by: Option<(Camera, [u32; 2])>,
    /// For the camera's rays, while there are pixels without one.
    rays: Option<SeenFrom>,
    /// Those of one tile after another.
    guides: Vec<Guide>,
    /// For each tile, the number of the last change of materials that its guides have; `None` before it was looked at.
    looked: Vec<Option<u64>>,
    /// For each tile, the finest lattice that all of its pixels have; `None` before the first.
    strides: Vec<Option<u32>>,
    /// Number of the last change of materials.
    changes: u64,
    /// For each material, the number of its last change.
    changed: Vec<u64>,
}

/// A pixel that nothing around it fits.
struct Hole {
    pixel: [u32; 2],
    /// What the filter gives if it looks at materials alone; `None` if no surface is near.
    guess: Option<Vec3>,
}

impl Sketch {
    /// Another scene.
    pub fn forget(&mut self) {
        *self = Self { changes: self.changes, ..Self::default() };
    }

    /// Another appearance after `old`: what the pixels of changed materials look like is looked up again.
    pub fn set_appearance(&mut self, old: &Appearance, new: &Appearance) {
        self.changes += 1;
        self.changed.resize(new.materials.len(), 0);
        old.changed_materials(new).into_iter().for_each(|material| self.changed[material] = self.changes);
    }

    /// Another picture; what its pixels see is kept if the camera is the same.
    pub fn begin(&mut self, camera: &Camera, size: [u32; 2]) {
        let tiles = Tiles::of(size);
        let count = tiles.count() as usize;
        if self.seen_by.as_ref().is_none_or(|(c, s)| c != camera || *s != size) {
            self.seen_by = Some((camera.clone(), size));
            self.guides.clear();
            self.rays = None;
            self.looked = vec![None; count];
        }
        self.strides = vec![None; count];
    }

    /// Whether all tiles have all lattices.
    pub fn is_complete(&self) -> bool {
        self.strides.iter().all(|&stride| stride == Some(1))
    }

    fn tiles(&self) -> Tiles {
        Tiles::of(self.seen_by.as_ref().map_or([0, 0], |(_, size)| *size))
    }

    fn guide(&self, x: u32, y: u32) -> &Guide {
        let (tile, place) = self.tiles().place(x, y);
        &self.guides[tile * Tiles::MOST_PIXELS + place]
    }

    /// Gives the pixels of some tiles on a lattice their first sample, and those without a surface to shade.
    pub fn add_tiles<'a>(
        &mut self,
        picture: &mut Picture,
        sampler: &PixelSampler<'a>,
        painter: impl Fn() -> Painter<'a> + Sync + Send,
        patches: Option<&[u8]>,
        stride: u32,
        tiles: &[u32],
    ) {
        let (all, materials) = (self.tiles(), MaterialChanges { last: self.changes, of: &self.changed });
        self.guides.resize(all.count() as usize * Tiles::MOST_PIXELS, Guide::unlit(Guide::BACKGROUND));
        let wanted: Vec<bool> = mask(all.count(), tiles);
        let needs_rays = tiles.iter().any(|&tile| self.looked[tile as usize].is_none());
        let rays = self.rays.take().or_else(|| needs_rays.then(|| sampler.seen_from_eye()));
        let shade_tile =
            |painter: &mut Painter<'a>, (tile, (guides, looked)): (usize, (&mut [Guide], &mut Option<u64>))| {
                let mut work = TileWork {
                    tiles: all,
                    region: all.region(tile as u32),
                    guides,
                    sampler,
                    patches,
                    rays: rays.as_ref(),
                };
                work.look(*looked, &materials);
                *looked = Some(materials.last);
                work.shade(picture, painter, stride, self.strides[tile].is_none())
            };
        let shaded: Vec<Vec<FirstSample>> = self
            .guides
            .par_chunks_mut(Tiles::MOST_PIXELS)
            .zip(&mut self.looked)
            .enumerate()
            .filter(|(tile, _)| wanted[*tile])
            .map_init(painter, shade_tile)
            .collect();
        shaded.into_iter().for_each(|samples| picture.set_first(samples));
        self.rays = rays.filter(|_| self.looked.contains(&None));
        tiles.iter().for_each(|&tile| self.strides[tile as usize] = Some(stride));
    }

    /// Fills the pixels that have no sample yet. At most `most_shaded` of those that nothing around fits are shaded instead,
    /// first those with no surface around them. All tiles must have a lattice. Returns how many were shaded.
    pub fn fill<'a>(
        &self,
        picture: &mut Picture,
        sampler: &PixelSampler<'a>,
        painter: impl Fn() -> Painter<'a> + Sync + Send,
        patches: Option<&[u8]>,
        most_shaded: u32,
    ) -> u32 {
        let Some((camera, size)) = &self.seen_by else { return 0 };
        let is_lit = sampler.view.mode == ViewMode::Shaded;
        let (eye, pixel_angle) = (camera.eye, pixel_angle(camera, *size));
        let filter = Filter { sketch: self, picture, eye, pixel_angle, is_lit };
        let mut filled = vec![Filled::default(); size[0] as usize * size[1] as usize];
        let fill_row = |(y, row): (usize, &mut [Filled])| filter.fill_row(y as u32, row, sampler);
        let holes: Vec<Hole> =
            filled.par_chunks_mut(size[0].max(1) as usize).enumerate().flat_map_iter(fill_row).collect();
        let chosen = chosen(&holes, most_shaded as usize);
        let view = &*picture;
        let shade = |painter: &mut Painter<'a>, hole: &&Hole| {
            let [x, y] = hole.pixel;
            first_sample(view, (sampler, painter), patches, self.guide(x, y), hole.pixel)
        };
        let shaded: Vec<FirstSample> = chosen.par_iter().with_min_len(16).map_init(painter, shade).collect();
        let count = shaded.len();
        picture.set_first(shaded);
        if count > 0 {
            let filter = Filter { sketch: self, picture, eye, pixel_angle, is_lit };
            let near = |hole: &Hole| filter.near(hole.pixel);
            let values: Vec<Option<Vec3>> = holes.par_iter().map(near).collect();
            for (Hole { pixel: [x, y], .. }, value) in holes.iter().zip(values) {
                let filled = &mut filled[*y as usize * size[0] as usize + *x as usize];
                filled.value = value.unwrap_or(filled.value);
            }
        }
        picture.set_filled(filled);
        count as u32
    }
}

/// Which of the tiles are among `tiles`.
fn mask(count: u32, tiles: &[u32]) -> Vec<bool> {
    let mut wanted = vec![false; count as usize];
    tiles.iter().for_each(|&tile| wanted[tile as usize] = true);
    wanted
}

/// At most so many holes, spread over the picture; first those without a guess.
fn chosen(holes: &[Hole], most: usize) -> Vec<&Hole> {
    let (bare, guessed): (Vec<&Hole>, Vec<&Hole>) = holes.iter().partition(|hole| hole.guess.is_none());
    let left = most.saturating_sub(bare.len());
    [spread(bare, most), spread(guessed, left)].concat()
}

/// At most so many, evenly.
fn spread<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let step = all.len().div_ceil(most.max(1)).max(1);
    all.into_iter().step_by(step).take(most).collect()
}

/// When materials changed.
struct MaterialChanges<'a> {
    last: u64,
    of: &'a [u64],
}

/// A tile at work.
struct TileWork<'t, 's, 'a> {
    tiles: Tiles,
    region: Region,
    guides: &'t mut [Guide],
    sampler: &'s PixelSampler<'a>,
    patches: Option<&'s [u8]>,
    /// There where pixels were not looked at.
    rays: Option<&'s SeenFrom>,
}

impl TileWork<'_, '_, '_> {
    /// Finds out what the pixels see, as far as that is not known or its material has changed since.
    fn look(&mut self, looked: Option<u64>, materials: &MaterialChanges) {
        if looked == Some(materials.last) {
            return;
        }
        for (x, y) in pixels(self.region) {
            let guide = &mut self.guides[self.tiles.place(x, y).1];
            let changed = materials.of.get(guide.material as usize).copied();
            if looked.is_none() {
                let hit = self.rays.and_then(|rays| self.sampler.first_hit(rays, x, y));
                *guide = looked_up(self.sampler, hit, x, y);
            } else if changed > looked {
                *guide = looked_up(self.sampler, hit(guide), x, y);
            }
        }
    }

    /// The first sample of the pixels on a lattice, and with `unlit` of those without a surface to shade.
    fn shade(&self, picture: &Picture, painter: &mut Painter, stride: u32, unlit: bool) -> Vec<FirstSample> {
        let mut shaded = Vec::new();
        for (x, y) in pixels(self.region) {
            let on_lattice = x % stride == 0 && y % stride == 0;
            if !(on_lattice || unlit) || picture.lacking(x, y).is_none() {
                continue;
            }
            let guide = &self.guides[self.tiles.place(x, y).1];
            if on_lattice || !guide.is_lit() {
                shaded.push(first_sample(picture, (self.sampler, &mut *painter), self.patches, guide, [x, y]));
            }
        }
        shaded
    }
}

fn pixels(region: Region) -> impl Iterator<Item = (u32, u32)> {
    region.rows().flat_map(move |y| region.columns().map(move |x| (x, y)))
}

/// What steers the filter where the first sample of a pixel meets the mesh at `hit`.
fn looked_up(sampler: &PixelSampler, hit: Option<Hit>, x: u32, y: u32) -> Guide {
    match (sampler.first_sight(x, y, hit).seen, hit) {
        (FirstHit::Surface(point), Some(hit)) => guide_of(sampler.material(hit.triangle), &hit, &point),
        (_, Some(hit)) => Guide { triangle: coded(&hit), ..Guide::unlit(Guide::BACK) },
        (_, None) => Guide::unlit(Guide::BACKGROUND),
    }
}

fn guide_of(material: u32, hit: &Hit, point: &SurfacePoint) -> Guide {
    Guide {
        material,
        triangle: coded(hit),
        barycentric: hit.barycentric,
        position: point.position,
        smooth_normal: point.smooth_normal,
        normal: point.world_from_local.z_axis,
        albedo: Guide::divisor(point.brdf.as_brdf().albedo()),
    }
}

fn coded(hit: &Hit) -> u32 {
    hit.triangle | if hit.back_face { Guide::FROM_BEHIND } else { 0 }
}

fn hit(guide: &Guide) -> Option<Hit> {
    let back_face = guide.triangle & Guide::FROM_BEHIND != 0;
    let hit = Hit {
        triangle: guide.triangle & !Guide::FROM_BEHIND,
        distance: 0.0,
        barycentric: guide.barycentric,
        back_face,
    };
    (guide.material != Guide::BACKGROUND).then_some(hit)
}

/// What a pixel lacks of its first sample, without its camera ray.
fn first_sample(
    picture: &Picture,
    (sampler, painter): (&PixelSampler, &mut Painter),
    patches: Option<&[u8]>,
    guide: &Guide,
    [x, y]: [u32; 2],
) -> FirstSample {
    FirstSample::new(picture, (sampler, painter), patches, [x, y], &sampler.first_sight(x, y, hit(guide)))
}

/// The joint bilateral filter.
struct Filter<'a> {
    sketch: &'a Sketch,
    picture: &'a Picture,
    eye: Vec3,
    pixel_angle: f32,
    /// Whether the pixels show radiance.
    is_lit: bool,
}

impl Filter<'_> {
    /// Fills the pixels of a row that have no sample, and returns those that nothing fits.
    fn fill_row(&self, y: u32, row: &mut [Filled], sampler: &PixelSampler) -> Vec<Hole> {
        let mut holes = Vec::new();
        for (x, filled) in row.iter_mut().enumerate() {
            let pixel = [x as u32, y];
            let Some(lacking) = self.picture.lacking(pixel[0], y) else { continue };
            let guide = self.sketch.guide(pixel[0], y);
            let fitting = self.fitting(pixel, guide, lacking);
            if fitting.is_none() {
                holes.push(Hole { pixel, guess: self.guess(pixel, guide, lacking) });
            }
            let mean = fitting.or_else(|| holes.last().and_then(|hole| hole.guess));
            filled.value = self.multiplied(mean.unwrap_or_default(), pixel, lacking);
            if sampler.view.wireframe {
                filled.wire = sampler.first_wire(pixel[0], y, guide.triangle & !Guide::FROM_BEHIND);
            }
        }
        holes
    }

    /// The value of a hole beside holes that were shaded: thin things are shaded in part.
    fn near(&self, pixel: [u32; 2]) -> Option<Vec3> {
        /// Pixels on each side of it, along which several holes lie that one shaded pixel stands for.
        const PIXELS: i32 = 3;
        let lacking = self.picture.lacking(pixel[0], pixel[1])?;
        let guide = self.sketch.guide(pixel[0], pixel[1]);
        let reach = self.reach(guide, PIXELS as u32);
        let mean = self.mean((pixel, lacking), 1, PIXELS, |other| guide.fit(other, reach)).any()?;
        Some(self.multiplied(mean, pixel, lacking))
    }

    /// Radiance over albedo as what a pixel shows, with the light that it does not lack.
    fn multiplied(&self, mean: Vec3, [x, y]: [u32; 2], lacking: Lacking) -> Vec3 {
        mean * self.divisor(self.sketch.guide(x, y)) + self.picture.mean_of_rest(x, y, lacking)
    }

    /// Distance of a lattice in metres at a pixel.
    fn reach(&self, guide: &Guide, stride: u32) -> f32 {
        stride as f32 * self.pixel_angle * guide.position.distance(self.eye)
    }

    fn divisor(&self, guide: &Guide) -> Vec3 {
        if self.is_lit { guide.albedo } else { Vec3::ONE }
    }

    /// The mean of the lattice points around a pixel, or of those around these, as far as they fit.
    fn fitting(&self, pixel: [u32; 2], guide: &Guide, lacking: Lacking) -> Option<Vec3> {
        let stride = self.stride(pixel);
        let reach = self.reach(guide, stride);
        [1, 2].into_iter().find_map(|cells| {
            self.mean((pixel, lacking), stride, cells, |other| guide.fit(other, reach)).fitting(cells)
        })
    }

    /// The mean over the nearest surfaces, with those of the same material far ahead.
    fn guess(&self, pixel: [u32; 2], guide: &Guide, lacking: Lacking) -> Option<Vec3> {
        const OTHER: f32 = 1e-3;
        let weight = |other: &Guide| if other.material == guide.material { 1.0 } else { OTHER };
        self.mean((pixel, lacking), self.stride(pixel), 2, weight).any()
    }

    fn mean(
        &self,
        (pixel, lacking): ([u32; 2], Lacking),
        stride: u32,
        cells: i32,
        fit: impl Fn(&Guide) -> f32,
    ) -> Mean {
        let mut mean = Mean::default();
        for (IVec2 { x, y }, weight) in around(pixel, stride, cells) {
            // Negative ones are beyond any size.
            let Some(value) = self.picture.mean_of(x as u32, y as u32, lacking) else { continue };
            let other = self.sketch.guide(x as u32, y as u32);
            let weight = if other.is_lit() { weight * fit(other) } else { 0.0 };
            if weight > 0.0 {
                mean.add(value / self.divisor(other), weight);
            }
        }
        mean
    }

    fn stride(&self, [x, y]: [u32; 2]) -> u32 {
        self.sketch.strides[self.sketch.tiles().place(x, y).0].unwrap_or(1)
    }
}

#[cfg(test)]
mod tests;
