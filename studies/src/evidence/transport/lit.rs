//! A scene of quads with its transport, and pictures of its light.

use super::super::{Measurement, cases::Case};
use crate::bounces::light_paths::LightPaths;
use anyhow::Result;
use glam::{Vec2, Vec3};
use lapidary_core::{
    dataset::Dataset,
    image::Image,
    lights::Light,
    offset,
    ray::Intersector,
    wavelet::{
        WaveletTransport,
        direct::DirectProjection,
        patch::{Patch, patch_of_triangles},
        picture::{PatchTexture, neighbors},
        reflecting::ReflectingPatch,
        series::{GlobalTransport, MOST_POWERS},
    },
};
use lapidary_precompute::wavelet::{TransportSettings, direct_transport};
use lapidary_render::{Baked, Look, Solution};
use rayon::prelude::*;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// A scene of quads, lit by its lamps.
pub struct LitQuads<'a> {
    pub name: &'a str,
    pub transport: WaveletTransport,
    /// Time of the transport of one bounce, and of all.
    pub precompute: [Duration; 2],
    rays: Intersector,
    offset: f32,
    lights: &'a [Light],
    look: Look,
    dataset: &'a Arc<Dataset>,
    /// The patch of each triangle.
    patch_of: Vec<Option<u32>>,
    /// The patches that continue each.
    neighbors: Vec<Vec<u32>>,
}

impl<'a> LitQuads<'a> {
    /// `None` for a scene with other surfaces, with maps, or without lamps.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn new(measurement: &Measurement, case: &'a Case) -> Result<Option<Self>> {
        let Some(dataset) = &case.functions else { return Ok(None) };
        // Wavelet transport reads no maps, so an error would not be the method's.
        let has_maps = case.scene.materials.iter().any(|material| material.maps.iter().next().is_some());
        let patches = ReflectingPatch::of_scene(&case.scene).ok().filter(|_| !has_maps);
        let Some(patches) = patches else { return Ok(None) };
        measurement.steps.begin(&format!("wavelet transport of {}", case.name));
        let rays = Intersector::of_scene(&case.scene);
        let offset = offset::TRANSPORT * case.scene.mesh.bounds().diagonal();
        let quads: Vec<Patch> = patches.iter().map(|reflecting| reflecting.patch).collect();
        let patch_of = patch_of_triangles(&case.scene.mesh, &quads);
        let settings = TransportSettings::DEFAULT;
        let start = Instant::now();
        let (basis, direct) =
            direct_transport(&patches, &|_| true, &rays, offset, &settings, &measurement.steps.reporter)?;
        let of_direct = start.elapsed();
        measurement.steps.check()?;
        let start = Instant::now();
        let global = GlobalTransport::of(&direct, settings.compression);
        let precompute = [of_direct, start.elapsed()];
        let neighbors = neighbors(&patches, &basis, &rays, offset);
        let transport = WaveletTransport { patches, basis, direct, global: global.operator };
        let look = measurement.bounced(dataset, Solution::Meshless);
        Ok(Some(Self {
            name: &case.name,
            transport,
            precompute,
            rays,
            offset,
            lights: &case.scene.lights,
            look,
            dataset,
            patch_of,
            neighbors,
        }))
    }

    /// Light of the lamps on the patches.
    pub fn direct(&self) -> Vec<Vec3> {
        let patches = &self.transport.patches;
        let levels = TransportSettings::DEFAULT.levels;
        DirectProjection { patches, rays: &self.rays, offset: self.offset, levels }
            .project(self.lights, &self.transport.basis)
    }

    /// Textures of light.
    pub fn textures(&self, light: &[Vec3]) -> Vec<PatchTexture> {
        PatchTexture::all(&self.transport.patches, &self.neighbors, &self.transport.basis, light)
    }

    /// The picture of light that arrives on the patches.
    pub fn picture(&self, light: &[Vec3]) -> Image {
        let textures = self.textures(light);
        let (camera, size) = (&self.look.view.camera, self.look.view.size);
        let pixel = |i: u32| {
            let at = Vec2::new((i % size[0]) as f32, (i / size[0]) as f32) + 0.5;
            let direction = camera.direction_through(at, size);
            let hit = self.rays.closest_hit(camera.eye, direction).filter(|hit| !hit.back_face);
            let on_patch = hit.and_then(|hit| Some((hit, self.patch_of[hit.triangle as usize]? as usize)));
            on_patch.map_or(Vec3::ZERO, |(hit, patch)| {
                let reflecting = &self.transport.patches[patch];
                let square = square_at(&reflecting.patch, camera.eye + direction * hit.distance);
                reflecting.outgoing(&textures[patch].at(square), -direction)
            })
        };
        Image { size, pixels: (0..size[0] * size[1]).into_par_iter().map(pixel).collect() }
    }

    /// Light paths of as many bounces.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn paths(&self, measurement: &Measurement) -> Result<LightPaths> {
        let baked = Baked::from(self.dataset.clone());
        Ok(measurement.posed_paths(&baked, &self.look, MOST_POWERS as u32 + 1, measurement.scale.spp)?.into())
    }
}

fn square_at(patch: &Patch, point: Vec3) -> Vec2 {
    patch.square_of(point).clamp(Vec2::ZERO, Vec2::ONE)
}
