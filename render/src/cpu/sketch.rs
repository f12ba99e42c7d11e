//! The first sample of a picture on lattices; see [`crate::sketch`]. A filter fills the pixels between them, with help from the
//! last picture if the camera moves.

mod filter;
mod history;
mod moved;

use crate::{
    appearance::Appearance,
    cpu::picture::{FirstSample, Picture, lights_seen},
    shade::{
        painter::Painter,
        pixel_sampler::{PixelSampler, Sight},
        surface::SurfacePoint,
    },
    sketch::{Guide, Tiles},
};
use filter::{Filter, Hole};
use history::History;
use lapidary_core::{camera::Camera, image::Region, ray::Hit};
pub(crate) use moved::Moved;
use rayon::prelude::*;

/// Surfaces of the pixels, kept while the camera stays, and the lattice progress of each tile.
#[derive(Default)]
pub(crate) struct Sketch {
    seen_by: Option<(Camera, [u32; 2])>,
    /// Guides of the pixels, tile by tile.
    guides: Vec<Guide>,
    /// Whether each guide is out of date because a posed object touches its pixel.
    stale: Vec<bool>,
    /// Number of the last material change in each tile's guides; `None` before the first lookup.
    looked: Vec<Option<u64>>,
    /// Finest lattice that all pixels of each tile have; `None` before the first.
    strides: Vec<Option<u32>>,
    /// Data of the last picture, if only the camera has moved since.
    history: Option<History>,
    /// Number of the last material change.
    changes: u64,
    /// Number of each material's last change.
    changed: Vec<u64>,
}

impl Sketch {
    /// Forgets the scene.
    pub fn forget(&mut self) {
        *self = Self { changes: self.changes, ..Self::default() };
    }

    /// Takes a scene with moved objects. Only pixels that saw one, or may see one now, are looked up again.
    pub fn pose(&mut self, moved: &Moved) {
        self.history = None;
        let Some((camera, size)) = &self.seen_by else { return };
        let tiles = Tiles::of(*size);
        let rectangles = moved.rectangles(camera, *size);
        if rectangles.contains(&[[0, 0], *size]) {
            return self.stale.fill(true);
        }
        for [[left, top], [right, bottom]] in rectangles {
            for (x, y) in (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y))) {
                let (tile, place) = tiles.place(x, y);
                if let Some(stale) = self.stale.get_mut(tile * Tiles::MOST_PIXELS + place) {
                    *stale = true;
                }
            }
        }
        let sees_moved =
            |guide: &Guide| guide.material != Guide::BACKGROUND && moved.contains(guide.triangle & !Guide::FROM_BEHIND);
        self.stale.par_iter_mut().zip(&self.guides).for_each(|(stale, guide)| *stale |= sees_moved(guide));
    }

    /// Takes a new appearance. Guides of pixels with changed materials are looked up again.
    pub fn set_appearance(&mut self, old: &Appearance, new: &Appearance) {
        self.changes += 1;
        let count = old.materials.len().max(new.materials.len());
        self.changed.resize(count, 0);
        let changed = old.changed_materials(new).unwrap_or_else(|| (0..count).collect());
        changed.into_iter().for_each(|material| self.changed[material] = self.changes);
    }

    /// Starts a picture; guides are kept if the camera is the same. `last` is the previous picture, if only camera and size have
    /// changed since.
    pub fn begin(&mut self, camera: &Camera, size: [u32; 2], last: Option<&Picture>) {
        let tiles = Tiles::of(size);
        let count = tiles.count() as usize;
        if self.seen_by.as_ref().is_none_or(|(c, s)| c != camera || *s != size) {
            self.remember(last);
            self.seen_by = Some((camera.clone(), size));
            self.looked = vec![None; count];
            self.stale.fill(false);
        } else {
            self.history = None;
        }
        self.strides = vec![None; count];
    }

    /// Keeps the last picture's data. An incomplete picture is worse than the one before it, which is kept instead.
    fn remember(&mut self, last: Option<&Picture>) {
        let history = self.history.take();
        let (Some(last), Some((camera, size))) = (last, &self.seen_by) else { return };
        let is_shown = last.is_filled() || self.is_complete();
        self.history = if is_shown && !self.looked.contains(&None) {
            Some(History::new(camera.projection(*size), last, |x, y| self.guide(x, y), history))
        } else {
            history
        };
    }

    /// Call when all pixels have their sample: no pixel needs filling any more.
    pub fn forget_last(&mut self) {
        self.history = None;
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

    /// Adds the first sample to pixels of some tiles on a lattice, and to those without a surface to shade.
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
        let pixels = all.count() as usize * Tiles::MOST_PIXELS;
        self.guides.resize(pixels, Guide::unlit(Guide::BACKGROUND));
        self.stale.resize(pixels, false);
        let wanted: Vec<bool> = mask(all.count(), tiles);
        type Known<'k> = ((&'k mut [Guide], &'k mut [bool]), &'k mut Option<u64>);
        let shade_tile = |painter: &mut Painter<'a>, (tile, ((guides, stale), looked)): (usize, Known)| {
            let region = all.region(tile as u32);
            let mut work = TileWork { tiles: all, region, guides, stale, sampler, patches };
            work.look(*looked, &materials);
            *looked = Some(materials.last);
            work.shade(picture, painter, stride, self.strides[tile].is_none())
        };
        let shaded: Vec<Vec<FirstSample>> = self
            .guides
            .par_chunks_mut(Tiles::MOST_PIXELS)
            .zip(self.stale.par_chunks_mut(Tiles::MOST_PIXELS))
            .zip(&mut self.looked)
            .enumerate()
            .filter(|(tile, _)| wanted[*tile])
            .map_init(painter, shade_tile)
            .collect();
        shaded.into_iter().for_each(|samples| picture.set_first(samples));
        tiles.iter().for_each(|&tile| self.strides[tile as usize] = Some(stride));
    }

    /// Fills the pixels that have no sample yet. Shades at most `most_shaded` of the pixels that no neighbor fits, first those with
    /// no surface around them. All tiles must have a lattice. Returns the number of shaded pixels.
    pub fn fill<'a>(
        &mut self,
        picture: &mut Picture,
        sampler: &PixelSampler<'a>,
        painter: impl Fn() -> Painter<'a> + Sync + Send,
        patches: Option<&[u8]>,
        most_shaded: u32,
    ) -> u32 {
        if let Some(mut history) = self.history.take() {
            history.predict(|x, y| self.guide(x, y), sampler.view.size);
            self.history = Some(history);
        }
        let mut filled = picture.take_filled(sampler);
        let holes = Filter::new(self, picture, sampler).fill(&mut filled);
        let shade = |painter: &mut Painter<'a>, eight: &[&Hole]| {
            let pixels: Vec<[u32; 2]> = eight.iter().map(|hole| hole.pixel).collect();
            let mut shaded = Vec::new();
            add_first_samples(picture, (sampler, painter), patches, (&pixels, |[x, y]| self.guide(x, y)), &mut shaded);
            shaded
        };
        let chosen = chosen(&holes, most_shaded as usize);
        let eights = chosen.par_chunks(8).with_min_len(2).map_init(painter, shade);
        let shaded: Vec<FirstSample> = eights.flatten_iter().collect();
        let count = shaded.len();
        picture.set_first(shaded);
        if count > 0 {
            Filter::new(self, picture, sampler).fill_beside(&holes, &mut filled);
        }
        picture.set_filled(filled);
        count as u32
    }
}

/// Whether each tile is among `tiles`.
fn mask(count: u32, tiles: &[u32]) -> Vec<bool> {
    let mut wanted = vec![false; count as usize];
    tiles.iter().for_each(|&tile| wanted[tile as usize] = true);
    wanted
}

/// At most `most` holes, spread over the picture; first those without a guess.
fn chosen(holes: &[Hole], most: usize) -> Vec<&Hole> {
    let (bare, guessed): (Vec<&Hole>, Vec<&Hole>) = holes.iter().partition(|hole| hole.is_bare);
    let left = most.saturating_sub(bare.len());
    [spread(bare, most), spread(guessed, left)].concat()
}

/// At most `most` items, evenly spread.
fn spread<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let step = all.len().div_ceil(most.max(1)).max(1);
    all.into_iter().step_by(step).take(most).collect()
}

/// Times of material changes.
struct MaterialChanges<'a> {
    last: u64,
    of: &'a [u64],
}

/// A tile being worked on.
struct TileWork<'t, 's, 'a> {
    tiles: Tiles,
    region: Region,
    guides: &'t mut [Guide],
    stale: &'t mut [bool],
    sampler: &'s PixelSampler<'a>,
    patches: Option<&'s [u8]>,
}

impl TileWork<'_, '_, '_> {
    /// Updates guides that are unknown or whose material has changed since.
    fn look(&mut self, looked: Option<u64>, materials: &MaterialChanges) {
        let is_unknown = |&[x, y]: &[u32; 2]| looked.is_none() || self.stale[self.tiles.place(x, y).1];
        let near: Vec<[u32; 2]> = by_blocks(self.region).filter(is_unknown).collect();
        for (&[x, y], hit) in near.iter().zip(self.sampler.hits(&near, 0)) {
            self.guides[self.tiles.place(x, y).1] = looked_up(self.sampler, hit, x, y);
        }
        self.stale.fill(false);
        if looked.is_none_or(|looked| looked == materials.last) {
            return;
        }
        for (x, y) in pixels(self.region) {
            let guide = &mut self.guides[self.tiles.place(x, y).1];
            if materials.of.get(guide.material as usize).copied() > looked {
                *guide = looked_up(self.sampler, hit(guide), x, y);
            }
        }
    }

    /// First samples of the pixels on a lattice; `unlit` includes those without a surface to shade.
    fn shade(&self, picture: &Picture, painter: &mut Painter, stride: u32, unlit: bool) -> Vec<FirstSample> {
        let guide = |[x, y]: [u32; 2]| &self.guides[self.tiles.place(x, y).1];
        let is_wanted = |&[x, y]: &[u32; 2]| {
            let on_lattice = x.is_multiple_of(stride) && y.is_multiple_of(stride);
            (on_lattice || unlit && !guide([x, y]).is_lit()) && picture.lacks(x, y).contains(&true)
        };
        let wanted: Vec<[u32; 2]> = pixels(self.region).map(|(x, y)| [x, y]).filter(is_wanted).collect();
        let mut shaded = Vec::with_capacity(wanted.len());
        for pixels in wanted.chunks(painter.together()) {
            add_first_samples(picture, (self.sampler, &mut *painter), self.patches, (pixels, guide), &mut shaded);
        }
        shaded
    }
}

fn pixels(region: Region) -> impl Iterator<Item = (u32, u32)> {
    region.rows().flat_map(move |y| region.columns().map(move |x| (x, y)))
}

/// The pixels of a region in blocks of four by two.
fn by_blocks(region: Region) -> impl Iterator<Item = [u32; 2]> {
    let part = |first: u32, side: u32, end: u32| first..(first + side).min(end);
    let (right, below) = (region.columns().end, region.rows().end);
    let blocks = region.rows().step_by(2).flat_map(move |y| region.columns().step_by(4).map(move |x| [x, y]));
    blocks.flat_map(move |[x, y]| part(y, 2, below).flat_map(move |y| part(x, 4, right).map(move |x| [x, y])))
}

/// Filter guide of a pixel whose first sample hits the mesh at `hit`.
fn looked_up(sampler: &PixelSampler, hit: Option<Hit>, x: u32, y: u32) -> Guide {
    let Some(hit) = hit else { return Guide::unlit(Guide::BACKGROUND) };
    match sampler.first_point(x, y, &hit) {
        Some(point) => guide_of(sampler.material(hit.triangle), &hit, &point),
        None => Guide { triangle: coded(&hit), ..Guide::unlit(Guide::BACK) },
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

/// Adds the missing parts of up to eight pixels' first samples, without their camera rays.
fn add_first_samples<'g>(
    picture: &Picture,
    (sampler, painter): (&PixelSampler, &mut Painter),
    patches: Option<&[u8]>,
    (pixels, guide): (&[[u32; 2]], impl Fn([u32; 2]) -> &'g Guide),
    shaded: &mut Vec<FirstSample>,
) {
    let sights: Vec<Sight> = pixels.iter().map(|&pixel| sampler.sight_of(pixel, 0, hit(guide(pixel)))).collect();
    let seen = lights_seen(painter, &sights, |i| picture.lacks(pixels[i][0], pixels[i][1]));
    let first =
        |((&pixel, sight), seen)| FirstSample::new(picture, (sampler, &mut *painter), patches, pixel, (sight, seen));
    shaded.extend(pixels.iter().zip(&sights).zip(seen).map(first));
}

#[cfg(test)]
mod tests;
