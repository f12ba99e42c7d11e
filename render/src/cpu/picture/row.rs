//! Adding samples to a row.

use super::{Seen, Sum, lights_seen};
use crate::{
    shade::{
        painter::{Painter, SeenOfParts},
        pixel_sampler::{PixelSampler, Sight},
        surface::FirstHit,
    },
    stale::LightPart,
};
use lapidary_core::ray::Hit;

/// The pixels of a row.
pub struct Row<'p> {
    pub(super) y: u32,
    pub(super) seen: &'p mut [Seen],
    pub(super) parts: [&'p mut [Sum]; LightPart::COUNT],
}

impl Row<'_> {
    /// Adds a sample to each pixel that lacks it. Returns the number of shaded surface samples by part.
    pub(super) fn add(
        mut self,
        sampler: &PixelSampler,
        painter: &mut Painter,
        patches: Option<&[u8]>,
        sample: u32,
    ) -> [u64; LightPart::COUNT] {
        let mut shaded = [0; LightPart::COUNT];
        let y = self.y;
        let lacking: Vec<[u32; 2]> =
            (0..self.seen.len()).filter(|&x| self.lacks_any(x, sample)).map(|x| [x as u32, y]).collect();
        let hits = sampler.hits(&lacking, sample as usize);
        let (mut sights, together) = (Vec::new(), painter.together());
        for (pixels, hits) in lacking.chunks(together).zip(hits.chunks(together)) {
            let sight = |(&pixel, &hit): (&[u32; 2], &Option<Hit>)| sampler.sight_of(pixel, sample as usize, hit);
            sights.clear();
            sights.extend(pixels.iter().zip(hits).map(sight));
            let seen_lights = lights_seen(painter, &sights, |i| self.lacks(pixels[i][0] as usize, sample));
            for ((&pixel, sight), seen_lights) in pixels.iter().zip(&sights).zip(seen_lights) {
                let lacks = self.lacks(pixel[0] as usize, sample);
                self.add_to_pixel(pixel, lacks, (sampler, &mut *painter), patches, (sample, sight, seen_lights));
                let surface = matches!(sight.seen, FirstHit::Surface(_));
                shaded.iter_mut().zip(lacks).for_each(|(count, lacks)| *count += u64::from(surface && lacks));
            }
        }
        shaded
    }

    /// Parts of a pixel that lack a sample.
    fn lacks(&self, x: usize, sample: u32) -> [bool; LightPart::COUNT] {
        LightPart::ALL.map(|part| self.parts[part as usize].get(x).is_some_and(|sum| sum.samples == sample))
    }

    /// Whether a pixel lacks a sample of any part or its surface.
    fn lacks_any(&self, x: usize, sample: u32) -> bool {
        self.lacks(x, sample).contains(&true) || self.seen[x].samples == sample
    }

    /// Adds a sample to those parts of a pixel that lack it.
    fn add_to_pixel(
        &mut self,
        [x, y]: [u32; 2],
        lacks: [bool; LightPart::COUNT],
        (sampler, painter): (&PixelSampler, &mut Painter),
        patches: Option<&[u8]>,
        (sample, sight, seen_lights): (u32, &Sight, SeenOfParts),
    ) {
        let seen = &mut self.seen[x as usize];
        if seen.samples == sample {
            seen.add(sampler, sight.position, &sight.seen, patches);
        }
        for part in LightPart::ALL.into_iter().filter(|&part| lacks[part as usize]) {
            let sum = &mut self.parts[part as usize][x as usize];
            sum.add(part, (sampler, painter), sight, ([x, y, sample], seen_lights));
        }
    }
}
